//! What the fuzz targets run: whatever the bytes, a decoder gives what stands its own checks, or an error.
//!
//! `cargo +nightly fuzz run spt` looks for new bytes; the tests of this crate run every target with the seeds in `corpus`,
//! and with damaged copies of them, on any toolchain.

use terrain_codec::LevelLimits;
use terrain_codec::clod::CurvedLimits;
use terrain_core::curved::tessellation::{Factors, Tessellation};
use terrain_core::levels::partition::validate;

/// Runs a decoder; true where it decoded something.
pub type Target = fn(&[u8]) -> bool;

/// Every target by its name, which is also that of its folder in `corpus` and of its program.
pub const TARGETS: [(&str, Target); 3] = [("clod", clod), ("spm", spm), ("spt", spt)];

/// Low enough that a made-up count never costs the fuzzer much memory or time, and above what the seeds in `corpus` need.
const LIMITS: LevelLimits = LevelLimits {
    levels: 64,
    vertices: 1 << 16,
    triangles: 1 << 17,
};

/// The decoder of curved levels.
///
/// # Panics
/// Where a level is decoded that cannot be drawn.
#[must_use]
pub fn clod(bytes: &[u8]) -> bool {
    let limits = CurvedLimits {
        levels: 64,
        patches: 1 << 12,
    };
    let decoded = terrain_codec::clod::decode(bytes, &limits);
    decoded.is_ok_and(|levels| {
        let coarse = Factors {
            edge: &|_| 2.0,
            patch: &|_| 3.0,
            is_gradual: false,
        };
        for level in 0..levels.len() {
            let made = Tessellation::by_factors(&levels.model(level), &coarse);
            assert!(made.is_ok_and(|made| made.mesh.triangles.len() >= levels.patch_count(level)));
        }
        true
    })
}

/// The decoder of tiles.
///
/// # Panics
/// Where a tile is decoded that is no Surface Partition.
#[must_use]
pub fn spt(bytes: &[u8]) -> bool {
    let decoded = terrain_codec::spt::decode(bytes, &LIMITS);
    decoded.is_ok_and(|tile| {
        assert_eq!(validate(&tile.partition), Ok(()));
        true
    })
}

/// The decoder of models.
///
/// # Panics
/// Where a model is decoded that is no Surface Partition.
#[must_use]
pub fn spm(bytes: &[u8]) -> bool {
    let decoded = terrain_codec::spm::decode(bytes, &LIMITS);
    decoded.is_ok_and(|model| {
        assert_eq!(validate(&model.partition), Ok(()));
        true
    })
}
