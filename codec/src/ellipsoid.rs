//! WGS84: geodetic coordinates (degrees, metres) and Earth-centred, Earth-fixed metres.

use glam::{DMat3, DVec2, DVec3};

/// Semi-major axis in metres (NIMA TR8350.2, table 3.1).
pub const SEMI_MAJOR: f64 = 6_378_137.0;
/// Flattening (NIMA TR8350.2, table 3.1).
pub const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Semi-minor axis in metres.
pub const SEMI_MINOR: f64 = SEMI_MAJOR * (1.0 - FLATTENING);
/// First eccentricity, squared.
pub const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Mean of the three semi-axes in metres, the Earth as a ball; to a kilometre.
pub const MEAN_RADIUS: f64 = terrain_core::height_field::ground::EARTH_RADIUS;
/// Smallest radius of curvature in metres, that of a meridian at the equator; rounded down to a kilometre.
pub const LEAST_CURVATURE_RADIUS: f64 = 6_335_000.0;
/// Metres in a degree of the equator; to ten metres.
pub const METRES_IN_A_DEGREE: f64 = 111_320.0;
/// Metres in the shortest degree of latitude, that at the equator; rounded down, so that a reach in degrees is no shorter.
pub const LEAST_METRES_IN_A_DEGREE: f64 = 110_000.0;

/// A point by longitude and latitude in degrees and height above the ellipsoid in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Degrees east of Greenwich.
    pub longitude: f64,
    /// Degrees north of the equator.
    pub latitude: f64,
    /// Metres above the ellipsoid.
    pub height: f64,
}

/// The ellipsoid's outward unit normal at a longitude and latitude in degrees.
#[must_use]
pub fn normal(longitude: f64, latitude: f64) -> DVec3 {
    let (sin_longitude, cos_longitude) = longitude.to_radians().sin_cos();
    let (sin_latitude, cos_latitude) = latitude.to_radians().sin_cos();
    DVec3::new(cos_latitude * cos_longitude, cos_latitude * sin_longitude, sin_latitude)
}

/// Earth-centred position, in metres, of a geodetic point.
#[must_use]
pub fn to_earth_centred(point: Geodetic) -> DVec3 {
    above(normal(point.longitude, point.latitude), point.height)
}

/// Earth-centred position, in metres, of the point of the ellipsoid at a longitude and latitude in degrees.
#[must_use]
pub fn on_ellipsoid(place: DVec2) -> DVec3 {
    above(normal(place.x, place.y), 0.0)
}

/// Earth-centred position, in metres, of the point `height` metres above the place whose outward unit normal is `up`.
#[must_use]
pub fn above(up: DVec3, height: f64) -> DVec3 {
    let prime_vertical = SEMI_MAJOR / (1.0 - ECCENTRICITY_SQUARED * up.z * up.z).sqrt();
    let polar = prime_vertical * (1.0 - ECCENTRICITY_SQUARED);
    let horizontal = prime_vertical + height;
    DVec3::new(horizontal * up.x, horizontal * up.y, (polar + height) * up.z)
}

/// Geodetic coordinates of an Earth-centred position in metres, by Bowring's formula with the reduced latitude
/// iterated: exact to nanometres from the deep sea to orbit.
#[must_use]
pub fn to_geodetic(position: DVec3) -> Geodetic {
    let axis_distance = position.truncate().length();
    let second_eccentricity_squared = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED);
    let (mut sin_reduced, mut cos_reduced) = unit(position.z * SEMI_MAJOR, axis_distance * SEMI_MINOR);
    let (mut sin_latitude, mut cos_latitude) = (0.0, 1.0);
    for _ in 0..2 {
        (sin_latitude, cos_latitude) = unit(
            position.z + second_eccentricity_squared * SEMI_MINOR * sin_reduced.powi(3),
            axis_distance - ECCENTRICITY_SQUARED * SEMI_MAJOR * cos_reduced.powi(3),
        );
        (sin_reduced, cos_reduced) = unit((1.0 - FLATTENING) * sin_latitude, cos_latitude);
    }
    let ellipsoid_point_distance = SEMI_MAJOR * (1.0 - ECCENTRICITY_SQUARED * sin_latitude * sin_latitude).sqrt();
    Geodetic {
        longitude: position.y.atan2(position.x).to_degrees(),
        latitude: sin_latitude.atan2(cos_latitude).to_degrees(),
        height: axis_distance * cos_latitude + position.z * sin_latitude - ellipsoid_point_distance,
    }
}

/// Columns east, north, up at a longitude and latitude in degrees: turns local metres into Earth-centred ones.
#[must_use]
pub fn east_north_up(longitude: f64, latitude: f64) -> DMat3 {
    let up = normal(longitude, latitude);
    let (sin_longitude, cos_longitude) = longitude.to_radians().sin_cos();
    let east = DVec3::new(-sin_longitude, cos_longitude, 0.0);
    DMat3::from_cols(east, up.cross(east), up)
}

fn unit(sine: f64, cosine: f64) -> (f64, f64) {
    let length = (sine * sine + cosine * cosine).sqrt();
    (sine / length, cosine / length)
}
