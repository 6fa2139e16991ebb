//! The tiles of an archive as a hierarchy to select from: where each is in space, and what its levels claim.

use std::collections::HashMap;

use terrain_core::levels::partition;
use terrain_core::selection::hierarchy::{Hierarchy, Level};
use terrain_core::selection::oriented_box::OrientedBox;

use terrain_codec::address::{Side, TileAddress};
use terrain_codec::ellipsoid;
use terrain_codec::tile::Tile;

/// What the selection asks of one tile.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Holds all its surfaces; in a pyramid, also those of all tiles below it.
    pub bounds: OrientedBox,
    /// Its interior levels, coarsest first. The triangles of the finest are those with all sides fine.
    pub levels: Vec<Level>,
}

/// Tiles by address.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    tiles: HashMap<TileAddress, Summary>,
    roots: Vec<TileAddress>,
}

impl Summary {
    /// Of a tile that takes `bytes` at any of its levels; bounds are in Earth-centred metres, along east, north and up in the
    /// middle of the tile. None of a tile that has no vertices or no interior level.
    #[must_use]
    pub fn of(tile: &Tile, bytes: u64) -> Option<Self> {
        let partition = &tile.partition;
        let places = partition.positions.iter().chain(&partition.blue_positions);
        let bounds = OrientedBox::around(axes(tile.address), places.map(|&place| tile.earth_centred(place)))?;
        let interior = partition.levels.len().checked_sub(Side::ALL.len())?;
        let finest = interior.checked_sub(1)?;
        let level = |(index, level): (usize, &partition::Level)| Level {
            error: level.error,
            triangles: if index == finest {
                partition.triangles.len() as u64
            } else {
                u64::from(level.triangle_end)
            },
            bytes,
        };
        let levels = partition.levels[..interior].iter().enumerate().map(level).collect();
        Some(Self { bounds, levels })
    }
}

fn axes(address: TileAddress) -> [glam::DVec3; 3] {
    let half = address.degrees() / 2.0;
    let turned = ellipsoid::east_north_up(address.west() + half, address.south() + half);
    [turned.x_axis, turned.y_axis, turned.z_axis]
}

impl Pyramid {
    /// Of all tiles that have their parents among them, up to a root.
    #[must_use]
    pub fn new(tiles: impl IntoIterator<Item = (TileAddress, Summary)>) -> Self {
        let mut tiles: HashMap<TileAddress, Summary> = tiles.into_iter().collect();
        let mut addresses: Vec<TileAddress> = tiles.keys().copied().collect();
        addresses.sort_unstable();
        addresses.retain(|address| {
            let has_parent = address.parent().is_none_or(|parent| tiles.contains_key(&parent));
            if !has_parent {
                tiles.remove(address);
            }
            has_parent
        });
        let mut pyramid = Self {
            tiles,
            roots: addresses.iter().copied().filter(|address| address.zoom == 0).collect(),
        };
        for address in addresses.into_iter().rev() {
            let inside = pyramid.tiles[&address].bounds;
            let parent = address.parent().and_then(|parent| pyramid.tiles.get_mut(&parent));
            if let Some(parent) = parent {
                parent.bounds = parent.bounds.holding(&inside);
            }
        }
        pyramid
    }

    /// How many tiles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Whether there is a tile.
    #[must_use]
    pub fn contains(&self, address: TileAddress) -> bool {
        self.tiles.contains_key(&address)
    }
}

impl Hierarchy for Pyramid {
    type Node = TileAddress;

    fn roots(&self) -> impl Iterator<Item = TileAddress> {
        self.roots.iter().copied()
    }

    fn parent(&self, node: TileAddress) -> Option<TileAddress> {
        node.parent()
    }

    fn children(&self, node: TileAddress) -> impl Iterator<Item = TileAddress> {
        node.children().into_iter().filter(|&child| self.contains(child))
    }

    fn neighbours(&self, node: TileAddress) -> [Option<TileAddress>; 4] {
        Side::ALL.map(|side| node.neighbour(side).filter(|&near| self.contains(near)))
    }

    /// # Panics
    /// Where there is no such tile.
    fn bounds(&self, node: TileAddress) -> OrientedBox {
        self.tiles[&node].bounds
    }

    /// # Panics
    /// Where there is no such tile.
    fn levels(&self, node: TileAddress) -> &[Level] {
        &self.tiles[&node].levels
    }
}

#[cfg(test)]
#[path = "pyramid_tests.rs"]
mod tests;
