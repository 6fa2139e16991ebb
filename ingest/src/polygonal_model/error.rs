//! Why a file is no model, or its levels do not go into another.

use std::io;

use terrain_codec::DecodeError;
use terrain_codec::spm::ProgressiveMeshError;
use terrain_core::topology::manifold::ManifoldError;
use terrain_tiles::formats::lod::LodError;
use terrain_tiles::formats::polygons::PolygonError;
use terrain_tiles::formats::x3d::WorldError;
use thiserror::Error;

/// Why a file is no model.
#[derive(Debug, Error)]
pub enum ModelError {
    /// Its name tells no format.
    #[error("models are read from .ply, .obj, .stl, .off, .gltf and .glb files, levels from .spm and .lod files")]
    Unknown,
    /// The output's name tells no format.
    #[error("levels are written as .spm, .lod, .x3d or .wrl, one of them as .ply")]
    UnknownOutput,
    /// The system says no.
    #[error("cannot be read")]
    Unreadable(#[from] io::Error),
    /// A file of polygons is at fault.
    #[error(transparent)]
    Polygons(#[from] PolygonError),
    /// A multilevel file is at fault.
    #[error(transparent)]
    Levels(#[from] LodError),
    /// The bytes of a progressive mesh file are not of its format.
    #[error("not a readable .spm file")]
    MalformedMesh(#[from] DecodeError),
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} has a coordinate that is no finite number")]
    NotFinite(usize),
    /// A coordinate is too large to reckon with.
    #[error("vertex {0} has a coordinate of more than 1e60; scale the model down")]
    TooFar(usize),
    /// No face has three different positions.
    #[error("has no triangles")]
    NoTriangles,
    /// The coarsest level of a multilevel file has nothing to draw.
    #[error("its coarsest level is empty")]
    EmptyLevel,
    /// It has fewer levels.
    #[error("there is no level {level}: levels go from 0, the finest, to {last}")]
    NoSuchLevel {
        /// The level asked for.
        level: usize,
        /// The coarsest that there is.
        last: usize,
    },
    /// A multilevel file has one position a vertex.
    #[error("its levels move vertices, which a .lod file cannot say; make them with --keep-vertices")]
    MovesVertices,
    /// A progressive mesh file holds surfaces only.
    #[error("a .spm file holds manifolds only, write a .lod or a .ply file: {0}")]
    NoManifold(ManifoldError),
    /// Curved models are fitted to surfaces only.
    #[error("only manifolds are fitted with patches: {0}")]
    NotManifold(ManifoldError),
    /// A progressive mesh file cannot hold the levels.
    #[error("a .spm file cannot hold these levels")]
    Incompressible(#[from] ProgressiveMeshError),
    /// Not even the finest level keeps the error.
    #[error("no lattice of a .spm file is fine enough for the error {0}, write a .lod or a .ply file")]
    TooExact(f64),
    /// A world for X3D browsers cannot hold it.
    #[error(transparent)]
    World(#[from] WorldError),
}
