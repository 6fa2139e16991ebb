//! The samples of opened rasters, brought into a store: read once, in whole blocks, by bands of rows as far as files reach, and cut
//! into chunks.
//!
//! A file whose samples are much farther apart than those of the lattice comes as it is, too. A chunk in which nothing but that file
//! counts, and that has no void, is not stored: it follows from the file's own samples ([`crate::interpolated`]).

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use terrain_core::height_field::relief::CHUNK;

use crate::chunk_grid::{
    ChunkId, chunks_under, first_sample, overlap, samples_key, samples_to_bytes, to_bytes, top_level,
};
use crate::interpolated::{self, Origin, OwnChunk, first_of};
use crate::progress::Progress;
use crate::raster::{NODES, OwnGrid};
use crate::samples::{Extremes, Faults, Raster, Rectangle};
use crate::store::{Name, Store};

/// Columns and rows of chunks that are read at once.
const BAND: [usize; 2] = [256, 4];

/// What is read at once.
#[derive(Clone, Debug)]
pub(crate) enum Band {
    /// A rectangle of chunks, in columns and rows of the raster.
    Lattice(Extent),
    /// Own samples of a coarse file: its place among those of the raster, and a row of chunks of its own columns and rows.
    Own { grid: usize, row: u32 },
}

/// Columns and rows.
#[derive(Clone, Debug)]
pub(crate) struct Extent {
    columns: Range<usize>,
    rows: Range<usize>,
}

/// What the reading of a band came to.
#[derive(Debug, Serialize, Deserialize)]
struct BandRecord {
    /// Column and row of each chunk with a height, and the hash of its samples.
    chunks: Vec<(u32, u32, String)>,
    extremes: Option<Extremes>,
    /// For each file that reaches into it what cannot be right in it.
    faults: Vec<Faults>,
    /// Column and row of each chunk that follows from a coarse file's own samples, and from which.
    #[serde(default)]
    interpolated: Vec<(u32, u32, Origin)>,
}

/// The samples of opened rasters while they are brought into a store.
pub(crate) struct Intake<'a> {
    raster: &'a dyn Raster,
    store: &'a Store,
    /// What the names of bands begin from: each file, and how it is read.
    stamps: Vec<String>,
}

/// What was taken into the store, and what is remarkable of it.
pub(crate) struct Taken {
    /// Of chunks whose samples are in the store.
    pub(crate) names: BTreeMap<ChunkId, Name>,
    /// Chunks that follow from a coarse file's own samples, and from which.
    pub(crate) interpolated: BTreeMap<ChunkId, Origin>,
    /// Of own samples, for each coarse file.
    pub(crate) own: Vec<BTreeMap<OwnChunk, Name>>,
    /// None where nothing has a height.
    pub(crate) extremes: Option<Extremes>,
    /// For each file.
    pub(crate) faults: Vec<Faults>,
}

impl<'a> Intake<'a> {
    pub(crate) fn new(raster: &'a dyn Raster, store: &'a Store) -> Self {
        Self {
            raster,
            store,
            stamps: raster.stamps(),
        }
    }

    /// Samples of all files.
    pub(crate) fn sample_count(&self) -> u64 {
        let extents = self.raster.extents().into_iter();
        extents.map(|[columns, rows]| (columns.len() * rows.len()) as u64).sum()
    }

    /// What is to be read, band by band, as far as files reach.
    pub(crate) fn bands(&self) -> Vec<Band> {
        let corner = first_sample(self.raster);
        let tall = BAND[1].min(self.raster.block_rows().div_ceil(CHUNK));
        let mut occupied: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
        for [columns, rows] in self.raster.extents() {
            for chunk in chunks_under(0, corner, [&columns, &rows]) {
                occupied
                    .entry(chunk.y as usize / tall)
                    .or_default()
                    .insert(chunk.x as usize);
            }
        }
        let band = |row: usize, columns: Range<usize>| {
            let rows = row * tall..(row + 1) * tall;
            Band::Lattice(self.extent_of([columns, rows]))
        };
        let runs_of = |(row, columns): (usize, BTreeSet<usize>)| {
            runs(columns).into_iter().map(move |run| (row, run)).collect::<Vec<_>>()
        };
        let own = self.raster.own_grids().iter().enumerate().flat_map(|(grid, own)| {
            let [_, rows] = own.reached();
            let rows = (rows.start / CHUNK) as u32..rows.end.div_ceil(CHUNK) as u32;
            rows.map(move |row| Band::Own { grid, row })
        });
        let of_lattice = occupied.into_iter().flat_map(runs_of);
        of_lattice.map(|(row, run)| band(row, run)).chain(own).collect()
    }

    /// Columns and rows of the raster in some columns and rows of chunks.
    fn extent_of(&self, [columns, rows]: [Range<usize>; 2]) -> Extent {
        let (corner, size) = (first_sample(self.raster), self.raster.size());
        let within = |chunks: Range<usize>, axis: usize| {
            (chunks.start * CHUNK).saturating_sub(corner[axis])..(chunks.end * CHUNK - corner[axis]).min(size[axis])
        };
        Extent {
            columns: within(columns, 0),
            rows: within(rows, 1),
        }
    }

    /// Brings all bands into the store, those that are not there yet.
    pub(crate) fn take(&self, bands: &[Band], progress: &Progress) -> Result<Taken> {
        let mut taken = Taken {
            names: BTreeMap::new(),
            interpolated: BTreeMap::new(),
            own: vec![BTreeMap::new(); self.raster.own_grids().len()],
            extremes: None,
            faults: vec![Faults::default(); self.raster.extents().len()],
        };
        for band in bands {
            let record = self.record(band, progress)?;
            for (x, y, name) in &record.chunks {
                let name = Name::parse(name).context("a record of chunks is damaged")?;
                match band {
                    Band::Lattice(_) => taken.names.insert(ChunkId { level: 0, x: *x, y: *y }, name),
                    Band::Own { grid, .. } => taken.own[*grid].insert(OwnChunk { x: *x, y: *y }, name),
                };
            }
            for (x, y, origin) in record.interpolated {
                ensure!(origin.file < taken.own.len(), "a record of chunks is damaged");
                taken.interpolated.insert(ChunkId { level: 0, x, y }, origin);
            }
            taken.extremes = of_both(taken.extremes, record.extremes);
            for (file, faults) in self.files_in(band).into_iter().zip(record.faults) {
                taken.faults[file] = taken.faults[file].with(faults);
            }
        }
        Ok(taken)
    }

    /// Numbers of the files that reach into a band.
    fn files_in(&self, band: &Band) -> Vec<usize> {
        let extent = match band {
            Band::Lattice(extent) => extent,
            Band::Own { grid, .. } => return vec![self.raster.own_grids()[*grid].file()],
        };
        let extents = self.raster.extents().into_iter().enumerate();
        extents
            .filter(|(_, of_file)| samples_of(of_file, extent) > 0)
            .map(|(file, _)| file)
            .collect()
    }

    /// Samples of all files in a band.
    fn samples_in(&self, band: &Band) -> u64 {
        match band {
            Band::Lattice(extent) => self.samples_in_extent(extent),
            Band::Own { .. } => 0,
        }
    }

    fn samples_in_extent(&self, extent: &Extent) -> u64 {
        let files = self.raster.extents();
        files.iter().map(|file| samples_of(file, extent)).sum()
    }

    /// Where a band's record is, named by the files in it and its place on the lattice.
    fn key(&self, band: &Band) -> String {
        let place = match band {
            Band::Lattice(Extent { columns, rows }) => {
                let [left, top] = first_sample(self.raster);
                format!(
                    "{:?}",
                    [left + columns.start, top + rows.start, columns.len(), rows.len()]
                )
            }
            Band::Own { grid, row } => {
                let [columns, rows] = self.raster.own_grids()[*grid].reached();
                format!("own {columns:?} {rows:?} {row}")
            }
        };
        let files = self.files_in(band).into_iter().map(|file| self.stamps[file].as_bytes());
        format!("records/{}.json", Name::of(files.chain([place.as_bytes()])))
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
        let record = match band {
            Band::Lattice(extent) => self.read(band, extent, progress)?,
            Band::Own { grid, row } => self.read_own(&self.raster.own_grids()[*grid], *row)?,
        };
        self.store.put(&key, serde_json::to_vec(&record)?)?;
        Ok(record)
    }

    /// Reads a band, but for what follows from own samples of a coarse file.
    fn read(&self, band: &Band, extent: &Extent, progress: &Progress) -> Result<BandRecord> {
        let corner = first_sample(self.raster);
        let ids: Vec<ChunkId> = chunks_under(0, corner, [&extent.columns, &extent.rows]).collect();
        let mut record = BandRecord {
            chunks: Vec::new(),
            extremes: None,
            faults: vec![Faults::default(); self.files_in(band).len()],
            interpolated: Vec::new(),
        };
        let mut others: BTreeMap<u32, BTreeSet<usize>> = BTreeMap::new();
        let alone = ids.par_iter().map(|&id| Ok((id, self.alone_in(id)?)));
        for (id, alone) in alone.collect::<Result<Vec<_>>>()? {
            match alone {
                Some((origin, extremes)) => {
                    record.interpolated.push((id.x, id.y, origin));
                    record.extremes = of_both(record.extremes, extremes);
                    let [x, y] = [id.x as usize, id.y as usize];
                    progress.advance(self.samples_in_extent(&self.extent_of([x..x + 1, y..y + 1])));
                }
                None => {
                    others.entry(id.y).or_default().insert(id.x as usize);
                }
            }
        }
        if record.interpolated.is_empty() {
            self.read_chunks(band, extent, &mut record)?;
            return Ok(record);
        }
        for (row, columns) in others {
            let row = row as usize;
            for run in runs(columns) {
                self.read_chunks(band, &self.extent_of([run, row..row + 1]), &mut record)?;
            }
        }
        Ok(record)
    }

    /// What a chunk follows from, if a coarse file is alone and whole there, and the extremes of its samples.
    fn alone_in(&self, id: ChunkId) -> Result<Option<(Origin, Option<Extremes>)>> {
        let first = first_of(self.raster.origin(), id);
        let rectangle = first.map(|first| first..first + CHUNK as i64);
        let own_grids = self.raster.own_grids().iter().enumerate();
        for (file, own) in own_grids.filter(|(_, own)| own.is_alone_in(&rectangle)) {
            let Some(samples) = own.samples_under(first, CHUNK / NODES) else {
                continue;
            };
            let [columns, rows] = samples.clone();
            let heights = self.raster.read_own(own, columns, rows)?;
            if !heights.iter().any(|height| height.is_nan()) {
                return Ok(Some((Origin { file, samples }, Extremes::of(&heights))));
            }
        }
        Ok(None)
    }

    /// Reads a rectangle of chunks of a band.
    fn read_chunks(&self, band: &Band, extent: &Extent, record: &mut BandRecord) -> Result<()> {
        let Extent { columns, rows } = extent;
        let rectangle = self.raster.read(columns.clone(), rows.clone())?;
        let corner = first_sample(self.raster);
        let ids: Vec<ChunkId> = chunks_under(0, corner, [columns, rows]).collect();
        let chunks: Result<Vec<_>> = ids
            .into_par_iter()
            .map(|id| self.put(id, extent, &rectangle))
            .filter_map(Result::transpose)
            .collect();
        record.chunks.extend(chunks?);
        record.extremes = of_both(record.extremes, Extremes::of(&rectangle.heights));
        for (file, faults) in self.files_in(band).into_iter().zip(&mut record.faults) {
            *faults = faults.with(rectangle.faults[file]);
        }
        Ok(())
    }

    /// Puts a chunk of what was read into the store; none where nothing has a height.
    fn put(&self, id: ChunkId, extent: &Extent, rectangle: &Rectangle) -> Result<Option<(u32, u32, String)>> {
        let Extent { columns: read, rows } = extent;
        let [left, top] = first_sample(self.raster);
        let (x, y) = (id.x as usize, id.y as usize);
        let mut samples = vec![f32::NAN; CHUNK * CHUNK];
        let mut filled = Vec::new();
        let columns = overlap(x, left, read);
        for row in overlap(y, top, rows) {
            let from = (row - rows.start) * read.len() + columns.start - read.start;
            let to = (top + row - y * CHUNK) * CHUNK + left + columns.start - x * CHUNK;
            samples[to..to + columns.len()].copy_from_slice(&rectangle.heights[from..from + columns.len()]);
            let of_row = filled_among(&rectangle.filled, from..from + columns.len());
            filled.extend(of_row.iter().map(|index| index - from + to));
        }
        if samples.iter().all(|sample| sample.is_nan()) {
            return Ok(None);
        }
        let bytes = samples_to_bytes(&samples, &filled);
        let name = Name::of([bytes.as_slice()]);
        self.store.put(&samples_key(id, name), bytes)?;
        Ok(Some((id.x, id.y, name.to_string())))
    }

    /// Reads a row of chunks of a coarse file's own samples.
    fn read_own(&self, own: &OwnGrid, row: u32) -> Result<BandRecord> {
        let [columns, rows] = own.reached();
        let rows = overlap(row as usize, 0, &rows);
        let samples = self.raster.read_own(own, columns.clone(), rows.clone())?;
        let mut chunks = Vec::new();
        for x in (columns.start / CHUNK) as u32..columns.end.div_ceil(CHUNK) as u32 {
            let across = overlap(x as usize, 0, &columns);
            let mut chunk = vec![f32::NAN; CHUNK * CHUNK];
            for line in rows.clone() {
                let from = (line - rows.start) * columns.len() + across.start - columns.start;
                let to = line % CHUNK * CHUNK + across.start % CHUNK;
                chunk[to..to + across.len()].copy_from_slice(&samples[from..from + across.len()]);
            }
            let bytes = to_bytes(&chunk);
            let name = Name::of([bytes.as_slice()]);
            self.store
                .put(&interpolated::own_key(OwnChunk { x, y: row }, name), bytes)?;
            chunks.push((x, row, name.to_string()));
        }
        Ok(BandRecord {
            chunks,
            extremes: None,
            faults: Vec::new(),
            interpolated: Vec::new(),
        })
    }
}

/// Of both, as far as there are any.
fn of_both(one: Option<Extremes>, other: Option<Extremes>) -> Option<Extremes> {
    one.into_iter().chain(other).reduce(Extremes::with)
}

/// Those of the indices of filled samples, which are in order, that are in a range.
fn filled_among(filled: &[usize], range: Range<usize>) -> &[usize] {
    let [first, end] = [range.start, range.end].map(|index| filled.partition_point(|&filled| filled < index));
    &filled[first..end]
}

/// Samples of a file in a rectangle.
fn samples_of([columns, rows]: &[Range<usize>; 2], extent: &Extent) -> u64 {
    let common = |a: &Range<usize>, b: &Range<usize>| a.end.min(b.end).saturating_sub(a.start.max(b.start)) as u64;
    common(columns, &extent.columns) * common(rows, &extent.rows)
}

/// The chunks of a level, or of the top one if it is lower, that samples of the files may be in.
pub(crate) fn chunks_over_files(raster: &dyn Raster, level: u8) -> Vec<ChunkId> {
    let level = level.min(top_level(raster.size()));
    let corner = first_sample(raster);
    let under = |[columns, rows]: [Range<usize>; 2]| chunks_under(level, corner, [&columns, &rows]);
    let found: BTreeSet<ChunkId> = raster.extents().into_iter().flat_map(under).collect();
    found.into_iter().collect()
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
