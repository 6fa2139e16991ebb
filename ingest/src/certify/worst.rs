//! The largest difference so far: what cannot be larger is not looked into.

use std::cell::Cell;

/// A difference in metres that only grows.
pub(super) struct Worst(Cell<f64>);

impl Worst {
    pub(super) fn new(metres: f64) -> Self {
        Self(Cell::new(metres))
    }

    pub(super) fn get(&self) -> f64 {
        self.0.get()
    }

    pub(super) fn set(&self, metres: f64) {
        self.0.set(metres);
    }

    /// Whether a difference with this bound may be larger; one whose bound is no number may be.
    pub(super) fn may_grow(&self, bound: f64) -> bool {
        bound.is_nan() || bound > self.get()
    }
}
