//! Tensor-product Bézier patches, and what the paper makes of bicubic ones (§5.2): those of a lower degree become bicubic by
//! elevation, those of a higher one nearly so, the more they are cut before.

use glam::DVec3;
use thiserror::Error;

use crate::curved::merging::with_average_centre;
use crate::curved::patch::CubicPatch;

/// A tensor-product Bézier patch: rows of control points along v, one row for each step along u. P(u, v) is
/// Σᵢ Bᵢ(u) Σⱼ Bⱼ(v) Pᵢⱼ.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorPatch {
    /// Control points, row by row.
    points: Vec<DVec3>,
    /// How many are in a row: the degree along v and one more.
    columns: usize,
}

/// Why control points are no patch.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum TensorError {
    /// A patch has a degree of 1 at least, both ways.
    #[error("{points} control points in rows of {columns} are no patch")]
    Shape {
        /// How many there are.
        points: usize,
        /// How many are in a row.
        columns: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("a control point is not finite")]
    NotFinite,
}

/// Sixteen control points, Pᵢⱼ at `[i][j]`.
pub type Bicubic = [[DVec3; 4]; 4];

impl TensorPatch {
    /// A patch of control points, row by row.
    ///
    /// # Errors
    /// Where they are no patch.
    pub fn new(points: Vec<DVec3>, columns: usize) -> Result<Self, TensorError> {
        if columns < 2 || points.len() < 2 * columns || !points.len().is_multiple_of(columns) {
            return Err(TensorError::Shape {
                points: points.len(),
                columns,
            });
        }
        if !points.iter().all(|point| point.is_finite()) {
            return Err(TensorError::NotFinite);
        }
        Ok(Self { points, columns })
    }

    /// Control points, row by row.
    pub fn points(&self) -> impl Iterator<Item = DVec3> {
        self.points.iter().copied()
    }

    /// Degrees along u and v.
    #[must_use]
    pub fn degrees(&self) -> [usize; 2] {
        [self.points.len() / self.columns - 1, self.columns - 1]
    }

    /// The point at (u, v).
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let along_v: Vec<DVec3> = self.rows().map(|row| split(row, v).0[row.len() - 1]).collect();
        split(&along_v, u).0[along_v.len() - 1]
    }

    /// A bicubic patch.
    #[must_use]
    pub fn of_bicubic(bicubic: &Bicubic) -> Self {
        Self {
            points: bicubic.as_flattened().to_vec(),
            columns: 4,
        }
    }

    /// The pieces that halving the patch so often along u and along v makes of it.
    #[must_use]
    pub fn halved(&self, [along_u, along_v]: [u32; 2]) -> Vec<Self> {
        let strips = halvings(self.transposed(), along_u);
        strips
            .into_iter()
            .flat_map(|strip| halvings(strip.transposed(), along_v))
            .collect()
    }

    /// The patch as a bicubic one, which along a degree above three has the ends and tangents of this one's control points; and
    /// how far apart both are at most.
    #[must_use]
    pub fn near_bicubic(&self) -> (Bicubic, f64) {
        let bicubic = self.as_bicubic();
        if self.degrees().into_iter().all(|degree| degree <= 3) {
            return (bicubic, 0.0);
        }
        let degrees = self.degrees().map(|degree| degree.max(3));
        let [own, near] = [self, &Self::of_bicubic(&bicubic)].map(|patch| patch.elevated(degrees));
        let distances = own.points.iter().zip(&near.points).map(|(a, b)| a.distance(*b));
        (bicubic, distances.fold(0.0, f64::max))
    }

    /// The same patch with more control points.
    fn elevated(&self, [along_u, along_v]: [usize; 2]) -> Self {
        let rows = |patch: &Self, degree: usize| Self {
            points: patch.rows().flat_map(|row| elevated(row, degree)).collect(),
            columns: degree + 1,
        };
        rows(&rows(self, along_v).transposed(), along_u).transposed()
    }

    /// Rows as columns: the same surface seen from its other side.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let rows = self.points.len() / self.columns;
        let column = |column: usize| self.points[column..].iter().step_by(self.columns).copied();
        Self {
            points: (0..self.columns).flat_map(column).collect(),
            columns: rows,
        }
    }

    fn rows(&self) -> impl Iterator<Item = &[DVec3]> {
        self.points.chunks_exact(self.columns)
    }

    fn halves_along_v(&self) -> [Self; 2] {
        let halves: Vec<_> = self.rows().map(|row| split(row, 0.5)).collect();
        let piece = |points: Vec<DVec3>| Self {
            points,
            columns: self.columns,
        };
        [
            piece(halves.iter().flat_map(|(low, _)| low.iter().copied()).collect()),
            piece(halves.iter().flat_map(|(_, high)| high.iter().copied()).collect()),
        ]
    }

    fn as_bicubic(&self) -> Bicubic {
        let along_v: Vec<[DVec3; 4]> = self.rows().map(as_cubic).collect();
        let columns = [0, 1, 2, 3].map(|j| as_cubic(&along_v.iter().map(|row| row[j]).collect::<Vec<_>>()));
        [0, 1, 2, 3].map(|i| columns.map(|column| column[i]))
    }
}

fn halvings(patch: TensorPatch, along_v: u32) -> Vec<TensorPatch> {
    (0..along_v).fold(vec![patch], |pieces, _| {
        pieces.iter().flat_map(TensorPatch::halves_along_v).collect()
    })
}

/// A Bézier curve with the control points of a higher degree.
fn elevated(curve: &[DVec3], degree: usize) -> Vec<DVec3> {
    (curve.len()..=degree).fold(curve.to_vec(), |curve, count| {
        let between = (1..count).map(|place| curve[place].lerp(curve[place - 1], place as f64 / count as f64));
        let ends = [curve[0], curve[count - 1]];
        [ends[0]].into_iter().chain(between).chain([ends[1]]).collect()
    })
}

/// Both parts of a Bézier curve of any degree.
fn split(curve: &[DVec3], t: f64) -> (Vec<DVec3>, Vec<DVec3>) {
    let mut left = Vec::with_capacity(curve.len());
    let mut right = curve.to_vec();
    for step in 1..=curve.len() {
        left.push(right[0]);
        for place in 0..curve.len() - step {
            right[place] = right[place].lerp(right[place + 1], t);
        }
    }
    (left, right)
}

/// A curve of degree 1 to 3 exactly, one of a higher degree by its ends and tangents; from either end the same, to the bit.
fn as_cubic(curve: &[DVec3]) -> [DVec3; 4] {
    match *curve {
        [a, b] => [a, (2.0 * a + b) / 3.0, (a + 2.0 * b) / 3.0, b],
        [a, b, c] => [a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c],
        [a, b, c, d] => [a, b, c, d],
        [a, b, .., c, d] => {
            let reach = (curve.len() - 1) as f64 / 3.0;
            [a, a + (b - a) * reach, d + (c - d) * reach, d]
        }
        _ => unreachable!("a row has two control points at least"),
    }
}

/// The cubic that the paper prints for the diagonal curve from P00 to P33, which is of degree six: Pᵢ = Σⱼ Pᵢⱼ Bⱼ(i/3). It leaves
/// the surface's tangent planes, so that models are made of [`near_triangles`](super::tensor_triangles::near_triangles) instead.
#[must_use]
pub fn diagonal(tensor: &Bicubic) -> [DVec3; 4] {
    [0, 1, 2, 3].map(|i| split(&tensor[i], i as f64 / 3.0).0[3])
}

/// The patches of the paper: with corners (P00, P30, P33) and (P00, P33, P03), that diagonal, and the centres of the first pass
/// of §5.1.
#[must_use]
pub fn triangles(tensor: &Bicubic) -> [CubicPatch; 2] {
    let p = tensor;
    let [start, first, second, end] = diagonal(tensor);
    [
        with_average_centre(
            [start, p[3][0], end],
            [[p[1][0], p[2][0]], [p[3][1], p[3][2]], [second, first]],
        ),
        with_average_centre(
            [start, end, p[0][3]],
            [[first, second], [p[2][3], p[1][3]], [p[0][2], p[0][1]]],
        ),
    ]
}

#[cfg(test)]
#[path = "tensor_tests.rs"]
mod tests;
