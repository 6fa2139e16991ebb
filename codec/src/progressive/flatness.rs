//! Which collapse of an edge changes a surface least, for collapses that only the codec sees.

use glam::DVec3;
use terrain_core::topology::connectivity::Connectivity;

/// Both ends of such a collapse have at most this many triangles together.
const MAX_TRIANGLES: usize = 20;
/// Cosine of the largest angle by which a triangle may turn.
const LEAST_COSINE: f64 = 0.3;
/// What a longer edge costs where the surface is flat.
const LENGTH_SHARE: f64 = 1e-3;

/// Triangles around a vertex and what is on their other edges.
#[derive(Debug, Default)]
pub(super) struct Neighbourhood {
    triangles: Vec<u32>,
    /// Both other corners of each triangle, growing: those along the boundary are there once.
    corners: Vec<u32>,
}

impl Neighbourhood {
    pub(super) fn gather(&mut self, connectivity: &Connectivity, vertex: u32) {
        self.triangles.clear();
        self.triangles.extend(connectivity.star(vertex));
        self.corners.clear();
        for &triangle in &self.triangles {
            let others = connectivity
                .corners(triangle)
                .into_iter()
                .filter(|&corner| corner != vertex);
            self.corners.extend(others);
        }
        self.corners.sort_unstable();
    }

    /// Each neighbour once, growing.
    pub(super) fn neighbours(&self) -> impl Iterator<Item = u32> + '_ {
        self.corners.chunk_by(|a, b| a == b).map(|same| same[0])
    }

    fn along_boundary(&self) -> impl Iterator<Item = u32> + '_ {
        self.corners
            .chunk_by(|a, b| a == b)
            .filter(|same| same.len() == 1)
            .map(|same| same[0])
    }

    /// Whether the boundary passes.
    pub(super) fn is_open(&self) -> bool {
        self.along_boundary().next().is_some()
    }

    /// Whether the triangles are one fan, or could be for all that their edges tell.
    pub(super) fn is_disk(&self) -> bool {
        let is_once_or_twice = self.corners.chunk_by(|a, b| a == b).all(|same| same.len() <= 2);
        is_once_or_twice && matches!(self.along_boundary().count(), 0 | 2) && !self.triangles.is_empty()
    }

    /// Whether the vertex that two collapse into has few enough triangles.
    pub(super) fn may_grow(&self, other: &Self) -> bool {
        self.triangles.len() + other.triangles.len() <= MAX_TRIANGLES
    }
}

/// Measures collapses of vertices that stay where they are.
pub(super) struct Flatness<'a> {
    pub(super) positions: &'a [DVec3],
    pub(super) is_height_field: bool,
    /// Whether the outline may change.
    pub(super) may_move_outline: bool,
}

impl Flatness<'_> {
    /// Six times the volume between the surfaces before and after the collapse, and what the boundary moves; none where a
    /// triangle would turn over.
    pub(super) fn cost(&self, connectivity: &Connectivity, around: &Neighbourhood, blue: u32, red: u32) -> Option<f64> {
        let at = |vertex: u32| self.positions[vertex as usize];
        let (from, to) = (at(blue), at(red));
        let mut volume = 0.0;
        for &triangle in &around.triangles {
            let corners = connectivity.corners(triangle);
            let [a, b, c] = corners.map(at);
            if corners.contains(&red) {
                continue;
            }
            let [d, e, f] = corners.map(|corner| if corner == blue { to } else { at(corner) });
            let (before, after) = ((b - a).cross(c - a), (e - d).cross(f - d));
            if !self.keeps_side(before, after) {
                return None;
            }
            volume += after.dot(from - to).abs();
        }
        let length = from.distance(to);
        let swept: f64 = around
            .along_boundary()
            .map(|end| self.area((at(end) - from).cross(to - from)))
            .sum();
        if swept > 0.0 && !self.may_move_outline {
            return None;
        }
        Some(volume + swept * length + LENGTH_SHARE * length * length * length)
    }

    /// In plan, for a height field.
    fn area(&self, normal: DVec3) -> f64 {
        if self.is_height_field {
            normal.z.abs()
        } else {
            normal.length()
        }
    }

    fn keeps_side(&self, before: DVec3, after: DVec3) -> bool {
        if self.is_height_field {
            return after.z > 0.0;
        }
        before.dot(after) > LEAST_COSINE * before.length() * after.length()
    }
}
