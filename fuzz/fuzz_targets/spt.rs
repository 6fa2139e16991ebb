//! Whatever the bytes, the decoder of tiles gives a tile that stands its own checks, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use terrain_core::levels::partition::validate;
use terrain_fuzz::LIMITS;
use terrain_tiles::formats::spt::decode;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(tile) = decode(bytes, &LIMITS) {
        assert_eq!(validate(&tile.partition), Ok(()));
    }
});
