//! Where a simulator has the ground: metres east, north and up of an origin on the ellipsoid, flat in space, so that the Earth
//! curves away below. Ground that is nowhere on the Earth is where its source has it: on a plane.
//!
//! ```text
//! longitude, latitude, height ─┬─▶ Earth-centred ─▶ turned about the origin ─┬─▶ rounded to a lattice
//!                              └─▶ x, y of the plane, from the origin; height ─┘
//! ```
//! The lattice is that of a power of two of a metre. Coordinates of a tile about a point of it are whole numbers of steps, so few
//! that single precision holds them: two tiles have a vertex that they share at the same place, to the bit.

use anyhow::Context;
use glam::{DAffine2, DMat3, DVec2, DVec3};
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{
    Geodetic, LEAST_CURVATURE_RADIUS, METRES_IN_A_DEGREE, east_north_up, normal, to_earth_centred, to_geodetic,
};

use super::super::unusable::Unusable;
use crate::georeference::{Crs, GeoReference, converted};

/// As far as the ground may be from the origin, degrees: there it falls away by 24 km, and its up is so much from the frame's.
const FARTHEST: f64 = 5.0;
/// The finest lattice has steps of 2 to the power of this, in metres.
const FINEST_STEP: i32 = -10;
/// Whole numbers up to 2 to the power of this are exact in single precision.
const SINGLE_BITS: i32 = 24;
/// A degree is longer nowhere.
const MOST_METRES_IN_A_DEGREE: f64 = 1.01 * METRES_IN_A_DEGREE;

/// The plane's places are tabulated for so many cells along a side, at most, of a metre at least.
const PLANE_CELLS: f64 = 65_536.0;

/// A local frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Degrees.
    pub(super) origin: DVec2,
    /// Metres from place to place of the lattice.
    pub(super) step: f64,
    /// Largest angle between the frame's up and the ground's, radians.
    pub(super) tilt: f64,
    ground: Ground,
}

/// What kind of ground there is.
#[derive(Clone, Debug)]
enum Ground {
    /// The Earth's.
    Earth {
        /// The origin, Earth-centred metres.
        origin: DVec3,
        /// Columns east, north, up.
        turn: DMat3,
    },
    /// Ground that is nowhere on the Earth.
    Plane(Plane),
}

/// The plane that such ground is on.
#[derive(Clone, Debug)]
struct Plane {
    /// From cells of the plane, and back.
    cells: GeoReference,
    /// Metres along the side of a cell.
    side: f64,
    /// The origin in cells.
    origin: DVec2,
    /// The origin in metres of the source.
    metres: DVec2,
}

impl Plane {
    /// Under `tiles`.
    fn new(origin: DVec2, tiles: &[TileAddress]) -> anyhow::Result<Self> {
        let geographic = Crs {
            name: "WGS 84".to_owned(),
            definition: "EPSG:4326".to_owned(),
        };
        let places: Vec<DVec2> = tiles.iter().flat_map(|&tile| corners(tile)).chain([origin]).collect();
        let metres = converted(&geographic, &Crs::laid_plane(), &places)?;
        let low = metres
            .iter()
            .copied()
            .reduce(DVec2::min)
            .context("there are no tiles")?;
        let high = metres.iter().copied().fold(low, DVec2::max);
        let side = ((high - low).max_element() / PLANE_CELLS).max(1.0);
        let first = (low / side).floor() - 1.0;
        let [columns, rows] = ((high / side).ceil() - first + 2.0)
            .to_array()
            .map(|count| count as usize);
        let cells = GeoReference::on_lattice(
            &Crs::laid_plane(),
            DAffine2::from_scale(DVec2::splat(side)),
            first.to_array().map(|cell| cell as i64),
            columns,
            rows,
        )?;
        Ok(Self {
            origin: cells.grid(origin),
            metres: metres[metres.len() - 1],
            cells,
            side,
        })
    }
}

impl Frame {
    /// A frame about `origin` for tiles that are near it, with heights from `low` to `high`.
    /// `is_local` where the ground is nowhere on the Earth.
    pub(super) fn new(
        origin: DVec2,
        tiles: &[TileAddress],
        [low, high]: [f64; 2],
        is_local: bool,
    ) -> anyhow::Result<Self> {
        let up = normal(origin.x, origin.y);
        let least = tiles.iter().flat_map(|&tile| corners(tile));
        let least = least.map(|place| normal(place.x, place.y).dot(up)).fold(1.0, f64::min);
        let tilt = least.clamp(-1.0, 1.0).acos();
        if tilt > FARTHEST.to_radians() {
            anyhow::bail!(Unusable(format!(
                "the ground reaches {:.1}° from the origin, where a flat frame is no use: {FARTHEST}° at most, give --bbox",
                tilt.to_degrees()
            )));
        }
        let ground = if is_local {
            Ground::Plane(Plane::new(origin, tiles)?)
        } else {
            Ground::Earth {
                origin: to_earth_centred(at(origin, 0.0)),
                turn: east_north_up(origin.x, origin.y),
            }
        };
        let widest = tiles.iter().map(|tile| tile.degrees()).fold(0.0, f64::max);
        let extent = widest * MOST_METRES_IN_A_DEGREE + (high - low);
        let coarse_enough = (extent.log2() - f64::from(SINGLE_BITS)).ceil() as i32;
        Ok(Self {
            origin,
            step: 2_f64.powi(coarse_enough.max(FINEST_STEP)),
            tilt: if is_local { 0.0 } else { tilt },
            ground,
        })
    }

    /// The origin in metres of the source's plane, of ground that is nowhere on the Earth.
    pub(super) fn origin_on_plane(&self) -> Option<DVec2> {
        match &self.ground {
            Ground::Earth { .. } => None,
            Ground::Plane(plane) => Some(plane.metres),
        }
    }

    /// Metres east, north and up of the origin, not rounded.
    pub(super) fn local(&self, place: Geodetic) -> DVec3 {
        match &self.ground {
            Ground::Earth { origin, turn } => turn.transpose() * (to_earth_centred(place) - origin),
            Ground::Plane(Plane {
                cells, side, origin, ..
            }) => {
                let cell = cells.grid(DVec2::new(place.longitude, place.latitude));
                ((cell - origin) * side).extend(place.height)
            }
        }
    }

    /// By how much a triangle with such a longest edge, flat in space, is bent on a plane: the sagitta over a circle around it.
    pub(super) fn bend(&self, longest: f64) -> f64 {
        match self.ground {
            Ground::Earth { .. } => 0.0,
            Ground::Plane(_) => longest * longest / (6.0 * LEAST_CURVATURE_RADIUS),
        }
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
        match self.ground {
            Ground::Earth { origin, turn } => {
                let place = to_geodetic(origin + turn * local);
                turn.transpose() * normal(place.longitude, place.latitude)
            }
            Ground::Plane(_) => DVec3::Z,
        }
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
