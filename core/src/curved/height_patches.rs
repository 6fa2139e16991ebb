//! Samples of heights become bicubic patches, one for each cell, that pass through all samples and have no creases between them.
//!
//! Slopes at a sample are central differences, as in Catmull–Rom splines (E. Catmull, R. Rom, *A class of local interpolating
//! splines*, 1974), one-sided beside a void or the grid's end; the twist is the central difference of slopes. Each is one number
//! a sample, so that patches that share a side have its tangent planes in common (Ferguson's patch, in Bézier's form: G. Farin,
//! *Curves and Surfaces for Computer Aided Geometric Design*, 1993, §16).

use glam::DVec2;

use crate::curved::tensor::Bicubic;

/// Heights on a grid of samples.
#[derive(Clone, Copy, Debug)]
pub struct HeightSamples<'a> {
    /// Samples in a row.
    pub columns: usize,
    /// Row by row; NaN is void.
    pub heights: &'a [f32],
    /// Where the first sample is.
    pub origin: DVec2,
    /// From one column to the next, and from one row to the next; neither 0, either may be negative.
    pub step: DVec2,
}

impl HeightSamples<'_> {
    /// A patch for each cell that has four samples, row by row; counter-clockwise seen from above. P(u, v) runs with u along x
    /// and v along y, or the other way round where that would be clockwise.
    #[must_use]
    pub fn bicubics(&self) -> Vec<Bicubic> {
        let rows = self.heights.len() / self.columns.max(1);
        let cells = (1..rows).flat_map(|row| (1..self.columns).map(move |column| [column - 1, row - 1]));
        cells.filter_map(|cell| self.cell(cell)).collect()
    }

    fn cell(&self, [column, row]: [usize; 2]) -> Option<Bicubic> {
        let [[a, b], [c, d]] = [0, 1].map(|across| [0, 1].map(|down| self.tangents([column + across, row + down])));
        let corners = [[a?, b?], [c?, d?]];
        let point = |i: usize, j: usize| {
            let grid = DVec2::new(column as f64 + i as f64 / 3.0, row as f64 + j as f64 / 3.0);
            let height = corners[i / 2][j / 2].beside([[0.0, 1.0, -1.0, 0.0][i], [0.0, 1.0, -1.0, 0.0][j]]);
            (self.origin + self.step * grid).extend(height)
        };
        let is_clockwise = self.step.x * self.step.y < 0.0;
        Some([0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| if is_clockwise { point(j, i) } else { point(i, j) })))
    }

    /// A sample that is there, and how the surface goes on from it.
    fn tangents(&self, at: [usize; 2]) -> Option<Tangents> {
        Some(Tangents {
            height: self.sample(at)?,
            slopes: [0, 1].map(|axis| self.difference(at, axis, |at| self.sample(at))),
            twist: self.difference(at, 1, |at| {
                self.sample(at)?;
                Some(self.difference(at, 0, |at| self.sample(at)))
            }),
        })
    }

    fn sample(&self, [column, row]: [usize; 2]) -> Option<f64> {
        let height = *self.heights.get(row * self.columns + column)?;
        (column < self.columns && !height.is_nan()).then_some(f64::from(height))
    }

    /// The difference from one place along an axis to the next, central where there are both; 0 where there is neither.
    fn difference(&self, at: [usize; 2], axis: usize, value: impl Fn([usize; 2]) -> Option<f64>) -> f64 {
        let beside = |step: isize| {
            let mut at = at;
            at[axis] = at[axis].checked_add_signed(step)?;
            value(at)
        };
        match (beside(-1), value(at), beside(1)) {
            (Some(before), _, Some(after)) => (after - before) / 2.0,
            (None, Some(here), Some(after)) => after - here,
            (Some(before), Some(here), None) => here - before,
            _ => 0.0,
        }
    }
}

/// A height and its derivatives, in steps of the grid.
#[derive(Clone, Copy)]
struct Tangents {
    height: f64,
    slopes: [f64; 2],
    twist: f64,
}

impl Tangents {
    /// The control point that is a third of a step away along each axis: 1 onwards, −1 back, 0 not.
    fn beside(&self, [across, down]: [f64; 2]) -> f64 {
        self.height + (across * self.slopes[0] + down * self.slopes[1]) / 3.0 + across * down * self.twist / 9.0
    }
}

#[cfg(test)]
#[path = "height_patches_tests.rs"]
mod tests;
