//! A mesh made ready for measuring, and where in the grid its triangles and edges may lie.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::source::Block;
use super::space::{Foot, Space};

/// A mesh in a [`Space`].
pub(super) struct Surface {
    pub(super) positions: Vec<DVec3>,
    pub(super) feet: Vec<Foot>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Of each triangle.
    footprints: Vec<Footprint>,
    /// Every edge once, in a fixed order.
    edges: Vec<SurfaceEdge>,
}

/// An edge of a mesh.
pub(super) struct SurfaceEdge {
    pub(super) ends: [u32; 2],
    /// How many cells it may stray from the straight path between its feet in the grid.
    pub(super) margin: f64,
}

impl Surface {
    pub(super) fn new(space: &impl Space, positions: Vec<DVec3>, feet: Vec<Foot>, triangles: Vec<[u32; 3]>) -> Self {
        let mut surface = Self {
            positions,
            feet,
            triangles,
            footprints: Vec::new(),
            edges: Vec::new(),
        };
        let footprint = |&corners: &[u32; 3]| surface.footprint_of(space, corners);
        surface.footprints = surface.triangles.iter().map(footprint).collect();
        let edge = |ends| SurfaceEdge {
            ends,
            margin: surface.margin(space, ends),
        };
        surface.edges = edges(&surface.triangles).into_iter().map(edge).collect();
        surface
    }

    /// Positions and feet of an edge's ends, a little inwards where they have no definite place in the grid.
    pub(super) fn ends(&self, space: &impl Space, ends: [u32; 2]) -> ([DVec3; 2], [Foot; 2]) {
        let mut positions = ends.map(|end| self.positions[end as usize]);
        let mut feet = ends.map(|end| self.feet[end as usize]);
        let middle = (positions[0] + positions[1]) / 2.0;
        for (position, foot) in positions.iter_mut().zip(&mut feet) {
            if space.is_singular(*position) {
                *position = space.exactly(*position).lerp(middle, 1e-6);
                *foot = space.foot(*position);
            }
        }
        (positions, feet)
    }

    fn margin(&self, space: &impl Space, ends: [u32; 2]) -> f64 {
        let (positions, feet) = self.ends(space, ends);
        let feet = feet.map(|foot| foot.grid);
        let moved = [0, 1].map(|i| feet[i].distance(self.feet[ends[i] as usize].grid));
        2.0 * bulge(space, positions, feet) + moved[0].max(moved[1]) + 1.0
    }

    /// The ends of all edges.
    pub(super) fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.edges.iter().map(|edge| edge.ends)
    }

    /// The edges that may come into the cells of `block`.
    pub(super) fn edges_near(&self, block: &Block) -> impl Iterator<Item = &SurfaceEdge> {
        self.edges.iter().filter(|edge| {
            let [a, b] = edge.ends.map(|end| self.feet[end as usize].grid);
            block.is_near(a.min(b) - edge.margin, a.max(b) + edge.margin)
        })
    }

    pub(super) fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|corner| self.positions[corner as usize])
    }

    /// The triangles that may lie over `block`, and their footprints.
    pub(super) fn over(&self, block: &Block) -> impl Iterator<Item = ([u32; 3], &Footprint)> {
        let all = self.triangles.iter().copied().zip(&self.footprints);
        all.filter(|(_, footprint)| {
            let (low, high) = footprint.extent();
            block.is_near(low, high)
        })
    }

    /// Lowest and highest column and row that triangles may touch.
    pub(super) fn extent(&self) -> Option<(DVec2, DVec2)> {
        let boxes = self.footprints.iter().map(Footprint::extent);
        boxes.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// The grid positions that a triangle may lie over: straight edges of the space are not straight in the grid, so
    /// the flat triangle of the corners' feet is widened by half as much again as its edges bulge.
    fn footprint_of(&self, space: &impl Space, triangle: [u32; 3]) -> Footprint {
        const AT_LEAST: f64 = 1e-3;
        let corners = triangle.map(|corner| self.feet[corner as usize].grid);
        let positions = self.corners(triangle);
        let bulge = (0..3).map(|i| {
            let next = (i + 1) % 3;
            bulge(space, [positions[i], positions[next]], [corners[i], corners[next]])
        });
        Footprint {
            corners,
            margin: 1.5 * bulge.fold(0.0, f64::max) + AT_LEAST,
        }
    }
}

/// How many cells an edge strays from the straight path between its ends, `feet` in the grid.
pub(super) fn bulge(space: &impl Space, [from, to]: [DVec3; 2], feet: [DVec2; 2]) -> f64 {
    const NEARLY_STRAIGHT: f64 = 0.05;
    let at = |part: f64| {
        let foot = space.foot(from.lerp(to, part)).grid;
        foot.distance(feet[0].lerp(feet[1], part))
    };
    let middle = at(0.5);
    // Near a pole the middle of an edge says little of the rest.
    if middle > NEARLY_STRAIGHT {
        [0.03, 0.25, 0.75, 0.97].into_iter().map(at).fold(middle, f64::max)
    } else {
        middle
    }
}

fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// A triangle in the grid, and by how many cells it is widened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    corners: [DVec2; 3],
    margin: f64,
}

impl Footprint {
    /// Lowest and highest column and row that it may touch.
    fn extent(&self) -> (DVec2, DVec2) {
        let [a, b, c] = self.corners;
        (a.min(b).min(c) - self.margin, a.max(b).max(c) + self.margin)
    }

    /// Those of `rows` that it may touch.
    pub(super) fn rows(&self, rows: &Range<usize>) -> Range<usize> {
        self.widened(self.corners.into_iter().map(|corner| corner.y), rows)
    }

    /// Those of `columns` that it may touch near `row`.
    pub(super) fn columns(&self, row: usize, columns: &Range<usize>) -> Range<usize> {
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
        self.widened(crossings, columns)
    }

    fn widened(&self, values: impl Iterator<Item = f64>, within: &Range<usize>) -> Range<usize> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let first = (low - self.margin).ceil().max(within.start as f64);
        let last = (high + self.margin).floor().min(within.end as f64 - 1.0);
        if first <= last {
            first as usize..last as usize + 1
        } else {
            0..0
        }
    }
}
