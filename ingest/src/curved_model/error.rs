//! Why a file is no curved model, or what is asked of it cannot be done.

use std::io;

use terrain_codec::clod::{CurvedError, EncodeError};
use terrain_core::curved::model;
use terrain_core::curved::tessellation::TessellationError;
use terrain_tiles::formats::bezier::BezierError;
use thiserror::Error;

use crate::polygonal_model;

/// Why there is no curved model, or none of what was asked for.
#[derive(Debug, Error)]
pub enum CurvedModelError {
    /// The output's name tells no format.
    #[error("curved levels are written as .clod or .json, one of them as .obj, .ply or .glb")]
    UnknownOutput,
    /// The input's name tells no format.
    #[error(
        "models are read from .ply, .obj, .stl, .off, .gltf and .glb files, patches from .bez, .bpt and .txt files, levels from .clod files"
    )]
    Unknown,
    /// The system says no.
    #[error("cannot be read")]
    Unreadable(#[from] io::Error),
    /// All control points of a patch are one.
    #[error("patch {0} is a single point")]
    Point(usize),
    /// A polygonal model is at fault.
    #[error(transparent)]
    Polygons(#[from] polygonal_model::ModelError),
    /// A file of patches is at fault.
    #[error(transparent)]
    Patches(#[from] BezierError),
    /// No patches can be fitted.
    #[error(transparent)]
    NoModel(#[from] model::ModelError),
    /// The bytes of a file of levels are not of its format.
    #[error("not a readable .clod file")]
    MalformedLevels(#[from] CurvedError),
    /// A file of levels cannot hold these.
    #[error("a .clod file cannot hold these levels")]
    Unwritable(#[from] EncodeError),
    /// There are no triangles within the tolerance.
    #[error(transparent)]
    Tessellation(#[from] TessellationError),
    /// It has fewer levels.
    #[error("there is no level {level}: levels go from 0, the finest, to {last}")]
    NoSuchLevel {
        /// The level asked for.
        level: usize,
        /// The coarsest that there is.
        last: usize,
    },
    /// Each level that is coarse enough is too far off.
    #[error("no level with so few patches is within {0}")]
    NoLevelWithin(f64),
}
