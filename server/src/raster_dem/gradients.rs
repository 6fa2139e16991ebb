//! Rasters of normals of a tile's square, for light that does not depend on how many triangles are drawn.
//!
//! ```text
//! corners of 256 × 256 cells and some around ─▶ heights two zooms finer ─▶ plane through each one's neighbours ─▶ normal ─▶ colour
//! ```
//!
//! A colour's red and green are the parts of the normal to the east and to the north: `128 + 127 √|n|`, or minus for those below 0.
//! A root, because most ground is nearly level. What is at a corner of a cell depends on its place and the zoom alone, so tiles have
//! the same colours along a common side.

use std::array;

use axum::body::Bytes;
use terrain_tiles::address::TileAddress;
use terrain_tiles::ellipsoid::{Geodetic, to_earth_centred};
use terrain_tiles::raster_dem::image::{Format, write};

use crate::heights::{Heights, Place};
use crate::tileset::{TileError, Tileset};

/// Cells along a side of a tile; there is one corner more.
const CELLS: i64 = 256;
/// So many corners on each side of one have a part in its plane.
const REACH: i64 = 3;
/// Of corners by their distance along an axis: binomial.
const WEIGHTS: [f64; 2 * REACH as usize + 1] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
const ROW: usize = (CELLS + 1 + 2 * REACH) as usize;
/// Heights are of a surface so many zooms finer: its error is a quarter of the tile's.
const FINER: u8 = 2;

/// The raster of a tile, rows from the north. Blocks for some 100 ms.
pub(super) fn draw(
    heights: &Heights,
    tileset: &Tileset,
    address: TileAddress,
    format: Format,
) -> Result<Bytes, TileError> {
    let places: Vec<Place> = corners(address).collect();
    let zoom = (address.zoom + FINER).min(tileset.metadata().max_zoom);
    let found = heights.at(tileset, zoom, &places)?;
    let metres: Vec<Option<f64>> = found.iter().map(|height| height.metres()).collect();
    let mut colours = Vec::with_capacity(3 * (CELLS as usize + 1).pow(2));
    for row in 0..=CELLS as usize {
        let cell = cell_metres(address, places[(row + REACH as usize) * ROW].latitude);
        for column in 0..=CELLS as usize {
            let window = |y: usize, x: usize| metres[(row + y) * ROW + column + x];
            colours.extend(colour(gradient(window, cell)));
        }
    }
    Ok(write(format, &colours, CELLS as u32 + 1)?.into())
}

/// Row by row from the north. Counted around the Earth, so that tiles say the same of the same corner.
fn corners(address: TileAddress) -> impl Iterator<Item = Place> {
    let step = address.degrees() / CELLS as f64;
    let [first_column, first_row] = [address.x, address.y].map(|index| i64::from(index) * CELLS);
    let columns = (2 * CELLS) << address.zoom;
    (-REACH..=CELLS + REACH).rev().flat_map(move |row| {
        (-REACH..=CELLS + REACH).map(move |column| Place {
            longitude: (first_column + column).rem_euclid(columns) as f64 * step - 180.0,
            latitude: ((first_row + row) as f64 * step - 90.0).clamp(-90.0, 90.0),
        })
    })
}

/// Metres along a cell to the east and to the north.
fn cell_metres(address: TileAddress, latitude: f64) -> [f64; 2] {
    let step = address.degrees() / CELLS as f64;
    let at = |longitude, latitude| {
        to_earth_centred(Geodetic {
            longitude,
            latitude,
            height: 0.0,
        })
    };
    let here = at(0.0, latitude);
    [at(step, latitude), at(0.0, latitude - step)].map(|beside| here.distance(beside))
}

/// How much the plane rises to the east and to the north, metres a metre, that fits the heights around a corner best in the sense of
/// weighted least squares; level where too few are measured.
fn gradient(window: impl Fn(usize, usize) -> Option<f64>, cell: [f64; 2]) -> [f64; 2] {
    let mut points = Vec::with_capacity(WEIGHTS.len().pow(2));
    for (y, north) in WEIGHTS.iter().enumerate() {
        for (x, east) in WEIGHTS.iter().enumerate() {
            if let Some(height) = window(y, x) {
                let place = [x as f64 - REACH as f64, REACH as f64 - y as f64];
                points.push((north * east, [place[0], place[1], height]));
            }
        }
    }
    let total: f64 = points.iter().map(|(weight, _)| weight).sum();
    if total == 0.0 {
        return [0.0; 2];
    }
    let mean = array::from_fn::<f64, 3, _>(|axis| points.iter().map(|(w, point)| w * point[axis]).sum::<f64>() / total);
    let moment = |i: usize, j: usize| -> f64 {
        let products = points.iter().map(|(w, p)| w * (p[i] - mean[i]) * (p[j] - mean[j]));
        products.sum::<f64>() / total
    };
    let [xx, xy, yy, xh, yh] = [moment(0, 0), moment(0, 1), moment(1, 1), moment(0, 2), moment(1, 2)];
    let determinant = xx * yy - xy * xy;
    if determinant < 1e-3 {
        return [0.0; 2];
    }
    [
        (xh * yy - yh * xy) / determinant / cell[0],
        (yh * xx - xh * xy) / determinant / cell[1],
    ]
}

fn colour([east, north]: [f64; 2]) -> [u8; 3] {
    let length = (1.0 + east * east + north * north).sqrt();
    let [red, green] = [-east / length, -north / length]
        .map(|part: f64| (128.0 + 127.0 * part.signum() * part.abs().sqrt()).round() as u8);
    [red, green, 0]
}

#[cfg(test)]
#[path = "gradients_tests.rs"]
mod tests;
