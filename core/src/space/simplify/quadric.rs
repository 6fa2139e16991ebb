//! Sums of squared distances from planes (M. Garland, P. Heckbert, *Surface Simplification Using Quadric Error Metrics*,
//! 1997).

use std::ops::Add;

use glam::{DMat3, DVec3};

/// How strongly, against the planes, a place is drawn to where it was expected: it decides where the planes leave a line or
/// a plane of places open.
const PULL: f64 = 1e-3;

/// `x ↦ xᵀ A x + 2 b·x + c`, the weighted sum of the squared distances of `x` from planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    /// No planes.
    pub(crate) const ZERO: Self = Self {
        a: DMat3::ZERO,
        b: DVec3::ZERO,
        c: 0.0,
        weight: 0.0,
    };

    /// The plane through `point` with the unit vector `normal`.
    pub(crate) fn plane(point: DVec3, normal: DVec3, weight: f64) -> Self {
        let offset = -normal.dot(point);
        let [x, y, z] = normal.to_array();
        Self {
            a: DMat3::from_cols(normal * x, normal * y, normal * z) * weight,
            b: normal * (offset * weight),
            c: offset * offset * weight,
            weight,
        }
    }

    /// The weighted sum at `point`.
    pub(crate) fn at(&self, point: DVec3) -> f64 {
        point.dot(self.a * point) + 2.0 * self.b.dot(point) + self.c
    }

    /// The root of the weighted mean at `point`: a distance that the largest one is hardly ever below.
    pub(crate) fn mean_distance(&self, point: DVec3) -> f64 {
        (self.at(point).max(0.0) / self.weight.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Where the sum is least; next to `expected` where that leaves a choice.
    pub(crate) fn best_place(&self, expected: DVec3) -> DVec3 {
        let trace = self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z;
        let pulled = self.a + DMat3::from_diagonal(DVec3::splat(PULL * trace));
        let slope = self.a * expected + self.b;
        let place = expected - pulled.inverse() * slope;
        if place.is_finite() { place } else { expected }
    }
}

impl Add for Quadric {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            a: self.a + other.a,
            b: self.b + other.b,
            c: self.c + other.c,
            weight: self.weight + other.weight,
        }
    }
}

#[cfg(test)]
#[path = "quadric_tests.rs"]
mod tests;
