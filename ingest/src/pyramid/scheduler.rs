//! Which job runs when: subtrees depth first, a parent as soon as its children are there, and nothing that is finished.
//! What lives in memory is a path of the tree.

use std::ops::Range;
use std::time::Instant;

use anyhow::{Result, bail};
use rayon::prelude::*;

use super::family::Child;
use super::finished::{FinishedTiles, TileRecord};
use super::jobs::Jobs;
use crate::chunk_grid::to_bytes;
use crate::lattice::Square;
use crate::progress::Progress;
use crate::samples::Samples;
use crate::store::Name;

/// Levels below a parent's own at which the names of chunks stand for the samples under it: a chunk is then a quarter as wide as
/// the tile, so that few samples beside it make it another.
const NAMED_LEVEL_BELOW: u8 = 3;

/// Makes tiles that are missing.
pub(crate) struct Scheduler<'a> {
    pub(crate) jobs: Jobs<'a>,
    pub(crate) tiles: FinishedTiles<'a>,
    pub(crate) progress: &'a Progress,
    /// Whether tiles that are missing are made.
    pub(crate) makes_tiles: bool,
}

impl Scheduler<'_> {
    /// Leaves that may have samples, to tell how long the work is.
    pub(crate) fn count_leaves(&self, square: Square) -> u64 {
        match self.jobs.cells_with_samples(square) {
            None => 0,
            Some(_) if self.jobs.plan.depths.is_leaf(square) => 1,
            Some(_) => square
                .children()
                .into_iter()
                .map(|child| self.count_leaves(child))
                .sum(),
        }
    }

    /// Makes the tile of a square and all below it, the tile itself last; none where there is no surface.
    ///
    /// # Errors
    /// When samples cannot be read, or the store cannot be written.
    pub(crate) fn tiles(&self, square: Square) -> Result<Vec<TileRecord>> {
        let Some(cells) = self.jobs.cells_with_samples(square) else {
            return Ok(Vec::new());
        };
        if square.zoom != self.jobs.plan.subtree_zoom {
            return self.tile_and_below(square, cells);
        }
        let name = self.subtree_name(square, &cells);
        if let Some(finished) = self.tiles.subtree(square, name)? {
            self.progress.skip(self.count_leaves(square));
            return Ok(finished);
        }
        let made = self.tile_and_below(square, cells)?;
        self.tiles.keep_subtree(square, name, &made)?;
        Ok(made)
    }

    /// Whether a subtree is finished.
    pub(crate) fn has_subtree(&self, square: Square) -> Result<bool> {
        match self.jobs.cells_with_samples(square) {
            Some(cells) => self.tiles.has_subtree(square, self.subtree_name(square, &cells)),
            None => Ok(true),
        }
    }

    fn tile_and_below(&self, square: Square, cells: [Range<usize>; 2]) -> Result<Vec<TileRecord>> {
        let is_leaf = self.jobs.plan.depths.is_leaf(square);
        let (mut all, mut children) = (Vec::new(), Vec::new());
        if !is_leaf {
            let below = square.children().into_par_iter().map(|child| self.tiles(child));
            let below: Result<Vec<Vec<TileRecord>>> = below.collect();
            for records in below? {
                children.extend(records.last().cloned());
                all.extend(records);
            }
            if children.is_empty() {
                return Ok(all);
            }
        }
        let name = self.name(square, &cells, &children)?;
        let found = self.tiles.find(square, name)?;
        let is_found = found.is_some();
        all.extend(match found {
            Some(record) => Some(record),
            None => self.make(square, cells, name, &children)?,
        });
        match (is_leaf, is_found) {
            (true, true) => self.progress.skip(1),
            (true, false) => self.progress.advance(1),
            (false, _) => {}
        }
        Ok(all)
    }

    fn make(
        &self,
        square: Square,
        cells: [Range<usize>; 2],
        name: Name,
        children: &[TileRecord],
    ) -> Result<Option<TileRecord>> {
        if !self.makes_tiles {
            bail!("tile {} has not been made", square.address());
        }
        let started = Instant::now();
        let tile = if children.is_empty() {
            self.jobs.leaf(square, cells)?
        } else {
            let family: Result<Vec<Child>> = children.iter().map(|child| self.tiles.coarsest(child)).collect();
            Some(self.jobs.parent(square, cells, &family?)?)
        };
        self.jobs.raster.check()?;
        let Some(tile) = tile else { return Ok(None) };
        let seconds = started.elapsed().as_secs_f64();
        self.tiles.keep(square, name, tile, seconds).map(Some)
    }

    /// Everything that a tile is made from, as one number.
    fn name(&self, square: Square, cells: &[Range<usize>; 2], children: &[TileRecord]) -> Result<Name> {
        let below: Vec<u8> = children.iter().flat_map(|child| child.name.bytes()).collect();
        let samples = if self.jobs.plan.height(square) == 0 {
            let [columns, rows] = cells.clone();
            let heights = to_bytes(&self.jobs.raster.window(columns, rows)?.heights);
            [heights, self.jobs.bytes_of_filled(cells)?].concat()
        } else {
            self.names_of_chunks(square, cells)
        };
        let lines = if children.is_empty() {
            self.jobs.bytes_of_breaklines(cells)
        } else {
            Vec::new()
        };
        Ok(self.named(square, cells, &[&samples, &below], &lines))
    }

    /// Everything that a subtree is made from.
    fn subtree_name(&self, square: Square, cells: &[Range<usize>; 2]) -> Name {
        let depths = self.jobs.plan.depths.fingerprint(square);
        let lines = self.jobs.bytes_of_breaklines(cells);
        let parts = [self.names_of_chunks(square, cells), depths.into_bytes()];
        self.named(square, cells, &parts.each_ref().map(Vec::as_slice), &lines)
    }

    /// The name of what is made for a square by the plan, of such parts, and of breaklines if there are any. How far samples reach, and up to which level there are
    /// blocks of them, is a part of it, too.
    fn named(&self, square: Square, cells: &[Range<usize>; 2], parts: &[&[u8]], lines: &[u8]) -> Name {
        let raster = self.jobs.raster;
        let level = self.jobs.plan.height(square).min(raster.top());
        let place = format!("{square:?} {level} {:?}", raster.on_lattice(cells));
        let plan = self.jobs.plan.name.bytes();
        let all = [plan.as_slice(), place.as_bytes()].into_iter();
        let lines = Some(lines).filter(|lines| !lines.is_empty());
        Name::of(all.chain(parts.iter().copied()).chain(lines))
    }

    /// The names of all chunks that have samples under a square, or just beside it where coarse samples of its height may be.
    fn names_of_chunks(&self, square: Square, cells: &[Range<usize>; 2]) -> Vec<u8> {
        let height = self.jobs.plan.height(square);
        let level = height.saturating_sub(NAMED_LEVEL_BELOW).min(self.jobs.raster.top());
        let step = 1_usize << height;
        let [columns, rows] = cells
            .each_ref()
            .map(|range| range.start.saturating_sub(step)..range.end + step);
        let chunks = self.jobs.raster.chunks_over(level, &columns, &rows);
        chunks.into_iter().flat_map(|(_, name)| name.bytes()).collect()
    }
}
