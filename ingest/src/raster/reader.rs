//! What readers of files have in common.

use std::ops::Range;

use gdal::spatial_ref::SpatialRef;
use glam::DAffine2;

use super::ReadError;

/// Reads what a file stores.
pub(super) trait Reader: Send + Sync {
    /// Values of a rectangle, row by row; NaN where the file says that there is none.
    fn stored(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError>;
}

/// What a reader finds in a file before its samples.
pub(super) struct Found {
    pub(super) reader: Box<dyn Reader>,
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Samples of a block that is stored as one, across and down.
    pub(super) block: [usize; 2],
    pub(super) crs: Option<SpatialRef>,
    /// Grid coordinates (integers at samples) to coordinates of the reference system.
    pub(super) to_crs: Option<DAffine2>,
    /// What heights are above by a tag.
    pub(super) datum: Option<String>,
    /// What the person is told of it.
    pub(super) remark: Option<String>,
    /// Height in `unit` = stored value × `scale` + `offset`.
    pub(super) scale: f64,
    pub(super) offset: f64,
    /// Name of the unit, empty where it has none.
    pub(super) unit: String,
    /// The greatest value that can be stored, 1 for numbers with a fraction.
    pub(super) greatest: f64,
}

impl Found {
    /// Of a file that holds nothing but samples, row by row.
    pub(super) fn bare(reader: impl Reader + 'static, size: [usize; 2], greatest: f64) -> Self {
        Self {
            reader: Box::new(reader),
            size,
            block: [size[0].max(1), 1],
            crs: None,
            to_crs: None,
            datum: None,
            remark: None,
            scale: 1.0,
            offset: 0.0,
            unit: String::new(),
            greatest,
        }
    }
}
