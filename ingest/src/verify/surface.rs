//! A mesh made ready for measuring, and the posts that a triangle may cover.

use std::collections::HashSet;
use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};

use super::space::{Foot, Space};

/// A mesh in a [`Space`].
pub(super) struct Surface {
    pub(super) positions: Vec<DVec3>,
    pub(super) feet: Vec<Foot>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Surface {
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|corner| self.positions[corner as usize])
    }

    /// Every edge once, in a fixed order.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The grid positions that a triangle may lie over: straight edges of the space are not straight in the grid, so
    /// the flat triangle of the corners' feet is widened by half as much again as the worst edge bulges at its middle.
    pub(super) fn footprint(&self, space: &impl Space, triangle: [u32; 3]) -> Footprint {
        const AT_LEAST: f64 = 1e-3;
        let corners = triangle.map(|corner| self.feet[corner as usize].grid);
        let positions = self.corners(triangle);
        let bulge = (0..3)
            .map(|i| {
                let middle = space.foot((positions[i] + positions[(i + 1) % 3]) / 2.0).grid;
                middle.distance((corners[i] + corners[(i + 1) % 3]) / 2.0)
            })
            .fold(0.0, f64::max);
        Footprint {
            corners,
            margin: 1.5 * bulge + AT_LEAST,
        }
    }
}

/// Directed edges that no other triangle runs along in the other direction, in the order of the triangles.
pub(super) fn boundary_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let directed = || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: HashSet<[u32; 2]> = directed().collect();
    directed().filter(|&[a, b]| !all.contains(&[b, a])).collect()
}

/// A triangle in the grid, and by how many cells it is widened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    corners: [DVec2; 3],
    margin: f64,
}

impl Footprint {
    /// Rows that it may touch, of the first `count`.
    pub(super) fn rows(&self, count: usize) -> RangeInclusive<usize> {
        let rows = self.corners.map(|corner| corner.y);
        self.widened(rows.into_iter(), count)
    }

    /// Columns that it may touch near `row`, of the first `count`.
    pub(super) fn columns(&self, row: usize, count: usize) -> RangeInclusive<usize> {
        let (low, high) = (row as f64 - self.margin, row as f64 + self.margin);
        let crossings = (0..3).flat_map(|i| {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
            let rise = to.y - from.y;
            let at = |y: f64| from.x + (to.x - from.x) * ((y - from.y) / rise).clamp(0.0, 1.0);
            let touches = from.y.min(to.y) <= high && from.y.max(to.y) >= low;
            let ends = if rise == 0.0 {
                [from.x, to.x]
            } else {
                [at(low), at(high)]
            };
            ends.into_iter().filter(move |_| touches)
        });
        self.widened(crossings, count)
    }

    #[expect(clippy::reversed_empty_ranges, reason = "an empty range is what is meant")]
    fn widened(&self, values: impl Iterator<Item = f64>, count: usize) -> RangeInclusive<usize> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (first, last) = ((low - self.margin).ceil().max(0.0), (high + self.margin).floor());
        if !(first <= last && last >= 0.0) || count == 0 {
            return 1..=0;
        }
        first as usize..=(last as usize).min(count - 1)
    }
}
