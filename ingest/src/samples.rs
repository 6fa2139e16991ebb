//! Samples of a raster by windows, wherever they are kept: nothing that is built or measured needs all of them at once.

use std::ops::Range;

use anyhow::Result;

use crate::height_grid::HeightGrid;

/// A rectangle of samples, cut off at the raster's edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Column and row in the raster of the first sample.
    pub first: [usize; 2],
    /// Samples in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Row by row, metres; NaN where void.
    pub heights: Vec<f32>,
}

/// What gives windows of samples.
pub trait Samples: Sync {
    /// Columns and rows of the whole raster.
    fn size(&self) -> [usize; 2];

    /// The samples in these columns and rows, as far as the raster reaches.
    ///
    /// # Errors
    /// When they cannot be read.
    fn window(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Window>;
}

impl Samples for HeightGrid {
    fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    fn window(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Window> {
        let (columns, rows) = (
            columns.start..columns.end.min(self.columns),
            rows.start..rows.end.min(self.rows),
        );
        let heights = rows.clone().flat_map(|row| {
            let start = row * self.columns;
            self.heights[start + columns.start..start + columns.end].iter().copied()
        });
        Ok(Window {
            first: [columns.start, rows.start],
            columns: columns.len(),
            rows: rows.len(),
            heights: heights.collect(),
        })
    }
}
