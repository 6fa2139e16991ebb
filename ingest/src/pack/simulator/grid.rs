//! Where the posts of heightmaps are: the largest rectangle of the frame that is inside a box of longitudes and latitudes, in
//! tiles of 2ⁿ + 1 posts a side that share their outer rows.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, UVec2};

use super::super::unusable::Unusable;
use super::frame::{Frame, at};

/// A tile has so many posts a side, at most, if nobody says how many.
const USUAL_SIZE: u32 = 1025;
/// Sides of the box are looked at in so many places.
const PLACES: u32 = 64;
/// Tiles along a side, at most.
const MOST_TILES: u32 = 1 << 10;

/// Posts in the frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// The south-west post.
    pub(super) low: DVec2,
    /// The north-east post.
    pub(super) high: DVec2,
    /// Posts along a side of a tile.
    pub(super) size: u32,
    /// Tiles across and up.
    pub(super) tiles: UVec2,
}

impl Grid {
    /// Posts no further apart than `spacing` in `rectangle`; as many a side as `size` says, or as few as do.
    pub(super) fn new([low, high]: [DVec2; 2], spacing: f64, size: Option<u32>) -> Result<Self, Unusable> {
        let cells = (high - low) / spacing;
        let enough = |size: &u32| f64::from(size - 1) >= cells.max_element();
        let least = (1..)
            .map(|bits| (1_u32 << bits) + 1)
            .take_while(|&size| size <= USUAL_SIZE);
        let size = size.unwrap_or_else(|| least.clone().find(enough).unwrap_or(USUAL_SIZE));
        let tiles = (cells / f64::from(size - 1)).ceil().max(DVec2::ONE);
        if tiles.max_element() > f64::from(MOST_TILES) {
            return Err(Unusable(format!(
                "posts every {spacing} m are {} × {} heightmaps: {MOST_TILES} a side at most, give a larger --spacing or --size",
                tiles.x, tiles.y
            )));
        }
        Ok(Self {
            low,
            high,
            size,
            tiles: tiles.as_uvec2(),
        })
    }

    /// Metres from post to post, east and north.
    pub(super) fn spacing(&self) -> DVec2 {
        (self.high - self.low) / (self.tiles * (self.size - 1)).as_dvec2()
    }

    /// A post, counted from the south-west over all tiles. It is the same to the bit for both tiles that have it.
    pub(super) fn post(&self, index: UVec2) -> DVec2 {
        self.low + self.spacing() * index.as_dvec2()
    }

    /// The south-west post of a tile.
    pub(super) fn first(&self, tile: UVec2) -> UVec2 {
        tile * (self.size - 1)
    }

    /// The outermost posts of a tile.
    pub(super) fn rectangle(&self, tile: UVec2) -> [DVec2; 2] {
        [self.first(tile), self.first(tile + 1)].map(|index| self.post(index))
    }

    /// All tiles, row by row from the south.
    pub(super) fn all(&self) -> impl Iterator<Item = UVec2> + use<> {
        let UVec2 { x: columns, y: rows } = self.tiles;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| UVec2::new(column, row)))
    }
}

/// The largest rectangle that is inside a box of degrees at all heights, by `margin` metres.
pub(super) fn inside(
    frame: &Frame,
    [west, south, east, north]: [f64; 4],
    heights: [f64; 2],
    margin: f64,
) -> Result<[DVec2; 2], Unusable> {
    let along = |from: DVec2, to: DVec2| {
        let parts = (0..=PLACES).map(move |part| f64::from(part) / f64::from(PLACES));
        let places = parts.map(move |part| from.lerp(to, part));
        places.flat_map(move |place| heights.map(|height| frame.local(at(place, height))))
    };
    let [southwest, southeast, northwest, northeast] =
        [(west, south), (east, south), (west, north), (east, north)].map(|(x, y)| DVec2::new(x, y));
    let low = DVec2::new(
        along(southwest, northwest).map(|at| at.x).fold(f64::MIN, f64::max),
        along(southwest, southeast).map(|at| at.y).fold(f64::MIN, f64::max),
    );
    let high = DVec2::new(
        along(southeast, northeast).map(|at| at.x).fold(f64::MAX, f64::min),
        along(northwest, northeast).map(|at| at.y).fold(f64::MAX, f64::min),
    );
    let (low, high) = (low + margin, high - margin);
    if (high - low).min_element() > 0.0 && frame.tilt < FRAC_PI_2 {
        Ok([low, high])
    } else {
        Err(Unusable("no rectangle is inside that box".to_owned()))
    }
}

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;
