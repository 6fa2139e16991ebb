//! How far flat pieces are from curves and patches, and into how many pieces those are cut so that it is little.
//!
//! A cubic curve that is cut at equal steps of its parameter into N chords is within ¾ D / N² of them, D being its largest
//! second difference of control points: |f − chord| ≤ h² max|f''| / 8, and f'' is in the hull of six times those differences
//! (R. Goldman, *Pyramid Algorithms*, 2003, calls it Wang's formula). A patch over a lattice of N steps is within
//! ⅛ (M₁ + 2 M₂ + M₃) / N² of its flat triangles, where M₁, M₂ and M₃ bound its second derivatives along two sides of the
//! domain (D. Filip, R. Magedson, R. Markot, *Surface algorithms using bounds on derivatives*, CAGD 3, 1986).

use glam::DVec3;

use crate::curved::patch::{CORNERS, CubicPatch};

/// Where somebody looks from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye, in the model's units.
    pub eye: DVec3,
    /// How many pixels a length has that is seen from as far away as it is long: half the picture's height over the tangent of
    /// half its angle.
    pub focal_length: f64,
    /// How far in pixels the picture may be off.
    pub tolerance: f64,
    /// What is nearer to the eye is treated as if it were so far away; above 0, in the model's units.
    pub nearest: f64,
}

impl View {
    /// How far off something may be whose control points are these, in the model's units.
    fn allowed(&self, points: &[DVec3]) -> f64 {
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points.iter().map(|point| point.distance(centre)).fold(0.0, f64::max);
        let distance = (self.eye.distance(centre) - radius).max(self.nearest);
        self.tolerance * distance / self.focal_length
    }

    /// Into how many chords a curve is cut, a real number: a function of the curve and the view alone.
    #[must_use]
    pub fn curve_factor(&self, curve: [DVec3; 4]) -> f64 {
        factor(chord_error(curve), self.allowed(&curve))
    }

    /// The same for the inside of a patch.
    #[must_use]
    pub fn patch_factor(&self, patch: &CubicPatch) -> f64 {
        factor(triangle_error(patch), self.allowed(&patch.points))
    }
}

/// How many steps bring an error down to what is allowed that falls with the square of their number; 1 at least.
pub(crate) fn factor(error: f64, allowed: f64) -> f64 {
    (error / allowed).sqrt().max(1.0)
}

/// How far a curve is from its chord at most, point by point.
#[must_use]
pub fn chord_error([a, b, c, d]: [DVec3; 4]) -> f64 {
    0.75 * second_difference(a, b, c).max(second_difference(b, c, d))
}

/// How far a patch is from the triangle of its corners at most, point by point. Divided by N² it holds for any lattice of N
/// steps.
#[must_use]
pub fn triangle_error(patch: &CubicPatch) -> f64 {
    let turns = [*patch, patch.rotated(), patch.rotated().rotated()];
    turns.iter().map(error_along_two_sides).fold(f64::INFINITY, f64::min)
}

/// The bound from the sides that meet in A.
fn error_along_two_sides(CubicPatch { points: p }: &CubicPatch) -> f64 {
    let largest = |four: [[usize; 4]; 3]| {
        let lengths = four.map(|[a, b, c, d]| (p[a] - p[b] - p[c] + p[d]).length());
        6.0 * lengths.into_iter().fold(0.0, f64::max)
    };
    let along_ab = largest([[0, 1, 1, 3], [1, 3, 3, 6], [2, 4, 4, 7]]);
    let along_ac = largest([[0, 2, 2, 5], [1, 4, 4, 8], [2, 5, 5, 9]]);
    let mixed = largest([[0, 1, 2, 4], [1, 3, 4, 7], [2, 4, 5, 8]]);
    (along_ab + 2.0 * mixed + along_ac) / 8.0
}

/// How far the part of a patch over a triangle of the domain is at most from a flat one with the same corners, point by point:
/// the difference of both is a patch, and in the hull of its control points.
#[must_use]
pub fn part_error(patch: &CubicPatch, places: [DVec3; 3]) -> f64 {
    let part = patch.part(places);
    let [a, b, c] = CORNERS.map(|corner| part.points[corner]);
    part.deviation(&flat([a, b, c]))
}

/// A triangle as a patch.
fn flat([a, b, c]: [DVec3; 3]) -> CubicPatch {
    let third = |a: DVec3, b: DVec3| a.lerp(b, 1.0 / 3.0);
    CubicPatch {
        points: [
            a,
            third(a, b),
            third(a, c),
            third(b, a),
            (a + b + c) / 3.0,
            third(c, a),
            b,
            third(b, c),
            third(c, b),
            c,
        ],
    }
}

fn second_difference(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    (a - 2.0 * b + c).length()
}

#[cfg(test)]
#[path = "flatness_tests.rs"]
mod tests;
