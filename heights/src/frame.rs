//! Local frames: metres east, north and up of a place, flat in space, so that the Earth curves away below.

use glam::{DMat3, DVec2, DVec3};
use terrain_codec::ellipsoid::{Geodetic, east_north_up, to_earth_centred};
use terrain_tiles::ground::line::Line;

/// A local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Earth-centred metres of its origin.
    pub origin: DVec3,
    /// Unit vectors east, north and up, Earth-centred, in columns.
    pub axes: DMat3,
}

impl Frame {
    /// That of a place in degrees, at a height above the ellipsoid in metres; none where there is no such place.
    #[must_use]
    pub fn at(longitude: f64, latitude: f64, height: f64) -> Option<Self> {
        let is_place = longitude.is_finite() && (-90.0..=90.0).contains(&latitude) && height.is_finite();
        is_place.then(|| Self {
            origin: to_earth_centred(Geodetic {
                longitude,
                latitude,
                height,
            }),
            axes: east_north_up(longitude, latitude),
        })
    }

    /// The line along the frame's up through a point of the plane through its origin; none where that does not come down to the
    /// ellipsoid, or too slantwise.
    pub(crate) fn upright(&self, plan: DVec2) -> Option<Line> {
        Line::through(self.origin + self.axes * plan.extend(0.0), self.axes.z_axis)
    }
}
