//! The vertices around one, and whether all triangles to them are upright.

use glam::DVec2;

use crate::height_field::filters::is_upright;
use crate::height_field::flat::GridPoint;
use crate::height_field::surface::Surface;
use crate::topology::edge_collapse::Edge;

/// The vertices around one, counter-clockwise, with their places side by side.
#[derive(Default)]
pub(crate) struct Ring {
    pub(crate) vertices: Vec<u32>,
    pub(crate) plan: Vec<DVec2>,
    pub(crate) points: Vec<GridPoint>,
    /// Whether the last is next to the first.
    pub(crate) is_closed: bool,
}

impl Ring {
    pub(crate) fn clear(&mut self, is_closed: bool) {
        self.vertices.clear();
        self.plan.clear();
        self.points.clear();
        self.is_closed = is_closed;
    }

    pub(crate) fn push(&mut self, surface: &Surface, vertex: u32) {
        self.vertices.push(vertex);
        self.plan.push(surface.plan(vertex));
        self.points.push(surface.point(vertex));
    }

    /// Becomes the ring around a vertex of a surface.
    pub(crate) fn surround(&mut self, surface: &Surface, vertex: u32) {
        self.clear(false);
        surface.connectivity.ring(vertex, &mut self.vertices);
        self.is_closed = !self.vertices.is_empty() && !surface.connectivity.is_boundary(vertex);
        self.plan.extend(self.vertices.iter().map(|&other| surface.plan(other)));
        self.points
            .extend(self.vertices.iter().map(|&other| surface.point(other)));
    }

    /// Becomes what will be around the red vertex of an edge when that has collapsed.
    ///
    /// ```text
    ///        x ─── c ─── y
    ///        │   ╱ │ ╲   │        around blue: red c x … d       around red: blue d … y c
    ///        │ blue ▶ red│        ring:        d … y c x …
    ///        │   ╲ │ ╱   │
    ///        … ─── d ─── …
    /// ```
    /// Where the collapse closes a hole, `c` or `d` is its third vertex.
    pub(crate) fn surround_collapsed(&mut self, surface: &Surface, edge: Edge, around_blue: &Self, around_red: &[u32]) {
        let has_both = !edge.is_on_boundary || edge.closes.is_some();
        self.clear(edge.closes.is_some() || !surface.connectivity.is_boundary(edge.red));
        let count = around_blue.vertices.len();
        let (is_first, is_last) = (edge.index == 0, edge.index + 1 == count);
        let is_shared_after = has_both || is_first;
        let is_shared_before = has_both || is_last;
        let first = edge.index + 1 + usize::from(is_shared_after);
        let own = count - 1 - usize::from(is_shared_after) - usize::from(is_shared_before);
        for &vertex in around_red {
            if vertex == edge.blue {
                self.extend_around(around_blue, first, own);
            } else {
                self.push(surface, vertex);
            }
        }
    }

    /// Appends `count` vertices of another ring from the one numbered `first` on, and after its last one its first.
    pub(crate) fn extend_around(&mut self, other: &Self, first: usize, count: usize) {
        let whole = other.vertices.len();
        let first = if first < whole { first } else { first - whole };
        let end = first + count;
        for part in [first..end.min(whole), 0..end.saturating_sub(whole)] {
            self.vertices.extend_from_slice(&other.vertices[part.clone()]);
            self.plan.extend_from_slice(&other.plan[part.clone()]);
            self.points.extend_from_slice(&other.points[part]);
        }
    }

    /// Whether all triangles from `centre` to the ring are counter-clockwise and high enough.
    pub(crate) fn is_seen_from(&self, centre: DVec2, least_altitude: f64) -> bool {
        let (Some(&first), Some(&last)) = (self.plan.first(), self.plan.last()) else {
            return false;
        };
        let wraps = !self.is_closed || is_upright(centre, last, first, least_altitude);
        wraps
            && self
                .plan
                .windows(2)
                .all(|pair| is_upright(centre, pair[0], pair[1], least_altitude))
    }
}
