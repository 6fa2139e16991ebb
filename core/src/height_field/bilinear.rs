//! The bilinear surface in a cell, and an edge over a part of it.

use glam::DVec2;

/// The bilinear form of a cell; its twist is NaN where a corner is void.
pub(crate) struct Cell {
    first: DVec2,
    height: f64,
    slope: DVec2,
    twist: f64,
}

impl Cell {
    /// Of the heights at its corners, row by row.
    pub(crate) fn new([column, row]: [usize; 2], [h00, h10, h01, h11]: [f64; 4]) -> Self {
        Self {
            first: DVec2::new(column as f64, row as f64),
            height: h00,
            slope: DVec2::new(h10 - h00, h01 - h00),
            twist: h00 - h10 - h01 + h11,
        }
    }

    /// Whether its four corners have a height.
    pub(crate) fn is_valid(&self) -> bool {
        !self.twist.is_nan()
    }

    pub(crate) fn height(&self, at: DVec2) -> f64 {
        let inside = at - self.first;
        self.height + self.slope.dot(inside) + self.twist * inside.x * inside.y
    }

    /// Of a step in the cell: 4 × the height in its middle below the mean of those at both ends.
    pub(crate) fn bend(&self, step: DVec2) -> f64 {
        self.twist * step.x * step.y
    }
}

/// A part of an edge `a → b` inside one valid cell. Where the edge meets the surface at the parameter
/// `start + s · (end − start)`, the straight line between its ends' heights has the height
/// `first + s · (last − first) − bend · s · (1 − s)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) first: f64,
    pub(crate) last: f64,
    pub(crate) bend: f64,
}

impl Piece {
    /// Differences from an edge between two heights at both ends, and at the summit in between if there is one.
    pub(crate) fn differences(&self, a: f64, b: f64) -> [f64; 3] {
        let first = self.first - (a + self.start * (b - a));
        let last = self.last - (a + self.end * (b - a));
        let rise = last - first;
        let summit = if rise.abs() < self.bend.abs() {
            (first + last) / 2.0 - self.bend / 4.0 - rise * rise / (4.0 * self.bend)
        } else {
            first
        };
        [first, summit, last]
    }

    /// Largest difference from an edge between two heights.
    pub(crate) fn deviation(&self, a: f64, b: f64) -> f64 {
        let [first, summit, last] = self.differences(a, b).map(f64::abs);
        first.max(summit).max(last)
    }

    /// Where the piece differs most from an edge between two heights, away from its ends, and the surface there.
    pub(crate) fn summit_from(&self, a: f64, b: f64) -> (f64, f64) {
        let [first, _, last] = self.differences(a, b);
        let t = self.summit(first, last);
        let share = (t - self.start) / (self.end - self.start);
        (
            t,
            self.first + share * (self.last - self.first) - self.bend * share * (1.0 - share),
        )
    }

    /// The surface at the middle of the piece.
    pub(crate) fn middle(&self) -> f64 {
        (self.first + self.last) / 2.0 - self.bend / 4.0
    }

    /// Where the piece differs most from an edge between two heights: the parameter, and the difference.
    pub(crate) fn worst(&self, a: f64, b: f64) -> (f64, f64) {
        let [first, summit, last] = self.differences(a, b);
        let places = [
            (self.start, first),
            (self.end, last),
            (self.summit(first, last), summit),
        ];
        let larger = |a: (f64, f64), b: (f64, f64)| if b.1.abs() > a.1.abs() { b } else { a };
        places.into_iter().fold((self.start, 0.0), larger)
    }

    pub(crate) fn summit(&self, first: f64, last: f64) -> f64 {
        let share = 0.5 - (last - first) / (2.0 * self.bend);
        self.start + share * (self.end - self.start)
    }
}
