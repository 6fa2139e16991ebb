//! Chunks of a raster as one tile sees them.

use std::ops::Range;
use std::sync::Arc;

use terrain_core::height_field::chunks::Chunks;
use terrain_core::height_field::relief::{CHUNK, Chunk};

use crate::chunk_grid::{ChunkId, FIRST, MOST_LEVELS};
use crate::chunks::ChunkedRaster;

/// Chunks under a rectangle of the raster, in columns and rows that are counted from a place on the lattice of chunks that
/// follows from the rectangle alone: what is computed from them is the same whatever else the raster holds.
pub(crate) struct ChunkView<'a> {
    raster: &'a ChunkedRaster,
    /// Lattice coordinates from where it counts.
    first: [usize; 2],
    size: [usize; 2],
    top_level: u8,
}

impl<'a> ChunkView<'a> {
    /// Chunks of all levels up to one, as far as the raster has them, under the columns and rows of a rectangle.
    pub(crate) fn new(raster: &'a ChunkedRaster, cells: &[Range<usize>; 2], level: u8) -> Self {
        let level = level.min(MOST_LEVELS);
        let step = CHUNK << level;
        let on_lattice = raster.on_lattice(cells);
        let first = on_lattice.each_ref().map(|range| range.start / step * step);
        Self {
            raster,
            first,
            size: [0, 1].map(|axis| on_lattice[axis].end - first[axis]),
            top_level: level.min(raster.top()),
        }
    }

    /// The rectangle in the view's columns and rows.
    pub(crate) fn cells(&self, cells: &[Range<usize>; 2]) -> [Range<usize>; 2] {
        let on_lattice = self.raster.on_lattice(cells);
        [0, 1].map(|axis| on_lattice[axis].start - self.first[axis]..on_lattice[axis].end - self.first[axis])
    }

    /// Column and row, on the lattice as georeferences count it, of the view's first.
    pub(crate) fn origin(&self) -> [i64; 2] {
        self.first.map(|first| first as i64 - FIRST)
    }
}

impl Chunks for ChunkView<'_> {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn chunk(&self, level: u8, x: usize, y: usize) -> Option<Arc<Chunk>> {
        let shift = CHUNK.ilog2() + u32::from(level);
        let at = |axis: usize, chunk: usize| ((self.first[axis] >> shift) + chunk) as u32;
        let id = ChunkId {
            level,
            x: at(0, x),
            y: at(1, y),
        };
        self.raster.chunk_or_fault(id)
    }

    fn top(&self) -> u8 {
        self.top_level
    }
}
