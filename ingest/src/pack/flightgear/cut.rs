//! Triangles cut where a bucket ends. What is cut is cut in space, where edges are straight, so that both buckets have the same points
//! on their common side.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::to_geodetic;

/// Steps by which an edge's part is halved until it is where a parallel is: to a millionth of a millimetre.
const HALVINGS: u32 = 50;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    /// Earth-centred metres.
    pub(super) position: DVec3,
    /// Unit normal, Earth-centred.
    pub(super) normal: DVec3,
    /// Degrees.
    place: DVec2,
}

impl Corner {
    pub(super) fn new(position: DVec3, normal: DVec3) -> Self {
        let place = to_geodetic(position);
        Self {
            position,
            normal,
            place: DVec2::new(place.longitude, place.latitude),
        }
    }

    fn between(one: &Self, other: &Self, part: f64) -> Self {
        Self::new(
            one.position.lerp(other.position, part),
            one.normal.lerp(other.normal, part).normalize(),
        )
    }
}

/// What is left of triangles in a bucket.
#[derive(Default)]
pub(super) struct Cut {
    pub(super) corners: Vec<Corner>,
    /// Of each material, three corners a triangle.
    pub(super) triangles: Vec<(usize, [u32; 3])>,
    known: HashMap<[u64; 3], u32>,
}

impl Cut {
    /// Takes the part of a triangle that is inside west, south, east, north.
    pub(super) fn add(&mut self, triangle: [Corner; 3], [west, south, east, north]: [f64; 4], material: usize) {
        let middle = west.midpoint(east);
        // The same longitudes as the bucket's, where the triangle is across the antimeridian from it.
        let near = triangle.map(|corner| Corner {
            place: DVec2::new(
                corner.place.x + 360.0 * ((middle - corner.place.x) / 360.0).round(),
                corner.place.y,
            ),
            ..corner
        });
        let mut polygon = near.to_vec();
        for side in [
            Side::East(west),
            Side::West(east),
            Side::North(south),
            Side::South(north),
        ] {
            polygon = clipped(&polygon, side, middle);
        }
        let corners: Vec<u32> = polygon.iter().map(|corner| self.index(corner)).collect();
        for pair in corners.get(1..).unwrap_or_default().windows(2) {
            let triangle = [corners[0], pair[0], pair[1]];
            let is_flat = triangle[0] == pair[0] || triangle[0] == pair[1] || pair[0] == pair[1];
            if !is_flat {
                self.triangles.push((material, triangle));
            }
        }
    }

    fn index(&mut self, corner: &Corner) -> u32 {
        let key = corner.position.to_array().map(f64::to_bits);
        *self.known.entry(key).or_insert_with(|| {
            self.corners.push(*corner);
            self.corners.len() as u32 - 1
        })
    }
}

/// What stays: the part of the Earth east of a meridian, and so on.
#[derive(Clone, Copy)]
enum Side {
    East(f64),
    West(f64),
    North(f64),
    South(f64),
}

impl Side {
    /// Degrees inside.
    fn depth(self, place: DVec2) -> f64 {
        match self {
            Self::East(meridian) => place.x - meridian,
            Self::West(meridian) => meridian - place.x,
            Self::North(parallel) => place.y - parallel,
            Self::South(parallel) => parallel - place.y,
        }
    }

    /// The point of an edge where it crosses, the same whichever end comes first.
    fn crossing(self, one: &Corner, other: &Corner, middle: f64) -> Corner {
        let key = |corner: &Corner| corner.position.to_array().map(f64::to_bits);
        let (first, last) = if key(one) < key(other) {
            (one, other)
        } else {
            (other, one)
        };
        let part = match self {
            Self::East(meridian) | Self::West(meridian) => {
                // A meridian is in a plane with the Earth's axis; that of 180° is the one of −180°, to the bit.
                let same = if meridian >= 180.0 { meridian - 360.0 } else { meridian };
                let (sine, cosine) = same.to_radians().sin_cos();
                let beside = |corner: &Corner| corner.position.y * cosine - corner.position.x * sine;
                let (from, to) = (beside(first), beside(last));
                from / (from - to)
            }
            Self::North(parallel) | Self::South(parallel) => {
                let is_north = |part: f64| to_geodetic(first.position.lerp(last.position, part)).latitude >= parallel;
                let (begins_north, mut low, mut high) = (is_north(0.0), 0.0_f64, 1.0_f64);
                for _ in 0..HALVINGS {
                    let between = low.midpoint(high);
                    let end = if is_north(between) == begins_north {
                        &mut low
                    } else {
                        &mut high
                    };
                    *end = between;
                }
                low.midpoint(high)
            }
        };
        let mut corner = Corner::between(first, last, part);
        corner.place.x += 360.0 * ((middle - corner.place.x) / 360.0).round();
        // It is on the line, whatever rounding says.
        match self {
            Self::East(meridian) | Self::West(meridian) => corner.place.x = meridian,
            Self::North(parallel) | Self::South(parallel) => corner.place.y = parallel,
        }
        corner
    }
}

/// After I. Sutherland and G. Hodgman, *Reentrant Polygon Clipping*, 1974.
fn clipped(polygon: &[Corner], side: Side, middle: f64) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, corner) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (here, there) = (side.depth(corner.place), side.depth(next.place));
        if here >= 0.0 {
            kept.push(*corner);
        }
        if here > 0.0 && there < 0.0 || here < 0.0 && there > 0.0 {
            kept.push(side.crossing(corner, next, middle));
        }
    }
    kept
}

#[cfg(test)]
#[path = "cut_tests.rs"]
mod tests;
