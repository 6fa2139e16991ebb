//! Where there is water: polygons on the Earth, and masks of tiles.

use std::ops::Range;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use terrain_codec::address::Rectangle;

/// Pixels along each side of a tile's mask.
pub const MASK_SIDE: usize = 256;
/// A pixel of land in a mask.
pub const LAND: u8 = 0;
/// A pixel of water in a mask.
pub const WATER: u8 = 255;

/// Areas of water.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Water {
    /// What is inside of an odd number of a polygon's rings is water. Rings are of longitudes and latitudes in degrees; longitudes go on
    /// past the antimeridian.
    pub polygons: Vec<Vec<Vec<[f64; 2]>>>,
}

impl Water {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.polygons.is_empty()
    }

    /// The mask of a tile as quantized-mesh has it: one pixel where all are the same, else [`MASK_SIDE`] rows of as many, the
    /// northernmost first. A pixel is what its middle is.
    #[must_use]
    pub fn mask(&self, tile: impl Into<Rectangle>) -> Vec<u8> {
        let tile = tile.into();
        let mut mask = vec![LAND; MASK_SIDE * MASK_SIDE];
        let polygons = self.polygons.iter().flat_map(|rings| in_pixels(rings, tile));
        for rings in polygons {
            let rows = runs(&rings, 0..MASK_SIDE as i64);
            for (row, columns) in mask.chunks_exact_mut(MASK_SIDE).zip(rows) {
                for run in columns {
                    let [start, end] = [run.start, run.end].map(|column| column.clamp(0, MASK_SIDE as i64) as usize);
                    row[start..end].fill(WATER);
                }
            }
        }
        let first = mask[0];
        if mask.iter().all(|&pixel| pixel == first) {
            mask.truncate(1);
        }
        mask
    }
}

/// A polygon in pixels of a tile, whose middles are at whole numbers; each time that it reaches into the tile on its way around the Earth.
fn in_pixels(rings: &[Vec<[f64; 2]>], tile: Rectangle) -> impl Iterator<Item = Vec<Vec<DVec2>>> {
    let pixels_in_a_degree = MASK_SIDE as f64 / DVec2::new(tile.width, tile.height);
    let north = tile.south + tile.height;
    let seen_from = move |west: f64| {
        let pixel = move |&[longitude, latitude]: &[f64; 2]| {
            DVec2::new(longitude - west, north - latitude) * pixels_in_a_degree - 0.5
        };
        let in_pixels = |ring: &Vec<[f64; 2]>| ring.iter().map(pixel).collect::<Vec<DVec2>>();
        rings.iter().map(in_pixels).collect::<Vec<_>>()
    };
    let reaches_in = |rings: &Vec<Vec<DVec2>>| {
        let nowhere = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let points = rings.iter().flatten();
        let (low, high) = points.fold(nowhere, |(low, high), &at| (low.min(at), high.max(at)));
        high.cmpge(DVec2::ZERO).all() && low.cmplt(DVec2::splat(MASK_SIDE as f64)).all()
    };
    let turns = [-360.0, 0.0, 360.0].map(|turn| seen_from(tile.west + turn));
    turns.into_iter().filter(reaches_in)
}

/// The whole columns inside of an odd number of closed rings, as runs, for each of `rows`.
#[must_use]
pub fn runs(rings: &[Vec<DVec2>], rows: Range<i64>) -> Vec<Vec<Range<i64>>> {
    let mut crossings = vec![Vec::new(); (rows.end - rows.start).max(0) as usize];
    for ring in rings {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (low, high) = (a.y.min(b.y), a.y.max(b.y));
            let [first, end] = [low, high].map(|y| (y.ceil() as i64).clamp(rows.start, rows.end));
            for row in first..end {
                let x = a.x + (b.x - a.x) * (row as f64 - a.y) / (b.y - a.y);
                crossings[(row - rows.start) as usize].push(x);
            }
        }
    }
    let inside = |mut crossings: Vec<f64>| {
        crossings.sort_by(f64::total_cmp);
        let pairs = crossings.chunks_exact(2);
        pairs.map(|pair| pair[0].ceil() as i64..pair[1].ceil() as i64).collect()
    };
    crossings.into_iter().map(inside).collect()
}

#[cfg(test)]
#[path = "water_tests.rs"]
mod tests;
