//! Where chunks of all levels come from.

use std::sync::Arc;

use crate::height_field::heights::Heights;
use crate::height_field::relief::{CHUNK, CORNERS, Chunk};

/// Blocks of the highest level along the longer side.
const FEW_BLOCKS: usize = 8;

/// Gives chunks by level, column and row of chunks.
pub trait Chunks: Sync {
    /// Columns and rows of samples.
    fn size(&self) -> [usize; 2];

    /// A chunk; none where no sample is.
    fn chunk(&self, level: u8, x: usize, y: usize) -> Option<Arc<Chunk>>;

    /// The highest level: all samples are in a few of its blocks.
    fn top(&self) -> u8 {
        top_over(self.size())
    }
}

/// The level at which so many columns and rows of samples are in a few blocks.
#[must_use]
pub fn top_over([columns, rows]: [usize; 2]) -> u8 {
    let cells = columns.max(rows).saturating_sub(1).max(1);
    cells.div_ceil(FEW_BLOCKS).next_power_of_two().trailing_zeros() as u8
}

/// All chunks of a window of samples, made at once.
#[derive(Debug)]
pub struct ChunksInMemory {
    size: [usize; 2],
    levels: Vec<Level>,
}

/// The chunks of one level, row by row.
#[derive(Debug)]
struct Level {
    columns: usize,
    chunks: Vec<Option<Arc<Chunk>>>,
}

impl Level {
    fn get(&self, x: usize, y: usize) -> Option<&Arc<Chunk>> {
        let is_inside = x < self.columns;
        self.chunks.get(y * self.columns + x).filter(|_| is_inside)?.as_ref()
    }
}

impl ChunksInMemory {
    /// Cuts a window into chunks and makes the levels above.
    #[must_use]
    pub fn new(heights: Heights) -> Self {
        let mut chunks = Self {
            size: [heights.columns, heights.rows],
            levels: Vec::new(),
        };
        for level in 0..=chunks.top() {
            let [columns, rows] = chunks.size.map(|samples| {
                let cells = samples.saturating_sub(1).max(1);
                cells.div_ceil(CHUNK << level)
            });
            let places = (0..columns * rows).map(|index| [index % columns, index / columns]);
            let made = places.map(|place| match chunks.levels.last() {
                None => chunk_of(heights, place),
                Some(finer) => chunk_over(finer, place),
            });
            let made = made.map(|chunk| chunk.map(Arc::new)).collect();
            chunks.levels.push(Level { columns, chunks: made });
        }
        chunks
    }
}

impl Chunks for ChunksInMemory {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn chunk(&self, level: u8, x: usize, y: usize) -> Option<Arc<Chunk>> {
        self.levels.get(usize::from(level))?.get(x, y).cloned()
    }
}

fn chunk_of(heights: Heights, [x, y]: [usize; 2]) -> Option<Chunk> {
    let first = [x * CHUNK, y * CHUNK];
    let sample = |index: usize| {
        let (column, row) = (first[0] + index % CORNERS, first[1] + index / CORNERS);
        let is_inside = column < heights.columns && row < heights.rows;
        if is_inside {
            heights.samples[row * heights.columns + column]
        } else {
            f32::NAN
        }
    };
    Chunk::of_samples((0..CORNERS * CORNERS).map(sample).collect())
}

fn chunk_over(finer: &Level, [x, y]: [usize; 2]) -> Option<Chunk> {
    let part = |across: usize, down: usize| finer.get(2 * x + across, 2 * y + down).map(Arc::as_ref);
    Chunk::over([part(0, 0), part(1, 0), part(0, 1), part(1, 1)])
}
