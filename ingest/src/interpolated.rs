//! Ground that one coarse file alone covers: its heights on the lattice, and the relief of these, follow from its own samples.
//!
//! ```text
//! samples of a chunk   bilinear between own samples, at the places of the lattice's
//! a block's bound      the surface is bilinear in each of the file's cells: against a plane it has its extremes where the block's
//!                      sides and the lines between cells cross; what the block's patch is bent, and what places are, is added
//! ```
//! So a country around a site costs what its own samples cost, not what it would have at the site's.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use anyhow::{Context, Result};
use glam::{DMat2, DVec2};
use moka::sync::Cache;
use serde::{Deserialize, Serialize};
use terrain_core::height_field::relief::{Blocks, CHUNK, Chunk, Computed};

use crate::chunk_grid::{ChunkId, FIRST, from_bytes, overlap};
use crate::raster::{NODES, OwnGrid, Places, between};
use crate::samples::{CoarseWindow, Raster};
use crate::store::{Name, Store};

/// Bytes of own samples of a file at hand.
const AT_HAND: u64 = 32 << 20;
/// Metres, and as a share of the greatest height, by which heights may be off that are rounded to single precision and taken at places
/// between others.
const ROUNDING: [f64; 2] = [1e-4, 2.5e-7];

/// Which chunk of 256 × 256 own samples of a file: its column and row among these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct OwnChunk {
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// What a chunk of samples follows from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Origin {
    /// The place of a coarse file among those of the raster.
    pub(crate) file: usize,
    /// Columns and rows of the file that all heights of the chunk are between.
    pub(crate) samples: [Range<usize>; 2],
}

/// Where own samples are in a store.
pub(crate) fn own_key(chunk: OwnChunk, name: Name) -> String {
    format!("own/{}-{}-{name}", chunk.x, chunk.y)
}

/// Column and row, counted from a raster's first sample, of a chunk's first; `origin` is that of the raster.
pub(crate) fn first_of(origin: [i64; 2], id: ChunkId) -> [i64; 2] {
    let side = (CHUNK as i64) << id.level;
    [
        i64::from(id.x) * side - FIRST - origin[0],
        i64::from(id.y) * side - FIRST - origin[1],
    ]
}

/// The chunks that follow from own samples of coarse files.
pub(crate) struct Interpolated {
    files: Vec<OwnSamples>,
    /// Column and row of the raster's first sample.
    origin: [i64; 2],
    /// Of chunks of samples.
    chunks: BTreeMap<ChunkId, Origin>,
    /// Place among `files`, of chunks of the relief all of whose corners follow from one.
    relief: BTreeMap<ChunkId, usize>,
}

impl Interpolated {
    /// Of a raster whose own samples are in the store by these names, those of each coarse file.
    pub(crate) fn new(
        raster: &dyn Raster,
        store: &Store,
        chunks: BTreeMap<ChunkId, Origin>,
        own: Vec<BTreeMap<OwnChunk, Name>>,
    ) -> Self {
        let files = raster.own_grids().iter().zip(own);
        let files: Vec<OwnSamples> = files
            .map(|(grid, names)| OwnSamples::new(Arc::clone(grid), names, store))
            .collect();
        let relief = relief_of(&chunks, |file| files[file].levels());
        Self {
            files,
            origin: raster.origin(),
            chunks,
            relief,
        }
    }

    /// All chunks of samples, and what names them: the own samples under each, and where these are.
    ///
    /// # Errors
    /// When own samples are missing.
    pub(crate) fn names(&self) -> Result<Vec<(ChunkId, Name)>> {
        let fingerprints: Vec<String> = self.files.iter().map(|file| file.grid.fingerprint()).collect();
        let name = |(&id, origin): (&ChunkId, &Origin)| {
            let file = &self.files[origin.file];
            let own = chunks_over(&origin.samples).into_iter().map(|chunk| file.name(chunk));
            let own: Vec<u8> = own
                .collect::<Result<Vec<Name>>>()?
                .iter()
                .flat_map(|name| name.bytes())
                .collect();
            let place = format!("{id:?}");
            let parts = [fingerprints[origin.file].as_bytes(), place.as_bytes(), &own];
            Ok((id, Name::of(parts)))
        };
        self.chunks.iter().map(name).collect()
    }

    /// Whether a chunk's samples follow from a coarse file's.
    pub(crate) fn has(&self, id: ChunkId) -> bool {
        self.chunks.contains_key(&id)
    }

    /// Whether a chunk of the relief follows from a coarse file's samples.
    pub(crate) fn has_relief(&self, id: ChunkId) -> bool {
        self.relief.contains_key(&id)
    }

    /// Heights of some columns and rows of a chunk, row by row; none where it does not follow from a coarse file's samples.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn heights(&self, id: ChunkId, columns: Range<usize>, rows: Range<usize>) -> Result<Option<Vec<f32>>> {
        let Some(origin) = self.chunks.get(&id) else {
            return Ok(None);
        };
        let file = &self.files[origin.file];
        // Places begin at one of those that the others are between.
        let first = [&columns, &rows].map(|range| range.start / NODES * NODES);
        let of_chunk = first_of(self.origin, id);
        let from = [0, 1].map(|axis| of_chunk[axis] + first[axis] as i64);
        let nodes = [columns.end - first[0], rows.end - first[1]].map(|samples| (samples - 1) / NODES + 2);
        let places = file.grid.places(from, NODES, nodes);
        let window = file.window(&places.nodes)?;
        let row = |row: usize| columns.clone().map(move |column| [column - first[0], row - first[1]]);
        let height = |[column, row]: [usize; 2]| window.height(places.at(column, row)) as f32;
        Ok(Some(rows.flat_map(row).map(height).collect()))
    }

    /// Some chunks and what they follow from, where that is one file for all of them.
    fn origins(&self, chunks: impl Iterator<Item = ChunkId>) -> Option<Vec<(ChunkId, &Origin)>> {
        let origins: Vec<(ChunkId, &Origin)> = chunks
            .map(|id| Some((id, self.chunks.get(&id)?)))
            .collect::<Option<_>>()?;
        let is_one = origins.windows(2).all(|pair| pair[0].1.file == pair[1].1.file);
        is_one.then_some(origins)
    }

    /// Whether some chunks all follow from one file's samples.
    pub(crate) fn has_all(&self, chunks: impl Iterator<Item = ChunkId>) -> bool {
        self.origins(chunks).is_some()
    }

    /// Heights of columns and rows under some chunks, counted from `before` the raster's first; none where they do not all follow from one
    /// file's samples.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn window(
        &self,
        chunks: impl Iterator<Item = ChunkId>,
        before: [usize; 2],
        [columns, rows]: [Range<usize>; 2],
    ) -> Result<Option<Box<dyn CoarseWindow + '_>>> {
        let Some(origins) = self.origins(chunks) else {
            return Ok(None);
        };
        let Some(&(first, Origin { file, samples })) = origins.first() else {
            return Ok(None);
        };
        let union = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        let own = origins.iter().fold(samples.clone(), |all, (_, origin)| {
            [0, 1].map(|axis| union(&all[axis], &origin.samples[axis]))
        });
        let file = &self.files[*file];
        let before = before.map(|before| before as i64);
        let first = first_of(self.origin, first);
        let nodes = |axis: usize, range: &Range<usize>| {
            let count = range.end as i64 - before[axis] - first[axis];
            count as usize / NODES + 2
        };
        let size = [nodes(0, &columns), nodes(1, &rows)];
        Ok(Some(Box::new(FollowingWindow {
            grid: &file.grid,
            own: file.read(own)?,
            columns,
            rows,
            before,
            first,
            nodes: vec![OnceCell::new(); size[0] * size[1]],
            across: size[0],
        })))
    }

    /// A chunk of the relief, if it follows from a coarse file's samples.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub(crate) fn relief(&self, id: ChunkId) -> Result<Option<Chunk>> {
        let Some(&file) = self.relief.get(&id) else {
            return Ok(None);
        };
        let file = &self.files[file];
        let (step, first) = (1 << id.level, first_of(self.origin, id));
        // Corners are at these places, or between them.
        let apart = step.max(NODES);
        let across = CHUNK * step / apart + 2;
        let places = file.grid.places(first, apart, [across, across]);
        let window = file.window(&places.nodes)?;
        let highest = window
            .heights
            .iter()
            .fold(0.0, |far: f64, &height| far.max(height.abs().into()));
        let blocks = FollowingBlocks {
            bent: if step > NODES { places.bend() } else { DVec2::ZERO },
            rounding: ROUNDING[0] + ROUNDING[1] * highest,
            step,
            window,
            places,
        };
        Ok(Some(Chunk {
            corners: Vec::new(),
            guessed: Vec::new(),
            residuals: Vec::new(),
            steepest: blocks.steepest() as f32,
            computed: Some(Computed(Arc::new(blocks))),
        }))
    }
}

/// The chunks of the relief all of whose corners follow from one file, up to the level that `levels` tells of each.
fn relief_of(chunks: &BTreeMap<ChunkId, Origin>, levels: impl Fn(usize) -> u8) -> BTreeMap<ChunkId, usize> {
    let is_whole = |id: ChunkId, file: usize| {
        let following = id.with_following();
        let is_alike = |beside| chunks.get(beside).is_some_and(|origin| origin.file == file);
        following.iter().all(is_alike)
    };
    let mut below: BTreeMap<ChunkId, usize> = chunks
        .iter()
        .map(|(&id, origin)| (id, origin.file))
        .filter(|&(id, file)| is_whole(id, file))
        .collect();
    let mut relief = below.clone();
    while !below.is_empty() {
        let above = below.iter().map(|(id, &file)| (id.above(), file));
        let above: BTreeMap<ChunkId, usize> = above
            .filter(|&(id, file)| id.level <= levels(file))
            .filter(|&(id, file)| id.parts().iter().all(|part| below.get(part) == Some(&file)))
            .collect();
        relief.extend(above.iter().map(|(&id, &file)| (id, file)));
        below = above;
    }
    relief
}

/// Own samples of a file, in a store.
struct OwnSamples {
    grid: Arc<OwnGrid>,
    names: BTreeMap<OwnChunk, Name>,
    store: Store,
    at_hand: Cache<OwnChunk, Arc<Vec<f32>>>,
}

impl OwnSamples {
    fn new(grid: Arc<OwnGrid>, names: BTreeMap<OwnChunk, Name>, store: &Store) -> Self {
        Self {
            grid,
            names,
            store: store.clone(),
            at_hand: Cache::builder()
                .weigher(|_, samples: &Arc<Vec<f32>>| 4 * samples.len() as u32)
                .max_capacity(AT_HAND)
                .build(),
        }
    }

    /// The highest level of blocks that are no wider than the file's cells.
    fn levels(&self) -> u8 {
        self.grid.coarseness().log2().floor() as u8
    }

    fn name(&self, chunk: OwnChunk) -> Result<Name> {
        let name = self.names.get(&chunk);
        name.copied()
            .with_context(|| format!("own samples {} {} are missing", chunk.x, chunk.y))
    }

    fn chunk(&self, chunk: OwnChunk) -> Result<Arc<Vec<f32>>> {
        if let Some(samples) = self.at_hand.get(&chunk) {
            return Ok(samples);
        }
        let key = own_key(chunk, self.name(chunk)?);
        let bytes = self.store.expect(&key)?;
        anyhow::ensure!(bytes.len() == 4 * CHUNK * CHUNK, "{key} is damaged");
        let samples = Arc::new(from_bytes(&bytes));
        self.at_hand.insert(chunk, Arc::clone(&samples));
        Ok(samples)
    }

    /// The own samples around some places.
    fn window(&self, places: &[DVec2]) -> Result<OwnWindow> {
        self.read(self.grid.samples_around(places, DVec2::ONE))
    }

    fn read(&self, [columns, rows]: [Range<usize>; 2]) -> Result<OwnWindow> {
        let mut heights = vec![f32::NAN; columns.len() * rows.len()];
        for id in chunks_over(&[columns.clone(), rows.clone()]) {
            let chunk = self.chunk(id)?;
            let across = overlap(id.x as usize, 0, &columns);
            for row in overlap(id.y as usize, 0, &rows) {
                let from = row % CHUNK * CHUNK + across.start % CHUNK;
                let to = (row - rows.start) * columns.len() + across.start - columns.start;
                heights[to..to + across.len()].copy_from_slice(&chunk[from..from + across.len()]);
            }
        }
        Ok(OwnWindow { columns, rows, heights })
    }
}

/// A rectangle of a file's own samples.
#[derive(Debug)]
struct OwnWindow {
    columns: Range<usize>,
    rows: Range<usize>,
    heights: Vec<f32>,
}

impl OwnWindow {
    fn sample(&self, column: usize, row: usize) -> f64 {
        f64::from(self.heights[(row - self.rows.start) * self.columns.len() + column - self.columns.start])
    }

    /// The bilinear height in the cell at a place.
    fn height(&self, place: DVec2) -> f64 {
        let cell = |at: f64, range: &Range<usize>| (at.max(0.0) as usize).clamp(range.start, range.end - 2);
        let (column, row) = (cell(place.x, &self.columns), cell(place.y, &self.rows));
        let share = place - DVec2::new(column as f64, row as f64);
        let along = |row: usize| {
            let (left, right) = (self.sample(column, row), self.sample(column + 1, row));
            left + (right - left) * share.x
        };
        let (above, below) = (along(row), along(row + 1));
        above + (below - above) * share.y
    }

    /// Metres by which samples side by side differ at most: in a row, in a column.
    fn steepest(&self) -> DVec2 {
        let width = self.columns.len();
        let rows = self.heights.chunks_exact(width);
        let across = rows
            .flat_map(|row| row.windows(2))
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f32::max);
        let down = self.heights.iter().zip(&self.heights[width..]);
        let down = down.map(|(above, below)| (below - above).abs()).fold(0.0, f32::max);
        DVec2::new(across.into(), down.into())
    }
}

/// Chunks over a rectangle of own samples.
fn chunks_over([columns, rows]: &[Range<usize>; 2]) -> Vec<OwnChunk> {
    let span = |range: &Range<usize>| (range.start / CHUNK) as u32..range.end.div_ceil(CHUNK) as u32;
    let across = span(columns);
    span(rows)
        .flat_map(|y| across.clone().map(move |x| OwnChunk { x, y }))
        .collect()
}

/// The blocks of a chunk over own samples of a file.
#[derive(Debug)]
struct FollowingBlocks {
    window: OwnWindow,
    places: Places,
    /// Samples of the lattice along the side of a block.
    step: usize,
    /// Cells of the file by which places may leave the bilinear ones inside a block.
    bent: DVec2,
    /// Metres.
    rounding: f64,
}

impl FollowingBlocks {
    fn place(&self, column: usize, row: usize) -> DVec2 {
        self.places.at(column * self.step, row * self.step)
    }

    /// Metres that neighbouring samples of the lattice may differ at most.
    fn steepest(&self) -> f64 {
        let Places {
            nodes,
            across: in_row,
            apart,
        } = &self.places;
        let slope = self.window.steepest();
        let steps_across = nodes.chunks_exact(*in_row).flat_map(|row| row.windows(2));
        let steps_across = steps_across.map(|pair| (pair[1] - pair[0]).abs());
        let steps_down = nodes.iter().zip(&nodes[*in_row..]);
        let steps_down = steps_down.map(|(&above, &below)| (below - above).abs());
        let rise = |cells: DVec2| slope.dot((cells + self.bent) / *apart as f64);
        steps_across.chain(steps_down).map(rise).fold(0.0, f64::max) + 2.0 * self.rounding
    }
}

impl Blocks for FollowingBlocks {
    fn corner(&self, column: usize, row: usize) -> f32 {
        self.window.height(self.place(column, row)) as f32
    }

    fn residual(&self, column: usize, row: usize) -> [f32; 2] {
        if self.step == 1 {
            return [0.0; 2];
        }
        let [p, q, r, s] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| self.place(column + x, row + y));
        let [a, b, c, d] = [p, q, r, s].map(|place| self.window.height(place));
        // The patch is a plane, over columns and rows of the file, and what it is bent.
        let (mean, twist) = ((a + b + c + d) / 4.0, (a - b - c + d).abs() / 4.0);
        let middle = (p + q + r + s) / 4.0;
        let sides = DMat2::from_cols((q + s - p - r) / 2.0, (r + s - p - q) / 2.0);
        let slope = sides.inverse().transpose() * DVec2::new((b + d - a - c) / 2.0, (c + d - a - b) / 2.0);
        let astray = (p - q - r + s).abs() / 4.0 + self.bent;
        let slack = twist + (slope.abs() * astray).element_sum() + self.rounding;
        let low = p.min(q).min(r).min(s) - self.bent;
        let high = p.max(q).max(r).max(s) + self.bent;
        let mut bound = [f64::INFINITY, f64::NEG_INFINITY];
        for y in crossed(low.y, high.y) {
            for x in crossed(low.x, high.x) {
                let place = DVec2::new(x, y);
                let above = self.window.height(place) - mean - slope.dot(place - middle);
                bound = [bound[0].min(above), bound[1].max(above)];
            }
        }
        [
            ((bound[0] - slack) as f32).next_down(),
            ((bound[1] + slack) as f32).next_up(),
        ]
    }

    fn bytes(&self) -> usize {
        size_of::<Self>() + 4 * self.window.heights.len() + size_of::<DVec2>() * self.places.nodes.len()
    }
}

/// A rectangle of the lattice over own samples of a file. Places are made when they are asked for.
struct FollowingWindow<'a> {
    grid: &'a OwnGrid,
    own: OwnWindow,
    columns: Range<usize>,
    rows: Range<usize>,
    /// Columns and rows before the raster's first sample, and where places begin, counted from that.
    before: [i64; 2],
    first: [i64; 2],
    /// Places of every [`NODES`]-th sample, `across` in a row.
    nodes: Vec<OnceCell<DVec2>>,
    across: usize,
}

impl FollowingWindow<'_> {
    fn place(&self, column: usize, row: usize) -> DVec2 {
        let from_first = |axis: usize, index: usize| (index as i64 - self.before[axis] - self.first[axis]) as usize;
        let at = [from_first(0, column), from_first(1, row)];
        let node = |right: usize, below: usize| {
            let node = [at[0] / NODES + right, at[1] / NODES + below];
            *self.nodes[node[1] * self.across + node[0]].get_or_init(|| {
                self.grid
                    .place([0, 1].map(|axis| self.first[axis] + (node[axis] * NODES) as i64))
            })
        };
        between(node, at, NODES)
    }
}

impl CoarseWindow for FollowingWindow<'_> {
    fn height(&self, column: usize, row: usize) -> f32 {
        self.own.height(self.place(column, row)) as f32
    }

    fn steepest(&self) -> f32 {
        /// By how much a step may be longer in the file than at the places where it is looked at.
        const LONGER: f64 = 1.25;
        const STRETCHES: usize = 4;
        let at = |range: &Range<usize>, part: usize| range.start + (range.len() - 2) * part / STRETCHES;
        let longest = (0..=STRETCHES)
            .flat_map(|down| (0..=STRETCHES).map(move |across| (across, down)))
            .map(|(across, down)| (at(&self.columns, across), at(&self.rows, down)))
            .flat_map(|(column, row)| {
                let place = self.place(column, row);
                [self.place(column + 1, row), self.place(column, row + 1)].map(|next| place.distance(next))
            })
            .fold(0.0, f64::max);
        (self.own.steepest().length() * longest * LONGER) as f32
    }

    fn around_own(&self) -> Vec<[usize; 2]> {
        let own = self.own.rows.clone();
        let samples = own.flat_map(|row| self.own.columns.clone().map(move |column| (column, row)));
        let on_mosaic = samples.flat_map(|(column, row)| self.grid.on_mosaic(column, row));
        let around = on_mosaic.flat_map(|place| {
            let first = place.floor();
            [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|step| first + step)
        });
        let in_window = around.filter_map(|sample| {
            let at = sample + DVec2::new(self.before[0] as f64, self.before[1] as f64);
            let is_inside = |range: &Range<usize>, at: f64| at >= range.start as f64 && at < range.end as f64;
            (is_inside(&self.columns, at.x) && is_inside(&self.rows, at.y)).then_some([at.x as usize, at.y as usize])
        });
        in_window.collect()
    }
}

/// Both ends of a stretch, and all whole numbers between.
fn crossed(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let whole = low.ceil() as i64..=high.floor() as i64;
    [low, high].into_iter().chain(whole.map(|line| line as f64))
}

#[cfg(test)]
#[path = "interpolated_tests.rs"]
mod tests;
