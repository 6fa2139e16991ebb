//! From where a scene is seen: what is in sight, and how large errors look.

use glam::DVec3;

use crate::selection::oriented_box::OrientedBox;

/// The side of a plane where `normal · point + offset` is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Towards the inside; of any length.
    pub normal: DVec3,
    /// Of the origin.
    pub offset: f64,
}

/// An ellipsoid of revolution that nothing can be seen through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Its middle.
    pub centre: DVec3,
    /// Unit vector along the axis that it turns about.
    pub axis: DVec3,
    /// Semi-axis across.
    pub equatorial: f64,
    /// Semi-axis along.
    pub polar: f64,
}

/// From where, and how, a scene is looked at; all lengths in one unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub eye: DVec3,
    /// What is in all of them is in the picture.
    pub frustum: Vec<HalfSpace>,
    /// Height of the viewport / (2 · tan(field of view / 2)): pixels of what is as large as it is far.
    pub pixels_per_radian: f64,
    /// Errors that are further away look as large as from here; infinite where they may look as small as they are.
    pub farthest: f64,
    /// The ground hides what is beyond its horizon. No drawn surface may be below it.
    pub ground: Option<Ellipsoid>,
}

impl Camera {
    /// What an error at a distance is on the screen at most, pixels: infinite where the distance is 0.
    #[must_use]
    pub fn pixels(&self, error: f64, distance: f64) -> f64 {
        if error == 0.0 {
            0.0
        } else {
            error * self.pixels_per_radian / distance.min(self.farthest)
        }
    }

    /// What it sees.
    #[must_use]
    pub fn sight(&self) -> Sight<'_> {
        Sight {
            frustum: &self.frustum,
            horizon: self.ground.and_then(|ground| Horizon::new(ground, self.eye)),
        }
    }
}

/// What a camera sees.
#[derive(Clone, Debug)]
pub struct Sight<'a> {
    frustum: &'a [HalfSpace],
    horizon: Option<Horizon>,
}

impl Sight<'_> {
    /// Whether some point of a box may be seen: no half space of the frustum is without the box, and it is not all beyond the
    /// horizon.
    #[must_use]
    pub fn sees(&self, bounds: &OrientedBox) -> bool {
        let outside = |half: &HalfSpace| half.normal.dot(bounds.centre) + half.offset + bounds.reach(half.normal) < 0.0;
        !self.frustum.iter().any(outside) && !self.horizon.is_some_and(|horizon| horizon.hides(bounds))
    }
}

/// The horizon of an eye over an ellipsoid, in a space where this is the unit ball (Cozzi and Ring, 3D Engine Design for
/// Virtual Globes, 2011, section 12.3).
///
/// What the ball hides holds the part of the cone of its tangents that is beyond the plane of the horizon. That part is
/// convex: it has all of a box if it has the box's corners.
#[derive(Clone, Copy, Debug)]
struct Horizon {
    ellipsoid: Ellipsoid,
    eye: DVec3,
    /// Square of the distance from the eye to its horizon.
    squared: f64,
}

impl Horizon {
    /// Nothing where the eye is not outside the ellipsoid.
    fn new(ellipsoid: Ellipsoid, eye: DVec3) -> Option<Self> {
        let eye = to_ball(&ellipsoid, eye - ellipsoid.centre);
        let squared = eye.dot(eye) - 1.0;
        (squared > 0.0).then_some(Self {
            ellipsoid,
            eye,
            squared,
        })
    }

    /// Whether the whole box is hidden.
    fn hides(&self, bounds: &OrientedBox) -> bool {
        let ray = to_ball(&self.ellipsoid, bounds.centre - self.ellipsoid.centre) - self.eye;
        let [x, y, z] = [0, 1, 2].map(|k| to_ball(&self.ellipsoid, bounds.axes[k] * bounds.half_sizes[k]));
        let corners = [
            ray - x - y - z,
            ray + x - y - z,
            ray - x + y - z,
            ray + x + y - z,
            ray - x - y + z,
            ray + x - y + z,
            ray - x + y + z,
            ray + x + y + z,
        ];
        corners.into_iter().all(|corner| self.hides_ray(corner))
    }

    /// Of a point, seen from the eye.
    fn hides_ray(&self, ray: DVec3) -> bool {
        let inwards = -ray.dot(self.eye);
        inwards > self.squared && inwards * inwards > self.squared * ray.dot(ray)
    }
}

fn to_ball(ellipsoid: &Ellipsoid, offset: DVec3) -> DVec3 {
    let along = offset.dot(ellipsoid.axis);
    let across = offset - ellipsoid.axis * along;
    across * (1.0 / ellipsoid.equatorial) + ellipsoid.axis * (along * (1.0 / ellipsoid.polar))
}

#[cfg(test)]
#[path = "camera_tests.rs"]
mod tests;
