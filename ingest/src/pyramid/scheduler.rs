//! Which job runs when: subtrees depth first, a parent as soon as its children are there, and nothing that the store has.
//! What lives in memory is a path of the tree.

use std::ops::Range;
use std::sync::Mutex;
use std::time::Instant;

use anyhow::Result;
use rayon::prelude::*;
use terrain_core::height_field::chunks::Chunks;

use super::finished::TileRecord;
use super::jobs::{Child, Jobs};
use crate::lattice::Square;
use crate::progress::Progress;
use crate::store::{Name, Store};

/// Levels below a tile's own at which the names of chunks stand for the samples under it.
const NAMED_LEVEL_BELOW: u8 = 1;

/// Makes tiles that are missing.
pub(crate) struct Scheduler<'a> {
    pub(crate) jobs: Jobs<'a>,
    pub(crate) store: &'a Store,
    pub(crate) progress: &'a Progress,
    pub(crate) finished: Mutex<Vec<TileRecord>>,
}

impl Scheduler<'_> {
    /// Leaves that may have samples, to tell how long the work is.
    pub(crate) fn count_leaves(&self, square: Square) -> u64 {
        match self.cells(square) {
            None => 0,
            Some(_) if self.jobs.plan.height(square) == 0 => 1,
            Some(_) => square
                .children()
                .into_iter()
                .map(|child| self.count_leaves(child))
                .sum(),
        }
    }

    /// Makes the tile of a square and all below it; none where there is no surface.
    ///
    /// # Errors
    /// When samples cannot be read, or the store cannot be written.
    pub(crate) fn tile(&self, square: Square) -> Result<Option<TileRecord>> {
        let Some(cells) = self.cells(square) else {
            return Ok(None);
        };
        let is_leaf = self.jobs.plan.height(square) == 0;
        let children: Vec<TileRecord> = if is_leaf {
            Vec::new()
        } else {
            let children = square.children().into_par_iter().map(|child| self.tile(child));
            let found: Result<Vec<Option<TileRecord>>> = children.collect();
            found?.into_iter().flatten().collect()
        };
        if !is_leaf && children.is_empty() {
            return Ok(None);
        }
        let name = self.name(square, &cells, &children);
        let record = match TileRecord::find(self.store, square, name)? {
            Some(record) => Some(record),
            None => self.make(square, cells, name, &children)?,
        };
        if let Some(record) = &record {
            self.lock().push(record.clone());
        }
        if is_leaf {
            self.progress.advance(1);
        }
        Ok(record)
    }

    fn make(
        &self,
        square: Square,
        cells: [Range<usize>; 2],
        name: Name,
        children: &[TileRecord],
    ) -> Result<Option<TileRecord>> {
        let started = Instant::now();
        let node = if children.is_empty() {
            self.jobs.leaf(square, cells)?
        } else {
            let family: Result<Vec<Child>> = children.iter().map(|child| child.coarsest(self.store)).collect();
            Some(self.jobs.parent(square, cells, &family?)?)
        };
        self.jobs.raster.check()?;
        let Some(node) = node else { return Ok(None) };
        TileRecord::keep(self.store, name, node, started.elapsed().as_secs_f64()).map(Some)
    }

    /// Everything that a tile is made from, as one number.
    fn name(&self, square: Square, [columns, rows]: &[Range<usize>; 2], children: &[TileRecord]) -> Name {
        let place = format!("{} {} {}", square.zoom, square.x, square.y);
        let level = self.named_level(square);
        let chunks = self.jobs.raster.chunks_over(level, columns, rows);
        let names = children
            .iter()
            .map(|child| child.name)
            .chain(chunks.into_iter().map(|(_, name)| name));
        let names: Vec<u8> = names.flat_map(Name::bytes).collect();
        Name::of([&self.jobs.plan.name.bytes(), place.as_bytes(), &names])
    }

    fn named_level(&self, square: Square) -> u8 {
        let height = self.jobs.plan.height(square).saturating_sub(NAMED_LEVEL_BELOW);
        height.min(self.jobs.raster.top())
    }

    /// The samples under a square, if it has any.
    fn cells(&self, square: Square) -> Option<[Range<usize>; 2]> {
        let cells = self.jobs.cells(square)?;
        let level = self.jobs.plan.height(square).min(self.jobs.raster.top());
        let has_samples = !self.jobs.raster.chunks_over(level, &cells[0], &cells[1]).is_empty();
        has_samples.then_some(cells)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<TileRecord>> {
        self.finished.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
