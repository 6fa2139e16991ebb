//! Boxes that are turned in any way: how near they are, and how large they look.

use glam::DVec3;

/// All points whose offset from `centre` along each of three axes is at most its half size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// Middle of the box.
    pub centre: DVec3,
    /// Three unit vectors at right angles.
    pub axes: [DVec3; 3],
    /// Half of the size along each axis, in the units of the centre.
    pub half_sizes: [f64; 3],
}

impl OrientedBox {
    /// The smallest box with these axes that holds `points`; nothing of no points.
    #[must_use]
    pub fn around(axes: [DVec3; 3], points: impl Iterator<Item = DVec3> + Clone) -> Option<Self> {
        points.clone().next()?;
        let (mut centre, mut half_sizes) = (DVec3::ZERO, [0.0; 3]);
        for (axis, half_size) in axes.into_iter().zip(&mut half_sizes) {
            let along = points.clone().map(|point| point.dot(axis));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (at.min(low), at.max(high))
            });
            centre += axis * ((low + high) / 2.0);
            *half_size = (high - low) / 2.0;
        }
        Some(Self {
            centre,
            axes,
            half_sizes,
        })
    }

    /// The smallest box with the same axes that holds this one and another.
    #[must_use]
    pub fn holding(&self, other: &Self) -> Self {
        let mut held = *self;
        for (axis, half_size) in self.axes.into_iter().zip(&mut held.half_sizes) {
            let (middle, reach) = ((other.centre - self.centre).dot(axis), other.reach(axis));
            let (low, high) = ((middle - reach).min(-*half_size), (middle + reach).max(*half_size));
            held.centre += axis * ((low + high) / 2.0);
            *half_size = (high - low) / 2.0;
        }
        held
    }

    /// Distance of a point from the nearest point of the box; 0 inside.
    #[must_use]
    pub fn distance(&self, point: DVec3) -> f64 {
        let offset = point - self.centre;
        let beyond = |k: usize| (offset.dot(self.axes[k]).abs() - self.half_sizes[k]).max(0.0);
        let [x, y, z] = [0, 1, 2].map(beyond);
        (x * x + y * y + z * z).sqrt()
    }

    /// How far the box reaches from its centre along a direction.
    #[must_use]
    pub fn reach(&self, direction: DVec3) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k| direction.dot(self.axes[k]).abs() * self.half_sizes[k]);
        x + y + z
    }

    /// Solid angle of the box for an eye outside it, steradians, as if all of it were as far as its centre: what parallel
    /// rays see of it, by the square of the distance.
    #[must_use]
    pub fn solid_angle(&self, eye: DVec3) -> f64 {
        let ray = self.centre - eye;
        let [x, y, z] = self.half_sizes;
        let faces = [y * z, z * x, x * y];
        let [x, y, z] = [0, 1, 2].map(|k| 4.0 * faces[k] * ray.dot(self.axes[k]).abs());
        let squared = ray.dot(ray);
        (x + y + z) / (squared * squared.sqrt())
    }
}

#[cfg(test)]
#[path = "oriented_box_tests.rs"]
mod tests;
