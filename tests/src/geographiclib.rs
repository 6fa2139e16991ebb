//! Debian's GeographicLib (Charles Karney) as an oracle, by a C++ shim. Angles are in degrees, lengths in metres.

use std::ffi::{CString, c_char};
use std::path::Path;

use glam::{DMat3, DVec2, DVec3};
use terrain_codec::ellipsoid::Geodetic;

unsafe extern "C" {
    fn shim_to_earth_centred(
        latitude: f64,
        longitude: f64,
        height: f64,
        position: *mut [f64; 3],
        rotation: *mut [f64; 9],
    ) -> i32;
    fn shim_to_geodetic(x: f64, y: f64, z: f64, geodetic: *mut [f64; 3]) -> i32;
    fn shim_distance(latitude1: f64, longitude1: f64, latitude2: f64, longitude2: f64, metres: *mut f64) -> i32;
    fn shim_to_utm(zone: i32, latitude: f64, longitude: f64, north: *mut i32, projected: *mut [f64; 2]) -> i32;
    fn shim_from_transverse_mercator(meridian: f64, x: f64, y: f64, geodetic: *mut [f64; 2]) -> i32;
    fn shim_to_local(origin: *const [f64; 3], point: *const [f64; 3], local: *mut [f64; 3]) -> i32;
    fn shim_undulations(
        folder: *const c_char,
        name: *const c_char,
        count: i32,
        places: *const [f64; 2],
        metres: *mut f64,
    ) -> i32;
    fn shim_from_utm(zone: i32, north: i32, easting: f64, northing: f64, geodetic: *mut [f64; 2]) -> i32;
}

/// Earth-centred position of a geodetic point, and the rotation from local east, north, up.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn to_earth_centred(point: Geodetic) -> (DVec3, DMat3) {
    let (mut position, mut rotation) = ([0.0; 3], [0.0; 9]);
    // SAFETY: both pointers are to arrays of the length that the shim fills, alive during the call.
    let status = unsafe {
        shim_to_earth_centred(
            point.latitude,
            point.longitude,
            point.height,
            &raw mut position,
            &raw mut rotation,
        )
    };
    assert_eq!(status, 0, "GeographicLib refuses {point:?}");
    (DVec3::from(position), DMat3::from_cols_array(&rotation).transpose())
}

/// Geodetic coordinates of an Earth-centred position.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn to_geodetic(position: DVec3) -> Geodetic {
    let mut geodetic = [0.0; 3];
    // SAFETY: the pointer is to an array of the length that the shim fills, alive during the call.
    let status = unsafe { shim_to_geodetic(position.x, position.y, position.z, &raw mut geodetic) };
    assert_eq!(status, 0, "GeographicLib refuses {position}");
    let [latitude, longitude, height] = geodetic;
    Geodetic {
        longitude,
        latitude,
        height,
    }
}

/// Length of the shortest path on the ellipsoid between two points (longitude, latitude).
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn distance(from: DVec2, to: DVec2) -> f64 {
    let mut metres = 0.0;
    // SAFETY: the pointer is to a number that is alive during the call.
    let status = unsafe { shim_distance(from.y, from.x, to.y, to.x, &raw mut metres) };
    assert_eq!(status, 0, "GeographicLib refuses {from}, {to}");
    metres
}

/// Longitude and latitude of easting and northing in a UTM zone, in UPS for zone 0.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn from_utm(zone: i32, is_north: bool, point: DVec2) -> DVec2 {
    let mut geodetic = [0.0; 2];
    // SAFETY: the pointer is to an array of the length that the shim fills, alive during the call.
    let status = unsafe { shim_from_utm(zone, i32::from(is_north), point.x, point.y, &raw mut geodetic) };
    assert_eq!(status, 0, "GeographicLib refuses {point} in zone {zone}");
    DVec2::new(geodetic[1], geodetic[0])
}

/// Easting and northing of a longitude and latitude in a UTM zone, in UPS for zone 0, and whether it is a northern one.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn to_utm(zone: i32, place: DVec2) -> (DVec2, bool) {
    let (mut projected, mut north) = ([0.0; 2], 0);
    // SAFETY: the pointers are to a number and an array of the length that the shim fills, alive during the call.
    let status = unsafe { shim_to_utm(zone, place.y, place.x, &raw mut north, &raw mut projected) };
    assert_eq!(status, 0, "GeographicLib refuses {place} in zone {zone}");
    (DVec2::from(projected), north != 0)
}

/// Longitude and latitude of a place of the transverse Mercator projection of WGS84, scale 1 on its central meridian, by the exact
/// formulas.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn from_transverse_mercator(meridian: f64, point: DVec2) -> DVec2 {
    let mut geodetic = [0.0; 2];
    // SAFETY: the pointer is to an array of the length that the shim fills, alive during the call.
    let status = unsafe { shim_from_transverse_mercator(meridian, point.x, point.y, &raw mut geodetic) };
    assert_eq!(status, 0, "GeographicLib refuses {point}");
    DVec2::new(geodetic[1], geodetic[0])
}

/// East, north and up of a point from an origin.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn to_local(origin: Geodetic, point: Geodetic) -> DVec3 {
    let numbers = |point: Geodetic| [point.latitude, point.longitude, point.height];
    let (origin, point, mut local) = (numbers(origin), numbers(point), [0.0; 3]);
    // SAFETY: the pointers are to arrays of three numbers, alive during the call.
    let status = unsafe { shim_to_local(&raw const origin, &raw const point, &raw mut local) };
    assert_eq!(status, 0, "GeographicLib refuses {point:?} from {origin:?}");
    DVec3::from(local)
}

/// Metres of a geoid above the ellipsoid at longitudes and latitudes, bilinear in the grid `NAME.pgm` of a folder.
///
/// # Panics
/// Where GeographicLib throws, or a name holds a zero.
#[must_use]
pub fn undulations(folder: &Path, name: &str, places: &[DVec2]) -> Vec<f64> {
    let text = |text: &str| CString::new(text).expect("names without zeros");
    let (folder, name) = (text(&folder.display().to_string()), text(name));
    let places: Vec<[f64; 2]> = places.iter().map(|place| [place.y, place.x]).collect();
    let mut metres = vec![0.0; places.len()];
    let count = i32::try_from(places.len()).expect("fewer than two billion places");
    // SAFETY: the pointers are to texts that end in a zero and to as many places and numbers as `count` says, alive during the call.
    let status = unsafe {
        shim_undulations(
            folder.as_ptr(),
            name.as_ptr(),
            count,
            places.as_ptr(),
            metres.as_mut_ptr(),
        )
    };
    assert_eq!(status, 0, "GeographicLib refuses {name:?}");
    metres
}
