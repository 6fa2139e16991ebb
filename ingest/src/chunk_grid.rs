//! Chunks of a raster: where they are on the lattice, and what is stored of their samples.

use std::ops::Range;

use terrain_core::height_field::chunks::top_over;
use terrain_core::height_field::relief::CHUNK;

use crate::samples::Raster;
use crate::store::Name;

/// Where the first sample of the first file is on the lattice of chunks, in both directions: a multiple of any chunk's size.
pub(crate) const FIRST: i64 = 1 << 31;
/// Levels above which nothing is gained: one chunk then covers 2^24 cells.
pub(crate) const MOST_LEVELS: u8 = 16;

/// Which chunk: its level, and its column and row among the chunks of that level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ChunkId {
    pub(crate) level: u8,
    pub(crate) x: u32,
    pub(crate) y: u32,
}

impl ChunkId {
    pub(crate) fn above(self) -> Self {
        Self {
            level: self.level + 1,
            x: self.x / 2,
            y: self.y / 2,
        }
    }

    /// The four of the level below, by row.
    pub(crate) fn parts(self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Self {
            level: self.level - 1,
            x: 2 * self.x + x,
            y: 2 * self.y + y,
        })
    }

    /// This one, and those that have the samples just beyond its last column and row.
    pub(crate) fn with_following(self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Self {
            x: self.x + x,
            y: self.y + y,
            ..self
        })
    }
}

/// What is stored of a chunk: heights, row by row, and indices of those that were not measured.
pub(crate) fn samples_to_bytes(heights: &[f32], filled: &[usize]) -> Vec<u8> {
    let mut bytes = to_bytes(heights);
    bytes.extend(filled.iter().flat_map(|&index| (index as u32).to_le_bytes()));
    bytes
}

pub(crate) fn samples_key(id: ChunkId, name: Name) -> String {
    format!("samples/{}-{}-{name}", id.x, id.y)
}

pub(crate) fn to_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub(crate) fn from_bytes(bytes: &[u8]) -> Vec<f32> {
    bytes
        .chunks_exact(4)
        .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
        .collect()
}

/// Lattice coordinates of a raster's first sample.
pub(crate) fn first_sample(raster: &dyn Raster) -> [usize; 2] {
    raster.origin().map(|origin| (origin + FIRST) as usize)
}

/// Chunks of a level under a rectangle of a raster's columns and rows, by row; `corner` is where these are counted from.
pub(crate) fn chunks_under(
    level: u8,
    corner: [usize; 2],
    [columns, rows]: [&Range<usize>; 2],
) -> impl Iterator<Item = ChunkId> + use<> {
    let shift = CHUNK.ilog2() + u32::from(level);
    let span = |range: &Range<usize>, corner: usize| {
        let last = range.end.max(range.start + 1) - 1;
        ((corner + range.start) >> shift) as u32..=((corner + last) >> shift) as u32
    };
    let across = span(columns, corner[0]);
    span(rows, corner[1]).flat_map(move |y| across.clone().map(move |x| ChunkId { level, x, y }))
}

/// Columns, or rows, of the raster in one chunk, as far as a range reaches.
pub(crate) fn overlap(chunk: usize, corner: usize, range: &Range<usize>) -> Range<usize> {
    let start = (chunk * CHUNK).max(corner + range.start) - corner;
    let end = ((chunk + 1) * CHUNK).min(corner + range.end) - corner;
    start..end
}

pub(crate) fn top_level(size: [usize; 2]) -> u8 {
    top_over(size).clamp(1, MOST_LEVELS)
}
