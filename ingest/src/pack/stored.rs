//! What a pack takes from an archive, and how it is stored.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use flate2::Compression;
use flate2::write::GzEncoder;
use terrain_codec::address::{Side, TileAddress};
use terrain_codec::tile::{Detail, Tile};
use terrain_tiles::archive::Reader;
use terrain_tiles::shading::{FinestSurface, Shading};

use crate::archive_tiles::tile;

/// Shaded surfaces kept in memory, bytes.
const SHADING_BYTES: u64 = 512 << 20;

/// Shaded surfaces of an archive's tiles, whether they are in a pack or not: a pack of a part has the same tiles as one of all.
pub(super) struct Surfaces<'a> {
    archive: &'a Reader,
    shading: Shading,
}

impl<'a> Surfaces<'a> {
    pub(super) fn of(archive: &'a Reader) -> Self {
        Self {
            archive,
            shading: Shading::new(SHADING_BYTES),
        }
    }

    /// That of a tile, if there is one.
    pub(super) fn at(&self, address: TileAddress) -> anyhow::Result<Option<Arc<FinestSurface>>> {
        let read = |address| {
            let is_there = self.archive.checksum(address).is_some();
            is_there.then(|| tile(self.archive, address)).transpose()
        };
        self.shading.surface(0, address, &read)
    }
}

/// The finest surface that meets those around: beside a leaf of the zoom above, the side is as coarse as the leaf's.
pub(super) fn detail(archive: &Reader, tile: &Tile) -> Detail {
    let is_fine = |side: Side| {
        let across = tile.address.neighbour(side);
        let standing = across.and_then(|across| archive.standing_for(across));
        standing.is_none_or(|standing| standing.zoom == tile.address.zoom)
    };
    Detail {
        fine_sides: Side::ALL.map(is_fine),
        ..tile.finest()
    }
}

/// The quantized-mesh at `address` in a folder of them, as packs of one file keep it.
pub(super) fn gzipped(folder: &Path, address: TileAddress) -> anyhow::Result<Vec<u8>> {
    let path = folder.join(format!("{address}.terrain"));
    let bytes = fs::read(&path).with_context(|| path.display().to_string())?;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&bytes)?;
    Ok(encoder.finish()?)
}
