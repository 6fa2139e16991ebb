//! Where tiles come from: an archive on disk, or a list in a test.

use std::collections::BTreeSet;

use terrain_codec::LevelLimits;
use terrain_codec::address::TileAddress;
use terrain_codec::spt;
use terrain_codec::tile::Tile;
use terrain_tiles::archive::Reader;
use terrain_tiles::metadata::Metadata;

/// Tiles and what their maker says of them.
pub(super) trait Tiles: Sync {
    fn metadata(&self) -> &Metadata;
    fn addresses(&self) -> Vec<TileAddress>;
    /// The tile, or why there is none, in one line.
    fn tile(&self, address: TileAddress) -> Result<Tile, String>;
}

impl Tiles for Reader {
    fn metadata(&self) -> &Metadata {
        Reader::metadata(self)
    }

    fn addresses(&self) -> Vec<TileAddress> {
        Reader::addresses(self).collect()
    }

    fn tile(&self, address: TileAddress) -> Result<Tile, String> {
        let bytes = Reader::tile(self, address)
            .map_err(|error| error.to_string())?
            .ok_or("is listed but not there")?;
        let tile = spt::decode(&bytes, &LevelLimits::default()).map_err(|error| error.to_string())?;
        check_header(&bytes, &tile)?;
        Ok(tile)
    }
}

/// Whether no tile is below one.
pub(super) fn is_leaf(exist: &BTreeSet<TileAddress>, tile: TileAddress) -> bool {
    !tile.children().iter().any(|child| exist.contains(child))
}

/// Compares the lowest and the highest height of the header, which clients cull by, with the vertices.
fn check_header(bytes: &[u8], tile: &Tile) -> Result<(), String> {
    let word = |at: usize| {
        bytes
            .get(at..at + 4)
            .and_then(|b| b.try_into().ok())
            .map(i32::from_le_bytes)
    };
    let (Some(lowest), Some(highest)) = (word(16), word(20)) else {
        return Err("is shorter than its header".to_owned());
    };
    let step = f64::from(tile.height_exponent).exp2();
    let vertices = || tile.partition.positions.iter().chain(&tile.partition.blue_positions);
    let (low, high) = vertices().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v.z), high.max(v.z))
    });
    if vertices().next().is_some() && (low != f64::from(lowest) * step || high != f64::from(highest) * step) {
        let (lowest, highest) = (f64::from(lowest) * step, f64::from(highest) * step);
        return Err(format!(
            "says its heights are {lowest} to {highest} m, but they are {low} to {high} m"
        ));
    }
    Ok(())
}
