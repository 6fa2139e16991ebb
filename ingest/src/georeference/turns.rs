//! Longitudes by whole turns.

use glam::DVec2;

/// A place with its longitude turned by whole turns to within half a turn of one.
pub(crate) fn nearest_turn(place: DVec2, longitude: f64) -> DVec2 {
    DVec2::new(place.x - ((place.x - longitude) / 360.0).round() * 360.0, place.y)
}
