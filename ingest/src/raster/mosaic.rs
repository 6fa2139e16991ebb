//! One grid over several files that share their lattice of samples.

use glam::{DAffine2, DVec2};

use super::layout::Layout;
use super::placement;
use super::{RasterLimits, ReadError};

/// Largest distance, in cells, of a file's samples from the first file's lattice.
const MISALIGNMENT: f64 = 0.01;
/// No index of a sample comes near it: beyond, a cell offset is no integer any more.
const FARTHEST: f64 = 1e9;

/// Where files lie on the lattice of the first one.
pub(super) struct Mosaic {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Column and row of its first sample, counted from that of the first file.
    pub(super) origin: [i64; 2],
    /// From the first file's columns and rows.
    pub(super) to_crs: DAffine2,
    /// Column and row of each file's first sample.
    pub(super) offsets: Vec<[usize; 2]>,
}

impl Mosaic {
    /// The smallest grid over all `layouts`.
    pub(super) fn new(layouts: &[&Layout], limits: RasterLimits) -> Result<Self, ReadError> {
        let first = *layouts.first().ok_or(ReadError::NoFile)?;
        let offsets = layouts
            .iter()
            .map(|layout| offset(first, layout))
            .collect::<Result<Vec<_>, _>>()?;
        let low = offsets.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = offsets
            .iter()
            .zip(layouts)
            .map(|(&offset, layout)| offset + DVec2::new(layout.columns as f64, layout.rows as f64))
            .fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = high - low;
        let (columns, rows) = (size.x as usize, size.y as usize);
        placement::check_size(&first.path, columns, rows, limits.samples)?;
        Ok(Self {
            columns,
            rows,
            origin: [low.x as i64, low.y as i64],
            to_crs: first.to_crs,
            offsets: offsets
                .iter()
                .map(|&offset| offset - low)
                .map(|offset| [offset.x as usize, offset.y as usize])
                .collect(),
        })
    }
}

/// Whole cells from the first sample of `first` to that of `layout`, on the lattice of `first`.
fn offset(first: &Layout, layout: &Layout) -> Result<DVec2, ReadError> {
    let mixed = |reason: String| ReadError::Mixed {
        path: layout.path.clone(),
        first: first.path.clone(),
        reason,
    };
    if layout.crs != first.crs {
        return Err(mixed(format!("its CRS is {}, not {}", layout.crs.name, first.crs.name)));
    }
    let to_first = first.to_crs.inverse() * nearest_turn(first, layout);
    let last = DVec2::new((layout.columns - 1) as f64, (layout.rows - 1) as f64);
    let begin = to_first.transform_point2(DVec2::ZERO);
    let drift = (to_first.transform_point2(last) - begin - last).abs().max_element();
    if drift.is_nan() || drift > MISALIGNMENT {
        return Err(mixed("its cells have another size or direction".to_owned()));
    }
    let cells = begin.round();
    let shift = (begin - cells).abs().max_element();
    if shift > MISALIGNMENT || cells.abs().max_element() > FARTHEST {
        return Err(mixed(format!(
            "its samples are {shift:.3} cells off the other's lattice"
        )));
    }
    Ok(cells)
}

/// The layout's transform, turned by whole turns of longitude where that brings it nearer to `first`: two files on
/// either side of the antimeridian are neighbours.
fn nearest_turn(first: &Layout, layout: &Layout) -> DAffine2 {
    let mut to_crs = layout.to_crs;
    if first.is_in_degrees {
        to_crs.translation.x -= ((to_crs.translation.x - first.to_crs.translation.x) / 360.0).round() * 360.0;
    }
    to_crs
}
