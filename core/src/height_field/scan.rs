//! Which samples lie in a triangle, and where an edge crosses grid lines: scan conversion in grid coordinates.

use std::ops::Range;

use glam::DVec2;

/// Cells within which a point is on a grid line: rounding must not hide the samples along an edge.
pub(crate) const ON_A_LINE: f64 = 1e-7;
/// Rows over which an edge must run for its slope to be worth anything.
const LEAST_RISE: f64 = 1e-6;
/// Columns up to which it is quicker to test each sample than to find where a row enters and leaves a triangle.
const SMALL: f64 = 6.0;

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
            slope: if rise > LEAST_RISE {
                (high.x - low.x) / rise
            } else {
                f64::NAN
            },
        }
    }

    /// Widens a range of columns to where the edge is within rounding of a row.
    #[inline(always)]
    fn widen(&self, row: f64, from: &mut f64, to: &mut f64) {
        let (low, high) = (self.low.y.max(row - ON_A_LINE), self.high.y.min(row + ON_A_LINE));
        if low <= high {
            let [first, last] = if self.slope.is_nan() {
                [self.low.x, self.high.x]
            } else {
                [low, high].map(|y| self.low.x + (y - self.low.y) * self.slope)
            };
            *from = from.min(first).min(last);
            *to = to.max(first).max(last);
        }
    }
}

/// Calls `visit(row, columns)` for each row of a grid of `size` columns and rows with samples in the triangle, or so
/// close to it that rounding cannot tell.
#[inline(always)]
pub(crate) fn visit_rows(corners: [DVec2; 3], size: [usize; 2], mut visit: impl FnMut(usize, Range<usize>)) {
    let [a, b, c] = corners;
    let (low, high) = (least(a, least(b, c)), -least(-a, least(-b, -c)));
    let rows = whole_numbers(low.y, high.y, size[1]);
    if rows.is_empty() {
        return;
    }
    if high.x - low.x < SMALL {
        let columns = whole_numbers(low.x, high.x, size[0]);
        let inside = Inside::new(corners);
        for row in rows {
            let found = inside.columns(row, columns.clone());
            if !found.is_empty() {
                visit(row, found);
            }
        }
        return;
    }
    let sides = [Side::new(a, b), Side::new(b, c), Side::new(c, a)];
    for row in rows {
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for side in &sides {
            side.widen(double(row), &mut from, &mut to);
        }
        if from <= to {
            visit(row, whole_numbers(from, to, size[0]));
        }
    }
}

fn least(a: DVec2, b: DVec2) -> DVec2 {
    // One instruction each, unlike `min`, which minds NaN.
    DVec2::new(if a.x < b.x { a.x } else { b.x }, if a.y < b.y { a.y } else { b.y })
}

/// What tells whether a point is in a triangle: the weights of its second and third corner.
struct Inside {
    origin: DVec2,
    of_second: DVec2,
    of_third: DVec2,
    slack: f64,
}

impl Inside {
    fn new([a, b, c]: [DVec2; 3]) -> Self {
        let (second, third) = (b - a, c - a);
        let per_area = 1.0 / second.perp_dot(third);
        let of_second = DVec2::new(third.y, -third.x) * per_area;
        let of_third = DVec2::new(-second.y, second.x) * per_area;
        let steepness = of_second.abs() + of_third.abs();
        Self {
            origin: a,
            of_second,
            of_third,
            slack: -ON_A_LINE * (steepness.x + steepness.y),
        }
    }

    fn columns(&self, row: usize, candidates: Range<usize>) -> Range<usize> {
        let start = DVec2::new(double(candidates.start), double(row)) - self.origin;
        let (mut second, mut third) = (self.of_second.dot(start), self.of_third.dot(start));
        let mut found = 0..0;
        for column in candidates {
            if second >= self.slack && third >= self.slack && 1.0 - second - third >= self.slack {
                if found.is_empty() {
                    found.start = column;
                }
                found.end = column + 1;
            }
            second += self.of_second.x;
            third += self.of_third.x;
        }
        found
    }
}

/// An index as a double. Signed numbers become one with one instruction, unsigned ones with five.
#[inline(always)]
pub(crate) fn double(index: usize) -> f64 {
    index as i64 as f64
}

/// Whole numbers from `low` to `high`, within rounding, that are indices below `count`.
#[inline]
pub(crate) fn whole_numbers(low: f64, high: f64, count: usize) -> Range<usize> {
    if low > high {
        return 0..0;
    }
    // Truncation is many times faster than `ceil` and `floor` where the processor has no instruction for them.
    let first = (low - ON_A_LINE).max(-0.5);
    let whole = first as i64;
    let begin = whole as usize + usize::from(first > whole as f64);
    let end = ((high + ON_A_LINE + 1.0).max(0.0) as i64 as usize).min(count);
    begin..end.max(begin)
}

/// Calls `visit(start, end)` for the stretches of the edge `a → b`, as growing parameters from 0 to 1, between grid
/// lines.
#[inline]
pub fn visit_cells(a: DVec2, b: DVec2, mut visit: impl FnMut(f64, f64)) {
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

/// Parameters from 0 to 1, growing, at which a coordinate on its way from `from` to `to` is a whole number.
pub fn crossings(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let begins_on_a_line = from != to && from.fract() == 0.0;
    let mut lines = Crossings::new(from, to);
    let further = std::iter::from_fn(move || {
        let parameter = lines.next;
        (parameter <= 1.0).then(|| {
            lines.pass(parameter);
            parameter
        })
    });
    begins_on_a_line.then_some(0.0).into_iter().chain(further)
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
