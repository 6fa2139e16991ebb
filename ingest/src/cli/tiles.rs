//! What surfaces are to be.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use terrain_tiles::metadata::OutsidePolicy;

use super::values::positive;

/// What tiles are to be.
#[derive(Args)]
pub(crate) struct TileArgs {
    /// Largest error of the finest tiles, in metres, doubled a zoom upwards. If not given, an eighth of the shorter side of a
    /// cell, rounded to 1, 2 or 5 times a power of ten: 0.1 m for cells of 1 m, 5 m for 30 m, 10 m for 90 m, and 200 m at
    /// most, or what cells of a degree and more bend away from the Earth. Where only coarser rasters are, tiles end at a coarser
    /// zoom and err by an eighth of those rasters' cells, if that is more than this.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) max_error: Option<f64>,
    /// What CesiumJS and its kin see where nothing was measured, around the data and in their holes.
    #[arg(long, value_enum, default_value = "extend")]
    pub(crate) outside: OutsideName,
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
}

/// What surface is made within the error.
#[derive(Args)]
pub(crate) struct SurfaceArgs {
    /// Where the error is bounded.
    #[arg(long, value_enum, default_value = "surface")]
    pub(crate) bound: Bound,
    /// How much work goes into few triangles; the error is the same for all.
    #[arg(long, value_enum, default_value = "default")]
    pub(crate) quality: Quality,
    /// Lines (GeoJSON, Shapefile, FlatGeobuf, GeoPackage) that the surface keeps as edges, at every level of detail: ridges, shores,
    /// walls; of polygons, their rings. They lie on the surface as the raster has it: heights of their own are not used.
    #[arg(long, value_name = "FILE")]
    pub(crate) breaklines: Option<PathBuf>,
}

/// What is where nothing was measured.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum OutsideName {
    /// The ellipsoid, with walls up to the data.
    Ellipsoid,
    /// The sea level, with walls up to the data.
    Geoid,
    /// Ground that goes on from the edge of the data without a wall, and comes down to the ellipsoid as far away as the data are
    /// wide.
    Extend,
}

impl From<OutsideName> for OutsidePolicy {
    fn from(name: OutsideName) -> Self {
        match name {
            OutsideName::Ellipsoid => Self::Ellipsoid,
            OutsideName::Geoid => Self::Geoid,
            OutsideName::Extend => Self::Extend,
        }
    }
}

/// Where an error is bounded.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Bound {
    /// At every point of the surface that is bilinear between samples.
    Surface,
    /// At samples only, as other programs do it: fewer triangles, a weaker promise.
    Samples,
}

/// How much work goes into few triangles.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Quality {
    /// Least time: vertices stay where they are when others collapse into them, and a tile has no level made for an error between its
    /// finest and its coarsest one.
    Fast,
    /// Vertices may go to the middle of an edge that collapses.
    Default,
    /// Fewest triangles: more places, and edges swapped and vertices moved to make room for further collapses.
    Best,
}
