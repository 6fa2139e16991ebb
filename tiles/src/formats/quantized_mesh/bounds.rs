//! What bounds a tile in space.

use glam::DVec3;

use terrain_codec::ellipsoid::{SEMI_MAJOR, SEMI_MINOR};

/// Semi-axes' reciprocals: Earth-centred metres times this is the space in which the ellipsoid is the unit sphere.
const SCALE: DVec3 = DVec3::new(1.0 / SEMI_MAJOR, 1.0 / SEMI_MAJOR, 1.0 / SEMI_MINOR);

/// How far out the horizon occlusion point goes, in Earth radii, where no finite one would do: from no sensible place
/// is such a point behind the Earth.
const FAR: f64 = 1e6;

/// Centre and radius, a hair's breadth rounded up, of a sphere around `positions`: its centre is that of their box.
pub(in crate::formats) fn sphere(positions: &[DVec3]) -> (DVec3, f64) {
    let infinity = DVec3::splat(f64::INFINITY);
    let (low, high) = positions
        .iter()
        .fold((infinity, -infinity), |(low, high), p| (low.min(*p), high.max(*p)));
    let center = (low + high) / 2.0;
    let radius = positions
        .iter()
        .map(|position| position.distance(center))
        .fold(0.0, f64::max);
    (center, radius * (1.0 + 1e-12))
}

/// The point on the ray through `toward` from which on the ellipsoid hides a point only when it hides all of
/// `positions`, in ellipsoid-scaled space. After K. Ring, *Horizon culling* and *Computing the horizon occlusion point*,
/// Cesium blog 2013.
///
/// In scaled space a viewer whose line of sight touches the unit sphere sees the position P just above the horizon; that
/// line meets the ray at distance 1 / cos(α + β), α the angle between ray and P, β the angle from P to where the line
/// touches, cos β = 1 / |P|. A position inside the ellipsoid counts as on it. From 90° on the two never meet.
pub(in crate::formats) fn horizon_occlusion_point(toward: DVec3, positions: &[DVec3]) -> DVec3 {
    let direction = (toward * SCALE).normalize();
    let distance = positions.iter().map(|&position| {
        let scaled = position * SCALE;
        let cos_beta = 1.0 / scaled.length().max(1.0);
        let sin_beta = (1.0 - cos_beta * cos_beta).sqrt();
        let unit = scaled.normalize();
        let (cos_alpha, sin_alpha) = (unit.dot(direction), unit.cross(direction).length());
        let cosine = cos_alpha * cos_beta - sin_alpha * sin_beta;
        if cosine > 1.0 / FAR { 1.0 / cosine } else { FAR }
    });
    direction * distance.fold(1.0, f64::max)
}

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
