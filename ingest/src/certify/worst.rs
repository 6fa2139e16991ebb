//! The largest difference so far: what cannot be larger is not looked into.

use std::cell::Cell;

/// Share by which what is claimed may be more than what was found, so that a wide summit is not searched to its last sample.
const ENOUGH: f64 = 1e-4;

/// A difference in metres that only grows.
#[derive(Clone, Debug)]
pub(super) struct Worst {
    /// Found at a place; minus infinity as long as nothing is.
    found: Cell<f64>,
    /// No place has more.
    claimed: Cell<f64>,
}

impl Worst {
    /// What is no worse than so many metres does not matter.
    pub(super) fn new(metres: f64) -> Self {
        Self {
            found: Cell::new(f64::NEG_INFINITY),
            claimed: Cell::new(metres),
        }
    }

    /// What no place that was looked at has more of.
    pub(super) fn get(&self) -> f64 {
        self.claimed.get()
    }

    /// Takes into account what was found at a place.
    pub(super) fn meet(&self, metres: f64) {
        self.found.set(self.found.get().max(metres));
        self.claimed.set(self.claimed.get().max(metres));
    }

    /// The same, with so many metres less of each.
    pub(super) fn less(&self, metres: f64) -> Self {
        Self {
            found: Cell::new(self.found.get() - metres),
            claimed: Cell::new(self.claimed.get() - metres),
        }
    }

    /// Takes over what came of [`Self::less`], if it has grown.
    pub(super) fn grow(&mut self, less: &Self, metres: f64) {
        self.found.set(self.found.get().max(less.found.get() + metres));
        if less.get() > self.get() - metres {
            self.claimed.set(less.get() + metres);
        }
    }

    /// Whether a difference with this bound may be larger; one whose bound is no number may be.
    pub(super) fn may_grow(&self, bound: f64) -> bool {
        bound.is_nan() || bound > self.get()
    }

    /// Whether what has this bound is to be looked into: it may be larger, and by so much that it is not claimed at once.
    pub(super) fn is_worth_a_look(&self, bound: f64) -> bool {
        let found = self.found.get();
        if self.may_grow(bound) && found > 0.0 && bound <= found * (1.0 + ENOUGH) {
            self.claimed.set(bound);
        }
        self.may_grow(bound)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_floor_that_nothing_was_found_above_is_no_claim() {
        let worst = Worst::new(1.0);
        assert!(worst.is_worth_a_look(1.000_05));
        assert_eq!(worst.get(), 1.0);
        worst.meet(1.000_02);
        assert!(!worst.is_worth_a_look(1.000_05));
        assert_eq!(worst.get(), 1.000_05);
        assert!(worst.is_worth_a_look(1.01));
    }
}
