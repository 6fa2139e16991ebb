//! Which samples lie in a triangle, and where an edge crosses grid lines: scan conversion in grid coordinates.

use std::ops::Range;

use glam::DVec2;

use crate::reference::ON_A_LINE;

/// Rows over which an edge must run for its slope to be worth anything.
const LEAST_RISE: f64 = 1e-6;

/// An edge of a triangle, from its lower to its higher end.
#[derive(Clone, Copy)]
struct Side {
    low: DVec2,
    high: DVec2,
    /// Columns a row.
    slope: f64,
}

impl Side {
    fn new(a: DVec2, b: DVec2) -> Self {
        let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
        let rise = high.y - low.y;
        Self {
            low,
            high,
            slope: if rise > LEAST_RISE { (high.x - low.x) / rise } else { f64::NAN },
        }
    }

    /// Its columns within rounding of a row.
    fn columns(&self, row: f64) -> Option<[f64; 2]> {
        let (from, to) = (self.low.y.max(row - ON_A_LINE), self.high.y.min(row + ON_A_LINE));
        if from > to {
            None
        } else if self.slope.is_nan() {
            Some([self.low.x, self.high.x])
        } else {
            Some([from, to].map(|y| self.low.x + (y - self.low.y) * self.slope))
        }
    }
}

/// Calls `visit(row, columns)` for each row of a grid of `size` columns and rows with samples in the triangle, or so
/// close to it that rounding cannot tell.
#[inline]
pub(crate) fn visit_rows(corners: [DVec2; 3], size: [usize; 2], mut visit: impl FnMut(usize, Range<usize>)) {
    let [a, b, c] = corners;
    let sides = [Side::new(a, b), Side::new(b, c), Side::new(c, a)];
    let (low, high) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
    for row in whole_numbers(low, high, size[1]) {
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for [first, second] in sides.iter().filter_map(|side| side.columns(row as f64)) {
            from = from.min(first).min(second);
            to = to.max(first).max(second);
        }
        if from <= to {
            visit(row, whole_numbers(from, to, size[0]));
        }
    }
}

/// Whole numbers from `low` to `high`, within rounding, that are indices below `count`.
#[inline]
pub(crate) fn whole_numbers(low: f64, high: f64, count: usize) -> Range<usize> {
    // Truncation is many times faster than `ceil` and `floor` where the processor has no instruction for them.
    let first = (low - ON_A_LINE).max(-0.5);
    let begin = first as usize + usize::from(first > (first as usize) as f64);
    let end = ((high + ON_A_LINE + 1.0).max(0.0) as usize).min(count);
    begin..end.max(begin)
}

/// Calls `visit(start, end)` for the stretches of the edge `a → b`, as growing parameters from 0 to 1, between grid
/// lines.
#[inline]
pub(crate) fn visit_cells(a: DVec2, b: DVec2, mut visit: impl FnMut(f64, f64)) {
    let mut columns = Crossings::new(a.x, b.x);
    let mut rows = Crossings::new(a.y, b.y);
    let mut start = 0.0;
    while start < 1.0 {
        let end = columns.next.min(rows.next).min(1.0);
        columns.pass(end);
        rows.pass(end);
        if end > start {
            visit(start, end);
            start = end;
        }
    }
}

/// Parameters at which a coordinate that runs from `from` to `to` passes whole numbers.
struct Crossings {
    next: f64,
    whole: f64,
    step: f64,
    from: f64,
    per_unit: f64,
}

impl Crossings {
    fn new(from: f64, to: f64) -> Self {
        let step = if to > from { 1.0 } else { -1.0 };
        let whole = if step > 0.0 {
            from.floor() + 1.0
        } else {
            from.ceil() - 1.0
        };
        let per_unit = 1.0 / (to - from);
        let next = if to == from {
            f64::INFINITY
        } else {
            (whole - from) * per_unit
        };
        Self {
            next,
            whole,
            step,
            from,
            per_unit,
        }
    }

    fn pass(&mut self, parameter: f64) {
        while self.next <= parameter {
            self.whole += self.step;
            self.next = (self.whole - self.from) * self.per_unit;
        }
    }
}
