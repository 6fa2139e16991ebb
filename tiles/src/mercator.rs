//! Where tiles of Web Mercator are (EPSG:3857, the sphere's Mercator): one square around the Earth, rows from the north.

use std::f64::consts::PI;

use terrain_codec::address::{Rectangle, TileAddress};

use crate::ground::Place;
use crate::tile_file::SquareTile;

/// Degrees north and south to which the square reaches.
pub const LATITUDES: f64 = 85.051_128_779_806_6;

/// Degrees of longitude that a tile of a zoom is wide.
#[must_use]
pub fn degrees(zoom: u8) -> f64 {
    360.0 / f64::from(1_u32 << zoom)
}

/// Degrees, at a part of the tile's width from its west side.
#[must_use]
pub fn longitude(tile: SquareTile, part: f64) -> f64 {
    (f64::from(tile.x) + part) * degrees(tile.zoom) - 180.0
}

/// Degrees, at a part of its height from its north side.
#[must_use]
pub fn latitude(tile: SquareTile, part: f64) -> f64 {
    let y = (f64::from(tile.y) + part) / f64::from(1_u32 << tile.zoom);
    ((1.0 - 2.0 * y) * PI).sinh().atan().to_degrees()
}

/// West, south, east, north in degrees.
#[must_use]
pub fn bounds(tile: SquareTile) -> [f64; 4] {
    [
        longitude(tile, 0.0),
        latitude(tile, 1.0),
        longitude(tile, 1.0),
        latitude(tile, 0.0),
    ]
}

impl From<SquareTile> for Rectangle {
    fn from(tile: SquareTile) -> Self {
        let [west, south, east, north] = bounds(tile);
        Self {
            west,
            south,
            width: east - west,
            height: north - south,
        }
    }
}

/// Bounds in degrees, west, south, east, north, as far as they are in the square: those across the antimeridian as the whole circle.
#[must_use]
pub fn within([west, south, east, north]: [f64; 4]) -> [f64; 4] {
    let [south, north] = [south, north].map(|latitude| latitude.clamp(-LATITUDES, LATITUDES));
    if west < -180.0 || east > 180.0 {
        return [-180.0, south, 180.0, north];
    }
    [west, south, east, north]
}

/// Whether it has a point with a box in degrees, whose east may exceed 180.
#[must_use]
pub fn meets(tile: SquareTile, [west, south, east, north]: [f64; 4]) -> bool {
    let own = bounds(tile);
    let meets = |turn: f64| own[0] + turn <= east && west <= own[2] + turn;
    (meets(0.0) || meets(360.0)) && own[1] <= north && south <= own[3]
}

/// Tiles of `zoom` that the square of a tile of the geographic scheme reaches into.
pub fn tiles_over(address: TileAddress, zoom: u8) -> impl Iterator<Item = SquareTile> {
    let count = f64::from(1_u32 << zoom);
    let column = |longitude: f64| (longitude + 180.0) / 360.0 * count;
    let row = |latitude: f64| {
        let latitude = latitude.clamp(-LATITUDES, LATITUDES).to_radians();
        (1.0 - latitude.tan().asinh() / PI) / 2.0 * count
    };
    // From the first that begins there to the last that begins before the end.
    let range =
        move |first: f64, end: f64| [first.floor(), end.ceil() - 1.0].map(|index| index.clamp(0.0, count - 1.0) as u32);
    let (west, south, side) = (address.west(), address.south(), address.degrees());
    let [left, right] = range(column(west), column(west + side));
    let [top, bottom] = range(row(south + side), row(south));
    (top..=bottom).flat_map(move |y| (left..=right).map(move |x| SquareTile { zoom, x, y }))
}

/// The tiles around one, up to eight: over the antimeridian, but not over the square's north and south sides.
pub fn around(tile: SquareTile) -> impl Iterator<Item = SquareTile> {
    let count = 1_i64 << tile.zoom;
    let steps = (-1..=1).flat_map(|down| (-1..=1).map(move |across| (across, down)));
    let beside = move |(across, down): (i64, i64)| {
        let (x, y) = (i64::from(tile.x) + across, i64::from(tile.y) + down);
        (0..count).contains(&y).then_some(SquareTile {
            zoom: tile.zoom,
            x: x.rem_euclid(count) as u32,
            y: y as u32,
        })
    };
    steps.filter_map(beside).filter(move |&other| other != tile)
}

/// Row by row from the north.
pub(crate) fn pixel_centres(tile: SquareTile, size: u32) -> Vec<Place> {
    let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(size);
    let rows = (0..size).map(|row| latitude(tile, at(row)));
    rows.flat_map(|latitude| {
        (0..size).map(move |column| Place {
            longitude: longitude(tile, at(column)),
            latitude,
        })
    })
    .collect()
}
