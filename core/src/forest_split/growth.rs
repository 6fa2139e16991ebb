//! Choosing collapses so that one forest split undoes as many of them as possible.
//!
//! ```text
//! queue ← every collapse of an edge, by cost
//! until it is empty:
//!     take the cheapest that may still be performed and fits the forest
//!     if it adds to a tree, or nothing else in the queue does: perform it; queue the edges around it again
//!     else: keep it until then
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
        queue: BinaryHeap::new(),
        new_trees: BinaryHeap::new(),
    };
    (0..fine.vertex_count()).for_each(|vertex| growth.enqueue(vertex));
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
    /// Whether it has to wait for another turn if it would begin a new tree.
    must_grow: bool,
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
    queue: BinaryHeap<Reverse<Queued>>,
    new_trees: BinaryHeap<Reverse<Queued>>,
}

impl<C: Fn(u32, u32, &[[u32; 3]]) -> Option<f64>> Growth<'_, C> {
    fn next(&mut self) -> Option<Queued> {
        let Reverse(queued) = self.queue.pop().or_else(|| self.new_trees.pop())?;
        Some(queued)
    }

    /// Performs a collapse if it is still what was queued, and its turn.
    fn perform(&mut self, queued: Queued) -> Option<[u32; 2]> {
        let candidate = self.collapsing.look(queued.ends).ok()?;
        let is_current = self.cost(candidate) == Some(queued.cost);
        if !is_current || !self.collapsing.forest.admits(candidate) {
            return None;
        }
        if queued.must_grow && !self.collapsing.forest.touches(candidate) {
            let must_grow = false;
            self.new_trees.push(Reverse(Queued { must_grow, ..queued }));
            return None;
        }
        self.collapsing.perform(candidate);
        let changed = [candidate.red].into_iter().chain(candidate.wings);
        changed.for_each(|vertex| self.enqueue(vertex));
        Some(queued.ends)
    }

    /// Puts every edge at `vertex` into the queue, in both directions.
    fn enqueue(&mut self, vertex: u32) {
        if self.collapsing.fine.is_virtual(vertex) {
            return;
        }
        let neighbours = self.neighbours(vertex).into_iter();
        for ends in neighbours.flat_map(|other| [[vertex, other], [other, vertex]]) {
            let Ok(candidate) = self.collapsing.look(ends) else {
                continue;
            };
            let queued = self.cost(candidate).map(|cost| Queued {
                cost,
                ends,
                must_grow: true,
            });
            self.queue.extend(queued.map(Reverse));
        }
    }

    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let connectivity = &self.collapsing.connectivity;
        let corners = connectivity
            .star(vertex)
            .flat_map(|triangle| connectivity.corners(triangle));
        let mut neighbours: Vec<u32> = corners.filter(|&other| other != vertex).collect();
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
