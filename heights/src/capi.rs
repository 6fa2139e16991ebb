//! Heights for C. Names begin with `terrain_heights_`; nothing here panics across the border.

#![expect(unsafe_code, reason = "C passes pointers")]

use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr;

use glam::{DMat3, DVec3};
use terrain_tiles::ground::Point;

use crate::frame::Frame;
use crate::heights::{Heights, HeightsError, Place};

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
    /// Metres above what `terrain_heights_above` says; in a frame, metres up of its origin.
    pub height: f64,
    /// Metres along the vertical that the source may be from that, certified; in a frame, along its up.
    pub error: f64,
    /// Unit normal of the surface: east, north, up, of the place or of the frame.
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

/// A local frame: metres east, north and up of its origin, flat in space, so that the Earth curves away below. All in Earth-centred
/// metres. `terrain_frame` makes it; a program may as well set it itself, the axes being unit vectors at right angles.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TerrainFrame {
    /// Where its origin is.
    pub origin: [f64; 3],
    /// Its axis to the east.
    pub east: [f64; 3],
    /// Its axis to the north.
    pub north: [f64; 3],
    /// Its axis upwards.
    pub up: [f64; 3],
}

impl From<&TerrainFrame> for Frame {
    fn from(frame: &TerrainFrame) -> Self {
        Self {
            origin: DVec3::from_array(frame.origin),
            axes: DMat3::from_cols_array_2d(&[frame.east, frame.north, frame.up]),
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
    let (status, found) = told(|| heights.at(longitude, latitude, zoom));
    // SAFETY: the caller promises it; what is there may never have been set.
    found.into_iter().for_each(|found| unsafe { ground.write(found) });
    status
}

/// Makes the local frame of a place: degrees of longitude and latitude, and metres above the ellipsoid. Gives whether there is such a
/// place.
///
/// # Safety
/// `frame` points at one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_frame(longitude: f64, latitude: f64, height: f64, frame: *mut TerrainFrame) -> bool {
    let Some(Frame { origin, axes }) = Frame::at(longitude, latitude, height) else {
        return false;
    };
    let [east, north, up] = axes.to_cols_array_2d();
    let made = TerrainFrame {
        origin: origin.to_array(),
        east,
        north,
        up,
    };
    // SAFETY: the caller promises it.
    unsafe { frame.write(made) };
    true
}

/// The ground at metres east and north in a local frame, where its vertical meets the surface of `zoom`, in all else as
/// `terrain_heights_at`: the height of `ground` is metres up in the frame, its error is along the frame's up, and its normal is in
/// the frame's axes. Heights of the archive are taken as above the ellipsoid. The error is infinite where the ground is so steep that a
/// vertical so far from its own may miss it; what is more than 45° from the origin is outside. It takes some microseconds.
///
/// # Safety
/// `heights` is open; `frame` points at one, and so does `ground`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn terrain_heights_in_frame(
    heights: *const TerrainHeights,
    frame: *const TerrainFrame,
    east: f64,
    north: f64,
    zoom: u8,
    ground: *mut TerrainGround,
) -> TerrainStatus {
    // SAFETY: the caller promises it.
    let (heights, frame) = unsafe { (&(*heights).heights, &*frame) };
    let (status, found) = told(|| heights.in_frame(&frame.into(), east, north, zoom));
    // SAFETY: the caller promises it; what is there may never have been set.
    found.into_iter().for_each(|found| unsafe { ground.write(found) });
    status
}

/// What was found, and the ground where there is any.
fn told(ask: impl FnOnce() -> Result<Place, HeightsError>) -> (TerrainStatus, Option<TerrainGround>) {
    match catch_unwind(AssertUnwindSafe(ask)) {
        Ok(Ok(Place::Measured(point, error))) => (TerrainStatus::Measured, Some(TerrainGround::at(point, error))),
        Ok(Ok(Place::Filled(point))) => (TerrainStatus::Filled, Some(TerrainGround::at(point, f64::NAN))),
        Ok(Ok(Place::Void)) => (TerrainStatus::Void, None),
        Ok(Ok(Place::Outside)) => (TerrainStatus::Outside, None),
        Ok(Err(_)) | Err(_) => (TerrainStatus::Failed, None),
    }
}
