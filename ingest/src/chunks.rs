//! A raster in a store: chunks of samples, and above them blocks with bounds of what they hold
//! ([`terrain_core::height_field::relief`]).
//!
//! ```text
//! chunks of 256 × 256 samples                        named by their content, brought here by intake.rs
//! for each level, until one chunk is left:
//!     chunk ← its four parts of the level below      named by all samples under it
//! ```
//! Chunks are counted from a fixed place on the lattice of the first file, so that they stay the same when others are added.
//! What has no height has no chunk: rasters far apart cost what each costs. What follows from own samples of a coarse file is made when it
//! is asked for ([`crate::interpolated`]).

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use anyhow::{Context, Result, bail, ensure};
use moka::sync::Cache;
use rayon::prelude::*;
use terrain_core::height_field::relief::{CHUNK, CORNERS, Chunk};

use crate::chunk_grid::{ChunkId, chunks_under, first_sample, from_bytes, overlap, samples_key, to_bytes, top_level};
use crate::intake::Taken;
use crate::interpolated::Interpolated;
use crate::progress::Progress;
use crate::samples::{CoarseWindow, Raster, Samples, Window};
use crate::store::{Name, Store};

/// The raster in the store: any window of its samples, any chunk of its relief.
pub(crate) struct ChunkedRaster {
    store: Store,
    interpolated: Interpolated,
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
    ///
    /// # Errors
    /// When something of it is missing.
    pub(crate) fn new(raster: &dyn Raster, store: &Store, taken: Taken, memory: u64) -> Result<Self> {
        let interpolated = Interpolated::new(raster, store, taken.interpolated, taken.own);
        let mut names = taken.names;
        names.extend(interpolated.names()?);
        let cache = |bytes: u64| bytes.max(1 << 20);
        let (size, first) = (raster.size(), first_sample(raster));
        let top_level = top_level(size);
        let of_top = CHUNK << top_level;
        let corner = first.map(|first| first / of_top * of_top);
        let before = [0, 1].map(|axis| first[axis] - corner[axis]);
        let mut raster = Self {
            store: store.clone(),
            interpolated,
            size: [before[0] + size[0], before[1] + size[1]],
            corner,
            before,
            names,
            top_level,
            fault: OnceLock::new(),
            samples: Cache::builder()
                .weigher(|_, samples: &Arc<ChunkSamples>| (4 * (samples.heights.len() + samples.filled.len())) as u32)
                .max_capacity(cache(memory / 2))
                .build(),
            relief: Cache::builder()
                .weigher(|_, chunk: &Arc<Chunk>| chunk.bytes() as u32)
                .max_capacity(cache(memory / 2))
                .build(),
        };
        raster.name_levels();
        Ok(raster)
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

    /// Whether there are samples under a chunk in the chunks over a rectangle of the lattice.
    fn has_chunk_in(&self, id: ChunkId, rectangle: &[Range<usize>; 2]) -> bool {
        let reaches = |chunk: u32, range: &Range<usize>| {
            let side = CHUNK << id.level;
            let first = chunk as usize * side;
            first < range.end && range.start < first + side
        };
        let is_there = reaches(id.x, &rectangle[0]) && reaches(id.y, &rectangle[1]) && self.names.contains_key(&id);
        is_there && (id.level == 0 || id.parts().into_iter().any(|part| self.has_chunk_in(part, rectangle)))
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
            Some(&name) if !self.interpolated.has_relief(id) => self.store.has(&relief_key(id, name)),
            _ => Ok(true),
        }
    }

    /// Makes a chunk above the samples and all below it, unless it is there: it is put there last.
    pub(crate) fn make_chunk(&self, id: ChunkId, progress: &Progress) -> Result<()> {
        let Some(&name) = self.names.get(&id) else {
            return Ok(());
        };
        let key = relief_key(id, name);
        if self.interpolated.has_relief(id) || self.store.has(&key)? {
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
        let made = if let Some(chunk) = self.interpolated.relief(id)? {
            Some(chunk)
        } else if id.level == 0 {
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
            computed: None,
        })
    }

    /// The samples of a chunk and those just beyond its last column and row.
    fn bordered(&self, id: ChunkId) -> Result<Vec<f32>> {
        let mut samples = vec![f32::NAN; CORNERS * CORNERS];
        let sizes = [[CHUNK, CHUNK], [1, CHUNK], [CHUNK, 1], [1, 1]];
        let places = [[0, 0], [CHUNK, 0], [0, CHUNK], [CHUNK, CHUNK]];
        for ((part, [columns, rows]), [left, top]) in id.with_following().into_iter().zip(sizes).zip(places) {
            let Some(heights) = self.heights_of(part, 0..columns, 0..rows)? else {
                continue;
            };
            for (row, heights) in heights.chunks_exact(columns).enumerate() {
                let to = (top + row) * CORNERS + left;
                samples[to..to + columns].copy_from_slice(heights);
            }
        }
        Ok(samples)
    }

    /// Heights of some columns and rows of a chunk, row by row; none where nothing has a height.
    fn heights_of(&self, id: ChunkId, columns: Range<usize>, rows: Range<usize>) -> Result<Option<Vec<f32>>> {
        if self.interpolated.has(id) {
            return self.interpolated.heights(id, columns, rows);
        }
        let samples = self.samples_of(id)?;
        Ok(samples.map(|samples| {
            let row = |row: usize| &samples.heights[row * CHUNK..][columns.clone()];
            rows.flat_map(row).copied().collect()
        }))
    }

    /// Whether all samples of a rectangle have heights.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn is_whole(&self, columns: &Range<usize>, rows: &Range<usize>) -> Result<bool> {
        for id in chunks_under(0, self.corner, [columns, rows]) {
            if self.interpolated.has(id) {
                continue;
            }
            let Some(samples) = self.samples_of(id)? else {
                return Ok(false);
            };
            let [across, down] = self.in_chunk(id, columns, rows);
            let row = |row: usize| &samples.heights[row * CHUNK..][across.clone()];
            if down.flat_map(row).any(|height| height.is_nan()) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Columns and rows of a chunk, counted in it, that are in a rectangle.
    fn in_chunk(&self, id: ChunkId, columns: &Range<usize>, rows: &Range<usize>) -> [Range<usize>; 2] {
        let [left, top] = self.corner;
        let of_chunk = |chunk: u32, corner: usize, range: &Range<usize>| {
            let common = overlap(chunk as usize, corner, range);
            let first = chunk as usize * CHUNK;
            common.start + corner - first..common.end + corner - first
        };
        [of_chunk(id.x, left, columns), of_chunk(id.y, top, rows)]
    }

    /// The samples of a chunk that is stored.
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
            if self.interpolated.has(id) {
                continue;
            }
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
            let [across, down] = self.in_chunk(id, &columns, &rows);
            let width = across.len();
            let Some(heights) = self.heights_of(id, across, down)? else {
                continue;
            };
            let start = overlap(id.x as usize, left, &columns).start - columns.start;
            for (row, heights) in overlap(id.y as usize, top, &rows).zip(heights.chunks_exact(width)) {
                let to = (row - rows.start) * columns.len() + start;
                window.heights[to..to + width].copy_from_slice(heights);
            }
        }
        Ok(window)
    }

    fn filled(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Option<Vec<[usize; 2]>>> {
        self.filled_in(columns, rows).map(Some)
    }

    fn is_coarse(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        let is_inside = columns.end <= self.size[0] && rows.end <= self.size[1];
        is_inside
            && self
                .interpolated
                .has_all(chunks_under(0, self.corner, [&columns, &rows]))
    }

    fn coarse(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Option<Box<dyn CoarseWindow + '_>>> {
        if columns.end > self.size[0] || rows.end > self.size[1] {
            return Ok(None);
        }
        let chunks = chunks_under(0, self.corner, [&columns, &rows]);
        self.interpolated.window(chunks, self.before, [columns, rows])
    }

    fn may_hold(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        let [left, top] = self.corner;
        let rectangle = [
            left + columns.start..left + columns.end,
            top + rows.start..top + rows.end,
        ];
        self.chunks_of(self.top_level)
            .into_iter()
            .any(|top| self.has_chunk_in(top, &rectangle))
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

fn relief_key(id: ChunkId, name: Name) -> String {
    format!("relief/{}-{}-{}-{name}", id.level, id.x, id.y)
}

#[cfg(test)]
#[path = "chunks_tests.rs"]
mod tests;
