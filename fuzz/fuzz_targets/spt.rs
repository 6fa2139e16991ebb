//! Bytes for the decoder of tiles.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = terrain_fuzz::spt(bytes);
});
