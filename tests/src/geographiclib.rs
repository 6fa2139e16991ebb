//! Debian's GeographicLib (Charles Karney) as an oracle, by a C++ shim. Angles are in degrees, lengths in metres.

use glam::{DMat3, DVec2, DVec3};
use terrain_tiles::ellipsoid::Geodetic;

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

/// Longitude and latitude of easting and northing in a northern UTM zone.
///
/// # Panics
/// Where GeographicLib throws.
#[must_use]
pub fn from_northern_utm(zone: i32, point: DVec2) -> DVec2 {
    let mut geodetic = [0.0; 2];
    // SAFETY: the pointer is to an array of the length that the shim fills, alive during the call.
    let status = unsafe { shim_from_utm(zone, 1, point.x, point.y, &raw mut geodetic) };
    assert_eq!(status, 0, "GeographicLib refuses {point} in zone {zone}");
    DVec2::new(geodetic[1], geodetic[0])
}
