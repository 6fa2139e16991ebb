//! How rasters are to be read.

use crate::progress::Progress;
use crate::samples::Overrides;

/// How to read.
#[derive(Clone, Default)]
pub struct ReadOptions {
    /// What is used instead of what files say of themselves.
    pub overrides: Overrides,
    /// What is too large.
    pub limits: RasterLimits,
    /// Is told of the samples read.
    pub progress: Progress,
}

/// What a raster may ask for; anything larger is refused before it costs memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RasterLimits {
    /// Samples of one file, and of the rectangle around all of them.
    pub samples: usize,
    /// Samples that are kept in memory at once, where a mesh is made of all of them.
    pub samples_in_memory: usize,
    /// Bytes of one block (tile or strip) of a file, unpacked.
    pub block_bytes: usize,
}

impl Default for RasterLimits {
    /// Two gigabytes of heights in memory, a quarter of a gigabyte a block.
    fn default() -> Self {
        Self {
            samples: 1 << 40,
            samples_in_memory: 1 << 29,
            block_bytes: 1 << 28,
        }
    }
}
