//! Paths of geodesics on the ellipsoid (C. Karney, *Algorithms for geodesics*, 2013), cut into stations: places and how many
//! metres along the path they are.

use geographiclib_rs::{DirectGeodesic, Geodesic, InverseGeodesic};

use super::forms::MOST_PLACES;
use crate::failure::Failure;
use crate::heights::Place;

/// A place, and metres along the path.
pub(super) type Station = (Place, f64);

/// A geodesic from corner to corner.
struct Leg {
    from: Place,
    azimuth: f64,
    length: f64,
    /// Metres along the path at which it begins.
    start: f64,
}

/// The corners themselves.
pub(super) fn corners(corners: &[Place]) -> Result<Vec<Station>, Failure> {
    let legs = legs(corners)?;
    let ends = legs.iter().map(|leg| leg.start + leg.length);
    Ok(corners.iter().copied().zip(std::iter::once(0.0).chain(ends)).collect())
}

/// So many places, evenly from the path's beginning to its end.
pub(super) fn samples(corners: &[Place], count: usize) -> Result<Vec<Station>, Failure> {
    if !(2..=MOST_PLACES).contains(&count) {
        return Err(Failure::BadRequest(format!(
            "a path is cut into 2 to {MOST_PLACES} places"
        )));
    }
    let legs = legs(corners)?;
    let last = &legs[legs.len() - 1];
    let length = last.start + last.length;
    let mut leg = 0;
    let mut stations = Vec::with_capacity(count);
    for index in 0..count {
        let distance = length * index as f64 / (count - 1) as f64;
        while leg + 1 < legs.len() && distance > legs[leg + 1].start {
            leg += 1;
        }
        stations.push((legs[leg].at(distance), distance));
    }
    Ok(stations)
}

/// Places so many metres apart at most, the same distance from each to the next.
pub(super) fn spaced(corners: &[Place], spacing: f64) -> Result<Vec<Station>, Failure> {
    let legs = legs(corners)?;
    let last = &legs[legs.len() - 1];
    let count = ((last.start + last.length) / spacing).ceil() + 1.0;
    // Also where the spacing is negative or no number.
    if !(spacing > 0.0 && count <= MOST_PLACES as f64) {
        return Err(Failure::BadRequest(format!(
            "a spacing of {spacing} m makes more than {MOST_PLACES} places"
        )));
    }
    samples(corners, (count as usize).max(2))
}

fn legs(corners: &[Place]) -> Result<Vec<Leg>, Failure> {
    if corners.len() < 2 {
        return Err(Failure::BadRequest("a path has two corners at least".to_owned()));
    }
    let ellipsoid = Geodesic::wgs84();
    let mut start = 0.0;
    let leg = |pair: &[Place]| {
        let (from, to) = (pair[0], pair[1]);
        let (length, azimuth, _, _): (f64, f64, f64, f64) =
            ellipsoid.inverse(from.latitude, from.longitude, to.latitude, to.longitude);
        let leg = Leg {
            from,
            azimuth,
            length,
            start,
        };
        start += length;
        leg
    };
    Ok(corners.windows(2).map(leg).collect())
}

impl Leg {
    fn at(&self, distance: f64) -> Place {
        let (latitude, longitude): (f64, f64) = Geodesic::wgs84().direct(
            self.from.latitude,
            self.from.longitude,
            self.azimuth,
            distance - self.start,
        );
        Place { longitude, latitude }
    }
}
