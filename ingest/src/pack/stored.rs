//! Tiles of an archive, decoded; and what is stored in a pack.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow};
use flate2::Compression;
use flate2::write::GzEncoder;
use moka::sync::Cache;
use terrain_tiles::address::TileAddress;
use terrain_tiles::archive::Reader;
use terrain_tiles::formats::quantized_mesh::addresses_around;
use terrain_tiles::formats::{LevelLimits, spt};
use terrain_tiles::ground::Ground;
use terrain_tiles::tile::Tile;

/// Surfaces kept in memory to be asked for heights, bytes.
const GROUND_BYTES: u64 = 256 << 20;

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

/// The quantized-mesh at `address` in a folder of them, as packs of one file keep it.
pub(super) fn gzipped(folder: &Path, address: TileAddress) -> anyhow::Result<Vec<u8>> {
    let path = folder.join(format!("{address}.terrain"));
    let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&bytes)?;
    Ok(encoder.finish()?)
}

/// Surfaces that are asked for heights, each decoded once if there is room for it.
pub(super) struct Grounds<'a> {
    archive: &'a Reader,
    kept: Cache<TileAddress, Option<Arc<Ground>>>,
}

impl<'a> Grounds<'a> {
    pub(super) fn of(archive: &'a Reader) -> Self {
        let weight = |_: &TileAddress, ground: &Option<Arc<Ground>>| {
            let bytes = ground.as_ref().map_or(1, |ground| ground.size());
            u32::try_from(bytes).unwrap_or(u32::MAX)
        };
        Self {
            archive,
            kept: Cache::builder().weigher(weight).max_capacity(GROUND_BYTES).build(),
        }
    }

    /// That of the tile that stands for the square at `address`, if there is one.
    pub(super) fn at(&self, address: TileAddress) -> anyhow::Result<Option<Arc<Ground>>> {
        let decode = || {
            let standing = self.archive.standing_for(address);
            let decoded = standing.map(|address| tile(self.archive, address)).transpose()?;
            anyhow::Ok(decoded.map(|tile| Arc::new(Ground::of(&tile))))
        };
        let found = self.kept.try_get_with(address, decode);
        found.map_err(|error: Arc<anyhow::Error>| anyhow!("{error:#}"))
    }
}
