//! Whatever the bytes, the decoder of tiles gives a tile that stands its own checks, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use terrain_core::partition::validate;
use terrain_tiles::codec::{Limits, decode};

const LIMITS: Limits = Limits {
    levels: 64,
    vertices: 1 << 16,
    triangles: 1 << 17,
};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(tile) = decode(bytes, &LIMITS) {
        assert_eq!(validate(&tile.partition), Ok(()));
    }
});
