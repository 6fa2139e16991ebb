//! Patches become one: the inverse of de Casteljau's algorithm for each pattern of §6.1, and the swap of a diagonal (§6.2).
//!
//! ```text
//!        C                C                 C                  C               F0
//!       ╱│╲              ╱│╲               ╱ ╲                ╱ ╲              ╱│╲
//!      ╱ │ ╲            ╱ │ ╲             ╱   R              Y───X            ╱ │ ╲
//!     ╱ _S_ ╲          ╱  │  ╲           ╱  ╱╱ ╲            ╱ ╲ ╱ ╲         E0──┼──E1
//!    ╱╱     ╲╲        ╱   │   ╲         ╱╱  ╱   ╲          ╱   Z   ╲          ╲ │ ╱
//!   A─────────B      A────S────B       A───S─────B        A────┴────B          ╲│╱
//!      star               T                2T               T-in-T             F1
//! ```
//! Each function tells the merged patch and how far it is from the given ones (§10): the largest distance of a control
//! point of its parts, made by subdividing it at the same place, from that of the given patch. That bounds the distance
//! between points with the same coordinates, so it bounds the distance between the surfaces both ways.
//!
//! Exact parts of one patch are merged exactly. Where they are not parts of one, the curves keep what the two ends say,
//! and a centre is the one that its parts' centres deviate from least, in the sense of least squares.

use glam::DVec3;

use crate::curved::patch::{CENTRE, CubicPatch};

/// A merged patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merged {
    /// The patch.
    pub patch: CubicPatch,
    /// A bound of its distance from each patch that it was merged from, in their order; the first ones are used.
    pub deviations: [f64; 4],
}

impl Merged {
    /// The largest of the deviations.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviations.into_iter().fold(0.0, f64::max)
    }

    fn new<const N: usize>(patch: CubicPatch, parts: [CubicPatch; N], given: [&CubicPatch; N]) -> Self {
        let mut deviations = [0.0; 4];
        for (deviation, (part, given)) in deviations.iter_mut().zip(parts.iter().zip(given)) {
            *deviation = part.deviation(given);
        }
        Self { patch, deviations }
    }
}

/// Two patches after their diagonal was swapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swapped {
    /// Patches (F0, E0, F1) and (F1, E1, F0).
    pub patches: [CubicPatch; 2],
    /// Bounds of the distance of each new patch (first index) from each given one (second index), where they overlap.
    pub deviations: [[f64; 2]; 2],
    /// Where the diagonals cross, from E0 to E1.
    pub along_old: f64,
    /// The same from F0 to F1.
    pub along_new: f64,
}

/// Where a curve was cut, from its two halves: the ratio of lengths on both sides of the cut. None where there is none.
#[must_use]
pub fn cut_parameter(left: [DVec3; 4], right: [DVec3; 4]) -> Option<f64> {
    let (before, after) = (left[2].distance(left[3]), right[0].distance(right[1]));
    let t = before / (before + after);
    is_inside(t).then_some(t)
}

/// Divisions by less than this make more of an error than there was.
fn is_inside(t: f64) -> bool {
    t > 1e-6 && t < 1.0 - 1e-6
}

/// The two inner control points of the curve that was cut at `t`: one from each half, since the halves need not agree.
fn uncut(left: [DVec3; 4], right: [DVec3; 4], t: f64) -> [DVec3; 2] {
    [
        left[0] + (left[1] - left[0]) / t,
        right[3] + (right[2] - right[3]) / (1.0 - t),
    ]
}

/// Patches (A, S, C) and (S, B, C) as (A, B, C). None where the curve through S has no direction there.
#[must_use]
pub fn merge_two(first: &CubicPatch, second: &CubicPatch) -> Option<Merged> {
    let t = cut_parameter(first.curve(0), second.curve(0))?;
    let (l, r) = (&first.points, &second.points);
    let [inner_a, inner_b] = uncut(first.curve(0), second.curve(0), t);
    let rest = 1.0 - t;
    let centre = (t * (l[4] - rest * l[2]) + rest * (r[4] - t * r[7])) / (t * t + rest * rest);
    let points = [l[0], inner_a, l[2], inner_b, centre, l[5], r[6], r[7], r[8], l[9]];
    let patch = CubicPatch { points };
    Some(Merged::new(patch, patch.split_first_curve(t), [first, second]))
}

/// Patches (S, B, C), (A, S, C) and (A, B, S) as (A, B, C). None where S is outside the triangle of its neighbours.
#[must_use]
pub fn merge_star(star: [&CubicPatch; 3]) -> Option<Merged> {
    let at = star_parameters(star)?;
    let [a, b, c] = star.map(|patch| &patch.points);
    let mut points = [c[0], c[1], b[2], c[3], DVec3::ZERO, b[5], c[6], a[7], a[8], a[9]];
    let [u, v, w] = at.to_array();
    // What each part's centre says of the whole's, weighted by how much of it is in there.
    let by_a = u * (a[CENTRE] - v * points[7] - w * points[8]);
    let by_b = v * (b[CENTRE] - u * points[2] - w * points[5]);
    let by_c = w * (c[CENTRE] - u * points[1] - v * points[3]);
    points[CENTRE] = (by_a + by_b + by_c) / at.length_squared();
    let patch = CubicPatch { points };
    Some(Merged::new(patch, patch.star(at), star))
}

/// Barycentric coordinates of S in the triangle of its neighbours among the control points, onto whose plane it is
/// projected.
#[must_use]
pub fn star_parameters([a, b, _]: [&CubicPatch; 3]) -> Option<DVec3> {
    let [origin, to_b, to_c] = [b.points[3], a.points[1], a.points[2]];
    let (e, f, s) = (to_b - origin, to_c - origin, a.points[0] - origin);
    let normal = e.cross(f);
    let v = s.cross(f).dot(normal) / normal.length_squared();
    let w = e.cross(s).dot(normal) / normal.length_squared();
    let at = DVec3::new(1.0 - v - w, v, w);
    at.to_array().into_iter().all(is_inside).then_some(at)
}

/// Patches (A, S, R), (S, B, R) and (A, R, C) as (A, B, C): two T patterns one after the other.
#[must_use]
pub fn merge_two_t([first, second, third]: [&CubicPatch; 3]) -> Option<Merged> {
    let lower = merge_two(first, second)?;
    // (B, C, A) has R on its first curve: (B, R, A) and (R, C, A).
    let upper = merge_two(&lower.patch.rotated(), &third.rotated())?;
    let [below, above] = [upper.deviations[0], upper.deviations[1]];
    Some(Merged {
        patch: upper.patch.rotated().rotated(),
        deviations: [lower.deviations[0] + below, lower.deviations[1] + below, above, 0.0],
    })
}

/// Patches (A, Z, Y), (Z, B, X), (Y, X, C) and (X, Y, Z) as (A, B, C), with the average of the curves' inner control
/// points as its centre (§5.1, first pass).
#[must_use]
pub fn merge_triangle_in_triangle(faces: [&CubicPatch; 4]) -> Option<Merged> {
    let [a, b, c, _] = faces;
    let halves = [
        [a.curve(0), b.curve(0)],
        [b.curve(1), c.curve(1)],
        [c.curve(2), a.curve(2)],
    ];
    let mut inner = [[DVec3::ZERO; 2]; 3];
    let mut ts = [0.0; 3];
    for (index, [left, right]) in halves.into_iter().enumerate() {
        ts[index] = cut_parameter(left, right)?;
        inner[index] = uncut(left, right, ts[index]);
    }
    let patch = with_average_centre([a.points[0], b.points[6], c.points[9]], inner);
    Some(Merged::new(patch, triangle_in_triangle(&patch, ts), faces))
}

/// The four parts that [`merge_triangle_in_triangle`] is the inverse of, for Z, X and Y at `ts` on the curves from A to B,
/// from B to C and from C to A.
#[must_use]
pub fn triangle_in_triangle(patch: &CubicPatch, ts: [f64; 3]) -> [CubicPatch; 4] {
    let [a, b, c] = [DVec3::X, DVec3::Y, DVec3::Z];
    let [z, x, y] = [a.lerp(b, ts[0]), b.lerp(c, ts[1]), c.lerp(a, ts[2])];
    [[a, z, y], [z, b, x], [y, x, c], [x, y, z]].map(|places| patch.part(places))
}

/// A patch from its corners and the inner control points of its curves AB, BC and CA.
#[must_use]
pub fn with_average_centre(corners: [DVec3; 3], [ab, bc, ca]: [[DVec3; 2]; 3]) -> CubicPatch {
    let centre = (ab[0] + ab[1] + bc[0] + bc[1] + ca[0] + ca[1]) / 6.0;
    CubicPatch::from_curves(corners, [ab, bc, ca], centre)
}

/// Patches (E0, E1, F0) and (E1, E0, F1) as (F0, E0, F1) and (F1, E1, F0): both are cut where the straight diagonals
/// cross, seen along the normal of both, and merged the other way. None where they do not cross.
#[must_use]
pub fn swap_diagonal([left, right]: [&CubicPatch; 2]) -> Option<Swapped> {
    let [e0, e1, f0, f1] = [left.points[0], left.points[6], left.points[9], right.points[9]];
    let (along_old, along_new) = crossing([e0, e1], [f0, f1])?;
    let [left_0, left_1] = left.split_first_curve(along_old);
    let [right_1, right_0] = right.split_first_curve(1.0 - along_old);
    // (F1, S, E0) and (S, F0, E0) are (F1, F0, E0); (F0, S, E1) and (S, F1, E1) are (F0, F1, E1).
    let first = merge_two(&right_0.rotated().rotated(), &left_0.rotated())?;
    let second = merge_two(&left_1.rotated().rotated(), &right_1.rotated())?;
    Some(Swapped {
        patches: [first.patch.rotated(), second.patch.rotated()],
        deviations: [
            [first.deviations[1], first.deviations[0]],
            [second.deviations[0], second.deviations[1]],
        ],
        along_old,
        along_new,
    })
}

/// Where two straight lines come closest, as parameters between their ends; none where that is not inside both.
pub(crate) fn crossing([e0, e1]: [DVec3; 2], [f0, f1]: [DVec3; 2]) -> Option<(f64, f64)> {
    let (e, f, between) = (e1 - e0, f1 - f0, f0 - e0);
    let normal = e.cross(f);
    let t = between.cross(f).dot(normal) / normal.length_squared();
    let s = between.cross(e).dot(normal) / normal.length_squared();
    (is_inside(t) && is_inside(s)).then_some((t, s))
}

#[cfg(test)]
#[path = "merging_tests.rs"]
mod tests;
