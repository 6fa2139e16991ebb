//! Ground beside the data: where what is outside goes on from their edge, so do pixels, without a step.
//!
//! ```text
//! height = outside here + share × (ground at the edge − outside at the edge)
//! ```

use crate::ground::Place;
use crate::metadata::Metadata;

/// The ground that a place takes its height from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearest {
    /// The place itself where it is within the bounds of the data, else the nearest that is, by a pixel inside of their outline.
    pub place: Place,
    /// How much the ground counts there: 1 within the bounds, 0 farther from them than the outside's grid is fine.
    pub share: f64,
}

/// `pixel` is the width of one, degrees.
pub(super) fn nearest(metadata: &Metadata, place: Place, pixel: f64) -> Nearest {
    if metadata.covers(place.longitude, place.latitude) {
        return Nearest { place, share: 1.0 };
    }
    let [west, south, east, north] = metadata.bounds;
    let turns = (f64::midpoint(west, east) - place.longitude) / 360.0;
    let longitude = place.longitude + turns.round() * 360.0;
    let beyond = |at: f64, low: f64, high: f64| (low - at).max(at - high).max(0.0);
    let away = beyond(longitude, west, east).hypot(beyond(place.latitude, south, north));
    let reach = metadata.outside.detail().filter(|_| metadata.outside.meets_data());
    let within = |at: f64, low: f64, high: f64| at.max(low + pixel).min(high - pixel).clamp(low, high);
    Nearest {
        place: Place::turned(within(longitude, west, east), within(place.latitude, south, north)),
        share: reach.map_or(0.0, |reach| (1.0 - away / reach).max(0.0)),
    }
}

#[cfg(test)]
#[path = "beside_tests.rs"]
mod tests;
