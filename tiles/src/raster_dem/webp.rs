//! Lossless WebP by libwebp, that of the system: in heights it finds a third fewer bytes than PNG has.
#![expect(unsafe_code, reason = "libwebp is a library in C")]

use std::io;
use std::ptr;
use std::slice;

use libwebp_sys::{WebPEncodeLosslessRGB, WebPFree};

/// Pixels along a side that the format has at most.
const LARGEST_SIDE: u32 = 16_383;

/// A file of colours of three bytes, row by row.
pub(super) fn write(colours: &[u8], [width, height]: [u32; 2]) -> io::Result<Vec<u8>> {
    let pixels = u64::from(width) * u64::from(height);
    if width.max(height) > LARGEST_SIDE || colours.len() as u64 != 3 * pixels {
        let count = colours.len();
        return Err(io::Error::other(format!(
            "{count} numbers for {width} × {height} pixels of a WebP file"
        )));
    }
    let [wide, high] = [width, height].map(|side| side as i32);
    let mut file = ptr::null_mut();
    // SAFETY: `colours` has `high` rows of `3 * wide` bytes.
    let size = unsafe { WebPEncodeLosslessRGB(colours.as_ptr(), wide, high, 3 * wide, &raw mut file) };
    if size == 0 || file.is_null() {
        return Err(io::Error::other(format!(
            "libwebp wrote no file of {width} × {height} pixels"
        )));
    }
    // SAFETY: libwebp gave so many bytes, and does not touch them until they are given back.
    let copy = unsafe { slice::from_raw_parts(file, size) }.to_vec();
    // SAFETY: they are given back once.
    unsafe { WebPFree(file.cast()) };
    Ok(copy)
}
