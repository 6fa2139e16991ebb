//! What keeps a raster from having places on the Earth.

use thiserror::Error;

/// Why samples have no longitude and latitude.
#[derive(Debug, Error, PartialEq)]
pub enum GeoReferenceError {
    /// PROJ does not know the coordinate reference system, or no way from it to WGS84.
    #[error(
        "PROJ knows no way from {crs} to WGS84 longitude and latitude: {reason}; --local takes its coordinates for metres on a plane"
    )]
    NoTransformation {
        /// Name of the coordinate reference system.
        crs: String,
        /// What PROJ said.
        reason: String,
    },
    /// Nothing shifts the datum to WGS84 but a grid that is not there.
    #[error(
        "{crs} has its place on the Earth by grids that PROJ does not find: {}; put them into PROJ's folder or one that PROJ_DATA names, \
         or let PROJ fetch them with PROJ_NETWORK=ON", grids.join(", ")
    )]
    MissingGrids {
        /// Name of the coordinate reference system.
        crs: String,
        /// Their names, with addresses.
        grids: Vec<String>,
    },
    /// PROJ gives no finite result at a sample or near the raster's edge.
    #[error("PROJ cannot transform column {column:.1}, row {row:.1} of the grid to WGS84: {reason}")]
    Untransformable {
        /// Grid coordinate.
        column: f64,
        /// Grid coordinate.
        row: f64,
        /// What PROJ said.
        reason: String,
    },
    /// Neighbouring samples lie far apart in longitude or latitude, whatever the resolution of the table.
    #[error("the raster has no continuous longitude and latitude; does it hold an edge of its projection?")]
    Discontinuous,
    /// A row or column beyond 90° north or south.
    #[error("the raster reaches to latitude {0}°, beyond the pole")]
    BeyondPole(f64),
    /// Two samples at one place, or a coordinate that is not finite.
    #[error("the raster's affine transform is degenerate")]
    Degenerate,
}
