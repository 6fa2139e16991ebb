//! Opened rasters written down: all that is known of them but their samples. With it and a store that has the samples, work goes
//! on where the files are not.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine2;
use serde::{Deserialize, Serialize};

use super::error::ReadError;
use super::own_grid::{OwnGrid, OwnGridRecord};
use super::remark::remark;
use crate::georeference::{Crs, GeoReference};
use crate::progress::Progress;
use crate::samples::{Extremes, Faults, Provenance, Raster, Rectangle};

/// All that is known of rasters on one lattice but their samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RasterRecord {
    /// The files, by absolute paths.
    pub paths: Vec<PathBuf>,
    pub(super) crs: Crs,
    /// From the lattice of samples to coordinates of the reference system: columns of a matrix, then what is added.
    pub(super) to_crs: [f64; 6],
    pub(super) origin: [i64; 2],
    pub(super) size: [usize; 2],
    pub(super) extents: Vec<[Range<usize>; 2]>,
    pub(super) coarseness: Vec<f64>,
    /// Files whose samples are much farther apart than those of the lattice.
    #[serde(default)]
    pub(super) own_grids: Vec<OwnGridRecord>,
    pub(super) block_rows: usize,
    pub(crate) provenance: Provenance,
    pub(super) stamps: Vec<String>,
}

/// Rasters of which the samples are elsewhere.
pub struct RecordedRaster {
    record: RasterRecord,
    georeference: GeoReference,
    own_grids: Vec<Arc<OwnGrid>>,
    progress: Progress,
}

impl RecordedRaster {
    /// What a record tells.
    ///
    /// # Errors
    /// When PROJ does not know its coordinate reference system here.
    pub fn new(record: RasterRecord, progress: Progress) -> Result<Self, ReadError> {
        let [columns, rows] = record.size;
        let to_crs = DAffine2::from_cols_array(&record.to_crs);
        let georeference = GeoReference::on_lattice(&record.crs, to_crs, record.origin, columns, rows)
            .map_err(|source| ReadError::Position(record.first().to_owned(), source))?;
        let own_grid = |of_file: &OwnGridRecord| {
            let own = of_file.georeference()?;
            let lattice = (&record.crs, to_crs);
            Ok(Arc::new(OwnGrid::new(of_file.clone(), lattice, own, &georeference)))
        };
        let own_grids = record.own_grids.iter().map(own_grid).collect::<Result<_, _>>();
        let own_grids = own_grids.map_err(|source| ReadError::Position(record.first().to_owned(), source))?;
        Ok(Self {
            record,
            georeference,
            own_grids,
            progress,
        })
    }
}

impl RecordedRaster {
    fn not_read(&self) -> ReadError {
        ReadError::unreadable(self.record.first(), "its samples are not in the store yet")
    }
}

impl RasterRecord {
    fn first(&self) -> &Path {
        self.paths.first().map_or(Path::new(""), PathBuf::as_path)
    }
}

impl Raster for RecordedRaster {
    fn size(&self) -> [usize; 2] {
        self.record.size
    }

    fn origin(&self) -> [i64; 2] {
        self.record.origin
    }

    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        self.record.extents.clone()
    }

    fn coarseness(&self) -> Vec<f64> {
        self.record.coarseness.clone()
    }

    fn block_rows(&self) -> usize {
        self.record.block_rows
    }

    fn read(&self, _columns: Range<usize>, _rows: Range<usize>) -> Result<Rectangle, ReadError> {
        Err(self.not_read())
    }

    fn own_grids(&self) -> &[Arc<OwnGrid>] {
        &self.own_grids
    }

    fn read_own(&self, _own: &OwnGrid, _columns: Range<usize>, _rows: Range<usize>) -> Result<Vec<f32>, ReadError> {
        Err(self.not_read())
    }

    fn georeference(&self) -> &GeoReference {
        &self.georeference
    }

    fn provenance(&self) -> Provenance {
        self.record.provenance.clone()
    }

    fn remark(&self, extremes: Option<Extremes>, faults: &[Faults]) -> Result<(), ReadError> {
        let paths: Vec<&Path> = self.record.paths.iter().map(PathBuf::as_path).collect();
        remark(&paths, extremes, faults, &self.progress)
    }

    fn stamps(&self) -> Vec<String> {
        self.record.stamps.clone()
    }
}
