//! A cubic patch for each triangle of a mesh with normals (§5.1), in two passes.
//!
//! ```text
//! first pass, for each triangle:
//!     corners are its vertices
//!     on each edge, from each end: the point at a third of the edge, projected onto the tangent plane there
//!     the centre is the average of those six
//! second pass, for each patch, from the first pass's centres alone (Jacobi):
//!     each curve with a neighbour gives a plane: through the curve, along the line between both centres
//!     three planes meet in the new centre; onto the line of two, or onto one, the centre is projected
//! ```
//! Where planes are nearly parallel, so that what they share is nowhere near the patch, the first centre stays.

use glam::{DMat3, DVec3};

use crate::curved::merging::with_average_centre;
use crate::curved::patch::{CENTRE, CubicPatch};

/// What a centre was moved to in the second pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refined {
    /// To the point that three planes share.
    Three,
    /// Onto the line of two.
    Line,
    /// Onto one.
    Plane,
    /// Nowhere: there is no neighbour.
    Unchanged,
    /// Nowhere: the planes are parallel, or too nearly so.
    Singular,
}

/// The first pass for one triangle: `corners`, and for each corner the unit normals that its edges to the next corner and to
/// the one before have there. Where there is one tangent plane, all normals of a corner are one.
#[must_use]
pub fn first_pass(corners: [DVec3; 3], tangents: [[Tangent; 2]; 3]) -> CubicPatch {
    let curves = [0, 1, 2].map(|corner| {
        let next = (corner + 1) % 3;
        [
            tangents[corner][0].control_point(corners[corner], corners[next]),
            tangents[next][1].control_point(corners[next], corners[corner]),
        ]
    });
    with_average_centre(corners, curves)
}

/// Where a curve may go from a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tangent {
    /// Anywhere in the plane of this unit normal.
    Plane(DVec3),
    /// Along this unit vector, which is in the tangent planes of both sides of a crease.
    Crease(DVec3),
}

impl Tangent {
    /// What a curve between two patches has at an end, from the unit normals that both have there.
    #[must_use]
    pub fn between(left: DVec3, right: DVec3) -> Self {
        let along = left.cross(right);
        match along.try_normalize() {
            Some(direction) if along.length() > SAME_NORMAL => Self::Crease(direction),
            _ => Self::Plane(left),
        }
    }

    /// The control point beside `from` of a curve to `to`: the edge's third, projected.
    fn control_point(self, from: DVec3, to: DVec3) -> DVec3 {
        let third = (to - from) / 3.0;
        from + match self {
            Self::Plane(normal) => third - normal * normal.dot(third),
            Self::Crease(direction) => direction * direction.dot(third),
        }
    }
}

/// Normals whose cross product is shorter are one.
pub(crate) const SAME_NORMAL: f64 = 1e-9;

/// The new centre of `patch`, from the centres of the patches across its curves AB, BC and CA.
#[must_use]
pub fn refined_centre(patch: &CubicPatch, across: [Option<DVec3>; 3]) -> (DVec3, Refined) {
    let centre = patch.points[CENTRE];
    let mut planes = [(DVec3::ZERO, 0.0); 3];
    let mut count = 0;
    for (curve, across) in across.into_iter().enumerate() {
        let Some(across) = across else { continue };
        let [_, first, second, _] = patch.curve(curve);
        let Some(normal) = (second - first).cross(across - centre).try_normalize() else {
            return (centre, Refined::Singular);
        };
        planes[count] = (normal, normal.dot(first - centre));
        count += 1;
    }
    let (step, how) = match planes {
        [one, two, three] if count == 3 => (meeting([one, two, three]), Refined::Three),
        [one, two, _] if count == 2 => (nearest_of_line(one, two), Refined::Line),
        [(normal, offset), ..] if count == 1 => (Some(normal * offset), Refined::Plane),
        _ => return (centre, Refined::Unchanged),
    };
    let is_near = |step: &DVec3| step.length_squared() <= longest_side_squared(patch);
    match step.filter(is_near) {
        Some(step) => (centre + step, how),
        None => (centre, Refined::Singular),
    }
}

/// Planes whose normals have a smaller volume, or cross product, share nothing that can be computed.
const LEAST_VOLUME: f64 = 1e-9;

/// The point that three planes of unit normals and offsets share.
fn meeting(planes: [(DVec3, f64); 3]) -> Option<DVec3> {
    let [one, two, three] = planes.map(|(normal, _)| normal);
    let rows = DMat3::from_cols(one, two, three).transpose();
    let offsets = DVec3::from_array(planes.map(|(_, offset)| offset));
    (rows.determinant().abs() > LEAST_VOLUME).then(|| rows.inverse() * offsets)
}

/// The point of the line of two planes that is nearest to the origin.
fn nearest_of_line((one, at_one): (DVec3, f64), (two, at_two): (DVec3, f64)) -> Option<DVec3> {
    let along = one.cross(two);
    let square = along.length_squared();
    let point = (at_one * two - at_two * one).cross(along) / square;
    (square.sqrt() > LEAST_VOLUME).then_some(point)
}

fn longest_side_squared(patch: &CubicPatch) -> f64 {
    let [a, b, c] = [0, 6, 9].map(|corner| patch.points[corner]);
    let sides = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    sides.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
#[path = "fit_tests.rs"]
mod tests;
