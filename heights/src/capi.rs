//! Heights for C. Names begin with `terrain_heights_`; nothing here panics across the border.

#![expect(unsafe_code, reason = "C passes pointers")]

use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr;

use terrain_tiles::ground::Point;

use crate::heights::{Heights, Place};

/// An open archive.
pub struct TerrainHeights {
    heights: Heights,
    /// With a zero behind it.
    above: Vec<u8>,
}

/// What there is at a place.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TerrainStatus {
    /// Ground: the answer is set.
    Measured = 0,
    /// Within the archive's bounds, but its source has no samples there.
    Void = 1,
    /// Out of the archive's bounds, or no place on the Earth.
    Outside = 2,
    /// The archive cannot be read there.
    Failed = 3,
    /// Ground, but not measured: a void of the source was filled there. The answer is set; its error is not a number.
    Filled = 4,
}

/// The ground at a place.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TerrainGround {
    /// Metres above what `terrain_heights_above` says.
    pub height: f64,
    /// Metres along the vertical that the source may be from that, certified.
    pub error: f64,
    /// Unit normal of the surface: east, north, up.
    pub normal: [f64; 3],
}

impl TerrainGround {
    fn at(point: Point, error: f64) -> Self {
        Self {
            height: point.height,
            error,
            normal: point.normal.to_array(),
        }
    }
}

/// Opens the archive at `path`. Decoded surfaces take `cache_bytes` of memory at most, besides those that are being asked. Gives NULL
/// where the archive cannot be read; `message`, if it is not NULL, then has the reason, cut to `message_size` bytes with the zero
/// at its end.
///
/// # Safety
/// `path` is a text with a zero at its end; `message` has `message_size` bytes, or is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_heights_open(
    path: *const c_char,
    cache_bytes: u64,
    message: *mut c_char,
    message_size: usize,
) -> *mut TerrainHeights {
    // SAFETY: the caller promises it.
    let path = (!path.is_null()).then(|| unsafe { CStr::from_ptr(path) });
    let opened = catch_unwind(|| {
        let path = path
            .and_then(|path| path.to_str().ok())
            .ok_or("the path is not UTF-8")?;
        Heights::open(Path::new(path), cache_bytes).map_err(|error| error.to_string())
    });
    match opened.unwrap_or_else(|_| Err("the archive cannot be read".to_owned())) {
        Ok(heights) => {
            let above = [heights.above().as_bytes(), &[0]].concat();
            Box::into_raw(Box::new(TerrainHeights { heights, above }))
        }
        Err(reason) => {
            if !message.is_null() && message_size > 0 {
                let length = reason.len().min(message_size - 1);
                // SAFETY: `message` has room for so many bytes and the zero.
                unsafe {
                    ptr::copy_nonoverlapping(reason.as_ptr(), message.cast(), length);
                    *message.add(length) = 0;
                }
            }
            ptr::null_mut()
        }
    }
}

/// Closes what `terrain_heights_open` gave; NULL is nothing. Nobody may be asking it, then or later.
///
/// # Safety
/// `heights` is what `terrain_heights_open` gave, and was not closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_heights_close(heights: *mut TerrainHeights) {
    if !heights.is_null() {
        // SAFETY: it was made by `Box::into_raw`, and the caller has no other.
        drop(unsafe { Box::from_raw(heights) });
    }
}

/// The archive's finest zoom.
///
/// # Safety
/// `heights` is open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_heights_finest_zoom(heights: *const TerrainHeights) -> u8 {
    // SAFETY: the caller promises it.
    unsafe { &*heights }.heights.finest_zoom()
}

/// What heights are above, in words; valid until `heights` is closed.
///
/// # Safety
/// `heights` is open.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_heights_above(heights: *const TerrainHeights) -> *const c_char {
    // SAFETY: the caller promises it.
    unsafe { &*heights }.above.as_ptr().cast()
}

/// The ground at degrees of longitude and latitude, on the surface of `zoom`; 255 is the finest. Any number of threads may ask at a
/// time, and all get the same. `ground` is set where there is any. A tile is read and decoded when it is asked first, and when it was
/// not for long; all else takes less than a microsecond or so and allocates nothing.
///
/// # Safety
/// `heights` is open; `ground` points at one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_heights_at(
    heights: *const TerrainHeights,
    longitude: f64,
    latitude: f64,
    zoom: u8,
    ground: *mut TerrainGround,
) -> TerrainStatus {
    // SAFETY: the caller promises it.
    let heights = unsafe { &(*heights).heights };
    match catch_unwind(AssertUnwindSafe(|| heights.at(longitude, latitude, zoom))) {
        Ok(Ok(Place::Measured(point, error))) => {
            // SAFETY: the caller promises it.
            unsafe { ground.write(TerrainGround::at(point, error)) };
            TerrainStatus::Measured
        }
        Ok(Ok(Place::Filled(point))) => {
            // SAFETY: the caller promises it.
            unsafe { ground.write(TerrainGround::at(point, f64::NAN)) };
            TerrainStatus::Filled
        }
        Ok(Ok(Place::Void)) => TerrainStatus::Void,
        Ok(Ok(Place::Outside)) => TerrainStatus::Outside,
        Ok(Err(_)) | Err(_) => TerrainStatus::Failed,
    }
}
