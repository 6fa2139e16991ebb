//! Where a simulator has the ground: metres east, north and up of an origin on the ellipsoid, flat in space, so that the Earth
//! curves away below.
//!
//! ```text
//! longitude, latitude, height ─▶ Earth-centred ─▶ turned about the origin ─▶ rounded to a lattice
//! ```
//! The lattice is that of a power of two of a metre. Coordinates of a tile about a point of it are whole numbers of steps, so few
//! that single precision holds them: two tiles have a vertex that they share at the same place, to the bit.

use glam::{DMat3, DVec2, DVec3};
use terrain_tiles::address::TileAddress;
use terrain_tiles::ellipsoid::{Geodetic, METRES_IN_A_DEGREE, east_north_up, normal, to_earth_centred, to_geodetic};

use super::super::unusable::Unusable;

/// As far as the ground may be from the origin, degrees: there it falls away by 24 km, and its up is so much from the frame's.
const FARTHEST: f64 = 5.0;
/// The finest lattice has steps of 2 to the power of this, in metres.
const FINEST_STEP: i32 = -10;
/// Whole numbers up to 2 to the power of this are exact in single precision.
const SINGLE_BITS: i32 = 24;
/// A degree is longer nowhere.
const MOST_METRES_IN_A_DEGREE: f64 = 1.01 * METRES_IN_A_DEGREE;

/// A local frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Degrees.
    pub(super) origin: DVec2,
    /// Metres from place to place of the lattice.
    pub(super) step: f64,
    /// Largest angle between the frame's up and the ground's, radians.
    pub(super) tilt: f64,
    earth_centred: DVec3,
    /// Columns east, north, up.
    turn: DMat3,
}

impl Frame {
    /// A frame about `origin` for tiles that are near it, with heights from `low` to `high`.
    pub(super) fn new(origin: DVec2, tiles: &[TileAddress], [low, high]: [f64; 2]) -> Result<Self, Unusable> {
        let up = normal(origin.x, origin.y);
        let least = tiles.iter().flat_map(|&tile| corners(tile));
        let least = least.map(|place| normal(place.x, place.y).dot(up)).fold(1.0, f64::min);
        let tilt = least.clamp(-1.0, 1.0).acos();
        if tilt > FARTHEST.to_radians() {
            return Err(Unusable(format!(
                "the ground reaches {:.1}° from the origin, where a flat frame is no use: {FARTHEST}° at most, give --bbox",
                tilt.to_degrees()
            )));
        }
        let widest = tiles.iter().map(|tile| tile.degrees()).fold(0.0, f64::max);
        let extent = widest * MOST_METRES_IN_A_DEGREE + (high - low);
        let coarse_enough = (extent.log2() - f64::from(SINGLE_BITS)).ceil() as i32;
        Ok(Self {
            origin,
            step: 2_f64.powi(coarse_enough.max(FINEST_STEP)),
            tilt,
            earth_centred: to_earth_centred(at(origin, 0.0)),
            turn: east_north_up(origin.x, origin.y),
        })
    }

    /// Metres east, north and up of the origin, not rounded.
    pub(super) fn local(&self, place: Geodetic) -> DVec3 {
        self.turn.transpose() * (to_earth_centred(place) - self.earth_centred)
    }

    /// The nearest place of the lattice.
    pub(super) fn rounded(&self, local: DVec3) -> DVec3 {
        (local / self.step).round() * self.step
    }

    /// By how much a surface may move along the vertical when its vertices go to the lattice, where it is no steeper than `steepest`.
    pub(super) fn rounding(&self, steepest: f64) -> f64 {
        self.step / 2.0 * 3_f64.sqrt() * (1.0 + steepest)
    }

    /// The vertical at a point of the frame.
    pub(super) fn up(&self, local: DVec3) -> DVec3 {
        let place = to_geodetic(self.earth_centred + self.turn * local);
        self.turn.transpose() * normal(place.longitude, place.latitude)
    }

    /// By what factor a distance along the vertical between two surfaces may be more than their largest one along the frame's up, if
    /// one of them is no steeper than `steepest` in the frame: whoever goes up along the one goes sideways along the other.
    pub(super) fn leaning(&self, steepest: f64) -> f64 {
        let steepest_here = (steepest.atan() + self.tilt).tan();
        if steepest_here < 0.0 {
            return f64::INFINITY;
        }
        1.0 + self.tilt.sin() * steepest_here
    }
}

/// The same place, at a height.
pub(super) fn at(place: DVec2, height: f64) -> Geodetic {
    Geodetic {
        longitude: place.x,
        latitude: place.y,
        height,
    }
}

fn corners(tile: TileAddress) -> [DVec2; 4] {
    let low = DVec2::new(tile.west(), tile.south());
    [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|corner| low + tile.degrees() * corner)
}

#[cfg(test)]
#[path = "frame_tests.rs"]
mod tests;
