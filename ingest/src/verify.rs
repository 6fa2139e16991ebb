//! Measures again, by brute force, everything that an archive or a mesh claims, from nothing but the decoded tiles and
//! the raster: no code of the simplifier, nothing that it wrote down on the way.
//!
//! Shared with the maker of the archive are its readers only: of bytes into a tile's arrays and addresses (`tiles`), of
//! rasters and where they are on the Earth, and WGS84, which `tests/tests/ellipsoid.rs` holds against GeographicLib.
//! Drawing a level of detail, and what makes triangles a surface, is written here a second time.
//!
//! Tiles and the raster pass by: in memory are, for each thread, one tile and one block of samples.
//!
//! ```text
//! for each tile, each level: triangles flat in Earth-centred space against the bilinear source,
//!     at every sample, and along every edge of the mesh               deviation
//!     samples that no triangle covers, mesh over voids                outline
//!     lines without a chain of edges along them                       breaklines
//! neighbours show the same vertices on their common side              sides
//! a tile's coarsest surface is its parent's finest                    nesting
//! random mixes of zooms, levels and sides have no gap                 mixes
//! nor those that are selected for cameras over the archive            views
//! metadata and the set of tiles                                       extent
//! ```

mod beside;
mod breaklines;
mod deviation;
mod drawing;
mod drawn;
mod extent;
mod farthest;
mod filled;
mod levels;
mod mesh_file;
mod mixes;
mod nesting;
mod outline;
mod plain_mesh;
mod report;
mod sides;
mod source;
mod source_outline;
mod space;
mod square;
mod surface;
mod tiles;
mod views;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::Result;
use rayon::prelude::*;
use terrain_codec::address::{Side, TileAddress};
use terrain_codec::tile::Tile;
use terrain_tiles::archive::Reader;
use terrain_tiles::pyramid::{Pyramid, Summary};

use self::breaklines::Lines;
use self::levels::{LevelMeasured, Measure, Measured};
pub use self::mesh_file::Claim;
use self::mixes::Interiors;
pub use self::plain_mesh::mesh;
pub use self::report::{ArchiveReport, MeshReport, Violation, ZoomReport};
use self::sides::Sides;
pub use self::source::Source;
use self::source_outline::SourceOutline;
use self::tiles::Tiles;
use crate::progress::Progress;

/// How many random mixes of tiles are drawn, and so many for random cameras.
const MIXES: u64 = 12;

/// Measures every claim of the archive at `path` against the raster that it was made from. Samples in memory take at
/// most some `memory` bytes, what `source` itself keeps not counted.
///
/// # Errors
/// When the file is no readable archive, or samples cannot be read. A tile that cannot be decoded is a violation in
/// the report.
pub fn archive(path: &Path, source: Source, memory: u64, progress: &Progress) -> Result<ArchiveReport> {
    check(&Reader::open(path)?, source, block_side(memory), progress)
}

/// Posts along a side of a block, so that a block for each thread fits into `memory` bytes.
fn block_side(memory: u64) -> usize {
    /// Heights, verticals, places, coverage, and outlines of blocks that are nothing but outline.
    const BYTES_PER_POST: u64 = 128;
    let posts = memory / BYTES_PER_POST / rayon::current_num_threads() as u64;
    (posts.isqrt() as usize).clamp(64, 512)
}

fn check(tiles: &dyn Tiles, source: Source, block_side: usize, progress: &Progress) -> Result<ArchiveReport> {
    let exist: BTreeSet<TileAddress> = tiles.addresses().into_iter().collect();
    let blocks = source.blocks(&source.whole(), block_side, |block| source.may_hold(block));
    let outline = SourceOutline::new(source, block_side)?;
    let metadata = tiles.metadata();
    let measure = Measure {
        source,
        tiles,
        exist: &exist,
        outline: &outline,
        lines: &Lines::new(&source),
        between_samples: metadata.bound == "surface",
        block_side,
    };
    let mut violations = nesting::orphans(&exist);
    if !["surface", "samples"].contains(&metadata.bound.as_str()) {
        let what = format!("metadata: bound “{}” is unknown", metadata.bound);
        violations.push(Violation::new(what));
    }
    let found = measure_tiles(&measure, progress)?;
    if found.lattices.len() > 1 {
        let what = format!("tiles on different lattices, of {:?} bits", found.lattices);
        violations.push(Violation::new(what));
    }
    let zooms: Vec<ZoomReport> = found.zooms.into_values().collect();
    let coarsest_outlines: Vec<f64> = found.coarsest_outlines.into_values().collect();
    let reaches = reaches(&source, &zooms);
    violations.extend(found.violations);
    violations.extend(extent::check_metadata(metadata, &zooms, &coarsest_outlines, &exist));
    violations.extend(extent::check_bounds(metadata, &source, &blocks)?);
    violations.extend(extent::check_presence(source, &blocks, tiles, &exist, &reaches)?);
    let sound = Sound {
        tiles,
        interiors: &found.interiors,
        pyramid: Pyramid::new(found.summaries),
    };
    let (shared_sides, gaps) = check_sides(&sound, &source, progress)?;
    violations.extend(gaps);
    let (parents, broken) = check_nesting(&sound, &exist, progress);
    violations.extend(broken);
    let (mixed_tiles, gaps) = check_mixes(&sound, &source, progress)?;
    violations.extend(gaps);

    let mut report = ArchiveReport {
        bound: metadata.bound.clone(),
        zooms,
        levels: found.levels,
        shared_sides,
        parents,
        mixed_tiles,
        violation_count: 0,
        violations: Vec::new(),
    };
    report.set_violations(violations);
    Ok(report)
}

/// The tiles that can be drawn; what is wrong with the others was told when they were measured.
struct Sound<'a> {
    tiles: &'a dyn Tiles,
    interiors: &'a Interiors,
    pyramid: Pyramid,
}

impl Sound<'_> {
    fn tile(&self, address: TileAddress) -> Option<Tile> {
        let is_sound = self.interiors.contains_key(&address);
        is_sound.then(|| self.tiles.tile(address).ok()).flatten()
    }
}

/// What was found in all tiles.
#[derive(Default)]
struct Found {
    zooms: BTreeMap<u8, ZoomReport>,
    /// Largest claim for the outline of a coarsest surface, by zoom.
    coarsest_outlines: BTreeMap<u8, f64>,
    /// Of the tiles that can be drawn.
    interiors: Interiors,
    summaries: Vec<(TileAddress, Summary)>,
    lattices: BTreeSet<u8>,
    levels: usize,
    violations: Vec<Violation>,
}

impl Found {
    fn add(&mut self, address: TileAddress, tile: Measured, is_leaf: bool) {
        let zoom = self.zooms.entry(address.zoom).or_insert_with(|| ZoomReport {
            zoom: address.zoom,
            ..Default::default()
        });
        let coarsest_outline = self.coarsest_outlines.entry(address.zoom).or_default();
        zoom.tiles += 1;
        zoom.triangles += tile.triangles;
        self.violations.extend(tile.violations);
        let (Some(coarsest), Some(finest)) = (tile.levels.first(), tile.levels.last()) else {
            return;
        };
        raise(coarsest_outline, coarsest.claimed_outline);
        raise(&mut zoom.claimed_finest, finest.claimed);
        if is_leaf {
            raise(&mut zoom.claimed_leaves, finest.claimed);
        }
        raise(&mut zoom.measured_finest, finest.measured);
        raise(&mut zoom.claimed_coarsest, coarsest.claimed);
        raise(&mut zoom.measured_coarsest, coarsest.measured);
        for level in &tile.levels {
            raise(&mut zoom.worst_ratio, ratio(level));
            raise(&mut zoom.claimed_outline, level.claimed_outline);
            raise(&mut zoom.measured_outline, level.measured_outline);
        }
        self.levels += tile.levels.len();
        self.lattices.insert(tile.lattice_bits);
        self.interiors.insert(address, tile.levels.len() - 1);
        self.summaries.extend(tile.summary.map(|summary| (address, summary)));
    }
}

/// Measures small tiles side by side, and large ones one after the other, each by all threads.
fn measure_tiles(measure: &Measure, progress: &Progress) -> Result<Found> {
    let (tiles, exist) = (measure.tiles, measure.exist);
    progress.stage("measuring tiles", exist.len() as u64);
    let measured = |address: TileAddress, spread: bool| {
        let result = match tiles.tile(address) {
            Ok(tile) if tile.address != address => {
                let what = format!("holds the tile {}", tile.address);
                Measured::broken(Violation::of_tile(what, address))
            }
            Ok(tile) => {
                let mut result = measure.tile(&tile, spread)?;
                if tiles::is_leaf(exist, address) {
                    result.violations.extend(filled::check_leaf(&measure.source, &tile)?);
                }
                result
            }
            Err(what) => Measured::broken(Violation::of_tile(what, address)),
        };
        progress.advance(1);
        Ok((address, result))
    };
    let (large, small): (Vec<TileAddress>, Vec<_>) = exist.iter().partition(|&&address| measure.is_large(address));
    let mut all: Vec<(TileAddress, Measured)> = large
        .into_iter()
        .map(|address| measured(address, true))
        .collect::<Result<_>>()?;
    let small = small.into_par_iter().map(|address| measured(address, false));
    all.extend(small.collect::<Result<Vec<_>>>()?);
    progress.done();
    all.sort_by_key(|&(address, _)| address);
    let mut found = Found::default();
    for (address, tile) in all {
        found.add(address, tile, tiles::is_leaf(exist, address));
    }
    Ok(found)
}

fn raise(largest: &mut f64, value: f64) {
    *largest = largest.max(value);
}

fn ratio(level: &LevelMeasured) -> f64 {
    if level.measured <= report::ROUNDING {
        0.0
    } else {
        level.measured / level.claimed
    }
}

/// How far from a tile's square a sample of the source may be that the tile stands for, by zoom, metres.
fn reaches(source: &Source, zooms: &[ZoomReport]) -> Vec<f64> {
    let [columns, rows] = source.size();
    let middle = glam::DVec2::new(columns as f64, rows as f64) / 2.0;
    let slack = source.georeference.cell_metres(middle).max_element() * 1e-3;
    zooms.iter().map(|zoom| zoom.claimed_outline + slack).collect()
}

/// Compares every pair of neighbours of one zoom on their common side, and every tile's sides with its parent's.
fn check_sides(sound: &Sound, source: &Source, progress: &Progress) -> Result<(usize, Vec<Violation>)> {
    progress.stage("sides", sound.interiors.len() as u64);
    let of_tile = |&address: &TileAddress| {
        let sides_of = |address: TileAddress| sound.tile(address).map(|tile| Sides::of(&tile));
        let Some(own) = sides_of(address) else {
            return Ok((0, Vec::new()));
        };
        let parent = address.parent().and_then(sides_of);
        let (mut pairs, mut violations) = (0, sides::check_own(&own, parent.as_ref()));
        for side in [Side::East, Side::North] {
            if let Some(other) = address.neighbour(side).and_then(sides_of) {
                pairs += 1;
                violations.extend(sides::check_pair(source, &own, side, &other)?);
            }
        }
        progress.advance(1);
        Ok((pairs, violations))
    };
    let addresses: Vec<TileAddress> = sound.interiors.keys().copied().collect();
    let all = addresses.par_iter().map(of_tile).try_reduce(Default::default, joined);
    progress.done();
    all
}

/// Sums up counts and violations.
fn joined((a, mut b): (usize, Vec<Violation>), (c, d): (usize, Vec<Violation>)) -> Result<(usize, Vec<Violation>)> {
    b.extend(d);
    Ok((a + c, b))
}

fn check_nesting(sound: &Sound, exist: &BTreeSet<TileAddress>, progress: &Progress) -> (usize, Vec<Violation>) {
    let parents: BTreeSet<TileAddress> = exist.iter().filter_map(|address| address.parent()).collect();
    progress.stage("nesting", parents.len() as u64);
    let violations = parents.par_iter().flat_map_iter(|&parent| {
        let existing = parent.children().into_iter().filter(|child| exist.contains(child));
        let children: Vec<_> = existing.filter_map(|child| sound.tile(child)).collect();
        progress.advance(1);
        sound
            .tile(parent)
            .map_or_else(Vec::new, |parent| nesting::check(&parent, &children))
    });
    let violations = violations.collect();
    progress.done();
    (parents.len(), violations)
}

fn check_mixes(sound: &Sound, source: &Source, progress: &Progress) -> Result<(usize, Vec<Violation>)> {
    progress.stage("random mixes", 2 * MIXES);
    let mixes = (0..2 * MIXES).into_par_iter().map(|number| {
        let (seed, is_view) = (number / 2, number % 2 == 1);
        let (mix, name) = if is_view {
            (
                views::random(&sound.pyramid, sound.interiors, seed),
                format!("view {seed}"),
            )
        } else {
            (mixes::random(sound.interiors, seed), format!("mix {seed}"))
        };
        let checked = mixes::check(sound.tiles, source, &mix, &name)?;
        progress.advance(1);
        Ok(checked)
    });
    let all = mixes.try_reduce(Default::default, joined);
    progress.done();
    all
}

#[cfg(test)]
#[path = "verify_tests.rs"]
mod tests;
