//! Rasters of normals of a tile's square, for light that does not depend on how many triangles are drawn.
//!
//! ```text
//! corners of 256 × 256 cells and some around ─▶ heights two zooms finer ─▶ plane through the neighbours of every second ─▶ normal ─▶ greys
//! ```
//!
//! A raster is two grey squares of 129 × 129 corners, one above the other: the parts of the normal to the east and to the north, each
//! `128 + 127 √|n|`, or minus for those below 0. A root, because most ground is nearly level. What is at a corner of a cell depends on its
//! place and the zoom alone, so tiles have the same greys along a common side.
//!
//! The plane through the neighbours is so smooth that corners between two of the raster tell little more: clients take them from a cubic.
//!
//! Towards a pole cells grow narrow: neighbours are then so many columns away that they are about as far as those in other rows, and
//! beyond the pole they are on its other side. How much a plane rises to the east is not told by neighbours that are closer still.

use std::array;

use axum::body::Bytes;
use glam::DVec2;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{east_north_up, on_ellipsoid};
use terrain_tiles::raster_dem::image::{Format, Pixels, write};

use crate::heights::{Heights, Place};
use crate::tileset::{TileError, Tileset};

/// Cells along a side of a tile; there is one corner more.
const CELLS: i64 = 256;
/// Of the corners, a raster has those so many cells apart.
const SPACING: i64 = 2;
/// Along a side of a raster.
const SIDE: u32 = (CELLS / SPACING) as u32 + 1;
/// So many corners on each side of one have a part in its plane.
const REACH: i64 = 3;
/// Of corners by their distance along an axis: binomial.
const WEIGHTS: [f64; 2 * REACH as usize + 1] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
/// Rows of corners that have a part in a raster.
const ROWS: usize = (CELLS + 1 + 2 * REACH) as usize;
/// Columns from a corner to the next one that has a part in its plane, at most.
const MOST_STRIDE: i64 = 32;
/// Neighbours that are spread to the east by less than the root of this, in cells from north to south, are taken to be so much.
const LEAST_SPREAD: f64 = 0.1;
/// Heights are of a surface so many zooms finer: its error is a quarter of the tile's.
const FINER: u8 = 2;

/// The raster of a tile, rows from the north. Blocks for some 100 ms.
pub(super) fn draw(
    heights: &Heights,
    tileset: &Tileset,
    address: TileAddress,
    format: Format,
) -> Result<Bytes, TileError> {
    let zoom = (address.zoom + FINER).min(tileset.metadata().max_zoom);
    let found = heights.at(tileset, zoom, &Corners::new(address).places())?;
    let metres: Vec<Option<f64>> = found.iter().map(|height| height.metres()).collect();
    let [east, north]: [Vec<u8>; 2] = gradients(address, &metres).map(greys).unzip().into();
    Ok(write(format, Pixels::Grey, &[east, north].concat(), [SIDE, 2 * SIDE])?.into())
}

/// The rise to the east and to the north at each corner of a raster, row by row from the north, of heights at the places of [`Corners`].
fn gradients(address: TileAddress, metres: &[Option<f64>]) -> impl Iterator<Item = [f64; 2]> {
    let corners = Corners::new(address);
    (0..=CELLS as usize).step_by(SPACING as usize).flat_map(move |row| {
        let middle = row as i64 + REACH;
        let stride = corners.stride(middle);
        let cell = corners.cell_metres(middle);
        let offsets = corners.offsets(middle, cell);
        let first = row * corners.width + corners.margin as usize;
        (0..=CELLS).step_by(SPACING as usize).map(move |column| {
            let window = |y: usize, x: usize| {
                let along = column + (x as i64 - REACH) * stride;
                metres[(first + y * corners.width).wrapping_add_signed(along as isize)]
            };
            gradient(window, &offsets).map(|rise| rise / cell)
        })
    })
}

/// The corners of a tile's cells and some around, row by row from the north.
#[derive(Clone, Copy)]
struct Corners {
    address: TileAddress,
    /// How many there are on each side of the tile's own columns.
    margin: i64,
    /// Columns.
    width: usize,
}

impl Corners {
    fn new(address: TileAddress) -> Self {
        let mut corners = Self {
            address,
            margin: 0,
            width: 0,
        };
        let widest = (0..=CELLS).map(|row| corners.stride(row + REACH)).max();
        corners.margin = REACH * widest.unwrap_or(1);
        corners.width = (CELLS + 1 + 2 * corners.margin) as usize;
        corners
    }

    /// Counted around the Earth, so that tiles say the same of the same corner.
    fn places(&self) -> Vec<Place> {
        let step = self.address.degrees() / CELLS as f64;
        let first = i64::from(self.address.x) * CELLS;
        let columns = (2 * CELLS) << self.address.zoom;
        let places = (0..ROWS as i64).flat_map(|row| {
            let latitude = self.latitude(row);
            // Beyond a pole is the other side of it.
            let (latitude, turn) = if latitude.abs() > 90.0 {
                (latitude.signum() * 180.0 - latitude, columns / 2)
            } else {
                (latitude, 0)
            };
            (-self.margin..=CELLS + self.margin).map(move |column| Place {
                longitude: (first + column + turn).rem_euclid(columns) as f64 * step - 180.0,
                latitude,
            })
        });
        places.collect()
    }

    /// Of a row from the north, degrees; beyond the pole further on.
    fn latitude(&self, row: i64) -> f64 {
        let from_south = i64::from(self.address.y) * CELLS + CELLS + REACH - row;
        from_south as f64 * self.address.degrees() / CELLS as f64 - 90.0
    }

    /// Columns from a corner of a row to the next one that has a part in its plane; all of them within a quarter of the way around.
    fn stride(&self, row: i64) -> i64 {
        let most = MOST_STRIDE.min(((2 * CELLS) << self.address.zoom) / 4 / REACH);
        let narrowness = 1.0 / self.latitude(row).to_radians().cos().abs().max(f64::MIN_POSITIVE);
        (narrowness as i64).clamp(1, most)
    }

    /// Metres along a cell of a row from south to north.
    fn cell_metres(&self, row: i64) -> f64 {
        let [here, below] = [row, row + 1].map(|row| on_ellipsoid(DVec2::new(0.0, self.latitude(row))));
        here.distance(below)
    }

    /// How far the neighbours of a corner of a row are to the east and to the north, in cells from south to north, on the plane that
    /// touches the Earth at the corner.
    fn offsets(&self, row: i64, cell: f64) -> [[[f64; 2]; WEIGHTS.len()]; WEIGHTS.len()] {
        let columns = self.stride(row) as f64 * self.address.degrees() / CELLS as f64;
        let frame = east_north_up(0.0, self.latitude(row));
        let here = on_ellipsoid(DVec2::new(0.0, self.latitude(row)));
        array::from_fn(|y| {
            let latitude = self.latitude(row + y as i64 - REACH);
            array::from_fn(|x| {
                let longitude = (x as i64 - REACH) as f64 * columns;
                let offset = (on_ellipsoid(DVec2::new(longitude, latitude)) - here) / cell;
                [frame.x_axis.dot(offset), frame.y_axis.dot(offset)]
            })
        })
    }
}

/// How many metres the plane rises over a cell to the east and to the north that fits the heights around a corner best in the sense of
/// weighted least squares; level where too few are measured.
fn gradient(
    window: impl Fn(usize, usize) -> Option<f64>,
    offsets: &[[[f64; 2]; WEIGHTS.len()]; WEIGHTS.len()],
) -> [f64; 2] {
    let mut points = Vec::with_capacity(WEIGHTS.len().pow(2));
    for (y, north) in WEIGHTS.iter().enumerate() {
        for (x, east) in WEIGHTS.iter().enumerate() {
            if let Some(height) = window(y, x) {
                let [to_east, to_north] = offsets[y][x];
                points.push((north * east, [to_east, to_north, height]));
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
    let xx = xx.max(LEAST_SPREAD);
    let determinant = xx * yy - xy * xy;
    if determinant < 1e-3 {
        return [0.0; 2];
    }
    [(xh * yy - yh * xy) / determinant, (yh * xx - xh * xy) / determinant]
}

/// Of the normal's parts to the east and to the north.
fn greys([east, north]: [f64; 2]) -> (u8, u8) {
    let length = (1.0 + east * east + north * north).sqrt();
    let grey = |part: f64| (128.0 + 127.0 * part.signum() * part.abs().sqrt()).round() as u8;
    (grey(-east / length), grey(-north / length))
}

#[cfg(test)]
#[path = "gradients_tests.rs"]
mod tests;
