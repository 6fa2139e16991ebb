//! Bytes for the decoder of models.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = terrain_fuzz::spm(bytes);
});
