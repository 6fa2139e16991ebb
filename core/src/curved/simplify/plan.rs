//! What one removal does to a surface: patches of each side of a mergeable pair, before and after.
//!
//! ```text
//!        p ──── q                 two faces:    T
//!       ╱ ╲    ╱ ╲                three faces:  one of V–p and V–q swapped, then T (Fig. 8)
//!      ╱   ╲  ╱   ╲                             p or q removed, too: 2T
//!     b ◀── ╲╱ ── a  of V                       both, with the face beyond p–q: T-in-T
//! ```
//! A side is swept counter-clockwise, from `a` to `b`. Its faces are (V, a, p), (V, p, q) and (V, q, b).

use smallvec::SmallVec;

use crate::curved::merging::{self, Merged};
use crate::curved::model::CurvedModel;
use crate::curved::patch::CubicPatch;

/// A patch that is to be, with its bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Made {
    pub(super) patch: CubicPatch,
    pub(super) corners: [u32; 3],
    pub(super) error: f64,
    pub(super) creases: [bool; 3],
}

impl Made {
    fn rotated(&self) -> Self {
        let ([a, b, c], [ab, bc, ca]) = (self.corners, self.creases);
        Self {
            patch: self.patch.rotated(),
            corners: [b, c, a],
            error: self.error,
            creases: [bc, ca, ab],
        }
    }

    /// The same with the vertex as its first corner.
    pub(super) fn from(&self, vertex: u32) -> Option<Self> {
        let turned = [*self, self.rotated(), self.rotated().rotated()];
        turned.into_iter().find(|made| made.corners[0] == vertex)
    }

    /// The bound after a merge of these, in the order of its deviations.
    fn error_of(merged: &Merged, parts: &[&Self]) -> f64 {
        let sums = parts
            .iter()
            .zip(merged.deviations)
            .map(|(part, deviation)| part.error + deviation);
        sums.fold(0.0, f64::max)
    }
}

/// The patch at a half-edge, turned so that its first curve is that of the half-edge.
pub(super) fn patch_at(model: &CurvedModel, errors: &[f64], edge: u32) -> Made {
    let slot = edge / 3;
    let mut made = Made {
        patch: model.patches[slot as usize],
        corners: model.topology.triangles()[slot as usize],
        error: errors[slot as usize],
        creases: model.creases(slot),
    };
    for _ in 0..edge % 3 {
        made = made.rotated();
    }
    made
}

/// One side after its vertex went.
#[derive(Clone, Debug)]
pub(super) struct Side {
    /// The patches' places that it takes.
    pub(super) slots: SmallVec<[u32; 4]>,
    /// What is there instead.
    pub(super) made: SmallVec<[Made; 2]>,
    /// The half-edge that is turned first.
    pub(super) flip: Option<u32>,
}

impl Side {
    pub(super) fn error(&self) -> f64 {
        self.made.iter().map(|made| made.error).fold(0.0, f64::max)
    }
}

/// Faces (V, a, x) and (V, x, b) as (b, a, x).
pub(super) fn t(near: &Made, far: &Made) -> Option<Made> {
    let far = far.rotated().rotated();
    let merged = merging::merge_two(&far.patch, &near.patch)?;
    Some(Made {
        patch: merged.patch,
        corners: [far.corners[0], near.corners[1], near.corners[2]],
        error: Made::error_of(&merged, &[&far, near]),
        creases: [near.creases[0] && far.creases[0], near.creases[1], far.creases[2]],
    })
}

/// Faces (V, a, x) and (V, x, b) as (V, a, b): x is on the curve from a to b.
pub(super) fn outer_t(near: &Made, far: &Made) -> Option<Made> {
    let (near, far) = (near.rotated(), far.rotated());
    let merged = merging::merge_two(&near.patch, &far.patch)?;
    let made = Made {
        patch: merged.patch,
        corners: [near.corners[0], far.corners[1], far.corners[2]],
        error: Made::error_of(&merged, &[&near, &far]),
        creases: [near.creases[0] && far.creases[0], far.creases[1], near.creases[2]],
    };
    Some(made.rotated().rotated())
}

/// Faces (V, x, y) and (V, a, x) with V–x swapped: (V, a, y) and (a, x, y).
pub(super) fn swapped(upper: &Made, lower: &Made) -> Option<[Made; 2]> {
    let lower = lower.rotated().rotated();
    let swapped = merging::swap_diagonal([&upper.patch, &lower.patch])?;
    let error = |new: usize| {
        let [left, right] = swapped.deviations[new];
        (left + upper.error).max(right + lower.error)
    };
    let ([v, x, y], [_, a_after]) = (upper.corners, [lower.corners[1], lower.corners[2]]);
    let inner = Made {
        patch: swapped.patches[0],
        corners: [y, v, a_after],
        error: error(0),
        creases: [upper.creases[2], lower.creases[1], false],
    };
    let outer = Made {
        patch: swapped.patches[1],
        corners: [a_after, x, y],
        error: error(1),
        creases: [lower.creases[2], upper.creases[1], false],
    };
    Some([inner.rotated(), outer])
}

/// The four faces of a T-in-T, (V, a, p), (V, p, q), (V, q, b) and (q, p, x), as (b, a, x).
pub(super) fn triangle_in_triangle([first, middle, last, beyond]: [&Made; 4]) -> Option<Made> {
    let (last, middle) = (last.rotated().rotated(), middle.rotated());
    let parts = [&last, first, beyond, &middle];
    let merged = merging::merge_triangle_in_triangle(parts.map(|made| &made.patch))?;
    Some(Made {
        patch: merged.patch,
        corners: [last.corners[0], first.corners[1], beyond.corners[2]],
        error: Made::error_of(&merged, &parts),
        creases: [
            last.creases[0] && first.creases[0],
            first.creases[1] && beyond.creases[1],
            beyond.creases[2] && last.creases[2],
        ],
    })
}

/// Faces (V, a, b), (V, b, c) and (V, c, a) as (a, b, c).
pub(super) fn star([ab, bc, ca]: [&Made; 3]) -> Option<Made> {
    let (ab, ca) = (ab.rotated(), ca.rotated().rotated());
    let parts = [bc, &ca, &ab];
    let merged = merging::merge_star(parts.map(|made| &made.patch))?;
    Some(Made {
        patch: merged.patch,
        corners: [ab.corners[0], ab.corners[1], bc.corners[2]],
        error: Made::error_of(&merged, &parts),
        creases: [ab.creases[0], bc.creases[1], ca.creases[2]],
    })
}
