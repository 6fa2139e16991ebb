//! Heights on the samples of a raster: what everything after reading starts from.

use std::ops::Range;

use terrain_core::height_field::heights::Heights;

use crate::georeference::GeoReference;

/// Samples of a surface in metres, with where on the Earth they are.
///
/// **Grid coordinates** are (column, row), and integers are *at* the samples: (0, 0) is the first sample, not the
/// corner of the first pixel. Between samples the surface is bilinear in grid coordinates.
#[derive(Clone, Debug)]
pub struct HeightGrid {
    /// Samples in a row, at least 2.
    pub columns: usize,
    /// Rows, at least 2.
    pub rows: usize,
    /// Row-major, in the order of the raster (the first row is usually the northernmost); metres; NaN where void.
    pub heights: Vec<f32>,
    /// Where the samples are.
    pub georeference: GeoReference,
}

impl HeightGrid {
    /// Whether some four neighbouring samples are all valid; without such a cell there is no surface.
    #[must_use]
    pub fn has_surface(&self) -> bool {
        let rows: Vec<&[f32]> = self.heights.chunks_exact(self.columns).collect();
        let whole = |above: &[f32], below: &[f32]| above.iter().chain(below).all(|height| !height.is_nan());
        rows.windows(2).any(|pair| {
            pair[0]
                .windows(2)
                .zip(pair[1].windows(2))
                .any(|(above, below)| whole(above, below))
        })
    }

    /// All samples, as those of one window.
    #[must_use]
    pub fn whole(&self) -> Heights<'_> {
        Heights {
            columns: self.columns,
            rows: self.rows,
            samples: &self.heights,
        }
    }

    /// Heights of a rectangle of samples, row by row.
    pub(crate) fn heights_in(&self, columns: &Range<usize>, rows: &Range<usize>) -> Vec<f32> {
        let row = |row: usize| &self.heights[row * self.columns..][columns.clone()];
        rows.clone().flat_map(row).copied().collect()
    }

    /// The sample at a column and a row, NaN where void.
    ///
    /// # Panics
    /// If there is no such sample.
    #[must_use]
    pub fn height(&self, column: usize, row: usize) -> f32 {
        assert!(column < self.columns, "column {column} of {}", self.columns);
        self.heights[row * self.columns + column]
    }
}
