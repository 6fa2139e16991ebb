//! Whatever the bytes, the decoder of models gives a model that stands its own checks, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use terrain_core::levels::partition::validate;
use terrain_fuzz::LIMITS;
use terrain_tiles::formats::spm::decode;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(model) = decode(bytes, &LIMITS) {
        assert_eq!(validate(&model.partition), Ok(()));
    }
});
