//! Levels of detail of one tile, each drawn and ready to be measured.

use std::collections::BTreeSet;

use glam::DVec2;
use terrain_codec::address::{Side, TileAddress};
use terrain_codec::ellipsoid::{Geodetic, to_earth_centred};
use terrain_codec::tile::Tile;

use super::drawing::{Drawing, coarse_sided, draw, finest, interior_levels};
use super::outline::Outline;
use super::source::Source;
use super::space::{Earth, Foot};
use super::square::turn;
use super::surface::Surface;

/// A level of a tile.
pub(super) struct Level {
    pub(super) surface: Surface,
    pub(super) outline: Outline,
    /// Index of its claims in the tile.
    pub(super) claims: usize,
    /// Whether its sides are fine.
    pub(super) has_fine_sides: bool,
}

/// Drawings of every level: the interior ones with coarse sides, and the finest with all sides fine.
pub(super) fn drawings(tile: &Tile) -> Vec<Drawing> {
    let shown = (0..interior_levels(tile)).map(coarse_sided).chain([finest(tile)]);
    shown.map(|shown| draw(tile, shown)).collect()
}

/// The Earth as the raster and a tile see it.
pub(super) fn earth<'a>(source: Source<'a>, address: TileAddress) -> Earth<'a> {
    Earth {
        source,
        middle_longitude: address.west() + address.degrees() / 2.0 + turn(&source, address),
    }
}

/// The levels of [`drawings`], in their order. `exist` are all tiles.
pub(super) fn levels(tile: &Tile, earth: &Earth, drawings: &[Drawing], exist: &BTreeSet<TileAddress>) -> Vec<Level> {
    let neighbour = |side| tile.address.neighbour(side);
    let neighbours = Side::ALL.map(|side| neighbour(side).is_some_and(|other| exist.contains(&other)));
    let level = |(index, drawing): (usize, &Drawing)| {
        let has_fine_sides = index + 1 == drawings.len();
        let surface = surface(tile, earth, drawing);
        Level {
            outline: Outline::new(tile, earth, drawing, &surface, neighbours),
            surface,
            claims: if has_fine_sides {
                tile.partition.levels.len() - 1
            } else {
                index
            },
            has_fine_sides,
        }
    };
    drawings.iter().enumerate().map(level).collect()
}

fn surface(tile: &Tile, earth: &Earth, drawing: &Drawing) -> Surface {
    let unit = tile.address.degrees() / (1_u64 << tile.extent_bits) as f64;
    let origin = DVec2::new(tile.address.west(), tile.address.south());
    let georeference = earth.source.georeference;
    let turn = DVec2::new(turn(&earth.source, tile.address), 0.0);
    let places = drawing.positions.iter().map(|at| (origin + at.truncate() * unit, at.z));
    let feet = places.clone().map(|(place, height)| Foot {
        grid: georeference.grid(place + turn),
        height,
    });
    let positions = places.map(|(place, height)| {
        to_earth_centred(Geodetic {
            longitude: place.x,
            latitude: place.y,
            height,
        })
    });
    Surface::new(earth, positions.collect(), feet.collect(), drawing.triangles.clone())
}
