//! Where a mesh lies on the ground, and distances seen from above: on a plane, or on the Earth.
//!
//! Seen from above, the edge between two vertices that is straight in space runs along a great circle. From a point of the
//! sphere all great circles look straight (the gnomonic projection), and what is seen is not shorter than it is.

use std::fmt;

use glam::{DVec2, DVec3};

/// Mean radius of the Earth, metres: what curvatures are of.
pub const EARTH_RADIUS: f64 = 6_371_000.0;
/// Flattening of the Earth, rounded up: how far its verticals are from pointing at its centre.
const FLATTENING: f64 = 0.0034;
/// More than the ground rises anywhere, metres.
const HIGHEST: f64 = 10_000.0;
/// How much longer a distance may be on the ellipsoid than on the sphere that touches it.
const BESIDE_A_SPHERE: f64 = 1.0001;
/// Cosine of the angle from which on the ends of an edge are taken for all that is seen of it.
const HORIZON: f64 = 0.1;

/// Where plan positions are on the ground.
#[derive(Clone, Copy)]
pub enum Ground<'a> {
    /// On a plane: metres in a plan unit along each axis.
    Plane(DVec2),
    /// Metres from the Earth's centre, on the ellipsoid.
    Earth(&'a (dyn Fn(DVec2) -> DVec3 + Sync)),
}

impl fmt::Debug for Ground<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plane(unit) => f.debug_tuple("Plane").field(unit).finish(),
            Self::Earth(_) => f.write_str("Earth"),
        }
    }
}

impl Ground<'_> {
    /// Where a plan position is, metres.
    pub(crate) fn place(&self, plan: DVec2) -> DVec3 {
        match self {
            Self::Plane(unit) => (plan * *unit).extend(0.0),
            Self::Earth(place) => place(plan),
        }
    }

    /// An upper bound of the metres, seen from above, between a place and an edge that is straight in space between two
    /// others.
    pub(crate) fn distance(&self, place: DVec3, [from, to]: [DVec3; 2]) -> f64 {
        match self {
            Self::Plane(_) => distance_to_segment(place, from, to),
            Self::Earth(_) => distance_on_earth(place, [from, to]),
        }
    }
}

/// The same on the Earth, of places in metres from its centre. Exact but for some ten thousandths, and for what its
/// flattening does to an edge.
#[must_use]
pub fn distance_on_earth(place: DVec3, [from, to]: [DVec3; 2]) -> f64 {
    let up = place.normalize();
    let is_in_sight = |end: DVec3| end.dot(up) > HORIZON * place.length();
    if !is_in_sight(from) || !is_in_sight(to) {
        return place.distance(from).min(place.distance(to));
    }
    let seen = |end: DVec3| end * (place.length() / end.dot(up));
    let length = from.distance(to);
    let beside_the_plane = FLATTENING * length * (length / 4.0 + HIGHEST) / EARTH_RADIUS;
    BESIDE_A_SPHERE * distance_to_segment(place, seen(from), seen(to)) + beside_the_plane
}

fn distance_to_segment(point: DVec3, from: DVec3, to: DVec3) -> f64 {
    let (along, before) = (to - from, point - from);
    let share = before.dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    (from + along * share.clamp(0.0, 1.0)).distance(point)
}

#[cfg(test)]
#[path = "ground_tests.rs"]
mod tests;
