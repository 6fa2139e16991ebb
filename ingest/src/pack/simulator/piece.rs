//! A tile's surface in a local frame.

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::Geodetic;
use terrain_codec::tile::{Detail, Tile};

use super::frame::Frame;

/// Triangles of one tile, counter-clockwise as seen from above.
pub(super) struct Piece {
    /// Metres in the frame, on its lattice.
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Least and greatest coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Piece {
    pub(super) fn of(tile: &Tile, detail: Detail, frame: &Frame) -> Self {
        let mesh = tile.surface(detail);
        let place = |&position: &DVec3| frame.rounded(frame.local(west_of_antimeridian(tile.geodetic(position))));
        Self {
            positions: mesh.positions.iter().map(place).collect(),
            triangles: mesh.triangles,
        }
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        let first = *self.positions.first()?;
        let (low, high) = self
            .positions
            .iter()
            .fold((first, first), |(low, high), &at| (low.min(at), high.max(at)));
        Some(Bounds { low, high })
    }

    pub(super) fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.positions[vertex as usize])
    }

    /// Metres along the longest edge.
    pub(super) fn longest(&self) -> f64 {
        let of_triangle = |&triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(triangle);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        self.triangles.iter().map(of_triangle).fold(0.0, f64::max)
    }

    /// Metres up for a metre across, at most; infinity where a triangle is upright.
    pub(super) fn steepest(&self, frame: &Frame) -> f64 {
        let slope = |&triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(triangle);
            let normal = (b - a).cross(c - a);
            let up = frame.up(a);
            let across = normal.cross(up).length();
            if across == 0.0 {
                0.0
            } else {
                across / normal.dot(up).max(0.0)
            }
        };
        self.triangles.iter().map(slope).fold(0.0, f64::max)
    }
}

impl Bounds {
    /// Whether it meets a rectangle in plan.
    pub(super) fn meets(&self, [low, high]: [DVec2; 2]) -> bool {
        self.low.truncate().cmple(high).all() && self.high.truncate().cmpge(low).all()
    }
}

/// The antimeridian is one line, whichever tile asks.
fn west_of_antimeridian(place: Geodetic) -> Geodetic {
    if place.longitude < 180.0 {
        return place;
    }
    Geodetic {
        longitude: place.longitude - 360.0,
        ..place
    }
}
