//! Choosing collapses so that one forest split undoes as many of them as possible.
//!
//! ```text
//! queues ← every collapse of an edge, by cost: those that add to a tree, and those that begin one
//! until both are empty:
//!     take the cheapest of the first queue, or else of the second; pass over it if it no longer fits the forest
//!     perform it; queue what fits of the edges around it
//! ```
//!
//! Trees grow before new ones begin, because two trees keep the vertices between them from both.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::Surface;
use super::batch::Collapsing;
use super::forest::Candidate;

/// Chooses collapses that make one forest, until there are none left that fit: where the surface allows it, nearly as many
/// as leave half of its vertices. Of those that fit, the one of the smallest cost is next.
///
/// `cost` is asked with the blue vertex, the red one and the triangles around the blue vertex that would have the red one in
/// its place; None forbids the collapse.
pub fn largest_batch(fine: &Surface, cost: impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64>) -> Vec<[u32; 2]> {
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

    /// Performs a collapse if it is still what was queued.
    fn perform(&mut self, queued: Queued) -> Option<[u32; 2]> {
        let candidate = self.collapsing.candidate(queued.ends)?;
        if self.cost_if_it_fits(candidate) != Some(queued.cost) {
            return None;
        }
        self.collapsing.perform(candidate);
        let changed = [candidate.red].into_iter().chain(candidate.wings);
        changed.for_each(|vertex| self.enqueue_around(vertex));
        Some(queued.ends)
    }

    fn enqueue_around(&mut self, vertex: u32) {
        if !self.collapsing.fine.is_virtual(vertex) {
            let neighbours = self.neighbours(vertex).into_iter();
            // Looked at from the neighbour, which more seldom has many triangles around it.
            neighbours.for_each(|other| self.enqueue([other, vertex]));
        }
    }

    /// Puts both collapses of an edge into their queues as far as they fit. What does not fit now will not before it is
    /// queued again: that takes a change at one of its ends.
    fn enqueue(&mut self, ends: [u32; 2]) {
        let Some(candidate) = self.collapsing.candidate(ends) else {
            return;
        };
        for candidate in [candidate, candidate.reversed()] {
            let Some(cost) = self.cost_if_it_fits(candidate) else {
                continue;
            };
            let ends = [candidate.blue, candidate.red];
            let queue = match self.collapsing.forest.touches(candidate) {
                true => &mut self.growing,
                false => &mut self.beginning,
            };
            queue.push(Reverse(Queued { cost, ends }));
        }
    }

    /// The cost of a collapse that may be performed and fits the forest; what is cheap to find out comes first.
    fn cost_if_it_fits(&mut self, candidate: Candidate) -> Option<f64> {
        if !self.collapsing.forest.admits(candidate) {
            return None;
        }
        self.collapsing.look([candidate.blue, candidate.red]).ok()?;
        self.cost(candidate)
    }

    /// The neighbours of a vertex, virtual ones left out.
    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let Collapsing { connectivity, fine, .. } = &self.collapsing;
        let corners = connectivity
            .star(vertex)
            .flat_map(|triangle| connectivity.corners(triangle));
        let mut neighbours: Vec<u32> = corners
            .filter(|&other| other != vertex && !fine.is_virtual(other))
            .collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
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
