//! Tiles of an archive, decoded, and their surfaces, which are asked for heights.

use std::ops::Deref;
use std::sync::Arc;

use anyhow::{Context, Result, anyhow};
use moka::sync::Cache;
use terrain_codec::address::TileAddress;
use terrain_codec::tile::Tile;
use terrain_codec::{LevelLimits, spt};
use terrain_tiles::archive::Reader;
use terrain_tiles::ground::{Ground, Place, answers};

/// Surfaces kept in memory, bytes.
const KEPT: u64 = 256 << 20;

/// The bytes of a tile that the archive has.
///
/// # Errors
/// When they cannot be read, or are not there.
pub(crate) fn bytes(archive: &Reader, address: TileAddress) -> Result<Vec<u8>> {
    archive
        .tile(address)?
        .with_context(|| format!("tile {address} is not there"))
}

/// A tile that the archive has.
///
/// # Errors
/// When it cannot be read, or is not there.
pub(crate) fn tile(archive: &Reader, address: TileAddress) -> Result<Tile> {
    spt::decode(&bytes(archive, address)?, &LevelLimits::default()).with_context(|| format!("tile {address}"))
}

/// Surfaces of an archive, each decoded once if there is room for it.
pub(crate) struct Grounds<A> {
    archive: A,
    kept: Cache<TileAddress, Option<Arc<Ground>>>,
}

impl<A: Deref<Target = Reader>> Grounds<A> {
    pub(crate) fn of(archive: A) -> Self {
        let weight = |_: &TileAddress, ground: &Option<Arc<Ground>>| {
            let bytes = ground.as_ref().map_or(1, |ground| ground.size());
            u32::try_from(bytes).unwrap_or(u32::MAX)
        };
        Self {
            archive,
            kept: Cache::builder().weigher(weight).max_capacity(KEPT).build(),
        }
    }

    /// That of the tile that stands for the square at `address`, if there is one.
    ///
    /// # Errors
    /// When the tile cannot be read.
    pub(crate) fn at(&self, address: TileAddress) -> Result<Option<Arc<Ground>>> {
        let decode = || {
            let standing = self.archive.standing_for(address);
            let decoded = standing.map(|address| tile(&self.archive, address)).transpose()?;
            anyhow::Ok(decoded.map(|tile| Arc::new(Ground::of(&tile))))
        };
        let found = self.kept.try_get_with(address, decode);
        found.map_err(|error: Arc<anyhow::Error>| anyhow!("{error:#}"))
    }

    /// Metres of the surface of `zoom` at places, in their order; none where there is no ground.
    ///
    /// # Errors
    /// When a tile cannot be read.
    pub(crate) fn heights(&self, zoom: u8, places: &[Place]) -> Result<Vec<Option<f64>>> {
        let ask = |ground: &Ground, at: Place| ground.height(at.longitude, at.latitude);
        answers::<Arc<Ground>, _, _>(zoom, places, |address| self.at(address), ask)
    }
}
