//! Which patches meet: those that have a whole curve between the same vertices in common.

use std::collections::HashMap;

use crate::curved::patch::CubicPatch;
use crate::topology::half_edges::NONE;

/// A curve and the vertices that it joins, as bits, with one zero.
pub(crate) type Curve = ([u32; 2], [[u64; 3]; 4]);

/// The three curves of a patch, in its own direction.
pub(crate) fn curves(corners: [u32; 3], patch: &CubicPatch) -> [Curve; 3] {
    [0, 1, 2].map(|index| {
        let points = patch
            .curve(index)
            .map(|point| point.to_array().map(|number| (number + 0.0).to_bits()));
        ([corners[index], corners[(index + 1) % 3]], points)
    })
}

/// The half-edge across each one, or [`NONE`]: patches meet where they have a whole curve between the same vertices in common,
/// in opposite directions. Of more than two that do, none.
pub(crate) fn twins(corners: &[[u32; 3]], patches: &[CubicPatch]) -> Vec<u32> {
    let all: Vec<Curve> = corners
        .iter()
        .zip(patches)
        .flat_map(|(&corners, patch)| curves(corners, patch))
        .collect();
    let mut edges: HashMap<&Curve, u32> = HashMap::with_capacity(all.len());
    for (edge, curve) in (0..).zip(&all) {
        edges.entry(curve).and_modify(|edge| *edge = NONE).or_insert(edge);
    }
    let single = |curve: &Curve| edges.get(curve).copied().filter(|&edge| edge != NONE);
    let across = |([from, to], points): &Curve| {
        let mut points = *points;
        points.reverse();
        ([*to, *from], points)
    };
    let twin = |curve: &Curve| {
        let back = across(curve);
        let is_own_back = back == *curve;
        single(curve)
            .and_then(|_| single(&back))
            .filter(|_| !is_own_back)
            .unwrap_or(NONE)
    };
    all.iter().map(twin).collect()
}
