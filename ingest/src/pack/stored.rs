//! Tiles of an archive, decoded.

use anyhow::Context;
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::Reader;
use terrain_tiles::formats::quantized_mesh::addresses_around;
use terrain_tiles::formats::{LevelLimits, spt};
use terrain_tiles::tile::Tile;

pub(super) fn bytes(archive: &Reader, address: TileAddress) -> anyhow::Result<Vec<u8>> {
    archive
        .tile(address)?
        .with_context(|| format!("tile {address} is not there"))
}

pub(super) fn tile(archive: &Reader, address: TileAddress) -> anyhow::Result<Tile> {
    spt::decode(&bytes(archive, address)?, &LevelLimits::default()).with_context(|| format!("tile {address}"))
}

/// Those of the archive, whether they are in a pack or not: a pack of a part has the same tiles as one of all.
pub(super) fn tiles_around(archive: &Reader, address: TileAddress) -> anyhow::Result<Vec<Tile>> {
    let around = addresses_around(address).into_iter();
    around
        .filter(|&other| archive.checksum(other).is_some())
        .map(|other| tile(archive, other))
        .collect()
}
