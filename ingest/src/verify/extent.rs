//! What the archive says of itself as a whole: its metadata, and that there is a tile wherever there is a sample.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use glam::DVec2;
use rayon::prelude::*;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::LEAST_METRES_IN_A_DEGREE;
use terrain_tiles::metadata::{Metadata, Zoom};

use super::beside::Beside;
use super::report::{Violation, ZoomReport};
use super::source::{Block, Post, Source};
use super::tiles::{Tiles, is_leaf};

/// Compares the metadata with the tiles that exist and with what was found in them.
pub(super) fn check_metadata(
    metadata: &Metadata,
    found: &[ZoomReport],
    coarsest_outlines: &[f64],
    exist: &BTreeSet<TileAddress>,
) -> Vec<Violation> {
    let mut violations = Vec::new();
    let zooms: Vec<u8> = metadata.zooms.iter().map(|zoom| zoom.zoom).collect();
    if zooms != (0..=metadata.max_zoom).collect::<Vec<_>>() || found.len() != zooms.len() {
        violations.push(Violation::new(format!(
            "metadata: zooms {zooms:?}, but tiles of {} zooms",
            found.len()
        )));
    }
    for ((zoom, found), &outline) in metadata.zooms.iter().zip(found).zip(coarsest_outlines) {
        let what = |name: &str| Violation::new(format!("metadata: {name} of zoom {}", zoom.zoom));
        let leaves = || {
            exist
                .iter()
                .filter(|tile| tile.zoom == zoom.zoom && is_leaf(exist, **tile))
        };
        let counts = [
            ("tiles", zoom.tiles, found.tiles),
            ("leaves", zoom.leaves, leaves().count()),
            ("triangles", zoom.triangles, found.triangles),
        ];
        for (name, claimed, counted) in counts {
            if claimed != counted {
                violations.push(what(&format!("{claimed} {name} instead of {counted}")));
            }
        }
        let errors = [
            ("finest error", zoom.finest_error, found.claimed_finest),
            ("leaves' error", zoom.leaf_error, found.claimed_leaves),
            ("coarsest error", zoom.coarsest_error, found.claimed_coarsest),
            ("outline error", zoom.outline_error, outline),
        ];
        for (name, claimed, of_tiles) in errors {
            if (claimed - of_tiles).abs() > of_tiles.abs() * 1e-6 {
                violations.push(what(name).figures(claimed, of_tiles));
            }
        }
        if available(zoom) != exist.iter().copied().filter(|tile| tile.zoom == zoom.zoom).collect() {
            violations.push(what("available tiles"));
        }
    }
    violations
}

fn available(zoom: &Zoom) -> BTreeSet<TileAddress> {
    // A rectangle larger than any archive is cut short, and so found to be wrong.
    const MOST: usize = 1 << 24;
    let tiles = zoom.available.iter().flat_map(|&[first_x, first_y, last_x, last_y]| {
        (first_y..=last_y).flat_map(move |y| (first_x..=last_x).map(move |x| (x, y)))
    });
    tiles
        .take(MOST)
        .filter_map(|(x, y)| TileAddress::new(zoom.zoom, x, y))
        .collect()
}

/// The bounds and the heights of the metadata must hold the source's surface, up to the errors of the deepest zoom.
/// `blocks` are all of the source.
///
/// # Errors
/// When samples cannot be read.
pub(super) fn check_bounds(metadata: &Metadata, source: &Source, blocks: &[Block]) -> Result<Vec<Violation>> {
    let Some(deepest) = metadata.zooms.last() else {
        return Ok(Vec::new());
    };
    let reach = DVec2::splat(deepest.outline_error / LEAST_METRES_IN_A_DEGREE + 1e-9);
    let [west, south, east, north] = metadata.bounds;
    let (low, high) = (DVec2::new(west, south) - reach, DVec2::new(east, north) + reach);
    let [lowest, highest] = metadata.heights;
    let heights = lowest - deepest.finest_error..=highest + deepest.finest_error;
    let outside = |block: &Block| {
        let patch = source.patch(block)?;
        let mut surface = patch
            .posts()
            .into_iter()
            .filter(|&(x, y)| patch.post(x, y) == Post::Surface);
        Ok(surface.find_map(|(column, row)| {
            let place = source.geographic(column, row);
            if source.is_twice(place) {
                return None;
            }
            let in_bounds = place.cmpge(low).all() && place.cmple(high).all();
            let in_heights = heights.contains(&patch.height(column, row));
            (!in_bounds || !in_heights).then_some((place, if in_bounds { "heights" } else { "bounds" }))
        }))
    };
    let found: Vec<Option<_>> = blocks.par_iter().map(outside).collect::<Result<_>>()?;
    let violation = |(place, name)| Violation::new(format!("metadata: a sample is outside its {name}")).at(place);
    Ok(found.into_iter().flatten().next().map(violation).into_iter().collect())
}

/// How many samples are missing in a tile, and the place of the first.
type Missing = BTreeMap<TileAddress, (usize, DVec2)>;

/// Samples of the source's surface that are in the square of no tile, nor within `reach` metres of one that is as near to them
/// as it claims, by zoom. `blocks` are all of the source.
///
/// # Errors
/// When samples cannot be read.
pub(super) fn check_presence(
    source: Source,
    blocks: &[Block],
    tiles: &dyn Tiles,
    exist: &BTreeSet<TileAddress>,
    reach: &[f64],
) -> Result<Vec<Violation>> {
    let missing: Vec<Missing> = blocks
        .par_iter()
        .map(|block| missing_in(&source, block, Beside::new(source, tiles, exist), reach))
        .collect::<Result<_>>()?;
    let mut all = Missing::new();
    for (tile, (count, place)) in missing.into_iter().flatten() {
        all.entry(tile).or_insert((0, place)).0 += count;
    }
    let violation = |(tile, (count, place))| {
        Violation::of_tile(
            format!("is not in the archive, but {count} samples are in its square"),
            tile,
        )
        .at(place)
    };
    Ok(all.into_iter().map(violation).collect())
}

fn missing_in(source: &Source, block: &Block, mut beside: Beside, reach: &[f64]) -> Result<Missing> {
    let patch = source.patch(block)?;
    let mut missing = Missing::new();
    for post in patch
        .posts()
        .into_iter()
        .filter(|&(x, y)| patch.post(x, y) == Post::Surface)
    {
        let place = source.geographic(post.0, post.1);
        if source.is_twice(place) {
            continue;
        }
        for (zoom, &reach) in (0..).zip(reach) {
            let Some(tile) = tile_at(place, zoom) else { continue };
            if beside.exists(tile) || beside.is_below_leaf(tile) {
                continue;
            }
            if !is_kept(&mut beside, post, nearby(place, zoom, reach))? {
                missing.entry(tile).or_insert((0, place)).0 += 1;
            }
        }
    }
    Ok(missing)
}

/// Whether one of some tiles is as near to a post as it claims.
fn is_kept(beside: &mut Beside, post: (usize, usize), tiles: impl Iterator<Item = TileAddress>) -> Result<bool> {
    let tiles: BTreeSet<TileAddress> = tiles.collect();
    for tile in tiles {
        if beside.keeps(tile, post, false)? && beside.keeps(tile, post, true)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The tiles that are within `reach` metres of a place.
fn nearby(place: DVec2, zoom: u8, reach: f64) -> impl Iterator<Item = TileAddress> {
    let north = reach / LEAST_METRES_IN_A_DEGREE;
    let east = north / place.y.to_radians().cos().max(1e-3);
    let offsets = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    offsets
        .into_iter()
        .filter_map(move |(x, y)| tile_at(place + DVec2::new(x * east, y * north), zoom))
}

fn tile_at(place: DVec2, zoom: u8) -> Option<TileAddress> {
    let tiles = (DVec2::new(place.x + 180.0, place.y + 90.0) / 180.0 * f64::from(1_u32 << zoom)).floor();
    let (columns, rows) = (f64::from(2_u32 << zoom), f64::from(1_u32 << zoom));
    TileAddress::new(
        zoom,
        tiles.x.rem_euclid(columns) as u32,
        tiles.y.clamp(0.0, rows - 1.0) as u32,
    )
}
