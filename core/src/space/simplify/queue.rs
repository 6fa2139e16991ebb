//! Vertices in the order in which collapses are tried: by rungs of the tolerance that each needs, and on a rung by turns.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Bits of a double below those that make a rung: four rungs to each power of two.
const FINER_BITS: u32 = 50;

/// A range of tolerances, the upper end at most a quarter above the lower one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Rung(u64);

impl Rung {
    /// The one of a tolerance, which is not negative.
    pub(crate) fn of(tolerance: f64) -> Self {
        Self(tolerance.to_bits() >> FINER_BITS)
    }

    pub(crate) fn next(self) -> Self {
        Self(self.0 + 1)
    }

    /// The least tolerance on it.
    pub(crate) fn start(self) -> f64 {
        f64::from_bits(self.0 << FINER_BITS)
    }
}

/// Vertices waiting, each once. On a rung the one that has waited longest comes first: what a collapse has changed is tried
/// again after all others, so that collapses spread over the surface.
#[derive(Clone, Debug)]
pub(crate) struct Queue {
    waiting: BinaryHeap<Reverse<(Rung, u64, u32)>>,
    /// The turn in which each vertex was put there last; 0 for those that do not wait.
    turns: Vec<u64>,
    rungs: Vec<Rung>,
    turn: u64,
}

impl Queue {
    /// Has none of so many vertices.
    pub(crate) fn new(vertex_count: usize) -> Self {
        Self {
            waiting: BinaryHeap::with_capacity(vertex_count),
            turns: vec![0; vertex_count],
            rungs: vec![Rung::of(0.0); vertex_count],
            turn: 0,
        }
    }

    /// Puts a vertex on a rung, wherever it was.
    pub(crate) fn put(&mut self, vertex: u32, rung: Rung) {
        self.turn += 1;
        self.turns[vertex as usize] = self.turn;
        self.rungs[vertex as usize] = rung;
        self.waiting.push(Reverse((rung, self.turn, vertex)));
    }

    /// Takes out the first vertex and its rung.
    pub(crate) fn take(&mut self) -> Option<(Rung, u32)> {
        while let Some(Reverse((rung, turn, vertex))) = self.waiting.pop() {
            if self.turns[vertex as usize] == turn {
                self.turns[vertex as usize] = 0;
                return Some((rung, vertex));
            }
        }
        None
    }

    /// Whether a vertex waits on a later rung, or waits no more: it has then been tried on this one.
    pub(crate) fn is_past(&self, vertex: u32, rung: Rung) -> bool {
        self.turns[vertex as usize] == 0 || self.rungs[vertex as usize] > rung
    }
}

#[cfg(test)]
#[path = "queue_tests.rs"]
mod tests;
