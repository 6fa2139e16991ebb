//! Tiles of one level for tests.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_codec::address::TileAddress;
use terrain_codec::filled::Filled;
use terrain_codec::tile::{Lineage, Tile};
use terrain_core::{Band, CollapseLog, Mesh, SurfacePartition};

/// A tile with `mesh` as its only level, which claims `error`.
pub(crate) fn of_one_level(
    address: TileAddress,
    extent_bits: u8,
    height_exponent: i8,
    mesh: &Mesh,
    error: f64,
) -> Tile {
    let log = CollapseLog {
        collapses: Vec::new(),
        bands: vec![Band { end: 0, error }; 4],
    };
    Tile {
        address,
        extent_bits,
        height_exponent,
        sampling: None,
        lineage: Lineage::default(),
        breaklines: Vec::new(),
        filled: Filled::default(),
        partition: SurfacePartition::from_log(mesh, &log, error).unwrap(),
        outline_errors: vec![0.0; 5],
    }
}
