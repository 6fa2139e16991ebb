//! A raster in a store: chunks of samples, and above them blocks with bounds of what they hold
//! ([`terrain_core::height_field::relief`]).
//!
//! ```text
//! for each band of rows, as far as files reach:      read once, in whole blocks
//!     chunks of 256 × 256 samples → store            named by their content
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
use serde::{Deserialize, Serialize};
use terrain_core::height_field::chunks::{Chunks, top_over};
use terrain_core::height_field::relief::{CHUNK, CORNERS, Chunk};

use crate::progress::Progress;
use crate::samples::{Extremes, Raster, Samples, Window};
use crate::store::{Name, Store};

/// Where the first sample of the first file is on the lattice of chunks, in both directions: a multiple of any chunk's size.
const FIRST: i64 = 1 << 31;
/// Columns and rows of chunks that are read at once.
const BAND: [usize; 2] = [256, 4];
/// Levels above which nothing is gained: one chunk then covers 2^24 cells.
const MOST_LEVELS: u8 = 16;

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

/// A rectangle of chunks that is read at once, in columns and rows of the raster.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    columns: Range<usize>,
    rows: Range<usize>,
}

/// What the reading of a band came to.
#[derive(Debug, Serialize, Deserialize)]
struct BandRecord {
    /// Column and row of each chunk with a height, and the hash of its samples.
    chunks: Vec<(u32, u32, String)>,
    extremes: Option<Extremes>,
    /// For each file that reaches into it how many samples became void because they cannot be heights.
    wild: Vec<usize>,
}

/// The samples of opened rasters while they are brought into a store.
pub(crate) struct Intake<'a> {
    raster: &'a dyn Raster,
    store: &'a Store,
    /// What the names of bands begin from: each file, and how it is read.
    stamps: Vec<String>,
}

/// What was taken into the store, and what is remarkable of it that cannot be heights.
pub(crate) struct Taken {
    pub(crate) names: BTreeMap<ChunkId, Name>,
    /// None where nothing has a height.
    pub(crate) extremes: Option<Extremes>,
    pub(crate) wild: Vec<usize>,
}

impl<'a> Intake<'a> {
    pub(crate) fn new(raster: &'a dyn Raster, store: &'a Store) -> Self {
        Self {
            raster,
            store,
            stamps: raster.stamps(),
        }
    }

    /// Lattice coordinates of the raster's first sample.
    fn corner(&self) -> [usize; 2] {
        self.raster.origin().map(|origin| (origin + FIRST) as usize)
    }

    /// Samples of all files.
    pub(crate) fn sample_count(&self) -> u64 {
        let extents = self.raster.extents().into_iter();
        extents.map(|[columns, rows]| (columns.len() * rows.len()) as u64).sum()
    }

    /// What is to be read, band by band, as far as files reach.
    pub(crate) fn bands(&self) -> Vec<Band> {
        let corner = self.corner();
        let tall = BAND[1].min(self.raster.block_rows().div_ceil(CHUNK));
        let mut occupied: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for [columns, rows] in self.raster.extents() {
            let chunk_rows = (corner[1] + rows.start) / CHUNK..=(corner[1] + rows.end - 1) / CHUNK;
            for row in chunk_rows {
                let columns = (corner[0] + columns.start) / CHUNK..=(corner[0] + columns.end - 1) / CHUNK;
                occupied.entry(row / tall).or_default().extend(columns);
            }
        }
        let [width, height] = self.raster.size();
        let within = |chunks: Range<usize>, axis: usize, size: usize| {
            (chunks.start * CHUNK).saturating_sub(corner[axis])..(chunks.end * CHUNK - corner[axis]).min(size)
        };
        let band = |row: usize, columns: Range<usize>| Band {
            columns: within(columns, 0, width),
            rows: within(row * tall..(row + 1) * tall, 1, height),
        };
        let runs_of = |(row, columns): (usize, BTreeSet<usize>)| {
            runs(columns).into_iter().map(move |run| (row, run)).collect::<Vec<_>>()
        };
        occupied
            .into_iter()
            .flat_map(runs_of)
            .map(|(row, run)| band(row, run))
            .collect()
    }

    /// Brings all bands into the store, those that are not there yet.
    pub(crate) fn take(&self, bands: &[Band], progress: &Progress) -> Result<Taken> {
        let mut taken = Taken {
            names: BTreeMap::new(),
            extremes: None,
            wild: vec![0; self.raster.extents().len()],
        };
        for band in bands {
            let record = self.record(band, progress)?;
            for (x, y, name) in &record.chunks {
                let name = Name::parse(name).context("a record of chunks is damaged")?;
                taken.names.insert(ChunkId { level: 0, x: *x, y: *y }, name);
            }
            let both = taken.extremes.into_iter().chain(record.extremes);
            taken.extremes = both.reduce(Extremes::with);
            for (file, wild) in self.files_in(band).into_iter().zip(record.wild) {
                taken.wild[file] += wild;
            }
        }
        Ok(taken)
    }

    /// Numbers of the files that reach into a band.
    fn files_in(&self, band: &Band) -> Vec<usize> {
        let extents = self.raster.extents().into_iter().enumerate();
        extents
            .filter(|(_, extent)| samples_of(extent, band) > 0)
            .map(|(file, _)| file)
            .collect()
    }

    /// Samples of all files in a band.
    fn samples_in(&self, band: &Band) -> u64 {
        self.raster
            .extents()
            .iter()
            .map(|extent| samples_of(extent, band))
            .sum()
    }

    /// Where a band's record is, named by the files in it and its place on the lattice.
    fn key(&self, band: &Band) -> String {
        let [left, top] = self.corner();
        let place = [
            left + band.columns.start,
            top + band.rows.start,
            band.columns.len(),
            band.rows.len(),
        ];
        let files = self.files_in(band).into_iter().map(|file| self.stamps[file].as_bytes());
        format!(
            "bands/{}.json",
            Name::of(files.chain([format!("{place:?}").as_bytes()]))
        )
    }

    /// Whether a band is in the store.
    pub(crate) fn has(&self, band: &Band) -> Result<bool> {
        self.store.has(&self.key(band))
    }

    fn record(&self, band: &Band, progress: &Progress) -> Result<BandRecord> {
        let key = self.key(band);
        if let Some(bytes) = self.store.get(&key)? {
            progress.skip(self.samples_in(band));
            return serde_json::from_slice(&bytes).with_context(|| key);
        }
        let record = self.read(band)?;
        self.store.put(&key, serde_json::to_vec(&record)?)?;
        Ok(record)
    }

    fn read(&self, band: &Band) -> Result<BandRecord> {
        let rectangle = self.raster.read(band.columns.clone(), band.rows.clone())?;
        let [left, top] = self.corner();
        let chunks_over =
            |range: &Range<usize>, corner: usize| (corner + range.start) / CHUNK..(corner + range.end).div_ceil(CHUNK);
        let across = chunks_over(&band.columns, left);
        let ids: Vec<(usize, usize)> = chunks_over(&band.rows, top)
            .flat_map(|y| across.clone().map(move |x| (x, y)))
            .collect();
        let put = |(x, y): (usize, usize)| -> Result<Option<(u32, u32, String)>> {
            let mut samples = vec![f32::NAN; CHUNK * CHUNK];
            let columns = overlap(x, left, &band.columns);
            for row in overlap(y, top, &band.rows) {
                let from = (row - band.rows.start) * band.columns.len() + columns.start - band.columns.start;
                let to = (top + row - y * CHUNK) * CHUNK + left + columns.start - x * CHUNK;
                samples[to..to + columns.len()].copy_from_slice(&rectangle.heights[from..from + columns.len()]);
            }
            if samples.iter().all(|sample| sample.is_nan()) {
                return Ok(None);
            }
            let bytes = to_bytes(&samples);
            let name = Name::of([bytes.as_slice()]);
            let key = samples_key(
                ChunkId {
                    level: 0,
                    x: x as u32,
                    y: y as u32,
                },
                name,
            );
            self.store.put(&key, bytes)?;
            Ok(Some((x as u32, y as u32, name.to_string())))
        };
        let chunks: Result<Vec<_>> = ids.into_par_iter().map(put).filter_map(Result::transpose).collect();
        let wild = self
            .files_in(band)
            .into_iter()
            .map(|file| rectangle.wild[file])
            .collect();
        Ok(BandRecord {
            chunks: chunks?,
            extremes: Extremes::of(&rectangle.heights),
            wild,
        })
    }
}

/// Samples of a file in a band.
fn samples_of([columns, rows]: &[Range<usize>; 2], band: &Band) -> u64 {
    let common = |a: &Range<usize>, b: &Range<usize>| a.end.min(b.end).saturating_sub(a.start.max(b.start)) as u64;
    common(columns, &band.columns) * common(rows, &band.rows)
}

fn top_level(size: [usize; 2]) -> u8 {
    top_over(size).clamp(1, MOST_LEVELS)
}

/// The chunks of a level, or of the top one if it is lower, that samples of the files may be in.
pub(crate) fn chunks_over_files(raster: &dyn Raster, level: u8) -> Vec<ChunkId> {
    let level = level.min(top_level(raster.size()));
    let corner = raster.origin().map(|origin| (origin + FIRST) as usize);
    let shift = CHUNK.ilog2() + u32::from(level);
    let mut found = BTreeSet::new();
    for [columns, rows] in raster.extents() {
        let span = |range: &Range<usize>, axis: usize| {
            ((corner[axis] + range.start) >> shift) as u32..=((corner[axis] + range.end - 1) >> shift) as u32
        };
        let across = span(&columns, 0);
        found.extend(span(&rows, 1).flat_map(|y| across.clone().map(move |x| ChunkId { level, x, y })));
    }
    found.into_iter().collect()
}

/// Columns, or rows, of the raster in one chunk, as far as a range reaches.
fn overlap(chunk: usize, corner: usize, range: &Range<usize>) -> Range<usize> {
    let start = (chunk * CHUNK).max(corner + range.start) - corner;
    let end = ((chunk + 1) * CHUNK).min(corner + range.end) - corner;
    start..end
}

/// Runs of numbers that follow each other, no longer than a band.
fn runs(numbers: impl IntoIterator<Item = usize>) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for number in numbers {
        match found.last_mut() {
            Some(run) if run.end == number && run.len() < BAND[0] => run.end += 1,
            _ => found.push(number..number + 1),
        }
    }
    found
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
    samples: Cache<ChunkId, Arc<Vec<f32>>>,
    relief: Cache<ChunkId, Arc<Chunk>>,
    /// The first chunk that could not be read while nobody could be told.
    fault: OnceLock<String>,
}

impl ChunkedRaster {
    /// The raster whose samples were taken into the store. `memory` is how many bytes of chunks are kept at hand.
    pub(crate) fn new(intake: &Intake, samples: BTreeMap<ChunkId, Name>, memory: u64) -> Self {
        let cache = |bytes: u64| bytes.max(1 << 20);
        let size = intake.raster.size();
        let top_level = top_level(size);
        let of_top = CHUNK << top_level;
        let align = |corner: usize| corner / of_top * of_top;
        let corner = intake.corner().map(align);
        let before = [0, 1].map(|axis| intake.corner()[axis] - corner[axis]);
        let mut raster = Self {
            store: intake.store.clone(),
            size: [before[0] + size[0], before[1] + size[1]],
            corner,
            before,
            names: samples,
            top_level,
            fault: OnceLock::new(),
            samples: Cache::builder()
                .weigher(|_, samples: &Arc<Vec<f32>>| (4 * samples.len()) as u32)
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
                samples[to..to + columns].copy_from_slice(&part[row * CHUNK..row * CHUNK + columns]);
            }
        }
        Ok(samples)
    }

    fn samples_of(&self, id: ChunkId) -> Result<Option<Arc<Vec<f32>>>> {
        let Some(&name) = self.names.get(&id) else {
            return Ok(None);
        };
        if let Some(samples) = self.samples.get(&id) {
            return Ok(Some(samples));
        }
        let key = samples_key(id, name);
        let samples = Arc::new(from_bytes(&self.store.expect(&key)?));
        ensure!(samples.len() == CHUNK * CHUNK, "{key} is damaged");
        self.samples.insert(id, Arc::clone(&samples));
        Ok(Some(samples))
    }

    /// Chunks of a level over a rectangle of the raster's cells, by row, those without a height left out.
    pub(crate) fn chunks_over(&self, level: u8, columns: &Range<usize>, rows: &Range<usize>) -> Vec<(ChunkId, Name)> {
        let span = |range: &Range<usize>, axis: usize| {
            let shift = CHUNK.ilog2() + u32::from(level);
            let last = range.end.max(range.start + 1) - 1;
            ((self.corner[axis] + range.start) >> shift) as u32..=((self.corner[axis] + last) >> shift) as u32
        };
        let across = span(columns, 0);
        span(rows, 1)
            .flat_map(|y| across.clone().map(move |x| ChunkId { level, x, y }))
            .filter_map(|id| self.names.get(&id).map(|&name| (id, name)))
            .collect()
    }
}

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
        let first = [0, 1].map(|axis| (raster.corner[axis] + cells[axis].start) / step * step);
        Self {
            raster,
            first,
            size: [0, 1].map(|axis| raster.corner[axis] + cells[axis].end - first[axis]),
            top_level: level.min(raster.top_level),
        }
    }

    /// The rectangle in the view's columns and rows.
    pub(crate) fn cells(&self, cells: &[Range<usize>; 2]) -> [Range<usize>; 2] {
        [0, 1].map(|axis| {
            let at = |cell: usize| self.raster.corner[axis] + cell - self.first[axis];
            at(cells[axis].start)..at(cells[axis].end)
        })
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
        self.raster.chunk_at(id).unwrap_or_else(|error| {
            self.raster.fault.get_or_init(|| format!("{error:#}"));
            None
        })
    }

    fn top(&self) -> u8 {
        self.top_level
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
                window.heights[to..to + across.len()].copy_from_slice(&samples[from..from + across.len()]);
            }
        }
        Ok(window)
    }

    fn may_hold(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        !self.chunks_over(0, &columns, &rows).is_empty()
    }
}

fn samples_key(id: ChunkId, name: Name) -> String {
    format!("samples/{}-{}-{name}", id.x, id.y)
}

fn relief_key(id: ChunkId, name: Name) -> String {
    format!("relief/{}-{}-{}-{name}", id.level, id.x, id.y)
}

fn to_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn from_bytes(bytes: &[u8]) -> Vec<f32> {
    bytes
        .chunks_exact(4)
        .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
        .collect()
}

#[cfg(test)]
#[path = "chunks_tests.rs"]
mod tests;
