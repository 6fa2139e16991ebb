//! Where an edge is cut into chords: a function of its curve and its factor alone, so that both patches of an edge have the
//! same points on it, bit for bit.
//!
//! The curve is taken in its *canonical* direction, in which the first control point that differs from its counterpart on the
//! way back is the lesser one. A factor is a whole number of even pieces, or any number from 1 on where points are to move in
//! gradually:
//!
//! ```text
//!  factor 4    ●───────●───────●───────●───────●
//!       4.6    ●─●─────●─●─────●─────●─●─────●─●     a new point leaves its neighbour towards the nearer end,
//!       6      ●─────●─●─────●─●─●─────●─●─────●     so that the longest piece is 1/factor
//!       8      ●───●───●───●───●───●───●───●───●
//! ```

use glam::DVec3;

use crate::curved::patch::split_cubic;

/// Where an edge is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeCuts {
    /// Growing from 0 to 1, in the canonical direction.
    pub parameters: Vec<f64>,
    /// Whether points that are there at one factor stay at twice it, so that each is reached from one side.
    is_gradual: bool,
}

impl EdgeCuts {
    /// Even pieces.
    #[must_use]
    pub fn even(pieces: u32) -> Self {
        Self {
            parameters: (0..=pieces).map(|place| f64::from(place) / f64::from(pieces)).collect(),
            is_gradual: false,
        }
    }

    /// Pieces of which none is longer than `1 / factor`, and whose ends are continuous in it.
    #[must_use]
    pub fn gradual(factor: f64) -> Self {
        let Steps { count, moved } = Steps::gradual(factor);
        let place = |place: u32| {
            let from = match place {
                _ if place.is_multiple_of(2) => place,
                _ if place <= count / 2 => place - 1,
                _ => place + 1,
            };
            let [from, to] = [from, place].map(|place| f64::from(place) / f64::from(count));
            from + moved * (to - from)
        };
        let parameters = if count == 1 {
            vec![0.0, 1.0]
        } else {
            (0..=count).map(place).collect()
        };
        Self {
            parameters,
            is_gradual: true,
        }
    }

    /// How many pieces there are.
    #[must_use]
    pub fn pieces(&self) -> u32 {
        self.parameters.len() as u32 - 1
    }

    /// The points between the curve's ends, in the canonical direction.
    pub fn points(&self, curve: [DVec3; 4]) -> impl Iterator<Item = DVec3> {
        let curve = canonical(curve).0;
        let inner = &self.parameters[1..self.parameters.len() - 1];
        inner.iter().map(move |&t| split_cubic(curve, t).0[3])
    }

    /// The point that stands for place `slot` of a lattice that has `slots` steps along the edge, no fewer than there are
    /// pieces; both counted in the canonical direction. Every point stands for a place, and those near an end are the end.
    pub(crate) fn nearest(&self, slot: u32, slots: u32) -> u32 {
        let pieces = self.pieces();
        let is_near_end = 2 * slot > slots;
        let [from_near, slot] = if is_near_end { [pieces, slots - slot] } else { [0, slot] };
        let (place, slots) = (u64::from(slot) * u64::from(pieces), u64::from(slots));
        let place = match self.is_gradual {
            true => place / slots,
            false => (2 * place + slots - 1) / (2 * slots),
        };
        from_near.abs_diff(place as u32)
    }
}

/// Steps of a lattice, and how far every second place of it moved from where it was in one of half the steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steps {
    pub(crate) count: u32,
    /// From 0 to 1.
    pub(crate) moved: f64,
}

impl Steps {
    /// The power of two from `factor` on. The longest of the pieces that a point on its way makes is `1 / factor`.
    pub(crate) fn gradual(factor: f64) -> Self {
        let count = (factor.ceil() as u32).next_power_of_two();
        let before = f64::from(count) / 2.0;
        Self {
            count,
            moved: 2.0 * (1.0 - before / factor).clamp(0.0, 0.5),
        }
    }
}

/// A curve in its canonical direction, and whether that is the other way round.
#[must_use]
pub fn canonical(curve: [DVec3; 4]) -> ([DVec3; 4], bool) {
    let [a, b, c, d] = curve;
    let numbers = [a.to_array(), b.to_array()];
    let back = [d.to_array(), c.to_array()];
    let orders = numbers.as_flattened().iter().zip(back.as_flattened());
    let is_reversed = orders
        .map(|(own, back)| own.total_cmp(back))
        .find(|order| order.is_ne());
    match is_reversed {
        Some(order) if order.is_gt() => ([d, c, b, a], true),
        _ => (curve, false),
    }
}

#[cfg(test)]
#[path = "edge_cuts_tests.rs"]
mod tests;
