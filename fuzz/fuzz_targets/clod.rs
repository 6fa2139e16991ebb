//! Bytes for the decoder of curved levels.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = terrain_fuzz::clod(bytes);
});
