//! Where the samples of one file are, before any is read.

use std::path::{Path, PathBuf};

use gdal::spatial_ref::SpatialRef;
use glam::{DAffine2, DMat2, DVec2};

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
    /// Whether it is nowhere on the Earth.
    pub(super) is_local: bool,
    /// What the person is told of the file.
    pub(super) remarks: Vec<String>,
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
            is_local: false,
            remarks: heights.remark().map(str::to_owned).into_iter().collect(),
            heights,
        })
    }

    /// Ground that is nowhere on the Earth: its last row's first sample is at (0, 0), x runs along the columns, y up the rows.
    pub(super) fn local(path: &Path, [columns, rows]: [usize; 2], pixel: [f64; 2], heights: HeightReference) -> Self {
        let [width, height] = pixel;
        let matrix = DMat2::from_diagonal(DVec2::new(width, -height));
        Self {
            path: path.to_owned(),
            columns,
            rows,
            to_crs: DAffine2::from_mat2_translation(matrix, DVec2::new(0.0, height * (rows as f64 - 1.0))),
            crs: Crs {
                name: "local metres".to_owned(),
                definition: String::new(),
            },
            is_in_degrees: false,
            is_local: true,
            remarks: Vec::new(),
            heights,
        }
    }
}
