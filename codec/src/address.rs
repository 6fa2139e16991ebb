//! Tile addresses of the default scheme: WGS84 geographic, two root tiles, rows counted from the south (TMS).

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Largest zoom: lattice coordinates of the whole Earth then still fit exactly in the integers of an `f64`.
pub const MAX_ZOOM: u8 = 26;

/// A tile of the geographic scheme. Zoom `z` has 2^(z+1) columns and 2^z rows; `y` counts from the south pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileAddress {
    /// 0 is the pair of roots.
    pub zoom: u8,
    /// Column from the antimeridian eastwards.
    pub x: u32,
    /// Row from the south pole northwards.
    pub y: u32,
}

/// A rectangle of longitudes and latitudes, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Longitude of its west side.
    pub west: f64,
    /// Latitude of its south side.
    pub south: f64,
    /// From west to east.
    pub width: f64,
    /// From south to north.
    pub height: f64,
}

impl From<TileAddress> for Rectangle {
    fn from(address: TileAddress) -> Self {
        Self {
            west: address.west(),
            south: address.south(),
            width: address.degrees(),
            height: address.degrees(),
        }
    }
}

impl Rectangle {
    /// Longitude and latitude at parts of its width and height.
    #[must_use]
    pub fn place(&self, [across, up]: [f64; 2]) -> [f64; 2] {
        [self.west + across * self.width, self.south + up * self.height]
    }
}

/// The four sides of a tile, in the order in which the tile format stores their levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// Towards smaller x.
    West,
    /// Towards smaller y.
    South,
    /// Towards larger x.
    East,
    /// Towards larger y.
    North,
}

impl Side {
    /// All four, in storage order.
    pub const ALL: [Side; 4] = [Side::West, Side::South, Side::East, Side::North];
}

impl TileAddress {
    /// The tile at `zoom`, `x`, `y`, if the scheme has one there.
    #[must_use]
    pub fn new(zoom: u8, x: u32, y: u32) -> Option<Self> {
        (zoom <= MAX_ZOOM && x >> (zoom + 1) == 0 && y >> zoom == 0).then_some(Self { zoom, x, y })
    }

    /// Degrees along a side.
    #[must_use]
    pub fn degrees(self) -> f64 {
        180.0 / f64::from(1_u32 << self.zoom)
    }

    /// Longitude of the west side, in degrees.
    #[must_use]
    pub fn west(self) -> f64 {
        f64::from(self.x) * self.degrees() - 180.0
    }

    /// Latitude of the south side, in degrees.
    #[must_use]
    pub fn south(self) -> f64 {
        f64::from(self.y) * self.degrees() - 90.0
    }

    /// The tile that holds this one a zoom up, if this is no root.
    #[must_use]
    pub fn parent(self) -> Option<Self> {
        (self.zoom > 0).then(|| Self {
            zoom: self.zoom - 1,
            x: self.x / 2,
            y: self.y / 2,
        })
    }

    /// The four tiles a zoom down: south-west, south-east, north-west, north-east.
    #[must_use]
    pub fn children(self) -> [Self; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| Self {
            zoom: self.zoom + 1,
            x: self.x * 2 + dx,
            y: self.y * 2 + dy,
        })
    }

    /// The tile across `side` at the same zoom; columns wrap at the antimeridian, rows end at the poles.
    #[must_use]
    pub fn neighbour(self, side: Side) -> Option<Self> {
        let columns = 1_u32 << (self.zoom + 1);
        match side {
            Side::West => Some(Self {
                x: (self.x + columns - 1) % columns,
                ..self
            }),
            Side::East => Some(Self {
                x: (self.x + 1) % columns,
                ..self
            }),
            Side::South => self.y.checked_sub(1).map(|y| Self { y, ..self }),
            Side::North => Self::new(self.zoom, self.x, self.y + 1),
        }
    }

    /// The tiles that meet this one at a side or a corner, those that there can be, in their order.
    #[must_use]
    pub fn around(self) -> Vec<Self> {
        let beside = |address: Option<Self>, side: Side| address.and_then(|address| address.neighbour(side));
        let all = [Side::South, Side::North].into_iter().flat_map(|side| {
            let row = beside(Some(self), side);
            [row, beside(row, Side::West), beside(row, Side::East)]
        });
        let row = [beside(Some(self), Side::West), beside(Some(self), Side::East)];
        let mut around: Vec<Self> = all.chain(row).flatten().filter(|&other| other != self).collect();
        around.sort_unstable();
        around.dedup();
        around
    }
}

impl fmt::Display for TileAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.zoom, self.x, self.y)
    }
}

/// Of the tiles that are there, the one that stands for a square: the one at `address`, or the leaf that is above it.
#[must_use]
pub fn standing_for(address: TileAddress, is_there: impl Fn(TileAddress) -> bool) -> Option<TileAddress> {
    let and_above = std::iter::successors(Some(address), |address| address.parent());
    let nearest = and_above.into_iter().find(|&address| is_there(address))?;
    (nearest == address || is_leaf(nearest, is_there)).then_some(nearest)
}

/// Whether a tile is a leaf: none of those that are there is below it.
#[must_use]
pub fn is_leaf(address: TileAddress, is_there: impl Fn(TileAddress) -> bool) -> bool {
    !address.children().into_iter().any(is_there)
}

/// Rectangles of one row each (first x, y, last x, y) that tiles of one zoom fill exactly, from the south.
#[must_use]
pub fn rows_of(tiles: impl Iterator<Item = TileAddress>) -> Vec<[u32; 4]> {
    let mut rows: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for tile in tiles {
        rows.entry(tile.y).or_default().insert(tile.x);
    }
    let runs = |(y, columns): (u32, BTreeSet<u32>)| {
        let columns: Vec<u32> = columns.into_iter().collect();
        let runs = columns.chunk_by(|one, next| one + 1 == *next);
        runs.map(|run| [run[0], y, run[run.len() - 1], y]).collect::<Vec<_>>()
    };
    rows.into_iter().flat_map(runs).collect()
}

#[cfg(test)]
#[path = "address_tests.rs"]
mod tests;
