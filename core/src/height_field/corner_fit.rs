//! Height and slope of one vertex of a curved surface, so that no sample around it is further off than the tolerance.
//!
//! ```text
//! weights ← 1
//! a few times:
//!     least squares: three unknowns
//!     nothing beyond the tolerance: done;  far beyond it at first: hopeless
//!     weights ← weights × what each sample is off          towards the smallest greatest difference
//! ```
//! C. L. Lawson, *Contributions to the theory of linear least maximum approximation*, thesis, University of California, 1961.

use glam::{DMat3, DVec2, DVec3};

use crate::height_field::cubic::Asked;

/// Solutions of least squares, at most.
const ROUNDS: usize = 4;
/// Tolerances that the first may be off: what is further is not mended by weights.
const HOPELESS: f64 = 2.5;
/// Share of all weights by which a vertex is held where it is: what samples do not tell stays as it was.
const HOLD: f64 = 1e-6;

/// Height and slope of a vertex: metres, and metres a column and a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangent {
    pub(crate) height: f64,
    pub(crate) slope: DVec2,
}

/// What samples ask of a vertex.
#[derive(Debug, Default)]
pub(crate) struct CornerFit {
    asked: Vec<Asked>,
    /// What each would be off, metres, at the tangent tried last.
    off: Vec<f64>,
    weights: Vec<f64>,
}

impl CornerFit {
    pub(crate) fn clear(&mut self) {
        self.asked.clear();
    }

    pub(crate) fn push(&mut self, asked: Asked) {
        self.asked.push(asked);
    }

    /// A tangent within the tolerance of all samples; `present` is where the search begins, `reach` about as many cells as the
    /// triangles are wide.
    pub(crate) fn solve(&mut self, present: Tangent, reach: f64, tolerance: f64) -> Option<Tangent> {
        self.weights.clear();
        self.weights.resize(self.asked.len(), 1.0);
        let mut tangent = present;
        for round in 0..ROUNDS {
            self.look(tangent);
            tangent = self.better(tangent, reach);
            let worst = self.look(tangent);
            if worst <= tolerance {
                return Some(tangent);
            }
            if round == 0 && worst > HOPELESS * tolerance {
                return None;
            }
            for (weight, off) in self.weights.iter_mut().zip(&self.off) {
                *weight *= off.abs() / worst;
            }
        }
        None
    }

    /// Finds what each sample is off; tells the worst.
    fn look(&mut self, tangent: Tangent) -> f64 {
        let off = |asked: &Asked| asked.of_height * tangent.height + asked.of_slope.dot(tangent.slope) - asked.target;
        self.off.clear();
        self.off.extend(self.asked.iter().map(off));
        self.off.iter().fold(0.0, |worst, off| worst.max(off.abs()))
    }

    /// The tangent of least squares. Slopes are counted in metres over `reach` cells, so that all unknowns are alike.
    fn better(&self, tangent: Tangent, reach: f64) -> Tangent {
        let (mut squares, mut sum) = (DMat3::ZERO, DVec3::ZERO);
        for ((asked, off), weight) in self.asked.iter().zip(&self.off).zip(&self.weights) {
            let row = DVec3::new(asked.of_height, asked.of_slope.x / reach, asked.of_slope.y / reach);
            let weighted = row * *weight;
            squares += DMat3::from_cols(weighted * row.x, weighted * row.y, weighted * row.z);
            sum += weighted * *off;
        }
        let trace = squares.x_axis.x + squares.y_axis.y + squares.z_axis.z;
        if trace == 0.0 {
            return tangent;
        }
        let held = squares + DMat3::from_diagonal(DVec3::splat(HOLD * trace));
        let step = held.inverse() * sum;
        Tangent {
            height: tangent.height - step.x,
            slope: tangent.slope - DVec2::new(step.y, step.z) / reach,
        }
    }
}

#[cfg(test)]
#[path = "corner_fit_tests.rs"]
mod tests;
