//! Places around a pole without a jump: degrees from it along the meridians of 0° and 90° E.

use glam::{DMat2, DVec2};

/// Which pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pole {
    North,
    South,
}

impl Pole {
    /// The one on whose side of the equator a latitude is.
    pub(super) fn nearest(latitude: f64) -> Self {
        if latitude < 0.0 { Self::South } else { Self::North }
    }

    /// Of a longitude and a latitude.
    pub(super) fn on_plane(self, geographic: DVec2) -> DVec2 {
        let distance = match self {
            Self::North => 90.0 - geographic.y,
            Self::South => 90.0 + geographic.y,
        };
        DVec2::from_angle(geographic.x.to_radians()) * distance
    }

    /// Longitude, within half a turn of `facing`, and latitude.
    pub(super) fn geographic(self, from_pole: DVec2, facing: f64) -> DVec2 {
        let longitude = from_pole.y.atan2(from_pole.x).to_degrees();
        let turns = ((facing - longitude) / 360.0).round();
        let distance = from_pole.length();
        let latitude = match self {
            Self::North => 90.0 - distance,
            Self::South => distance - 90.0,
        };
        DVec2::new(longitude + 360.0 * turns, latitude)
    }

    /// Southernmost and northernmost latitude, the pole among them.
    pub(super) fn with(self, south: f64, north: f64) -> (f64, f64) {
        match self {
            Self::North => (south, 90.0),
            Self::South => (-90.0, north),
        }
    }
}

/// Metres of the two columns of `step`, degrees from the pole, at a place; `metres_per_degree` of longitude and of latitude there.
pub(super) fn lengths(from_pole: DVec2, step: DMat2, metres_per_degree: DVec2) -> DVec2 {
    let distance = from_pole.length();
    let away = from_pole.normalize_or(DVec2::X);
    // Along a parallel, a degree from the pole is so much of one of longitude; at the pole, the same in all directions.
    let along = metres_per_degree.x / distance.to_radians();
    let along = if along.is_finite() { along } else { metres_per_degree.y };
    let length = |step: DVec2| (step.dot(away) * metres_per_degree.y).hypot(step.perp_dot(away) * along);
    DVec2::new(length(step.x_axis), length(step.y_axis))
}
