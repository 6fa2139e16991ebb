//! The two priority queues that keep an adaptive surface at a maximum error (Surface Partitions §3).
//!
//! ```text
//! while the largest error of a collapse that can be split is larger than the maximum:    split it
//! while the smallest error of a collapse that can be performed is smaller:               perform it
//! ```
//!
//! Each split or collapse lets others become possible; their errors are asked for and they join the queues. Between
//! refills errors are those of the time when an entry was made. After some views, [`RefinementQueues::refill`]
//! makes both queues anew from what is possible now; that costs as many errors as the surface has such collapses.
//!
//! A collapse of a large error can stay performed for ever under one of a small error that rests on it. Errors that are
//! monotone along the graph rule that out: [`CollapseDag::monotone_errors`](crate::levels::dag::CollapseDag::monotone_errors),
//! or [`NeededSplits`](crate::levels::view_error::NeededSplits) for errors that depend on the view. Otherwise
//! [`AdaptiveSurface::force_split`] is the way.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use crate::levels::adaptive_surface::AdaptiveSurface;

/// A collapse and its error when it joined the queue.
#[derive(Clone, Copy, Debug)]
struct Entry {
    error: f64,
    collapse: u32,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_error = self.error.total_cmp(&other.error);
        by_error.then(self.collapse.cmp(&other.collapse))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// How many collapses were undone.
    pub splits: usize,
    /// How many collapses were performed.
    pub collapses: usize,
    /// Entries that went into the queues or came out of them, and what the splits and collapses looked at: the cost,
    /// but for the logarithm of the queues' lengths.
    pub operations: usize,
}

/// The split queue, largest error first, and the collapse queue, smallest error first.
///
/// An entry whose collapse has changed since stays in its queue and is passed over when it comes up.
#[derive(Clone, Debug)]
pub struct RefinementQueues {
    splits: BinaryHeap<Entry>,
    collapses: BinaryHeap<Reverse<Entry>>,
    /// The error in the latest entry of each collapse.
    errors: Vec<f64>,
}

impl RefinementQueues {
    /// Queues for `surface` as it is now.
    #[must_use]
    pub fn new(surface: &AdaptiveSurface, error: impl Fn(u32) -> f64) -> Self {
        let mut queues = Self {
            splits: BinaryHeap::new(),
            collapses: BinaryHeap::new(),
            errors: vec![0.0; surface.dag().len()],
        };
        queues.refill(surface, error);
        queues
    }

    /// Flushes both queues and fills them with what can be split and performed now, by new errors. Returns how many
    /// entries that makes. An error that is not a number counts as infinite.
    pub fn refill(&mut self, surface: &AdaptiveSurface, error: impl Fn(u32) -> f64) -> usize {
        self.splits.clear();
        self.collapses.clear();
        for &collapse in surface.splittable().iter().chain(surface.collapsible()) {
            self.enter(surface, collapse, &error);
        }
        self.splits.len() + self.collapses.len()
    }

    /// Splits what has an error above `maximum`, then collapses what has one below it, once. `error` is asked for what
    /// joins the queues on the way. Whatever is reached is a consistent surface.
    pub fn update(&mut self, surface: &mut AdaptiveSurface, maximum: f64, error: impl Fn(u32) -> f64) -> Changes {
        let mut changes = Changes::default();
        while let Some(entry) = self.pop_split(maximum) {
            changes.operations += 1;
            if self.is_latest(entry) && surface.split(entry.collapse) {
                changes.splits += 1;
                changes.operations += self.enter_around(surface, entry.collapse, &error);
            }
        }
        while let Some(entry) = self.pop_collapse(maximum) {
            changes.operations += 1;
            if self.is_latest(entry) && surface.collapse(entry.collapse) {
                changes.collapses += 1;
                changes.operations += self.enter_around(surface, entry.collapse, &error);
            }
        }
        changes
    }

    fn pop_split(&mut self, maximum: f64) -> Option<Entry> {
        self.splits.peek().filter(|entry| entry.error > maximum)?;
        self.splits.pop()
    }

    fn pop_collapse(&mut self, maximum: f64) -> Option<Entry> {
        self.collapses.peek().filter(|entry| entry.0.error < maximum)?;
        self.collapses.pop().map(|entry| entry.0)
    }

    fn is_latest(&self, entry: Entry) -> bool {
        self.errors[entry.collapse as usize] == entry.error
    }

    /// Enters what a change of `collapse` made possible: itself, the other way, and its neighbours in the graph.
    /// Returns what that and the change itself cost.
    fn enter_around(&mut self, surface: &AdaptiveSurface, collapse: u32, error: &impl Fn(u32) -> f64) -> usize {
        let dag = surface.dag();
        let around = if surface.is_performed(collapse) {
            dag.split_constraints(collapse)
        } else {
            dag.constraints(collapse)
        };
        let entered = around.iter().chain([&collapse]);
        let entries = entered.filter(|&&entered| self.enter(surface, entered, error)).count();
        surface.cost(collapse) + entries
    }

    fn enter(&mut self, surface: &AdaptiveSurface, collapse: u32, error: &impl Fn(u32) -> f64) -> bool {
        let (can_split, can_collapse) = (surface.can_split(collapse), surface.can_collapse(collapse));
        if can_split || can_collapse {
            let error = Some(error(collapse))
                .filter(|error| !error.is_nan())
                .unwrap_or(f64::INFINITY);
            self.errors[collapse as usize] = error;
            let entry = Entry { error, collapse };
            if can_split {
                self.splits.push(entry);
            } else {
                self.collapses.push(Reverse(entry));
            }
        }
        can_split || can_collapse
    }
}

#[cfg(test)]
#[path = "refinement_queues_tests.rs"]
mod tests;
