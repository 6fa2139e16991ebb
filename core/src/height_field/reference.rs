//! The reference surface of a tolerance volume: samples on a grid, bilinear in each cell, and how far a flat triangle
//! or edge strays from it.
//!
//! Everything is measured in *grid coordinates* (column, row; whole numbers at the samples). A triangle that is flat in
//! space hangs below the straight interpolation of its corners' heights by the sagitta of the Earth's curvature: with
//! `q(c, r) = kx·c² + ky·r²` it is linear in `height − q`. A cell with a void corner is no surface.
//!
//! ```text
//! against a bilinear cell the difference of an edge is a parabola in each piece between grid lines:
//! its extremes are at the piece's ends or at the parabola's summit; that of a triangle is at samples or on its edges
//! ```

use glam::DVec2;

use crate::height_field::bilinear::{Cell, Piece};
use crate::height_field::finer::Finer;
use crate::height_field::flat::{self, Flat};
use crate::height_field::ground::{EARTH_RADIUS, Ground};
use crate::height_field::heights::Heights;
use crate::height_field::plan::PlanMap;
use crate::height_field::scan::{self, ON_A_LINE};

pub use crate::height_field::flat::GridPoint;

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
    /// The samples; grid coordinates are those of this window.
    pub heights: Heights<'a>,
    /// Between the mesh's plan coordinates and the grid's.
    pub plan: PlanMap<'a>,
    /// `kx` and `ky` of each row: squared ground metres of a step over twice the Earth's radius; 0 on a plane.
    pub curvature: &'a [DVec2],
    /// Where the mesh lies on the ground, for distances in plan.
    pub ground: Ground<'a>,
    /// Where the bound is to hold.
    pub bound: Bound,
    /// What lies between the samples, where these are not all there are.
    pub finer: Option<Finer<'a>>,
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

    /// The larger of two.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if other.size > self.size { other } else { self }
    }
}

impl Reference<'_> {
    /// Height of the surface at a position in plan, metres; in a void, of the nearest sample, and 0 where there is none.
    #[must_use]
    pub fn height_near(&self, plan: DVec2) -> f64 {
        let at = self.plan.grid(plan);
        self.height_near_grid(at).unwrap_or(0.0)
    }

    /// The same in grid coordinates; none where there is no sample.
    pub(crate) fn height_near_grid(&self, at: DVec2) -> Option<f64> {
        let of_finer = self.finer.and_then(|finer| finer.height(at));
        of_finer.or_else(|| self.heights.height_near(at))
    }

    /// The place of the sample next to one.
    pub(crate) fn nearest_sample(&self, at: DVec2) -> DVec2 {
        self.finer.map_or_else(|| at.round(), |finer| finer.nearest_sample(at))
    }

    /// Largest difference between the triangle and all samples that it covers, as far as it is more than the tolerance: between those
    /// of the window, too, where these are not all there are.
    pub(crate) fn triangle_worst(&self, corners: [GridPoint; 3], tolerance: f64) -> Deviation {
        let of_window = self.triangle_deviation(corners);
        let Some(finer) = self.finer.filter(|_| of_window.size <= tolerance) else {
            return of_window;
        };
        let curvature = self.curvature_at(corners.map(|corner| corner.grid.y).iter().sum::<f64>() / 3.0);
        let found = finer.worst_under(corners, curvature, tolerance);
        found.map_or(of_window, |(size, at)| Deviation { size, at })
    }

    /// The same between the straight edge and the surface under it.
    pub(crate) fn edge_worst(&self, a: GridPoint, b: GridPoint, tolerance: f64) -> Deviation {
        let Some(finer) = self.finer else {
            return self.edge_deviation(a, b);
        };
        let curvature = self.curvature_at((a.grid.y + b.grid.y) / 2.0);
        let found = finer.worst_along([a, b], curvature, tolerance);
        found.map_or(Deviation::NONE, |(size, at)| Deviation { size, at })
    }

    /// `kx` and `ky` at a row.
    pub(crate) fn curvature_at(&self, row: f64) -> DVec2 {
        self.curvature[(row.max(0.0) as usize).min(self.heights.rows - 1)]
    }

    /// Metres along the longer side of a cell at a row; 0 on a plane.
    pub(crate) fn cell_at(&self, row: f64) -> f64 {
        (self.curvature_at(row).max_element() * 2.0 * EARTH_RADIUS).sqrt()
    }

    /// Metres, seen from above, by which a triangle that is counter-clockwise in plan lies over others: it is not on the grid, where a
    /// map projection bends long straight lines.
    pub(crate) fn fold(&self, corners: [GridPoint; 3]) -> f64 {
        if self.plan.is_affine() {
            return 0.0;
        }
        let [a, b, c] = corners.map(|corner| corner.grid);
        if (b - a).perp_dot(c - a) * self.plan.handedness() >= 0.0 {
            return 0.0;
        }
        flat::altitude([a, b, c]) * self.cell_at(a.y)
    }

    /// Largest difference between the triangle and the samples that it covers.
    #[must_use]
    pub fn triangle_deviation(&self, corners: [GridPoint; 3]) -> Deviation {
        let mut worst = Deviation::NONE;
        let curvature = self.curvature_at(corners.map(|corner| corner.grid.y).iter().sum::<f64>() / 3.0);
        let Some(flat) = Flat::through(corners, curvature) else {
            return worst;
        };
        let Flat { origin: a, slope, .. } = flat;
        let [_, b, c] = corners;
        scan::visit_rows(
            [a.grid, b.grid, c.grid],
            [self.heights.columns, self.heights.rows],
            |row, columns| {
                let down = scan::double(row) - a.grid.y;
                let at_row = a.height + (slope.y + curvature.y * down) * down;
                let samples = &self.heights.samples[row * self.heights.columns..][columns.clone()];
                let from_a = scan::double(columns.start) - a.grid.x;
                let difference = |step: usize, sample: f32| {
                    let across = from_a + scan::double(step);
                    (f64::from(sample) - at_row - (slope.x + curvature.x * across) * across).abs()
                };
                let (mut size, mut place) = (worst.size, usize::MAX);
                for (step, &sample) in samples.iter().enumerate() {
                    let found = difference(step, sample);
                    if found > size {
                        (size, place) = (found, step);
                    }
                }
                if place != usize::MAX {
                    worst = Deviation {
                        size,
                        at: DVec2::new((columns.start + place) as f64, row as f64),
                    };
                }
            },
        );
        worst
    }

    /// Largest difference between the straight edge and the bilinear surface under it, exactly.
    #[must_use]
    pub fn edge_deviation(&self, a: GridPoint, b: GridPoint) -> Deviation {
        let mut worst = Deviation::NONE;
        let at = |t: f64| a.grid.lerp(b.grid, t);
        self.visit_pieces(a.grid, b.grid, |piece| {
            let [first, summit, last] = piece.differences(a.height, b.height);
            worst.include(first, || at(piece.start));
            worst.include(last, || at(piece.end));
            worst.include(summit, || at(piece.summit(first, last)));
        });
        worst
    }

    /// Sum of the squared differences between the edge and the surface, at the middle and the end of each piece; none
    /// where one is beyond the tolerance.
    pub(crate) fn edge_squares(&self, a: GridPoint, b: GridPoint, tolerance: f64) -> Option<f64> {
        let (mut squares, mut is_within) = (0.0, true);
        self.visit_pieces(a.grid, b.grid, |piece| {
            let at = |t: f64| a.height + t * (b.height - a.height);
            let middle = piece.middle() - at((piece.start + piece.end) / 2.0);
            let last = piece.last - at(piece.end);
            squares += middle * middle + last * last;
            is_within &= piece.deviation(a.height, b.height) <= tolerance;
        });
        is_within.then_some(squares)
    }

    /// Calls `visit` with each piece of the edge `a → b` in a valid cell, or on the side of one.
    pub(crate) fn visit_pieces(&self, a: DVec2, b: DVec2, mut visit: impl FnMut(Piece)) {
        let direction = b - a;
        let hang = self.curvature_at((a.y + b.y) / 2.0).dot(direction * direction);
        let hanging = |t: f64| hang * t * (1.0 - t);
        let mut before: Option<f64> = None;
        scan::visit_cells(a, b, |start, end| {
            let [from, middle, to] = [start, (start + end) / 2.0, end].map(|t| a + direction * t);
            let Some(cell) = self.cell_under(middle) else {
                before = None;
                return;
            };
            let first = before.unwrap_or_else(|| cell.height(from) + hanging(start));
            let last = cell.height(to) + hanging(end);
            before = Some(last);
            let (step, length) = (to - from, end - start);
            visit(Piece {
                start,
                end,
                first,
                last,
                bend: cell.bend(step) - hang * length * length,
            });
        });
    }

    /// The valid cell at a point; either neighbour where the point is on a grid line.
    fn cell_under(&self, point: DVec2) -> Option<Cell> {
        let index = |coordinate: f64, count: usize| (coordinate.max(0.0) as usize).min(count.saturating_sub(2));
        let (column, row) = (index(point.x, self.heights.columns), index(point.y, self.heights.rows));
        let cell = Cell::new([column, row], self.heights.corners(column, row));
        if cell.is_valid() {
            return Some(cell);
        }
        let before = |coordinate: f64, index: usize| {
            if coordinate - (index as f64) < ON_A_LINE {
                index.saturating_sub(1)
            } else {
                index
            }
        };
        let beside = [before(point.x, column), before(point.y, row)];
        let neighbour = Cell::new(beside, self.heights.corners(beside[0], beside[1]));
        neighbour.is_valid().then_some(neighbour)
    }
}

#[cfg(test)]
#[path = "reference_tests.rs"]
mod tests;
