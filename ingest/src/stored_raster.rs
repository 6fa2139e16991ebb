//! A raster taken into a store: its samples by windows and its relief by chunks, whatever the size of the whole.

use crate::chunks::ChunkedRaster;
use crate::georeference::GeoReference;
use crate::intake::Intake;
use crate::progress::Progress;
use crate::raster::ReadError;
use crate::samples::{Raster, Samples};
use crate::store::Store;
use crate::verify::Source;

/// Part of the memory to stay below that chunks at hand may take, and the most that is of any use: the operating system keeps
/// what was read before, too.
const SHARE: u64 = 8;
const MOST: u64 = 256 << 20;

/// A raster in a store.
pub struct StoredRaster {
    pub(crate) chunks: ChunkedRaster,
    /// Of the columns and rows as the chunks count them.
    pub(crate) georeference: GeoReference,
    /// Lowest and highest sample, metres.
    pub(crate) heights: [f32; 2],
}

/// Why a raster cannot be taken into a store.
#[derive(Debug, thiserror::Error)]
pub enum TakeError {
    /// The raster cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The store cannot be written or read.
    #[error(transparent)]
    Store(anyhow::Error),
}

impl From<anyhow::Error> for TakeError {
    fn from(error: anyhow::Error) -> Self {
        match error.downcast() {
            Ok(error) => Self::Read(error),
            Err(error) => Self::Store(error),
        }
    }
}

impl StoredRaster {
    /// Reads the samples, once, into a store; what is there already is not read again. `memory` is bytes to stay below, roughly.
    ///
    /// # Errors
    /// When the raster cannot be read or has no height, or the store cannot be written.
    pub fn take(raster: &dyn Raster, store: &Store, memory: u64, progress: &Progress) -> Result<Self, TakeError> {
        let intake = Intake::new(raster, store);
        let bands = intake.bands();
        progress.stage("reading samples", intake.sample_count());
        let taken = intake.take(&bands, progress)?;
        progress.done();
        raster.remark(taken.extremes, &taken.faults)?;
        let extremes = taken.extremes;
        let chunks = ChunkedRaster::new(raster, store, taken, (memory / SHARE).min(MOST))?;
        let [columns, rows] = Samples::size(&chunks);
        let before = chunks.before().map(|before| -(before as i64));
        Ok(Self {
            chunks,
            georeference: raster.georeference().window(before, columns, rows),
            heights: extremes.map_or([f32::INFINITY, f32::NEG_INFINITY], |extremes| {
                [extremes.lowest, extremes.highest]
            }),
        })
    }

    /// Where the samples are, counted from the first of them, and how many columns and rows they have.
    pub(crate) fn of_samples(&self) -> (GeoReference, [usize; 2]) {
        let before = self.chunks.before();
        let size = Samples::size(&self.chunks);
        let [columns, rows] = [0, 1].map(|axis| size[axis] - before[axis]);
        let georeference = self
            .georeference
            .window(before.map(|before| before as i64), columns, rows);
        (georeference, [columns, rows])
    }

    /// What claims are measured against.
    #[must_use]
    pub fn source(&self) -> Source<'_> {
        Source {
            samples: &self.chunks,
            georeference: &self.georeference,
            breaklines: &[],
        }
    }
}
