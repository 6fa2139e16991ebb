//! Thinning without a log: collapses, and edits that make room for further ones, edge swaps and vertex moves.
//!
//! ```text
//! collapse until nothing can be
//! as often as the quality asks:
//!     swap edges and move vertices where that lowers the sum of squared differences
//!     collapse what can be now
//! ```

use glam::DVec2;

use crate::height_field::collapse::{Place, Scratch};
use crate::height_field::filters::is_upright;
use crate::height_field::reference::Bound;
use crate::height_field::simplify::{Allowance, Quality, Simplifier, VertexKind};
use crate::topology::half_edges::NONE;

/// What the sum of squares must fall to for an edit to be worth it, as a share.
const GAIN: f64 = 0.99;
/// Steps of vertex moves in each pass, as shares of the distance to the nearest neighbour.
const STEPS: [f64; 4] = [0.3, 0.3, 0.15, 0.3];

impl Simplifier<'_> {
    /// Collapses what is allowed without recording it, and what edits make possible.
    pub fn thin(&mut self, allowance: Allowance) {
        self.try_all();
        while self.round(allowance, false) > 0 && self.quality != Quality::Fast {}
        if self.quality == Quality::Best {
            for step in STEPS {
                self.swap_edges(allowance.vertical);
                self.move_vertices(allowance.vertical, step);
                while self.round(allowance, false) > 0 {}
            }
        }
    }

    fn swap_edges(&mut self, tolerance: f64) {
        let mut scratch = std::mem::take(&mut self.scratch);
        for edge in 0..3 * self.surface.connectivity.triangle_slots() {
            self.swap_edge(edge, tolerance, &mut scratch);
        }
        self.scratch = scratch;
    }

    /// Swaps an edge if that is allowed and lowers the sum of squares.
    ///
    /// The fan from `c` over `a`, `d`, `b` is the quadrilateral after the swap, the one from `a` over `d`, `b`, `c` before.
    fn swap_edge(&mut self, edge: u32, tolerance: f64, scratch: &mut Scratch) {
        let connectivity = &self.surface.connectivity;
        let twin = connectivity.twin(edge);
        if twin == NONE || twin < edge {
            return;
        }
        let [a, b, c, d] = connectivity.quadrilateral(edge);
        if !self.may_swap([a, b, c, d]) {
            return;
        }
        scratch.clear_samples();
        for triangle in [edge / 3, twin / 3] {
            self.samples
                .gather(self.surface.reference, triangle, &mut scratch.samples);
        }
        let before = self.squares_around([a, b], [d, b, c], f64::INFINITY, scratch);
        let after = self.squares_around([c, d], [a, d, b], tolerance, scratch);
        let is_better = before.zip(after).is_some_and(|(before, after)| after < before * GAIN);
        if !is_better {
            return;
        }
        for triangle in [edge / 3, twin / 3] {
            self.samples.clear(triangle);
        }
        self.surface.connectivity.flip(edge);
        self.lay_samples(c, scratch);
        [a, b, c, d].into_iter().for_each(|vertex| self.try_again(vertex));
    }

    /// Whether the edge `a → b` can become `c → d`: both triangles upright, no line of the strip or outline broken.
    fn may_swap(&self, [a, b, c, d]: [u32; 4]) -> bool {
        let kind = |vertex: u32| self.kinds[vertex as usize];
        let plan = |vertex: u32| self.surface.plan(vertex);
        let least = self.shape.least_altitude;
        (kind(a) == VertexKind::Free || kind(b) == VertexKind::Free)
            && is_upright(plan(c), plan(a), plan(d), least)
            && is_upright(plan(c), plan(d), plan(b), least)
    }

    /// Sum of squares of a quadrilateral with its diagonal: of the fan from the diagonal's start over the other corners,
    /// and along the diagonal; none where it is beyond the tolerance.
    fn squares_around(&self, diagonal: [u32; 2], ring: [u32; 3], tolerance: f64, scratch: &mut Scratch) -> Option<f64> {
        scratch.ring.clear(false);
        ring.into_iter()
            .for_each(|vertex| scratch.ring.push(&self.surface, vertex));
        let [start, end] = diagonal.map(|vertex| self.surface.point(vertex));
        let reference = self.surface.reference;
        let at_samples = scratch.squares(reference, start, tolerance)?;
        let along = match reference.bound {
            Bound::Samples => 0.0,
            Bound::Surface => reference.edge_squares(start, end, tolerance)?,
        };
        Some(at_samples + along)
    }

    fn move_vertices(&mut self, tolerance: f64, step: f64) {
        let mut scratch = std::mem::take(&mut self.scratch);
        for vertex in 0..self.kinds.len() as u32 {
            self.move_vertex(vertex, tolerance, step, &mut scratch);
        }
        self.scratch = scratch;
    }

    /// Moves a vertex in plan where that lowers the sum of squares.
    fn move_vertex(&mut self, vertex: u32, tolerance: f64, step: f64, scratch: &mut Scratch) {
        if self.kinds[vertex as usize] != VertexKind::Free || !self.surface.connectivity.is_live(vertex) {
            return;
        }
        scratch.clear_samples();
        self.gather_around(vertex, &mut scratch.samples);
        scratch.ring.surround(&self.surface, vertex);
        let start = self.surface.plan(vertex);
        let Some(present) = self.fit(start, self.surface.grid(vertex), tolerance, scratch) else {
            return;
        };
        let best = self.better_place(present, tolerance, step, scratch);
        if best.squares >= present.squares * GAIN {
            return;
        }
        self.clear_samples(vertex);
        self.surface.put(vertex, best.plan, best.point);
        self.lay_samples(vertex, scratch);
        for &neighbour in &scratch.ring.vertices {
            self.try_again(neighbour);
        }
        self.try_again(vertex);
    }

    fn better_place(&self, present: Place, tolerance: f64, step: f64, scratch: &mut Scratch) -> Place {
        let nearest = scratch
            .ring
            .plan
            .iter()
            .map(|plan| plan.distance(present.plan))
            .fold(f64::INFINITY, f64::min);
        let step = (nearest * step).round().max(1.0);
        let mut best = present;
        for direction in [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y] {
            let plan = (best.plan + direction * step).round();
            if let Some(place) = self.fit(plan, self.surface.reference.plan.grid(plan), tolerance, scratch)
                && place.squares < best.squares
            {
                best = place;
            }
        }
        best
    }
}
