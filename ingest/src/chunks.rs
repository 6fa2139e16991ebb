//! A raster in a store: chunks of samples, and above them blocks with bounds of what they hold
//! ([`terrain_core::height_field::relief`]).
//!
//! ```text
//! chunks of 256 × 256 samples                        named by their content, brought here by intake.rs
//! for each level, until one chunk is left:
//!     chunk ← its four parts of the level below      named by all samples under it
//! ```
//! Chunks are counted from a fixed place on the lattice of the first file, so that they stay the same when others are added.
//! What has no height has no chunk: rasters far apart cost what each costs.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use anyhow::{Context, Result, bail, ensure};
use moka::sync::Cache;
use rayon::prelude::*;
use terrain_core::height_field::chunks::top_over;
use terrain_core::height_field::relief::{CHUNK, CORNERS, Chunk};

use crate::progress::Progress;
use crate::samples::{Raster, Samples, Window};
use crate::store::{Name, Store};

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
    fn above(self) -> Self {
        Self {
            level: self.level + 1,
            x: self.x / 2,
            y: self.y / 2,
        }
    }

    /// The four of the level below, by row.
    fn parts(self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Self {
            level: self.level - 1,
            x: 2 * self.x + x,
            y: 2 * self.y + y,
        })
    }

    /// This one, and those that have the samples just beyond its last column and row.
    fn with_following(self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Self {
            x: self.x + x,
            y: self.y + y,
            ..self
        })
    }
}

/// The raster in the store: any window of its samples, any chunk of its relief.
pub(crate) struct ChunkedRaster {
    store: Store,
    /// Columns and rows, counted from a corner of a chunk of the highest level: nothing is in the first ones where samples begin
    /// later.
    size: [usize; 2],
    /// Lattice coordinates of that corner.
    corner: [usize; 2],
    /// Columns and rows before the first sample.
    before: [usize; 2],
    /// Of level 0 by content, of the others by all samples under them. What has no height is missing.
    names: BTreeMap<ChunkId, Name>,
    top_level: u8,
    samples: Cache<ChunkId, Arc<ChunkSamples>>,
    relief: Cache<ChunkId, Arc<Chunk>>,
    /// The first chunk that could not be read while nobody could be told.
    fault: OnceLock<String>,
}

impl ChunkedRaster {
    /// The raster whose samples were taken into the store. `memory` is how many bytes of chunks are kept at hand.
    pub(crate) fn new(raster: &dyn Raster, store: &Store, samples: BTreeMap<ChunkId, Name>, memory: u64) -> Self {
        let cache = |bytes: u64| bytes.max(1 << 20);
        let (size, first) = (raster.size(), first_sample(raster));
        let top_level = top_level(size);
        let of_top = CHUNK << top_level;
        let corner = first.map(|first| first / of_top * of_top);
        let before = [0, 1].map(|axis| first[axis] - corner[axis]);
        let mut raster = Self {
            store: store.clone(),
            size: [before[0] + size[0], before[1] + size[1]],
            corner,
            before,
            names: samples,
            top_level,
            fault: OnceLock::new(),
            samples: Cache::builder()
                .weigher(|_, samples: &Arc<ChunkSamples>| (4 * (samples.heights.len() + samples.filled.len())) as u32)
                .max_capacity(cache(memory / 2))
                .build(),
            relief: Cache::builder()
                .weigher(|_, chunk: &Arc<Chunk>| (4 * chunk.corners.len() + 8 * chunk.residuals.len()) as u32)
                .max_capacity(cache(memory / 2))
                .build(),
        };
        raster.name_levels();
        raster
    }

    /// Names the chunks above the samples, level by level.
    fn name_levels(&mut self) {
        let mut below: Vec<ChunkId> = self.names.keys().copied().collect();
        for _ in 1..=self.top_level {
            let above: BTreeSet<ChunkId> = below.iter().map(|id| id.above()).collect();
            for &id in &above {
                let name = Name::of([self.parts_of_name(id).as_slice()]);
                self.names.insert(id, name);
            }
            below = above.into_iter().collect();
        }
    }

    /// The names of everything that a chunk above the samples is made of.
    fn parts_of_name(&self, id: ChunkId) -> Vec<u8> {
        let named = |id: &ChunkId| self.names.get(id).map_or([0; 16], |name| name.bytes());
        let parts = id.parts();
        if id.level > 1 {
            return parts.iter().flat_map(named).collect();
        }
        parts
            .iter()
            .flat_map(|part| part.with_following())
            .flat_map(|part| named(&part))
            .collect()
    }

    /// Makes the chunks above the samples that are not in the store yet.
    pub(crate) fn make_relief(&self, progress: &Progress) -> Result<()> {
        progress.stage("bounding blocks", self.chunks_of(1).len() as u64);
        let top = self.chunks_of(self.top_level).into_par_iter();
        top.try_for_each(|id| self.make_chunk(id, progress))?;
        progress.done();
        Ok(())
    }

    /// The chunks of a level that have a height.
    pub(crate) fn chunks_of(&self, level: u8) -> Vec<ChunkId> {
        let first = |level: u8| ChunkId { level, x: 0, y: 0 };
        self.names
            .range(first(level)..first(level + 1))
            .map(|(&id, _)| id)
            .collect()
    }

    /// How many chunks just above the samples are under one, itself included.
    fn lowest_under(&self, id: ChunkId) -> u64 {
        match (self.names.contains_key(&id), id.level) {
            (false, _) => 0,
            (true, 0 | 1) => 1,
            (true, _) => id.parts().into_iter().map(|part| self.lowest_under(part)).sum(),
        }
    }

    /// Whether a chunk above the samples, and so all below it, is in the store.
    pub(crate) fn is_made(&self, id: ChunkId) -> Result<bool> {
        match self.names.get(&id) {
            Some(&name) => self.store.has(&relief_key(id, name)),
            None => Ok(true),
        }
    }

    /// Makes a chunk above the samples and all below it, unless it is there: it is put there last.
    pub(crate) fn make_chunk(&self, id: ChunkId, progress: &Progress) -> Result<()> {
        let Some(&name) = self.names.get(&id) else {
            return Ok(());
        };
        let key = relief_key(id, name);
        if self.store.has(&key)? {
            progress.skip(self.lowest_under(id));
            return Ok(());
        }
        if id.level > 1 {
            let parts = id.parts().into_par_iter();
            parts.try_for_each(|part| self.make_chunk(part, progress))?;
        } else {
            progress.advance(1);
        }
        let parts = id.parts().map(|part| self.chunk_at(part));
        let [a, b, c, d] = parts;
        let parts = [a?, b?, c?, d?];
        let made = Chunk::over([0, 1, 2, 3].map(|part| parts[part].as_deref()));
        let made = made.context("a chunk without parts has a name")?;
        let mut bytes = made.steepest.to_le_bytes().to_vec();
        bytes.extend((made.guessed.len() as u32).to_le_bytes());
        bytes.extend(made.guessed.iter().flat_map(|index| index.to_le_bytes()));
        bytes.extend(to_bytes(&made.corners));
        bytes.extend(made.residuals.iter().flatten().flat_map(|value| value.to_le_bytes()));
        self.store.put(&key, bytes)
    }

    /// Largest difference between neighbouring samples of a row or a column, metres.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn steepest(&self) -> Result<f32> {
        let mut steepest: f32 = 0.0;
        for id in self.chunks_of(self.top_level) {
            steepest = steepest.max(self.chunk_at(id)?.map_or(0.0, |chunk| chunk.steepest));
        }
        Ok(steepest)
    }

    /// The highest level of chunks: all samples are in a few of its blocks.
    pub(crate) fn top(&self) -> u8 {
        self.top_level
    }

    /// Where a rectangle is on the lattice of chunks.
    pub(crate) fn on_lattice(&self, cells: &[Range<usize>; 2]) -> [Range<usize>; 2] {
        [0, 1].map(|axis| self.corner[axis] + cells[axis].start..self.corner[axis] + cells[axis].end)
    }

    /// Columns and rows before the first sample: the raster's own are counted from there.
    pub(crate) fn before(&self) -> [usize; 2] {
        self.before
    }

    /// What could not be read while nobody could be told.
    ///
    /// # Errors
    /// With the first of it.
    pub(crate) fn check(&self) -> Result<()> {
        match self.fault.get() {
            Some(fault) => bail!("{fault}"),
            None => Ok(()),
        }
    }

    /// A chunk of the relief; none where nothing has a height.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn chunk_at(&self, id: ChunkId) -> Result<Option<Arc<Chunk>>> {
        if id.level > 0 && !self.names.contains_key(&id) {
            return Ok(None);
        }
        if let Some(chunk) = self.relief.get(&id) {
            return Ok(Some(chunk));
        }
        let made = if id.level == 0 {
            Chunk::of_samples(self.bordered(id)?)
        } else {
            self.names.get(&id).map(|&name| self.read_chunk(id, name)).transpose()?
        };
        Ok(made.map(|chunk| {
            let chunk = Arc::new(chunk);
            self.relief.insert(id, Arc::clone(&chunk));
            chunk
        }))
    }

    /// A chunk of the relief; none where nothing has a height, or where the store cannot be read, which [`Self::check`] tells.
    pub(crate) fn chunk_or_fault(&self, id: ChunkId) -> Option<Arc<Chunk>> {
        self.chunk_at(id).unwrap_or_else(|error| {
            self.fault.get_or_init(|| format!("{error:#}"));
            None
        })
    }

    fn read_chunk(&self, id: ChunkId, name: Name) -> Result<Chunk> {
        let key = relief_key(id, name);
        let bytes = self.store.expect(&key)?;
        let damaged = || format!("{key} is damaged");
        let (steepest, rest) = bytes.split_first_chunk().with_context(damaged)?;
        let (length, rest) = rest.split_first_chunk().with_context(damaged)?;
        let guessed = u32::from_le_bytes(*length) as usize;
        let count = CORNERS * CORNERS;
        ensure!(
            rest.len() == 4 * (guessed + count + 2 * CHUNK * CHUNK),
            "{key} is damaged"
        );
        let (guessed, values) = rest.split_at(4 * guessed);
        let values = from_bytes(values);
        Ok(Chunk {
            steepest: f32::from_le_bytes(*steepest),
            guessed: guessed
                .chunks_exact(4)
                .map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
                .collect(),
            corners: values[..count].to_vec(),
            residuals: values[count..].chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect(),
        })
    }

    /// The samples of a chunk and those just beyond its last column and row.
    fn bordered(&self, id: ChunkId) -> Result<Vec<f32>> {
        let mut samples = vec![f32::NAN; CORNERS * CORNERS];
        let sizes = [[CHUNK, CHUNK], [1, CHUNK], [CHUNK, 1], [1, 1]];
        let places = [[0, 0], [CHUNK, 0], [0, CHUNK], [CHUNK, CHUNK]];
        for ((part, [columns, rows]), [left, top]) in id.with_following().into_iter().zip(sizes).zip(places) {
            let Some(part) = self.samples_of(part)? else { continue };
            for row in 0..rows {
                let to = (top + row) * CORNERS + left;
                samples[to..to + columns].copy_from_slice(&part.heights[row * CHUNK..row * CHUNK + columns]);
            }
        }
        Ok(samples)
    }

    fn samples_of(&self, id: ChunkId) -> Result<Option<Arc<ChunkSamples>>> {
        let Some(&name) = self.names.get(&id) else {
            return Ok(None);
        };
        if let Some(samples) = self.samples.get(&id) {
            return Ok(Some(samples));
        }
        let key = samples_key(id, name);
        let samples = ChunkSamples::from_bytes(&self.store.expect(&key)?);
        let samples = Arc::new(samples.with_context(|| format!("{key} is damaged"))?);
        self.samples.insert(id, Arc::clone(&samples));
        Ok(Some(samples))
    }

    /// Columns and rows of the samples among these that were not measured: voids that were filled.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn filled_in(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<[usize; 2]>> {
        let mut found = Vec::new();
        for (id, _) in self.chunks_over(0, &columns, &rows) {
            let Some(samples) = self.samples_of(id)? else { continue };
            let first = [id.x, id.y].map(|chunk| chunk as usize * CHUNK);
            for &index in &samples.filled {
                let on_lattice = [first[0] + index as usize % CHUNK, first[1] + index as usize / CHUNK];
                // Samples of a chunk may be before the first that is counted.
                let [column, row] = [0, 1].map(|axis| on_lattice[axis].wrapping_sub(self.corner[axis]));
                if columns.contains(&column) && rows.contains(&row) {
                    found.push([column, row]);
                }
            }
        }
        Ok(found)
    }

    /// Chunks of a level over a rectangle of the raster's cells, by row, those without a height left out.
    pub(crate) fn chunks_over(&self, level: u8, columns: &Range<usize>, rows: &Range<usize>) -> Vec<(ChunkId, Name)> {
        chunks_under(level, self.corner, [columns, rows])
            .filter_map(|id| self.names.get(&id).map(|&name| (id, name)))
            .collect()
    }
}

impl Samples for ChunkedRaster {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn window(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Window> {
        let columns = columns.start..columns.end.min(self.size[0]);
        let rows = rows.start..rows.end.min(self.size[1]);
        let mut window = Window {
            first: [columns.start, rows.start],
            columns: columns.len(),
            rows: rows.len(),
            heights: vec![f32::NAN; columns.len() * rows.len()],
        };
        let [left, top] = self.corner;
        for (id, _) in self.chunks_over(0, &columns, &rows) {
            let Some(samples) = self.samples_of(id)? else { continue };
            let across = overlap(id.x as usize, left, &columns);
            for row in overlap(id.y as usize, top, &rows) {
                let from = (top + row - id.y as usize * CHUNK) * CHUNK + left + across.start - id.x as usize * CHUNK;
                let to = (row - rows.start) * columns.len() + across.start - columns.start;
                window.heights[to..to + across.len()].copy_from_slice(&samples.heights[from..from + across.len()]);
            }
        }
        Ok(window)
    }

    fn filled(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Option<Vec<[usize; 2]>>> {
        self.filled_in(columns, rows).map(Some)
    }

    fn may_hold(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        !self.chunks_over(0, &columns, &rows).is_empty()
    }
}

/// The samples of a chunk.
struct ChunkSamples {
    /// Row by row, metres; NaN where void.
    heights: Vec<f32>,
    /// Indices of those that were not measured: voids that were filled.
    filled: Vec<u32>,
}

impl ChunkSamples {
    /// None where these are not the bytes of a chunk.
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (heights, filled) = bytes.split_at_checked(4 * CHUNK * CHUNK)?;
        let (filled, rest) = filled.as_chunks();
        let filled: Vec<u32> = filled.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        let is_sound = rest.is_empty() && filled.iter().all(|&index| (index as usize) < CHUNK * CHUNK);
        is_sound.then(|| Self {
            heights: from_bytes(heights),
            filled,
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

fn relief_key(id: ChunkId, name: Name) -> String {
    format!("relief/{}-{}-{}-{name}", id.level, id.x, id.y)
}

pub(crate) fn to_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn from_bytes(bytes: &[u8]) -> Vec<f32> {
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

#[cfg(test)]
#[path = "chunks_tests.rs"]
mod tests;
