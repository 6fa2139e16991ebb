//! Where the samples of one file are, before any is read.

use std::path::{Path, PathBuf};

use gdal::spatial_ref::SpatialRef;
use glam::DAffine2;

use super::vertical::HeightReference;
use super::{ReadError, crs};
use crate::georeference::Crs;

/// Size and position of one file's grid.
pub(super) struct Layout {
    pub(super) path: PathBuf,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Grid coordinates (integers at samples) to coordinates of the reference system.
    pub(super) to_crs: DAffine2,
    pub(super) crs: Crs,
    /// Whether x is a longitude in degrees.
    pub(super) is_in_degrees: bool,
    pub(super) heights: HeightReference,
    /// What the person is told of the file.
    pub(super) remarks: Vec<String>,
}

impl Layout {
    pub(super) fn new(
        path: &Path,
        (columns, rows): (usize, usize),
        to_crs: DAffine2,
        reference: &SpatialRef,
        heights: HeightReference,
    ) -> Result<Self, ReadError> {
        Ok(Self {
            path: path.to_owned(),
            columns,
            rows,
            to_crs,
            crs: crs::describe(reference).ok_or_else(|| ReadError::NoCrs(path.to_owned()))?,
            is_in_degrees: crs::is_in_degrees(reference),
            remarks: heights.remark().map(str::to_owned).into_iter().collect(),
            heights,
        })
    }
}
