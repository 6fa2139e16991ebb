//! Thinning without a log: collapses, and edits that make room for further ones, edge swaps and vertex moves.
//!
//! ```text
//! collapse until nothing can be
//! as often as the quality asks:
//!     swap edges and move vertices where that lowers the sum of squared differences
//!     collapse what can be now
//! ```

use glam::DVec2;

use crate::height_field::filters::is_upright;
use crate::height_field::reference::Bound;
use crate::height_field::rules::{Allowance, Quality, VertexKind};
use crate::height_field::sampled_surface::Place;
use crate::height_field::simplify::Simplifier;
use crate::topology::half_edges::NONE;

/// What the sum of squares must fall to for an edit to be worth it, as a share.
const GAIN: f64 = 0.99;
/// Steps of vertex moves in each pass, as shares of the distance to the nearest neighbour.
const STEPS: [f64; 4] = [0.3, 0.3, 0.15, 0.3];

impl Simplifier<'_> {
    /// Collapses what is allowed without recording it, and what edits make possible.
    pub fn thin(&mut self, allowance: Allowance) {
        self.try_all();
        while self.round(allowance, false) > 0 && self.evaluator.quality != Quality::Fast {}
        if self.evaluator.quality == Quality::Best {
            for step in STEPS {
                self.swap_edges(allowance.vertical);
                self.move_vertices(allowance.vertical, step);
                while self.round(allowance, false) > 0 {}
            }
        }
    }

    fn swap_edges(&mut self, tolerance: f64) {
        for edge in 0..3 * self.sampled.surface.connectivity.triangle_slots() {
            self.swap_edge(edge, tolerance);
        }
    }

    /// Swaps an edge if that is allowed and lowers the sum of squares.
    ///
    /// The fan from `c` over `a`, `d`, `b` is the quadrilateral after the swap, the one from `a` over `d`, `b`, `c` before.
    fn swap_edge(&mut self, edge: u32, tolerance: f64) {
        let connectivity = &self.sampled.surface.connectivity;
        let twin = connectivity.twin(edge);
        if twin == NONE || twin < edge {
            return;
        }
        let [a, b, c, d] = connectivity.quadrilateral(edge);
        if !self.may_swap([a, b, c, d]) {
            return;
        }
        let gathered = &mut self.evaluator.gathered;
        gathered.clear();
        let reference = self.sampled.surface.reference;
        for triangle in [edge / 3, twin / 3] {
            self.sampled
                .samples
                .gather(reference, triangle, &mut gathered.around_blue);
        }
        let before = self.squares_around([a, b], [d, b, c], f64::INFINITY);
        let after = self.squares_around([c, d], [a, d, b], tolerance);
        let is_better = before.zip(after).is_some_and(|(before, after)| after < before * GAIN);
        if is_better {
            self.sampled.flip(edge, &self.evaluator.gathered);
            [a, b, c, d].into_iter().for_each(|vertex| self.try_again(vertex));
        }
    }

    /// Whether the edge `a → b` can become `c → d`: both triangles upright, no line of the strip or outline broken.
    fn may_swap(&self, [a, b, c, d]: [u32; 4]) -> bool {
        let kind = |vertex: u32| self.sampled.kinds[vertex as usize];
        let plan = |vertex: u32| self.sampled.surface.plan(vertex);
        let least = self.evaluator.shape.least_altitude;
        (kind(a) == VertexKind::Free || kind(b) == VertexKind::Free)
            && is_upright(plan(c), plan(a), plan(d), least)
            && is_upright(plan(c), plan(d), plan(b), least)
    }

    /// Sum of squares of a quadrilateral with its diagonal: of the fan from the diagonal's start over the other corners,
    /// and along the diagonal; none where it is beyond the tolerance.
    fn squares_around(&mut self, diagonal: [u32; 2], ring: [u32; 3], tolerance: f64) -> Option<f64> {
        let surface = &self.sampled.surface;
        self.evaluator.ring.clear(false);
        ring.into_iter()
            .for_each(|vertex| self.evaluator.ring.push(surface, vertex));
        let [start, end] = diagonal.map(|vertex| surface.point(vertex));
        let reference = surface.reference;
        let at_samples = self.evaluator.squares(reference, start, tolerance)?;
        let along = match reference.bound {
            Bound::Samples => 0.0,
            Bound::Surface => reference.edge_squares(start, end, tolerance)?,
        };
        Some(at_samples + along)
    }

    fn move_vertices(&mut self, tolerance: f64, step: f64) {
        for vertex in 0..self.sampled.kinds.len() as u32 {
            self.move_vertex(vertex, tolerance, step);
        }
    }

    /// Moves a vertex in plan where that lowers the sum of squares.
    fn move_vertex(&mut self, vertex: u32, tolerance: f64, step: f64) {
        let surface = &self.sampled.surface;
        if self.sampled.kinds[vertex as usize] != VertexKind::Free || !surface.connectivity.is_live(vertex) {
            return;
        }
        self.evaluator.gather(&self.sampled, vertex);
        self.evaluator.ring.surround(surface, vertex);
        let (start, grid) = (surface.plan(vertex), surface.grid(vertex));
        let Some(present) = self.evaluator.fit(surface.reference, start, grid, tolerance) else {
            return;
        };
        let best = self.better_place(present, tolerance, step);
        if best.squares >= present.squares * GAIN {
            return;
        }
        self.sampled.move_to(vertex, &best, &self.evaluator.gathered);
        for place in 0..self.evaluator.ring.vertices.len() {
            self.try_again(self.evaluator.ring.vertices[place]);
        }
        self.try_again(vertex);
    }

    fn better_place(&mut self, present: Place, tolerance: f64, step: f64) -> Place {
        let around = self.evaluator.ring.plan.iter();
        let nearest = around
            .map(|plan| plan.distance(present.plan))
            .fold(f64::INFINITY, f64::min);
        let step = (nearest * step).round().max(1.0);
        let reference = self.sampled.surface.reference;
        let mut best = present;
        for direction in [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y] {
            let plan = (best.plan + direction * step).round();
            if let Some(place) = self
                .evaluator
                .fit(reference, plan, reference.plan.grid(plan), tolerance)
                && place.squares < best.squares
            {
                best = place;
            }
        }
        best
    }
}
