//! Triangles whose height over the grid is a cubic polynomial, given by heights and slopes at the corners.
//!
//! ```text
//!            030                  height = Σ b · 3!/(i! j! k!) · uⁱ vʲ wᵏ      (u, v, w: barycentric, from the corners)
//!          021   120
//!       012   111   210           b300 = height at the corner
//!    003   102   201   300        b210 = b300 + slope · (next corner − this one) / 3
//! ```
//! The curve along an edge depends on the edge's two ends alone, so that triangles meet without a crack. The middle
//! height makes each quadratic polynomial one of these triangles: G. Farin, *Triangular Bernstein–Bézier patches*,
//! Computer Aided Geometric Design 3, 1986, section 2.

use glam::DVec2;

use crate::height_field::flat::GridPoint;

/// A vertex of a curved surface over the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopedPoint {
    /// Where it is.
    pub point: GridPoint,
    /// Metres that the surface rises a column and a row.
    pub slope: DVec2,
}

impl SlopedPoint {
    /// Height of the control point a third of the way to another place.
    fn towards(&self, other: DVec2) -> f64 {
        self.point.height + self.slope.dot(other - self.point.grid) / 3.0
    }
}

/// A place of a triangle as weights of its corners.
#[derive(Clone, Copy)]
struct Weights([f64; 3]);

/// Gives weights of a triangle's second and third corner, from offsets from the first one.
#[derive(Clone, Copy, Debug)]
struct Barycentric {
    second: DVec2,
    third: DVec2,
}

impl Barycentric {
    /// From offsets of the other two corners; none where all are on one line.
    fn new(to_second: DVec2, to_third: DVec2) -> Option<Self> {
        let area = to_second.perp_dot(to_third);
        (area != 0.0).then(|| Self {
            second: -to_third.perp() / area,
            third: to_second.perp() / area,
        })
    }

    fn weights(&self, offset: DVec2) -> Weights {
        let [v, w] = [self.second.dot(offset), self.third.dot(offset)];
        Weights([1.0 - v - w, v, w])
    }
}

/// Heights of the control points in the order 300 210 201 120 111 102 030 021 012 003.
type ControlHeights = [f64; 10];

fn control_heights([a, b, c]: [SlopedPoint; 3]) -> ControlHeights {
    let towards = |from: &SlopedPoint, to: &SlopedPoint| from.towards(to.point.grid);
    let [ab, ac, ba] = [towards(&a, &b), towards(&a, &c), towards(&b, &a)];
    let [bc, ca, cb] = [towards(&b, &c), towards(&c, &a), towards(&c, &b)];
    let corners = [a, b, c].map(|corner| corner.point.height);
    let middle = (ab + ac + ba + bc + ca + cb) / 4.0 - corners.iter().sum::<f64>() / 6.0;
    [corners[0], ab, ac, ba, middle, ca, corners[1], bc, cb, corners[2]]
}

fn height(control: &ControlHeights, Weights([u, v, w]): Weights) -> f64 {
    let &[b300, b210, b201, b120, b111, b102, b030, b021, b012, b003] = control;
    u * u * (u * b300 + 3.0 * (v * b210 + w * b201))
        + v * v * (v * b030 + 3.0 * (u * b120 + w * b021))
        + w * w * (w * b003 + 3.0 * (u * b102 + v * b012))
        + 6.0 * u * v * w * b111
}

/// A curved triangle.
#[derive(Clone, Copy, Debug)]
pub struct Cubic {
    first: DVec2,
    barycentric: Barycentric,
    /// Metres, in the order 300 210 201 120 111 102 030 021 012 003.
    pub control_heights: [f64; 10],
}

impl Cubic {
    /// None where the corners are on one line.
    #[must_use]
    pub fn through(corners: [SlopedPoint; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| corner.point.grid);
        Some(Self {
            first: a,
            barycentric: Barycentric::new(b - a, c - a)?,
            control_heights: control_heights(corners),
        })
    }

    /// Metres at a column and row.
    #[must_use]
    pub fn height(&self, at: DVec2) -> f64 {
        height(&self.control_heights, self.barycentric.weights(at - self.first))
    }
}

/// What a sample asks of a corner with unknown height and slope: `of_height · height + of_slope · slope` is to be `target`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    pub(crate) of_height: f64,
    pub(crate) of_slope: DVec2,
    pub(crate) target: f64,
}

/// A curved triangle of which the first corner's height and slope are unknown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unknown {
    barycentric: Barycentric,
    to_second: DVec2,
    to_third: DVec2,
    /// As if the first corner were at height 0 and level.
    control_heights: ControlHeights,
}

impl Unknown {
    /// None where the corners are on one line.
    pub(crate) fn new(first: DVec2, second: SlopedPoint, third: SlopedPoint) -> Option<Self> {
        let level = SlopedPoint {
            point: GridPoint {
                grid: first,
                height: 0.0,
            },
            slope: DVec2::ZERO,
        };
        let [to_second, to_third] = [second, third].map(|corner| corner.point.grid - first);
        Some(Self {
            barycentric: Barycentric::new(to_second, to_third)?,
            to_second,
            to_third,
            control_heights: control_heights([level, second, third]),
        })
    }

    /// What a sample at an offset from the first corner asks of that.
    pub(crate) fn asked(&self, offset: DVec2, sample: f64) -> Asked {
        let weights = self.barycentric.weights(offset);
        let Weights([u, v, w]) = weights;
        let inside = u * v * w / 2.0;
        Asked {
            of_height: u * u * (u + 3.0 * (v + w)) + 4.0 * inside,
            of_slope: (u * u * v + inside) * self.to_second + (u * u * w + inside) * self.to_third,
            target: sample - height(&self.control_heights, weights),
        }
    }
}

#[cfg(test)]
#[path = "cubic_tests.rs"]
mod tests;
