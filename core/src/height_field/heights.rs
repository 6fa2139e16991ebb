//! A window of samples on a grid: heights and what of them is a surface.

use glam::DVec2;

/// Samples row by row. Grid coordinates (column, row) are the window's own: whole numbers at the samples, 0 at the first one.
#[derive(Clone, Copy, Debug)]
pub struct Heights<'a> {
    /// Samples in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row, metres; NaN is void.
    pub samples: &'a [f32],
}

impl Heights<'_> {
    /// Height of a sample; NaN where it is void.
    #[must_use]
    #[inline]
    pub fn sample(&self, column: usize, row: usize) -> f64 {
        f64::from(self.samples[row * self.columns + column])
    }

    /// Whether the cell whose first corner is (`column`, `row`) has four samples.
    #[must_use]
    pub fn cell_is_valid(&self, column: i64, row: i64) -> bool {
        let inside = column >= 0 && row >= 0 && column + 1 < self.columns as i64 && row + 1 < self.rows as i64;
        inside
            && !self
                .corners(column as usize, row as usize)
                .iter()
                .any(|height| height.is_nan())
    }

    /// Height of the surface at a point; where some corners of its cell are void, of what samples there are. Points beside the
    /// window count as those on its edge that are nearest.
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

    /// Heights at the corners of a cell, row by row.
    pub(crate) fn corners(&self, column: usize, row: usize) -> [f64; 4] {
        let (above, below) = (row * self.columns + column, (row + 1) * self.columns + column);
        [above, above + 1, below, below + 1].map(|index| f64::from(self.samples[index]))
    }
}
