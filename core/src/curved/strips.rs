//! Tensor-product patches are halved until triangles are near to each piece, so that pieces meet as the patches did.
//!
//! ```text
//!  ┌────┬────┐   halving a patch along u halves two of its sides, so that patches across these are halved, too, and those
//!  ├──▶─┼──▶─┼─  across from them: a strip, which may close, or cross itself
//!  └────┴────┘
//! each direction of each patch is in one strip
//! while pieces of some patch deviate more than they may:
//!     halve the strip of such a patch that makes them deviate less
//! ```

use std::collections::BTreeSet;

use crate::curved::orientation;
use crate::curved::tensor::{Bicubic, TensorPatch};
use crate::curved::tensor_triangles::{has_opposite_points, near_triangles};

/// A strip is halved so many times at most.
const MOST_HALVINGS: u32 = 6;

/// What is clearly less is below this share.
const CLEARLY: f64 = 0.9;

/// There are so many pieces at most.
const MOST_PIECES: u64 = 1 << 22;

/// How often each patch is halved along u and along v, so that triangles are within `tolerance` of each piece, or as near as
/// limits allow.
pub(super) fn halvings(tensors: &[TensorPatch], bicubics: &[Bicubic], tolerance: f64) -> Vec<[u32; 2]> {
    let strips = strips(bicubics);
    let mut counts = vec![0; 2 * tensors.len()];
    loop {
        let halvings = |patch: usize| strips[patch].map(|strip| counts[strip]);
        let far = (0..tensors.len()).filter(|&patch| deviation(&tensors[patch], halvings(patch)) > tolerance);
        let halved: BTreeSet<usize> = far
            .filter_map(|patch| Some(strips[patch][better(&tensors[patch], halvings(patch))?]))
            .collect();
        let halvings: Vec<[u32; 2]> = (0..tensors.len()).map(halvings).collect();
        if halved.is_empty() {
            return halvings;
        }
        halved.iter().for_each(|&strip| counts[strip] += 1);
        let pieces = strips
            .iter()
            .map(|own| 1_u64 << own.map(|strip| counts[strip]).iter().sum::<u32>());
        if pieces.sum::<u64>() > MOST_PIECES {
            return halvings;
        }
    }
}

/// The largest deviation of a triangle from a piece; infinite where pieces have to be halved to be triangles.
fn deviation(tensor: &TensorPatch, halvings: [u32; 2]) -> f64 {
    let of_piece = |piece: &TensorPatch| {
        let (bicubic, deviation) = piece.near_bicubic();
        if has_opposite_points(&bicubic) {
            return f64::INFINITY;
        }
        let near = near_triangles(&bicubic);
        deviation + near.iter().map(|near| near.deviation).fold(0.0, f64::max)
    };
    tensor.halved(halvings).iter().map(of_piece).fold(0.0, f64::max)
}

/// The direction to halve next: that which was halved less, unless the other makes pieces deviate clearly less; none where neither
/// may be halved.
fn better(tensor: &TensorPatch, halvings: [u32; 2]) -> Option<usize> {
    let after = |direction: usize| {
        let mut more = halvings;
        more[direction] += 1;
        deviation(tensor, more)
    };
    let less = usize::from(halvings[1] < halvings[0]);
    let other = 1 - less;
    let is_allowed = |direction: usize| halvings[direction] < MOST_HALVINGS;
    match [less, other].map(is_allowed) {
        [false, _] => None,
        [true, true] if after(other) < CLEARLY * after(less) => Some(other),
        _ => Some(less),
    }
}

/// The strip of each patch's directions.
fn strips(bicubics: &[Bicubic]) -> Vec<[usize; 2]> {
    let mut above: Vec<usize> = (0..2 * bicubics.len()).collect();
    for sides in orientation::meetings(bicubics) {
        let [one, other] = sides.map(|side| top(&above, 2 * side.patch + side.number % 2));
        above[one.max(other)] = one.min(other);
    }
    (0..bicubics.len())
        .map(|patch| [top(&above, 2 * patch), top(&above, 2 * patch + 1)])
        .collect()
}

fn top(above: &[usize], mut strip: usize) -> usize {
    while above[strip] != strip {
        strip = above[strip];
    }
    strip
}

#[cfg(test)]
#[path = "strips_tests.rs"]
mod tests;
