//! Measures again, by brute force, everything that an archive or a mesh claims, from nothing but the decoded tiles and
//! the raster: no code of the simplifier, nothing that it wrote down on the way.
//!
//! ```text
//! for each tile, each level: triangles flat in Earth-centred space against the bilinear source,
//!     at every sample, and along every edge of the mesh               deviation
//!     samples that no triangle covers, mesh over voids                outline
//! neighbours show the same vertices on their common side              sides
//! a tile's coarsest surface is its parent's finest                    nesting
//! random mixes of zooms, levels and sides have no gap                 mixes
//! metadata and the set of tiles                                       extent
//! ```

mod deviation;
mod extent;
mod levels;
mod mesh_file;
mod mixes;
mod nesting;
mod outline;
mod plain_mesh;
mod reference;
mod report;
mod sides;
mod space;
mod surface;
mod tiles;
mod window;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;
use terrain_tiles::address::{Side, TileAddress};
use terrain_tiles::archive::Reader;

use self::levels::{LevelMeasured, Measured, Source};
pub use self::mesh_file::Claim;
use self::mixes::Interiors;
pub use self::plain_mesh::mesh;
use self::reference::Reference;
pub use self::report::{ArchiveReport, MeshReport, Violation, ZoomReport};
use self::tiles::Tiles;
use crate::height_grid::HeightGrid;
use crate::progress::Progress;

/// How many random mixes of tiles are drawn.
const MIXES: u64 = 12;

/// Measures every claim of the archive at `path` against the raster that it was made from.
///
/// # Errors
/// When the file is no readable archive. A tile that cannot be decoded is a violation in the report.
pub fn archive(path: &Path, grid: &HeightGrid, progress: &Progress) -> anyhow::Result<ArchiveReport> {
    Ok(check(&Reader::open(path)?, grid, progress))
}

fn check(tiles: &dyn Tiles, grid: &HeightGrid, progress: &Progress) -> ArchiveReport {
    let reference = Reference::new(grid);
    let exist: BTreeSet<TileAddress> = tiles.addresses().into_iter().collect();
    let mut violations = nesting::orphans(&exist);
    if !["surface", "samples"].contains(&tiles.metadata().bound.as_str()) {
        violations.push(Violation::new(format!(
            "metadata: bound “{}” is unknown",
            tiles.metadata().bound
        )));
    }
    let normals = space::normals(grid);
    let between_samples = tiles.metadata().bound == "surface";
    let source = Source {
        reference: &reference,
        normals: &normals,
        between_samples,
    };
    let measured = measure_tiles(tiles, &exist, &source, progress);
    violations.extend(measured.values().flat_map(|tile| tile.violations.iter().cloned()));

    let lattices = measured.iter().filter(|(_, tile)| !tile.levels.is_empty());
    let lattices: BTreeSet<u8> = lattices
        .map(|(address, tile)| address.zoom + tile.sides.extent_bits)
        .collect();
    if lattices.len() > 1 {
        violations.push(Violation::new(format!(
            "tiles on different lattices, of {lattices:?} bits"
        )));
    }

    let zooms = zoom_reports(&measured);
    let outlines: Vec<f64> = zooms.iter().map(|zoom| zoom.claimed_outline).collect();
    violations.extend(extent::check_metadata(
        tiles.metadata(),
        &zooms,
        &coarsest_outlines(&measured),
        &exist,
    ));
    violations.extend(extent::check_bounds(tiles.metadata(), &reference));
    violations.extend(extent::check_presence(
        &reference,
        &exist,
        &reaches(&reference, &outlines),
    ));
    let (shared_sides, gaps) = check_sides(&measured, &reference);
    violations.extend(gaps);
    let (parents, broken) = check_nesting(tiles, &exist, progress);
    violations.extend(broken);
    let (mixed_tiles, gaps) = check_mixes(tiles, &measured, &reference, progress);
    violations.extend(gaps);

    let mut report = ArchiveReport {
        bound: tiles.metadata().bound.clone(),
        zooms,
        levels: measured.values().map(|tile| tile.levels.len()).sum(),
        shared_sides,
        parents,
        mixed_tiles,
        violation_count: 0,
        violations: Vec::new(),
    };
    report.set_violations(violations);
    report
}

type MeasuredTiles = BTreeMap<TileAddress, Measured>;

fn measure_tiles(
    tiles: &dyn Tiles,
    exist: &BTreeSet<TileAddress>,
    source: &Source,
    progress: &Progress,
) -> MeasuredTiles {
    progress.stage("measuring tiles", exist.len() as u64);
    let addresses: Vec<TileAddress> = exist.iter().copied().collect();
    let measure = |address: TileAddress| {
        let measured = match tiles.tile(address) {
            Ok(tile) if tile.address != address => {
                let what = format!("holds the tile {}", tile.address);
                Measured {
                    violations: vec![Violation::of_tile(what, address)],
                    ..Measured::default()
                }
            }
            Ok(tile) => levels::measure(
                source,
                &tile,
                outline::neighbours(address, |other| exist.contains(&other)),
            ),
            Err(what) => Measured {
                violations: vec![Violation::of_tile(what, address)],
                ..Measured::default()
            },
        };
        progress.advance(1);
        (address, measured)
    };
    let measured = addresses.into_par_iter().map(measure).collect();
    progress.done();
    measured
}

fn zoom_reports(measured: &MeasuredTiles) -> Vec<ZoomReport> {
    let mut zooms: BTreeMap<u8, ZoomReport> = BTreeMap::new();
    for (address, tile) in measured {
        let zoom = zooms.entry(address.zoom).or_insert_with(|| ZoomReport {
            zoom: address.zoom,
            ..Default::default()
        });
        zoom.tiles += 1;
        zoom.triangles += tile.triangles;
        let (Some(coarsest), Some(finest)) = (tile.levels.first(), tile.levels.last()) else {
            continue;
        };
        raise(&mut zoom.claimed_finest, finest.claimed);
        raise(&mut zoom.measured_finest, finest.measured);
        raise(&mut zoom.claimed_coarsest, coarsest.claimed);
        raise(&mut zoom.measured_coarsest, coarsest.measured);
        for level in &tile.levels {
            raise(&mut zoom.worst_ratio, ratio(level));
            raise(&mut zoom.claimed_outline, level.claimed_outline);
            raise(&mut zoom.measured_outline, level.measured_outline);
        }
    }
    zooms.into_values().collect()
}

/// Largest claim for the outline of a coarsest surface, by zoom.
fn coarsest_outlines(measured: &MeasuredTiles) -> Vec<f64> {
    let mut largest = BTreeMap::new();
    for (address, tile) in measured {
        let claimed = tile.levels.first().map_or(0.0, |level| level.claimed_outline);
        raise(largest.entry(address.zoom).or_insert(0.0), claimed);
    }
    largest.into_values().collect()
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
fn reaches(reference: &Reference, outlines: &[f64]) -> Vec<f64> {
    let middle = glam::DVec2::new(reference.grid.columns as f64, reference.grid.rows as f64) / 2.0;
    let slack = reference.grid.georeference.cell_metres(middle).max_element() * 1e-3;
    outlines.iter().map(|outline| outline + slack).collect()
}

/// Compares every pair of neighbours of one zoom on their common side, and every tile's sides with its parent's.
fn check_sides(measured: &MeasuredTiles, reference: &Reference) -> (usize, Vec<Violation>) {
    let mut violations = Vec::new();
    let mut pairs = 0;
    for (&address, tile) in measured {
        let parent = address.parent().and_then(|parent| measured.get(&parent));
        violations.extend(sides::check_own(
            address,
            &tile.sides,
            parent.map(|parent| &parent.sides),
        ));
        for side in [Side::East, Side::North] {
            let Some(other) = address.neighbour(side).filter(|other| measured.contains_key(other)) else {
                continue;
            };
            pairs += 1;
            violations.extend(check_pair(measured, reference, address, side, other));
        }
    }
    (pairs, violations)
}

fn check_pair(
    measured: &MeasuredTiles,
    reference: &Reference,
    address: TileAddress,
    side: Side,
    other: TileAddress,
) -> Vec<Violation> {
    let opposite = sides::opposite(side);
    let (first, second) = (&measured[&address].sides, &measured[&other].sides);
    let pairs = [
        (
            "coarse",
            &first.coarse[side as usize],
            &second.coarse[opposite as usize],
        ),
        ("fine", &first.fine[side as usize], &second.fine[opposite as usize]),
    ];
    let mut violations = Vec::new();
    for (name, of_first, of_second) in pairs {
        let lonely = sides::unmatched(of_first, of_second)
            .into_iter()
            .filter(|&(is_first, edge)| {
                let (place, side) = if is_first { (address, side) } else { (other, opposite) };
                let bits = if is_first {
                    first.extent_bits
                } else {
                    second.extent_bits
                };
                !sides::is_one_sided(reference, place, bits, side, edge)
            });
        let count = lonely.count();
        if count > 0 {
            let what = format!("{side:?} side, {name}: {count} edges are not shared with tile {other}");
            violations.push(Violation::of_tile(what, address));
        }
    }
    violations
}

fn check_nesting(tiles: &dyn Tiles, exist: &BTreeSet<TileAddress>, progress: &Progress) -> (usize, Vec<Violation>) {
    let deepest = exist.last().map_or(0, |address| address.zoom);
    let parents: Vec<TileAddress> = exist.iter().copied().filter(|address| address.zoom < deepest).collect();
    progress.stage("nesting", parents.len() as u64);
    let violations = parents.par_iter().flat_map_iter(|&parent| {
        let existing = parent.children().into_iter().filter(|child| exist.contains(child));
        // Tiles that cannot be read have been reported by whoever measured them.
        let children: Vec<_> = existing.filter_map(|child| tiles.tile(child).ok()).collect();
        progress.advance(1);
        tiles
            .tile(parent)
            .map_or_else(|_| Vec::new(), |parent| nesting::check(&parent, &children))
    });
    let violations = violations.collect();
    progress.done();
    (parents.len(), violations)
}

fn check_mixes(
    tiles: &dyn Tiles,
    measured: &MeasuredTiles,
    reference: &Reference,
    progress: &Progress,
) -> (usize, Vec<Violation>) {
    progress.stage("random mixes", MIXES);
    let sound = measured.iter().filter(|(_, tile)| !tile.levels.is_empty());
    let interiors: Interiors = sound.map(|(&address, tile)| (address, tile.levels.len() - 1)).collect();
    let mixes = (0..MIXES).into_par_iter().map(|seed| {
        let mix = mixes::check(tiles, &interiors, reference, seed);
        progress.advance(1);
        mix
    });
    let join = |(a, mut b): (usize, Vec<Violation>), (c, d)| {
        b.extend(d);
        (a + c, b)
    };
    let all = mixes.reduce(Default::default, join);
    progress.done();
    all
}

#[cfg(test)]
#[path = "verify_tests.rs"]
mod tests;
