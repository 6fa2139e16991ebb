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

/// Where a file's samples are in a reference system.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) crs: &'a Crs,
    pub(super) to_crs: DAffine2,
    /// Whether x is a longitude in degrees.
    pub(super) is_in_degrees: bool,
}

impl Frame<'_> {
    /// Columns in 360°, where columns are longitudes in degrees.
    pub(super) fn columns_around(&self) -> Option<f64> {
        let step = self.to_crs.matrix2.x_axis;
        (self.is_in_degrees && step.y == 0.0).then(|| (360.0 / step.x).abs())
    }
}

impl Layout {
    pub(super) fn new(
        path: &Path,
        [columns, rows]: [usize; 2],
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

    /// Where its samples are.
    pub(super) fn frame(&self) -> Frame<'_> {
        Frame {
            crs: &self.crs,
            to_crs: self.to_crs,
            is_in_degrees: self.is_in_degrees,
        }
    }

    /// Ground that is nowhere on the Earth; `to_crs` leads to metres on its plane.
    pub(super) fn local(path: &Path, [columns, rows]: [usize; 2], to_crs: DAffine2, heights: HeightReference) -> Self {
        Self {
            path: path.to_owned(),
            columns,
            rows,
            to_crs,
            crs: Crs::laid_plane(),
            is_in_degrees: false,
            remarks: Vec::new(),
            heights,
        }
    }
}
