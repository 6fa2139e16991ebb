//! Choosing collapses so that one forest split undoes as many of them as possible.
//!
//! ```text
//! queues ← every collapse of an edge, by cost: those that add to a tree, and those that begin one
//! until both are empty:
//!     take the cheapest of the first queue, or else of the second; pass over it if it no longer fits the forest
//!     perform it; queue what fits of the edges that it changed
//! ```
//!
//! Trees grow before new ones begin, because two trees keep the vertices between them from both.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::ClosedSurface;
use super::collapsing::Collapsing;
use super::forest::Candidate;

/// Chooses collapses that make one forest, until there are none left that fit: where the surface allows it, nearly as many
/// as leave half of its vertices. Of those that fit, the one of the smallest cost is next.
///
/// `cost` is asked with the blue vertex, the red one and the triangles around the blue vertex that would have the red one in
/// its place; None forbids the collapse.
pub fn largest_batch(fine: &ClosedSurface, cost: impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64>) -> Vec<[u32; 2]> {
    let mut growth = Growth {
        collapsing: Collapsing::new(fine),
        cost,
        growing: BinaryHeap::new(),
        beginning: BinaryHeap::new(),
    };
    for edge in fine.edges() {
        growth.enqueue(edge);
    }
    let mut collapses = Vec::new();
    while let Some(queued) = growth.next() {
        collapses.extend(growth.perform(queued));
    }
    collapses
}

/// A collapse that waits for its turn, by cost and then by its vertices.
#[derive(Clone, Copy, PartialEq)]
struct Queued {
    cost: f64,
    ends: [u32; 2],
}

impl Eq for Queued {}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.ends.cmp(&other.ends))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

struct Growth<'a, C> {
    collapsing: Collapsing<'a>,
    cost: C,
    /// Collapses that add to a tree.
    growing: BinaryHeap<Reverse<Queued>>,
    /// Those that begin one.
    beginning: BinaryHeap<Reverse<Queued>>,
}

impl<C: Fn(u32, u32, &[[u32; 3]]) -> Option<f64>> Growth<'_, C> {
    fn next(&mut self) -> Option<Queued> {
        let Reverse(queued) = self.growing.pop().or_else(|| self.beginning.pop())?;
        Some(queued)
    }

    /// Performs a collapse if it still fits; if its cost is another by now, it has to wait for another turn.
    fn perform(&mut self, queued: Queued) -> Option<[u32; 2]> {
        let candidate = self.collapsing.candidate(queued.ends)?;
        let cost = self.cost_if_it_fits(candidate)?;
        if cost.total_cmp(&queued.cost).is_ne() {
            self.push(candidate, cost);
            return None;
        }
        self.collapsing.perform(candidate);
        self.changed_edges(candidate)
            .into_iter()
            .for_each(|edge| self.enqueue(edge));
        Some(queued.ends)
    }

    /// The edges that a collapse gave another end, and those in a triangle with an edge that it marked: what can begin to
    /// fit is among them. Not all edges of the red vertex are, which may have very many.
    fn changed_edges(&self, Candidate { red, wings, .. }: Candidate) -> Vec<[u32; 2]> {
        let Collapsing { connectivity, fine, .. } = &self.collapsing;
        let moved = self.collapsing.moved().iter().map(|corner| corner / 3);
        let mut edges = Vec::new();
        for [a, b, c] in moved.map(|triangle| connectivity.corners(triangle)) {
            edges.extend([[a, red], [b, red], [c, red]]);
        }
        for wing in wings {
            let around = connectivity.star(wing).map(|triangle| connectivity.corners(triangle));
            for [a, b, c] in around.filter(|corners| corners.contains(&red)) {
                edges.extend([[a, b], [b, c], [c, a]]);
            }
        }
        edges.retain(|&[from, to]| from != to && !fine.is_virtual(from) && !fine.is_virtual(to));
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Puts both collapses of an edge into their queues as far as they fit.
    fn enqueue(&mut self, edge: [u32; 2]) {
        let Some(candidate) = self.collapsing.candidate(edge) else {
            return;
        };
        for candidate in [candidate, candidate.reversed()] {
            if let Some(cost) = self.cost_if_it_fits(candidate) {
                self.push(candidate, cost);
            }
        }
    }

    fn push(&mut self, candidate: Candidate, cost: f64) {
        let ends = [candidate.blue, candidate.red];
        let queue = match self.collapsing.forest.touches(candidate) {
            true => &mut self.growing,
            false => &mut self.beginning,
        };
        queue.push(Reverse(Queued { cost, ends }));
    }

    /// The cost of a collapse that may be performed and fits the forest; what is cheap to find out comes first.
    fn cost_if_it_fits(&mut self, candidate: Candidate) -> Option<f64> {
        if !self.collapsing.forest.admits(candidate) {
            return None;
        }
        self.collapsing.look([candidate.blue, candidate.red]).ok()?;
        self.cost(candidate)
    }

    fn cost(&self, Candidate { blue, red, .. }: Candidate) -> Option<f64> {
        let Collapsing { connectivity, fine, .. } = &self.collapsing;
        let triangles = connectivity.star(blue).map(|triangle| connectivity.corners(triangle));
        let is_kept = |corners: &[u32; 3]| corners.iter().all(|&vertex| vertex != red && !fine.is_virtual(vertex));
        let mut kept: Vec<[u32; 3]> = triangles.filter(is_kept).collect();
        kept.sort_unstable();
        (self.cost)(blue, red, &kept)
    }
}
