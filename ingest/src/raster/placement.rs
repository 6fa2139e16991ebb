//! How many samples a grid may have, and where they are by what formats say of it.

use std::path::Path;

use glam::{DAffine2, DMat2, DVec2};

use super::ReadError;

/// Refuses grids without a surface and grids that are too large.
pub(super) fn check_size(path: &Path, columns: usize, rows: usize, limit: usize) -> Result<(), ReadError> {
    if columns < 2 || rows < 2 {
        return Err(ReadError::Empty {
            path: path.to_owned(),
            columns,
            rows,
        });
    }
    if columns.checked_mul(rows).is_none_or(|samples| samples > limit) {
        return Err(ReadError::TooLarge {
            path: path.to_owned(),
            what: format!("{columns} × {rows} samples"),
            limit,
        });
    }
    Ok(())
}

/// Grid coordinates to a reference system, from the corner-based transform that GDAL has (for PixelIsPoint files too):
/// the first sample is half a pixel from the corner in both directions.
pub(super) fn from_corner_based(transform: [f64; 6]) -> DAffine2 {
    let [x, x_by_column, x_by_row, y, y_by_column, y_by_row] = transform;
    let matrix = DMat2::from_cols(DVec2::new(x_by_column, y_by_column), DVec2::new(x_by_row, y_by_row));
    DAffine2::from_mat2_translation(matrix, DVec2::new(x, y) + matrix * DVec2::splat(0.5))
}

/// Grid coordinates to metres on a plane: the last row's first sample is at (0, 0), x runs along the columns, y up the rows.
pub(super) fn from_pixel_size([width, height]: [f64; 2], rows: usize) -> DAffine2 {
    let matrix = DMat2::from_diagonal(DVec2::new(width, -height));
    DAffine2::from_mat2_translation(matrix, DVec2::new(0.0, height * (rows as f64 - 1.0)))
}

/// Grid coordinates to a reference system, from the outer edges of the pixels, the first row northernmost.
pub(super) fn from_bounds(bounds: [f64; 4], columns: usize, rows: usize) -> Result<DAffine2, ReadError> {
    let [west, south, east, north] = bounds;
    let is_ordered = west < east && south < north;
    if !is_ordered || !bounds.iter().all(|bound| bound.is_finite()) {
        return Err(ReadError::BadBounds(bounds));
    }
    let (width, height) = ((east - west) / columns as f64, (north - south) / rows as f64);
    Ok(from_corner_based([west, width, 0.0, north, 0.0, -height]))
}
