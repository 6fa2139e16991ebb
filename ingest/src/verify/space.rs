//! The spaces in which triangles are flat: Earth-centred metres for tiles, the raster's own grid for plain meshes.

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::{above, normal, to_geodetic};

use super::source::Source;

/// Metres: smaller than any radius of curvature of the ellipsoid, and of any line of steady height.
const LEAST_RADIUS: f64 = 6.3e6;

/// A point of a mesh seen from above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Column and row.
    pub(super) grid: DVec2,
    /// Metres.
    pub(super) height: f64,
}

/// Where planes are planes.
pub(super) trait Space: Sync {
    /// The direction along which the deviation at a post is measured, of length 1.
    fn vertical(&self, column: usize, row: usize) -> DVec3;
    /// Where a height at a post is; `up` is the vertical there.
    fn position(&self, column: usize, row: usize, up: DVec3, height: f64) -> DVec3;
    /// What is under (or over) a point.
    fn foot(&self, position: DVec3) -> Foot;
    /// Whether the foot of a point has no definite place in the grid: the poles.
    fn is_singular(&self, position: DVec3) -> bool;

    /// Where a position without a definite place is but for rounding, which has a pole on some meridian.
    fn exactly(&self, position: DVec3) -> DVec3;

    /// For a height at a post at a pole, which is on all meridians: the place next to it on its own, and the vertical there. `up`
    /// is the vertical at the post.
    fn beside_a_pole(&self, column: usize, row: usize, up: DVec3, height: f64) -> Option<(DVec3, DVec3)>;

    /// How far a straight line of so many metres is from one of steady height between its ends, at most.
    fn sag(&self, length: f64) -> f64;

    /// Whether a vertical goes on to the ground on the other side of the Earth.
    fn is_round(&self) -> bool;

    /// The verticals at some posts.
    fn verticals(&self, posts: &[(usize, usize)]) -> Vec<DVec3> {
        posts.iter().map(|&(column, row)| self.vertical(column, row)).collect()
    }
}

/// Earth-centred metres.
pub(super) struct Earth<'a> {
    pub(super) source: Source<'a>,
    /// Longitudes are taken from the half-turn on either side of this one: the raster's may exceed 180°.
    pub(super) middle_longitude: f64,
}

impl Space for Earth<'_> {
    fn vertical(&self, column: usize, row: usize) -> DVec3 {
        let place = self.source.geographic(column, row);
        normal(place.x, place.y)
    }

    fn position(&self, _: usize, _: usize, up: DVec3, height: f64) -> DVec3 {
        above(up, height)
    }

    fn foot(&self, position: DVec3) -> Foot {
        let place = to_geodetic(position);
        let turns = ((self.middle_longitude - place.longitude) / 360.0).round();
        let geographic = DVec2::new(place.longitude + 360.0 * turns, place.latitude);
        Foot {
            grid: self.source.georeference.grid(geographic),
            height: place.height,
        }
    }

    fn beside_a_pole(&self, column: usize, row: usize, up: DVec3, height: f64) -> Option<(DVec3, DVec3)> {
        /// Degrees: a decimetre.
        const BESIDE: f64 = 1e-6;
        const AT_IT: f64 = 1e-12;
        (up.truncate().length() < AT_IT).then(|| {
            let place = self.source.geographic(column, row);
            let up = normal(place.x, (90.0 - BESIDE).copysign(place.y));
            (above(up, height), up)
        })
    }

    fn sag(&self, length: f64) -> f64 {
        length * length / (8.0 * LEAST_RADIUS)
    }

    fn is_round(&self) -> bool {
        true
    }

    fn is_singular(&self, position: DVec3) -> bool {
        position.truncate().length_squared() < 1e-4
    }

    fn exactly(&self, position: DVec3) -> DVec3 {
        /// Metres.
        const ROUNDING: f64 = 1e-6;
        let is_rounded = position.truncate().length() < ROUNDING;
        if is_rounded { position * DVec3::Z } else { position }
    }
}

/// Column, row, metres: an affine picture of the raster's own reference system.
pub(super) struct Raster;

impl Space for Raster {
    fn vertical(&self, _: usize, _: usize) -> DVec3 {
        DVec3::Z
    }

    fn position(&self, column: usize, row: usize, _: DVec3, height: f64) -> DVec3 {
        DVec3::new(column as f64, row as f64, height)
    }

    fn foot(&self, position: DVec3) -> Foot {
        Foot {
            grid: position.truncate(),
            height: position.z,
        }
    }

    fn beside_a_pole(&self, _: usize, _: usize, _: DVec3, _: f64) -> Option<(DVec3, DVec3)> {
        None
    }

    fn sag(&self, _: f64) -> f64 {
        0.0
    }

    fn is_round(&self) -> bool {
        false
    }

    fn is_singular(&self, _: DVec3) -> bool {
        false
    }

    fn exactly(&self, position: DVec3) -> DVec3 {
        position
    }
}
