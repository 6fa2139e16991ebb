//! The samples of opened rasters, brought into a store: read once, in whole blocks, by bands of rows as far as files reach, and cut
//! into chunks.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use terrain_core::height_field::relief::CHUNK;

use crate::chunks::{self, ChunkId, chunks_under, overlap, samples_key, samples_to_bytes, top_level};
use crate::progress::Progress;
use crate::samples::{Extremes, Faults, Raster};
use crate::store::{Name, Store};

/// Columns and rows of chunks that are read at once.
const BAND: [usize; 2] = [256, 4];

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
    /// For each file that reaches into it what cannot be right in it.
    faults: Vec<Faults>,
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
    pub(crate) names: BTreeMap<ChunkId, Name>,
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
        let corner = chunks::first_sample(self.raster);
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
            faults: vec![Faults::default(); self.raster.extents().len()],
        };
        for band in bands {
            let record = self.record(band, progress)?;
            for (x, y, name) in &record.chunks {
                let name = Name::parse(name).context("a record of chunks is damaged")?;
                taken.names.insert(ChunkId { level: 0, x: *x, y: *y }, name);
            }
            let both = taken.extremes.into_iter().chain(record.extremes);
            taken.extremes = both.reduce(Extremes::with);
            for (file, faults) in self.files_in(band).into_iter().zip(record.faults) {
                taken.faults[file] = taken.faults[file].with(faults);
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
        let [left, top] = chunks::first_sample(self.raster);
        let place = [
            left + band.columns.start,
            top + band.rows.start,
            band.columns.len(),
            band.rows.len(),
        ];
        let files = self.files_in(band).into_iter().map(|file| self.stamps[file].as_bytes());
        format!(
            "records/{}.json",
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
        let [left, top] = chunks::first_sample(self.raster);
        let ids: Vec<ChunkId> = chunks_under(0, [left, top], [&band.columns, &band.rows]).collect();
        let put = |id: ChunkId| -> Result<Option<(u32, u32, String)>> {
            let (x, y) = (id.x as usize, id.y as usize);
            let mut samples = vec![f32::NAN; CHUNK * CHUNK];
            let mut filled = Vec::new();
            let columns = overlap(x, left, &band.columns);
            for row in overlap(y, top, &band.rows) {
                let from = (row - band.rows.start) * band.columns.len() + columns.start - band.columns.start;
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
        };
        let chunks: Result<Vec<_>> = ids.into_par_iter().map(put).filter_map(Result::transpose).collect();
        let faults = self
            .files_in(band)
            .into_iter()
            .map(|file| rectangle.faults[file])
            .collect();
        Ok(BandRecord {
            chunks: chunks?,
            extremes: Extremes::of(&rectangle.heights),
            faults,
        })
    }
}

/// Those of the indices of filled samples, which are in order, that are in a range.
fn filled_among(filled: &[usize], range: Range<usize>) -> &[usize] {
    let [first, end] = [range.start, range.end].map(|index| filled.partition_point(|&filled| filled < index));
    &filled[first..end]
}

/// Samples of a file in a band.
fn samples_of([columns, rows]: &[Range<usize>; 2], band: &Band) -> u64 {
    let common = |a: &Range<usize>, b: &Range<usize>| a.end.min(b.end).saturating_sub(a.start.max(b.start)) as u64;
    common(columns, &band.columns) * common(rows, &band.rows)
}

/// The chunks of a level, or of the top one if it is lower, that samples of the files may be in.
pub(crate) fn chunks_over_files(raster: &dyn Raster, level: u8) -> Vec<ChunkId> {
    let level = level.min(top_level(raster.size()));
    let corner = chunks::first_sample(raster);
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
