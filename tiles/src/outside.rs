//! What is drawn where nothing was measured, by clients that need a surface everywhere.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use terrain_codec::address::{Rectangle, TileAddress};
use terrain_codec::ellipsoid::{self, Geodetic};

/// What is beside the data and in their holes: a function of the place alone, so that all tiles agree.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "policy")]
pub enum Outside {
    /// The ellipsoid, at height 0, with walls up to the data.
    #[default]
    Ellipsoid,
    /// The sea level, with walls up to the data.
    Geoid {
        /// Its height above the ellipsoid, over the whole Earth.
        field: HeightField,
    },
    /// Ground that goes on from the edge of the data without a wall, and comes down to height 0 farther away.
    Extend {
        /// Heights around the data, 0 beyond.
        field: HeightField,
    },
}

/// Heights on a grid of longitudes and latitudes, bilinear between its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightField {
    /// West, south, east, north in degrees; nodes are on them.
    pub bounds: [f64; 4],
    /// Nodes from west to east.
    pub columns: usize,
    /// Decimetres, row by row from the south, each from the west.
    pub decimetres: Vec<i32>,
}

impl Outside {
    /// Metres above the ellipsoid where nothing was measured.
    pub(crate) fn height(&self, longitude: f64, latitude: f64) -> f64 {
        match self {
            Self::Ellipsoid => 0.0,
            Self::Geoid { field } | Self::Extend { field } => field.height(longitude, latitude),
        }
    }

    /// Degrees around all places where its height may be another one than 0: west, south, east, north.
    pub(crate) fn bounds(&self) -> Option<[f64; 4]> {
        match self {
            Self::Ellipsoid => None,
            Self::Geoid { field } | Self::Extend { field } => Some(field.bounds),
        }
    }

    /// The same at coordinates of 0 … `extent` in a tile's rectangle.
    pub(crate) fn height_in(&self, rectangle: Rectangle, place: [u16; 2], extent: u16) -> f64 {
        let [longitude, latitude] = degrees(rectangle, place, extent);
        self.height(longitude, latitude)
    }

    /// The Earth-centred unit normal there.
    pub(crate) fn normal(&self, rectangle: Rectangle, place: [u16; 2], extent: u16) -> DVec3 {
        let [longitude, latitude] = degrees(rectangle, place, extent);
        // The antimeridian is one place: the sines of its two longitudes differ in sign.
        let longitude = if longitude == 180.0 { -180.0 } else { longitude };
        let Some(detail) = self.detail() else {
            return ellipsoid::normal(longitude, latitude);
        };
        let at = |east: f64, north: f64| {
            let (longitude, latitude) = (longitude + east, (latitude + north).clamp(-90.0, 90.0));
            let height = self.height(longitude, latitude);
            ellipsoid::to_earth_centred(Geodetic {
                longitude,
                latitude,
                height,
            })
        };
        let half = detail / 2.0;
        let across = at(half, 0.0) - at(-half, 0.0);
        let up = at(0.0, half) - at(0.0, -half);
        let normal = across.cross(up).try_normalize();
        normal.unwrap_or_else(|| ellipsoid::normal(longitude, latitude))
    }

    /// Its least and greatest height, metres.
    pub(crate) fn everywhere(&self) -> [f64; 2] {
        match self {
            Self::Ellipsoid => [0.0; 2],
            Self::Geoid { field } | Self::Extend { field } => field.range([0.0; 2], |_, _| true),
        }
    }

    /// No narrower than the range of its heights over a tile's square, metres.
    pub(crate) fn heights_over(&self, address: TileAddress) -> [f64; 2] {
        match self {
            Self::Ellipsoid => [0.0; 2],
            Self::Geoid { field } | Self::Extend { field } => field.range_over(address),
        }
    }

    /// Whether it goes on from the data, at the heights that these have at their edge.
    pub(crate) fn meets_data(&self) -> bool {
        matches!(self, Self::Extend { .. })
    }

    /// Degrees between places at which it is worth to be asked.
    pub(crate) fn detail(&self) -> Option<f64> {
        match self {
            Self::Ellipsoid => None,
            Self::Geoid { field } | Self::Extend { field } => Some(field.steps()[0].min(field.steps()[1])),
        }
    }
}

fn degrees(rectangle: Rectangle, place: [u16; 2], extent: u16) -> [f64; 2] {
    rectangle.place(place.map(|coordinate| f64::from(coordinate) / f64::from(extent)))
}

impl HeightField {
    fn rows(&self) -> usize {
        self.decimetres.len() / self.columns.max(1)
    }

    fn steps(&self) -> [f64; 2] {
        let [west, south, east, north] = self.bounds;
        let steps = |from: f64, to: f64, nodes: usize| (to - from) / (nodes.max(2) - 1) as f64;
        [steps(west, east, self.columns), steps(south, north, self.rows())]
    }

    /// Of the heights of those columns and rows that `is_asked` for, and of `others`.
    fn range(&self, others: [f64; 2], is_asked: impl Fn(usize, usize) -> bool) -> [f64; 2] {
        let nodes = self.decimetres.iter().enumerate();
        let asked = nodes.filter(|&(index, _)| is_asked(index % self.columns, index / self.columns));
        let heights = asked.map(|(_, &height)| f64::from(height) / 10.0);
        heights.fold(others, |[low, high], height| [low.min(height), high.max(height)])
    }

    /// Of the nodes in a tile's square and of those next to it.
    fn range_over(&self, address: TileAddress) -> [f64; 2] {
        let [step_x, step_y] = self.steps();
        let half = address.degrees() / 2.0;
        let middle = [address.west() + half, address.south() + half];
        let is_near = |column: usize, row: usize| {
            let across = self.bounds[0] + column as f64 * step_x - middle[0];
            let across = across - (across / 360.0).round() * 360.0;
            let up = self.bounds[1] + row as f64 * step_y - middle[1];
            across.abs() <= half + step_x && up.abs() <= half + step_y
        };
        // Beside the grid it is 0.
        let others = if self.holds(address) {
            [f64::INFINITY, f64::NEG_INFINITY]
        } else {
            [0.0; 2]
        };
        self.range(others, is_near)
    }

    /// Whether all of a tile's square is over the grid.
    fn holds(&self, address: TileAddress) -> bool {
        let [west, south, east, north] = self.bounds;
        let (near, far) = (address.west(), address.west() + address.degrees());
        let is_across = [0.0, 360.0]
            .iter()
            .any(|turn| west <= near + turn && far + turn <= east);
        is_across && south <= address.south() && address.south() + address.degrees() <= north
    }

    /// Metres; 0 beside the grid.
    fn height(&self, longitude: f64, latitude: f64) -> f64 {
        let [west, south, east, _] = self.bounds;
        let middle = f64::midpoint(west, east);
        let longitude = longitude - ((longitude - middle) / 360.0).round() * 360.0;
        let [step_x, step_y] = self.steps();
        let place = [(longitude - west) / step_x, (latitude - south) / step_y];
        let last = [self.columns, self.rows()].map(|nodes| nodes.saturating_sub(2) as f64);
        if (0..2).any(|axis| !(0.0..=last[axis] + 1.0).contains(&place[axis])) || self.columns < 2 || self.rows() < 2 {
            return 0.0;
        }
        let [column, row] = [0, 1].map(|axis| place[axis].floor().min(last[axis]));
        let (across, up) = (place[0] - column, place[1] - row);
        let node = |x: usize, y: usize| {
            let index = (row as usize + y) * self.columns + column as usize + x;
            f64::from(self.decimetres[index]) / 10.0
        };
        let along = |y: usize| node(0, y) + (node(1, y) - node(0, y)) * across;
        along(0) + (along(1) - along(0)) * up
    }
}

#[cfg(test)]
#[path = "outside_tests.rs"]
mod tests;
