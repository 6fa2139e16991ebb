//! Cubic triangles that are near to a bicubic patch, and how near.
//!
//! ```text
//!  P03 ───── P33          P03 = P33
//!   │ second ╱│             ╱ ╲           a side that is one point is a corner of one triangle;
//!   │      ╱  │            ╱   ╲          otherwise the patch is cut along its diagonal into two
//!   │    ╱    │           ╱     ╲
//!   │  ╱ first│          ╱       ╲
//!  P00 ───── P30        P00 ───── P30
//! ```
//! The sides are kept. The diagonal, a curve of degree six, becomes the cubic with its ends and tangents, so that both triangles
//! have the tangent planes of the patch at their corners: halving the patch divides its error by 16, that of the paper's diagonal
//! (§5.2) by 4. The centre is the one with which a triangle is nearest to the patch, in the sense of least squares.
//!
//! A bicubic patch over a triangle of its domain is a triangular patch of degree six. The triangle is elevated to that degree, too;
//! the largest distance between control points bounds the distance at equal coordinates, by the convex hull of differences. Over a
//! corner, the triangle is compared as the bicubic patch that it is there.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use crate::curved::patch::{CENTRE, CubicPatch};
use crate::curved::tensor::Bicubic;

/// A triangle in the place of a patch or a part of it, and how far both are apart at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearTriangle {
    /// The triangle.
    pub patch: CubicPatch,
    /// The largest distance between points with the same coordinates.
    pub deviation: f64,
}

/// Triangles in the place of a bicubic patch, turned as it is: (P00, P30, P33) and (P00, P33, P03), or the only one where a side
/// is one point. A patch with two sides of one point each has two triangles, though they may be folded.
#[must_use]
pub fn near_triangles(tensor: &Bicubic) -> SmallVec<[NearTriangle; 2]> {
    let turned = quarter_turns(tensor);
    let mut with_point = turned.iter().filter(|turned| begins_in_a_point(turned));
    match (with_point.next(), with_point.next()) {
        (Some(corner), None) => smallvec![over_corner(corner)],
        _ => halves(tensor),
    }
}

/// Whether two opposite sides are one point each, so that halving the patch leaves each half one.
pub(crate) fn has_opposite_points(tensor: &Bicubic) -> bool {
    let [a, b, c, d] = quarter_turns(tensor).map(|turned| begins_in_a_point(&turned));
    a && c || b && d
}

/// The patch with each of its corners as P00, and what came next.
fn quarter_turns(tensor: &Bicubic) -> [Bicubic; 4] {
    let mut turned = *tensor;
    [0, 1, 2, 3].map(|_| {
        let given = turned;
        turned = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| given[j][3 - i]));
        given
    })
}

fn begins_in_a_point(tensor: &Bicubic) -> bool {
    tensor[0].iter().all(|point| *point == tensor[0][0])
}

/// The triangle (P00, P30, P33) of a patch where P00 is P03.
fn over_corner(p: &Bicubic) -> NearTriangle {
    let centre = (3.0 * (p[2][1] + p[2][2]) - p[2][0] - p[2][3]) / 4.0;
    let patch = CubicPatch::from_curves(
        [p[0][0], p[3][0], p[3][3]],
        [[p[1][0], p[2][0]], [p[3][1], p[3][2]], [p[2][3], p[1][3]]],
        centre,
    );
    // As a tensor product, the rows of a triangle are Bézier curves of degrees 0 to 3.
    let own = [
        [p[1][1], (2.0 * p[1][0] + p[1][3]) / 3.0],
        [p[1][2], (p[1][0] + 2.0 * p[1][3]) / 3.0],
        [p[2][1], (p[2][0] + 2.0 * centre) / 3.0],
        [p[2][2], (2.0 * centre + p[2][3]) / 3.0],
    ];
    let deviation = own
        .map(|[given, own]| given.distance(own))
        .into_iter()
        .fold(0.0, f64::max);
    NearTriangle { patch, deviation }
}

/// The triangles on both sides of the diagonal.
fn halves(p: &Bicubic) -> SmallVec<[NearTriangle; 2]> {
    let start = p[1][0] + p[0][1] - p[0][0];
    let end = p[2][3] + p[3][2] - p[3][3];
    let first = [[p[1][0], p[2][0]], [p[3][1], p[3][2]], [end, start]];
    let second = [[start, end], [p[2][3], p[1][3]], [p[0][2], p[0][1]]];
    let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]];
    smallvec![nearest(p, [a, b, c], first), nearest(p, [a, c, d], second)]
}

/// The triangle over three corners (u, v) of the domain that has the given curves.
fn nearest(tensor: &Bicubic, corners: [[usize; 2]; 3], curves: [[DVec3; 2]; 3]) -> NearTriangle {
    let ends = corners.map(|[u, v]| tensor[3 * u][3 * v]);
    let mut patch = CubicPatch::from_curves(ends, curves, DVec3::ZERO);
    let left = SEXTIC.map(|exponents| sextic(tensor, corners, exponents) - elevated(&patch, exponents));
    let shares = SEXTIC.map(|[i, j, k]| (i * j * k) as f64 / choose(6, 3));
    let both = || left.iter().zip(shares);
    let weight: f64 = shares.iter().map(|share| share * share).sum();
    let centre = both().map(|(left, share)| share * *left).sum::<DVec3>() / weight;
    patch.points[CENTRE] = centre;
    let deviations = both().map(|(left, share)| (*left - share * centre).length());
    NearTriangle {
        patch,
        deviation: deviations.fold(0.0, f64::max),
    }
}

/// Exponents of the control points of a patch of degree six.
const SEXTIC: [[usize; 3]; 28] = {
    let mut all = [[0; 3]; 28];
    let (mut count, mut i) = (0, 0);
    while i <= 6 {
        let mut j = 0;
        while i + j <= 6 {
            all[count] = [i, j, 6 - i - j];
            count += 1;
            j += 1;
        }
        i += 1;
    }
    all
};

/// A control point of degree six of a bicubic patch over a triangle of corners of its domain: the average of its blossom over all
/// ways to take three of the six corners along u and the rest along v.
fn sextic(tensor: &Bicubic, corners: [[usize; 2]; 3], exponents: [usize; 3]) -> DVec3 {
    let [i, j, k] = exponents;
    let mut sum = DVec3::ZERO;
    for x in 0..=i.min(3) {
        for y in 0..=j.min(3 - x) {
            let z = 3 - x - y;
            if z > k {
                continue;
            }
            let ways = choose(i, x) * choose(j, y) * choose(k, z);
            let [[ua, va], [ub, vb], [uc, vc]] = corners;
            let row = x * ua + y * ub + z * uc;
            let column = (i - x) * va + (j - y) * vb + (k - z) * vc;
            sum += ways * tensor[row][column];
        }
    }
    sum / choose(6, 3)
}

/// A control point of a cubic patch elevated to degree six.
fn elevated(patch: &CubicPatch, [i, j, k]: [usize; 3]) -> DVec3 {
    let cubic = [
        [3, 0, 0],
        [2, 1, 0],
        [2, 0, 1],
        [1, 2, 0],
        [1, 1, 1],
        [1, 0, 2],
        [0, 3, 0],
        [0, 2, 1],
        [0, 1, 2],
        [0, 0, 3],
    ];
    let shares = cubic.map(|[a, b, c]| choose(i, a) * choose(j, b) * choose(k, c));
    let sum: DVec3 = patch
        .points
        .iter()
        .zip(shares)
        .map(|(point, share)| share * *point)
        .sum();
    sum / choose(6, 3)
}

/// How many ways there are to take `taken` of `all` things.
fn choose(all: usize, taken: usize) -> f64 {
    if taken > all {
        return 0.0;
    }
    (0..taken).fold(1.0, |ways, step| ways * (all - step) as f64 / (step + 1) as f64)
}

#[cfg(test)]
#[path = "tensor_triangles_tests.rs"]
mod tests;
