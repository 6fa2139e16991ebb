//! The cubic triangular Bézier patch: points, normals and exact parts of it.
//!
//! ```text
//!                  C = 003                         9
//!                                                 
//!               102       012                   5     8
//!                                     as
//!           201      111      021     indices  2    4    7
//!                                              
//!  A = 300     210       120    030 = B      0    1    3    6
//! ```
//! The domain is a triangle with barycentric coordinates (u, v, w); u is 1 at A. Everything is computed by the patch's
//! blossom, which is what de Casteljau's algorithm leaves out nothing of (G. Farin, *Curves and Surfaces for Computer Aided
//! Geometric Design*, 1993).

use glam::DVec3;

/// A cubic triangular Bézier patch: ten control points in the order 300 210 201 120 111 102 030 021 012 003, in the
/// model's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicPatch {
    /// The control points; the corners A, B and C are those of [`CORNERS`].
    pub points: [DVec3; 10],
}

/// Where the corners A, B and C stand among the control points.
pub const CORNERS: [usize; 3] = [0, 6, 9];

/// Where the four control points of the boundary curves from A to B, from B to C and from C to A stand.
pub const CURVES: [[usize; 4]; 3] = [[0, 1, 3, 6], [6, 7, 8, 9], [9, 5, 2, 0]];

/// The control point that no boundary curve uses.
pub const CENTRE: usize = 4;

/// Where each control point stands in the same patch with B, C, A as its corners.
const ROTATED: [usize; 10] = [6, 7, 3, 8, 4, 1, 9, 5, 2, 0];

impl CubicPatch {
    /// A patch from its corners, the inner control points of its curves AB, BC and CA, and its centre.
    #[must_use]
    pub fn from_curves([a, b, c]: [DVec3; 3], [ab, bc, ca]: [[DVec3; 2]; 3], centre: DVec3) -> Self {
        Self {
            points: [a, ab[0], ca[1], ab[1], centre, ca[0], b, bc[0], bc[1], c],
        }
    }

    /// The point at barycentric coordinates (u, v, w), which sum up to 1.
    #[must_use]
    pub fn point(&self, at: DVec3) -> DVec3 {
        let [a, b, c] = self.corner_triangle(at);
        blend([a, b, c], at)
    }

    /// The normal at (u, v, w), of no particular length; zero where the patch has no tangent plane.
    #[must_use]
    pub fn normal(&self, at: DVec3) -> DVec3 {
        let [a, b, c] = self.corner_triangle(at);
        (b - a).cross(c - a)
    }

    /// De Casteljau's last triangle but one, which touches the patch at (u, v, w).
    pub(crate) fn corner_triangle(&self, at: DVec3) -> [DVec3; 3] {
        once(&twice(&self.points, at), at)
    }

    /// The blossom: the centre of the part over the triangle of three places.
    pub(crate) fn blossom(&self, [x, y, z]: [DVec3; 3]) -> DVec3 {
        blend(once(&twice(&self.points, x), y), z)
    }

    /// The same patch with corners B, C, A.
    #[must_use]
    pub fn rotated(&self) -> Self {
        Self {
            points: ROTATED.map(|index| self.points[index]),
        }
    }

    /// The part over the triangle of three places, each in barycentric coordinates: exact, whatever the triangle.
    #[must_use]
    pub fn part(&self, [x, y, z]: [DVec3; 3]) -> Self {
        let (from_x, from_y) = (twice(&self.points, x), twice(&self.points, y));
        let (xx, xy, xz) = (once(&from_x, x), once(&from_x, y), once(&from_x, z));
        let (yy, yz) = (once(&from_y, y), once(&from_y, z));
        let zz = once(&twice(&self.points, z), z);
        let points = [
            blend(xx, x),
            blend(xx, y),
            blend(xx, z),
            blend(xy, y),
            blend(xy, z),
            blend(xz, z),
            blend(yy, y),
            blend(yy, z),
            blend(yz, z),
            blend(zz, z),
        ];
        Self { points }
    }

    /// Parts (S, B, C), (A, S, C) and (A, B, S) for S at (u, v, w) (§4.2).
    #[must_use]
    pub fn star(&self, at: DVec3) -> [Self; 3] {
        let [a, b, c] = [DVec3::X, DVec3::Y, DVec3::Z];
        [[at, b, c], [a, at, c], [a, b, at]].map(|places| self.part(places))
    }

    /// Parts (A, S, C) and (S, B, C) for S on the curve from A to B, at parameter `t` (§4.2).
    #[must_use]
    pub fn split_first_curve(&self, t: f64) -> [Self; 2] {
        let p = &self.points;
        let (left, right) = split_cubic([p[0], p[1], p[3], p[6]], t);
        let [start, end] = [p[2].lerp(p[4], t), p[4].lerp(p[7], t)];
        let middle = start.lerp(end, t);
        let upper = p[5].lerp(p[8], t);
        let first = [
            left[0], left[1], p[2], left[2], start, p[5], left[3], middle, upper, p[9],
        ];
        let second = [
            right[0], right[1], middle, right[2], end, upper, right[3], p[7], p[8], p[9],
        ];
        [Self { points: first }, Self { points: second }]
    }

    /// Four control points of a boundary curve, as [`CURVES`] counts them.
    #[must_use]
    pub fn curve(&self, index: usize) -> [DVec3; 4] {
        CURVES[index].map(|point| self.points[point])
    }

    /// The flat triangle between the corners, as a patch.
    #[must_use]
    pub fn flat(&self) -> Self {
        Self::flat_between(CORNERS.map(|corner| self.points[corner]))
    }

    /// A flat triangle as a patch.
    #[must_use]
    pub fn flat_between([a, b, c]: [DVec3; 3]) -> Self {
        let third = |near: DVec3, far: DVec3| (2.0 * near + far) / 3.0;
        let curves = [[a, b], [b, c], [c, a]].map(|[from, to]| [third(from, to), third(to, from)]);
        Self::from_curves([a, b, c], curves, (a + b + c) / 3.0)
    }

    /// The largest distance between control points of the same number. No two points of the patches with the same
    /// coordinates are farther apart: their difference is a patch, too, and in the convex hull of its control points.
    #[must_use]
    pub fn deviation(&self, other: &Self) -> f64 {
        let squares = self
            .points
            .iter()
            .zip(&other.points)
            .map(|(a, b)| a.distance_squared(*b));
        squares.fold(0.0, f64::max).sqrt()
    }
}

/// Both halves of a cubic Bézier curve at parameter `t`.
#[must_use]
pub fn split_cubic(p: [DVec3; 4], t: f64) -> ([DVec3; 4], [DVec3; 4]) {
    let [a, b, c] = [p[0].lerp(p[1], t), p[1].lerp(p[2], t), p[2].lerp(p[3], t)];
    let [d, e] = [a.lerp(b, t), b.lerp(c, t)];
    let middle = d.lerp(e, t);
    ([p[0], a, d, middle], [middle, e, c, p[3]])
}

/// The control points of the quadratic patch that is left when one argument of the blossom is given.
#[inline(always)]
fn twice(p: &[DVec3; 10], at: DVec3) -> [DVec3; 6] {
    [
        blend([p[0], p[1], p[2]], at),
        blend([p[1], p[3], p[4]], at),
        blend([p[2], p[4], p[5]], at),
        blend([p[3], p[6], p[7]], at),
        blend([p[4], p[7], p[8]], at),
        blend([p[5], p[8], p[9]], at),
    ]
}

/// The same from two arguments to go to one.
#[inline(always)]
fn once(p: &[DVec3; 6], at: DVec3) -> [DVec3; 3] {
    [
        blend([p[0], p[1], p[2]], at),
        blend([p[1], p[3], p[4]], at),
        blend([p[2], p[4], p[5]], at),
    ]
}

#[inline(always)]
fn blend([a, b, c]: [DVec3; 3], at: DVec3) -> DVec3 {
    at.x * a + at.y * b + at.z * c
}

#[cfg(test)]
#[path = "patch_tests.rs"]
pub(crate) mod tests;
