//! What the archive says of itself as a whole: its metadata, and that there is a tile wherever there is a sample.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use rayon::prelude::*;
use terrain_tiles::address::TileAddress;
use terrain_tiles::ellipsoid::LEAST_METRES_IN_A_DEGREE;
use terrain_tiles::metadata::{Metadata, Zoom};

use super::reference::{Post, Reference};
use super::report::{Violation, ZoomReport};

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
        let counts = [
            ("tiles", zoom.tiles, found.tiles),
            ("triangles", zoom.triangles, found.triangles),
        ];
        for (name, claimed, counted) in counts {
            if claimed != counted {
                violations.push(what(&format!("{claimed} {name} instead of {counted}")));
            }
        }
        let errors = [
            ("finest error", zoom.finest_error, found.claimed_finest),
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
pub(super) fn check_bounds(metadata: &Metadata, reference: &Reference) -> Vec<Violation> {
    let Some(deepest) = metadata.zooms.last() else {
        return Vec::new();
    };
    let reach = DVec2::splat(deepest.outline_error / LEAST_METRES_IN_A_DEGREE + 1e-9);
    let [west, south, east, north] = metadata.bounds;
    let (low, high) = (DVec2::new(west, south) - reach, DVec2::new(east, north) + reach);
    let [lowest, highest] = metadata.heights;
    let heights = lowest - deepest.finest_error..=highest + deepest.finest_error;
    let posts = (0..reference.grid.rows).flat_map(|row| (0..reference.grid.columns).map(move |column| (column, row)));
    let outside = posts
        .filter(|&(column, row)| reference.post(column, row) == Post::Surface)
        .find_map(|(column, row)| {
            let place = reference
                .grid
                .georeference
                .geographic(DVec2::new(column as f64, row as f64));
            let in_bounds = place.cmpge(low).all() && place.cmple(high).all();
            let in_heights = heights.contains(&reference.height(column, row));
            (!in_bounds || !in_heights).then_some((place, if in_bounds { "heights" } else { "bounds" }))
        });
    let violation = |(place, name)| Violation::new(format!("metadata: a sample is outside its {name}")).at(place);
    outside.map(violation).into_iter().collect()
}

/// Samples of the source's surface that are in the square of no tile, nor within `reach` metres of one, by zoom.
pub(super) fn check_presence(reference: &Reference, exist: &BTreeSet<TileAddress>, reach: &[f64]) -> Vec<Violation> {
    let rows = (0..reference.grid.rows).into_par_iter();
    let missing = rows
        .map(|row| missing_in_row(reference, exist, reach, row))
        .reduce(BTreeMap::new, |mut all, row| {
            for (tile, (count, place)) in row {
                all.entry(tile).or_insert((0, place)).0 += count;
            }
            all
        });
    let violation = |(tile, (count, place))| {
        Violation::of_tile(
            format!("is not in the archive, but {count} samples are in its square"),
            tile,
        )
        .at(place)
    };
    missing.into_iter().map(violation).collect()
}

fn missing_in_row(
    reference: &Reference,
    exist: &BTreeSet<TileAddress>,
    reach: &[f64],
    row: usize,
) -> BTreeMap<TileAddress, (usize, DVec2)> {
    let mut missing = BTreeMap::new();
    for column in (0..reference.grid.columns).filter(|&column| reference.post(column, row) == Post::Surface) {
        let place = reference
            .grid
            .georeference
            .geographic(DVec2::new(column as f64, row as f64));
        for (zoom, &reach) in (0..).zip(reach) {
            if !nearby(place, zoom, reach).any(|tile| exist.contains(&tile)) {
                let Some(tile) = tile_at(place, zoom) else { continue };
                missing.entry(tile).or_insert((0, place)).0 += 1;
            }
        }
    }
    missing
}

/// The tile of a place and those that are within `reach` metres of it.
fn nearby(place: DVec2, zoom: u8, reach: f64) -> impl Iterator<Item = TileAddress> {
    let north = reach / LEAST_METRES_IN_A_DEGREE;
    let east = north / place.y.to_radians().cos().max(1e-3);
    let offsets = [(0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
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
