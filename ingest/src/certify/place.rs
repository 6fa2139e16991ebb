//! A vertex on the Earth and on the raster.

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::{self, Geodetic};

use crate::georeference::GeoReference;

/// Degrees from a pole within which a vertex is there: its longitude is none.
const AT_A_POLE: f64 = 1e-9;

#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) space: DVec3,
    /// The ellipsoid's normal.
    pub(super) up: DVec3,
    pub(super) longitude: f64,
    pub(super) height: f64,
    pub(super) grid: DVec2,
    pub(super) is_pole: bool,
}

impl Place {
    pub(super) fn of(geodetic: Geodetic, georeference: &GeoReference) -> Self {
        Self {
            space: ellipsoid::to_earth_centred(geodetic),
            up: ellipsoid::normal(geodetic.longitude, geodetic.latitude),
            longitude: geodetic.longitude,
            height: geodetic.height,
            grid: georeference.grid(DVec2::new(geodetic.longitude, geodetic.latitude)),
            is_pole: geodetic.latitude.abs() >= 90.0 - AT_A_POLE,
        }
    }
}
