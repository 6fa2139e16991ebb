//! The reference surface of a tolerance volume: samples on a grid, bilinear in each cell, and how far a flat triangle
//! or edge strays from it.
//!
//! Everything is measured in *grid coordinates* (column, row; whole numbers at the samples). A triangle that is flat in
//! space hangs below the straight interpolation of its corners' heights by the sagitta of the Earth's curvature: with
//! `q(c, r) = kx·c² + ky·r²` it is linear in `height − q`. A cell with a void corner is no surface.
//!
//! ```text
//! against a bilinear cell the difference of an edge is a parabola in each piece between grid lines:
//! its extremes are at the piece's ends or at the parabola's vertex; that of a triangle is at samples or on its edges
//! ```

use glam::DVec2;

use crate::plan::PlanMap;

/// Cells within which a point is on a grid line: rounding must not hide the samples along an edge.
const ON_A_LINE: f64 = 1e-7;

/// Where the promised bound holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// At every point of the bilinear surface.
    Surface,
    /// At the samples only.
    Samples,
}

/// Samples on a grid, and how a mesh's plan coordinates lie over them.
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    /// Samples in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row, metres; NaN is void.
    pub heights: &'a [f32],
    /// Between the mesh's plan coordinates and the grid's.
    pub plan: PlanMap,
    /// `kx` and `ky` of each row: squared ground metres of a step over twice the Earth's radius; 0 on a plane.
    pub curvature: &'a [DVec2],
    /// Ground metres of a column and of a row step, for distances in plan.
    pub ground: DVec2,
    /// Where the bound is to hold.
    pub bound: Bound,
}

/// A mesh vertex over the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPoint {
    /// Column and row.
    pub grid: DVec2,
    /// Metres.
    pub height: f64,
}

/// The largest difference found so far, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Metres, never negative.
    pub size: f64,
    /// Column and row.
    pub at: DVec2,
}

impl Deviation {
    /// Nothing found yet.
    pub const NONE: Self = Self {
        size: 0.0,
        at: DVec2::ZERO,
    };

    fn include(&mut self, difference: f64, at: impl FnOnce() -> DVec2) {
        if difference.abs() > self.size {
            *self = Self {
                size: difference.abs(),
                at: at(),
            };
        }
    }
}

/// A part of an edge inside one valid cell.
struct Piece {
    start: f64,
    end: f64,
    /// Constant, column, row and product coefficient of the cell's bilinear form.
    bilinear: [f64; 4],
}

impl Reference<'_> {
    /// Height of a sample; NaN where it is void.
    #[must_use]
    pub fn sample(&self, column: usize, row: usize) -> f64 {
        f64::from(self.heights[row * self.columns + column])
    }

    /// Whether the cell whose first corner is (`column`, `row`) has four samples.
    #[must_use]
    pub fn cell_is_valid(&self, column: i64, row: i64) -> bool {
        self.corners(column, row).is_some()
    }

    /// Height of the surface at a point; where some corners of its cell are void, of what samples there are.
    #[must_use]
    pub fn height_near(&self, grid: DVec2) -> Option<f64> {
        let limit = DVec2::new(self.columns as f64 - 1.0, self.rows as f64 - 1.0);
        let inside = grid.clamp(DVec2::ZERO, limit);
        let first = inside.floor().min((limit - 1.0).max(DVec2::ZERO));
        let weight = inside - first;
        let (mut total, mut height) = (0.0, 0.0);
        for (column, across) in [(0.0, 1.0 - weight.x), (1.0, weight.x)] {
            for (row, down) in [(0.0, 1.0 - weight.y), (1.0, weight.y)] {
                let sample = self.sample((first.x + column) as usize, (first.y + row) as usize);
                if !sample.is_nan() && across * down > 0.0 {
                    total += across * down;
                    height += across * down * sample;
                }
            }
        }
        (total > 1e-9).then(|| height / total)
    }

    /// `kx` and `ky` at a row.
    fn curvature_at(&self, row: f64) -> DVec2 {
        self.curvature[(row.max(0.0) as usize).min(self.rows - 1)]
    }

    /// Largest difference between the triangle and the samples that it covers.
    #[must_use]
    pub fn triangle_deviation(&self, corners: [GridPoint; 3]) -> Deviation {
        let mut worst = Deviation::NONE;
        self.visit_samples(corners, |column, row, weights, residual| {
            let difference = residual
                - weights
                    .iter()
                    .zip(corners)
                    .map(|(w, corner)| w * corner.height)
                    .sum::<f64>();
            worst.include(difference, || DVec2::new(column as f64, row as f64));
        });
        worst
    }

    /// Calls `visit(column, row, weights, target)` for each valid sample in the triangle: the flat triangle meets the
    /// sample where the weighted sum of its corners' heights is `target`.
    pub fn visit_samples(&self, corners: [GridPoint; 3], mut visit: impl FnMut(usize, usize, [f64; 3], f64)) {
        let [a, b, c] = corners.map(|corner| corner.grid);
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            return;
        }
        let curvature = self.curvature_at((a.y + b.y + c.y) / 3.0);
        let sag = |p: DVec2| curvature.dot((p - a) * (p - a));
        let (sag_b, sag_c) = (sag(b), sag(c));
        let (low, high) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let last_row = (high + ON_A_LINE).floor().min(self.rows as f64 - 1.0);
        let mut row = (low - ON_A_LINE).ceil().max(0.0);
        while row <= last_row {
            let (from, to) = span(row, [a, b, c]);
            let first = (from - ON_A_LINE).ceil().max(0.0);
            let last = (to + ON_A_LINE).floor().min(self.columns as f64 - 1.0);
            let mut column = first;
            while column <= last {
                let sample = self.sample(column as usize, row as usize);
                if !sample.is_nan() {
                    let p = DVec2::new(column, row);
                    let weight_b = (p - a).perp_dot(c - a) / area;
                    let weight_c = (b - a).perp_dot(p - a) / area;
                    let target = sample - sag(p) + weight_b * sag_b + weight_c * sag_c;
                    visit(
                        column as usize,
                        row as usize,
                        [1.0 - weight_b - weight_c, weight_b, weight_c],
                        target,
                    );
                }
                column += 1.0;
            }
            row += 1.0;
        }
    }

    /// Largest difference between the straight edge and the bilinear surface under it, exactly.
    #[must_use]
    pub fn edge_deviation(&self, a: GridPoint, b: GridPoint) -> Deviation {
        let mut worst = Deviation::NONE;
        let curvature = self.curvature_at((a.grid.y + b.grid.y) / 2.0);
        let direction = b.grid - a.grid;
        let hang = curvature.dot(direction * direction);
        self.visit_pieces(a.grid, b.grid, |piece| {
            let difference = |t: f64| {
                let edge = a.height + t * (b.height - a.height) - hang * t * (1.0 - t);
                bilinear_at(&piece.bilinear, a.grid + direction * t) - edge
            };
            let middle = (piece.start + piece.end) / 2.0;
            let [first, centre, last] = [piece.start, middle, piece.end].map(difference);
            worst.include(first, || a.grid + direction * piece.start);
            worst.include(last, || a.grid + direction * piece.end);
            let bend = first - 2.0 * centre + last;
            let vertex = (first - last) / (4.0 * bend);
            if bend != 0.0 && vertex.abs() < 0.5 {
                let t = middle + vertex * (piece.end - piece.start);
                worst.include(difference(t), || a.grid + direction * t);
            }
        });
        worst
    }

    /// Calls `visit(t, target)` at the ends and the middle of each piece of the edge `a → b` between grid lines: the
    /// edge meets the surface where `(1 − t)·height_a + t·height_b` is `target`.
    pub fn visit_edge(&self, a: DVec2, b: DVec2, mut visit: impl FnMut(f64, f64)) {
        let direction = b - a;
        let hang = self.curvature_at((a.y + b.y) / 2.0).dot(direction * direction);
        self.visit_pieces(a, b, |piece| {
            for t in [piece.start, (piece.start + piece.end) / 2.0, piece.end] {
                visit(
                    t,
                    bilinear_at(&piece.bilinear, a + direction * t) + hang * t * (1.0 - t),
                );
            }
        });
    }

    fn visit_pieces(&self, a: DVec2, b: DVec2, mut visit: impl FnMut(Piece)) {
        let mut columns = Crossings::new(a.x, b.x);
        let mut rows = Crossings::new(a.y, b.y);
        let mut start = 0.0;
        while start < 1.0 {
            let end = columns.next.min(rows.next).min(1.0);
            columns.pass(end);
            rows.pass(end);
            if end > start {
                if let Some(bilinear) = self.cell_under(a + (b - a) * ((start + end) / 2.0)) {
                    visit(Piece { start, end, bilinear });
                }
                start = end;
            }
        }
    }

    /// The bilinear form of the valid cell at a point; of either neighbour's where the point is on a grid line.
    fn cell_under(&self, point: DVec2) -> Option<[f64; 4]> {
        let first = point.floor();
        let (column, row) = (first.x as i64, first.y as i64);
        let before = DVec2::new(
            f64::from(point.x - first.x < ON_A_LINE),
            f64::from(point.y - first.y < ON_A_LINE),
        );
        let corners = self.corners(column, row).map(|heights| (column, row, heights));
        let (column, row, [h00, h10, h01, h11]) = corners.or_else(|| {
            let (column, row) = (column - before.x as i64, row - before.y as i64);
            self.corners(column, row).map(|heights| (column, row, heights))
        })?;
        let (across, down, twist) = (h10 - h00, h01 - h00, h00 - h10 - h01 + h11);
        let (c, r) = (column as f64, row as f64);
        Some([
            h00 - across * c - down * r + twist * c * r,
            across - twist * r,
            down - twist * c,
            twist,
        ])
    }

    fn corners(&self, column: i64, row: i64) -> Option<[f64; 4]> {
        let inside = column >= 0 && row >= 0 && column + 1 < self.columns as i64 && row + 1 < self.rows as i64;
        if !inside {
            return None;
        }
        let (c, r) = (column as usize, row as usize);
        let heights = [(c, r), (c + 1, r), (c, r + 1), (c + 1, r + 1)].map(|(c, r)| self.sample(c, r));
        (!heights.iter().any(|height| height.is_nan())).then_some(heights)
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

fn bilinear_at(form: &[f64; 4], p: DVec2) -> f64 {
    form[0] + form[1] * p.x + form[2] * p.y + form[3] * p.x * p.y
}

/// First and last column of the triangle on a row, or so close to it that rounding cannot tell.
fn span(row: f64, corners: [DVec2; 3]) -> (f64, f64) {
    let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
    for (p, q) in [
        (corners[0], corners[1]),
        (corners[1], corners[2]),
        (corners[2], corners[0]),
    ] {
        let (low, high) = if p.y <= q.y { (p, q) } else { (q, p) };
        let (first, last) = (low.y.max(row - ON_A_LINE), high.y.min(row + ON_A_LINE));
        if first <= last {
            let at = |y: f64| low.x + (y - low.y) / (high.y - low.y) * (high.x - low.x);
            let columns = if low.y == high.y {
                [low.x, high.x]
            } else {
                [at(first), at(last)]
            };
            from = from.min(columns[0]).min(columns[1]);
            to = to.max(columns[0]).max(columns[1]);
        }
    }
    (from, to)
}

#[cfg(test)]
#[path = "reference_tests.rs"]
mod tests;
