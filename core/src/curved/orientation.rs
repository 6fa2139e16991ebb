//! Tensor-product patches with their sides all one way round: files have them as their authors drew them.
//!
//! Patches that meet are made to agree, as most of those that hang together have it. Then, if the surface is rather closed,
//! all are turned so that their normals point outwards: it encloses a volume above zero.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::curved::edge_cuts::canonical;
use crate::curved::tensor::Bicubic;

/// Normals of a closed surface cancel out, those of a flat one sum up to its area. Below this share of it there is an outside.
const CLOSED: f64 = 0.5;

/// Of which patches rows and columns are to be exchanged.
pub(crate) fn to_turn(tensors: &[Bicubic]) -> Vec<bool> {
    let is_turned = turned_to_agree(&neighbours(tensors));
    let agreeing = tensors.iter().zip(&is_turned);
    let agreeing: Vec<Bicubic> = agreeing
        .map(|(tensor, is_turned)| if *is_turned { transposed(tensor) } else { *tensor })
        .collect();
    let is_inside_out = is_inside_out(&agreeing);
    is_turned
        .into_iter()
        .map(|is_turned| is_turned != is_inside_out)
        .collect()
}

fn transposed(tensor: &Bicubic) -> Bicubic {
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| tensor[j][i]))
}

/// The sides, counter-clockwise.
fn sides(p: &Bicubic) -> [[DVec3; 4]; 4] {
    let along = [0, 1, 2, 3];
    [
        along.map(|i| p[i][0]),
        along.map(|j| p[3][j]),
        along.map(|i| p[3 - i][3]),
        along.map(|j| p[0][3 - j]),
    ]
}

/// For each patch those that meet it along a side, and whether they run along it the same way, which they should not.
fn neighbours(tensors: &[Bicubic]) -> Vec<Vec<(usize, bool)>> {
    let mut neighbours = vec![Vec::new(); tensors.len()];
    for [one, other] in meetings(tensors) {
        let is_same_way = one.is_reversed == other.is_reversed;
        neighbours[one.patch].push((other.patch, is_same_way));
        neighbours[other.patch].push((one.patch, is_same_way));
    }
    neighbours
}

/// A side of a patch.
#[derive(Clone, Copy)]
pub(crate) struct Side {
    pub(crate) patch: usize,
    /// Counter-clockwise from v = 0: even ones run along u, odd ones along v.
    pub(crate) number: usize,
    is_reversed: bool,
}

/// Sides that are one curve, of two patches or of one.
pub(crate) fn meetings(tensors: &[Bicubic]) -> Vec<[Side; 2]> {
    let mut uses: BTreeMap<[[u64; 3]; 4], Vec<Side>> = BTreeMap::new();
    for (patch, tensor) in tensors.iter().enumerate() {
        for (number, side) in sides(tensor).into_iter().enumerate() {
            let (curve, is_reversed) = canonical(side.map(|point| point + DVec3::ZERO));
            let has_direction = curve[0] != curve[3] || curve[1] != curve[2];
            if has_direction {
                let key = curve.map(|point| point.to_array().map(f64::to_bits));
                let side = Side {
                    patch,
                    number,
                    is_reversed,
                };
                uses.entry(key).or_default().push(side);
            }
        }
    }
    let pairs = uses.into_values().filter_map(|uses| <[Side; 2]>::try_from(uses).ok());
    pairs.collect()
}

/// Which patches to turn, the fewer of each part that hangs together. A surface with one side stays cut somewhere.
fn turned_to_agree(neighbours: &[Vec<(usize, bool)>]) -> Vec<bool> {
    let mut turned: Vec<Option<bool>> = vec![None; neighbours.len()];
    for start in 0..neighbours.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut part = vec![(start, false)];
        let mut done = 0;
        while let Some(&(patch, is_turned)) = part.get(done) {
            done += 1;
            for &(other, is_same_way) in &neighbours[patch] {
                if turned[other].is_none() {
                    turned[other] = Some(is_turned != is_same_way);
                    part.push((other, is_turned != is_same_way));
                }
            }
        }
        let count = part.iter().filter(|(_, is_turned)| *is_turned).count();
        if 2 * count > part.len() {
            for (patch, is_turned) in part {
                turned[patch] = Some(!is_turned);
            }
        }
    }
    turned.into_iter().map(|is_turned| is_turned == Some(true)).collect()
}

/// Whether a surface that is rather closed encloses less than nothing, by the triangles of the control points.
fn is_inside_out(tensors: &[Bicubic]) -> bool {
    let count = (16 * tensors.len()).max(1) as f64;
    let middle = tensors.as_flattened().as_flattened().iter().sum::<DVec3>() / count;
    let (mut normals, mut area, mut volume) = (DVec3::ZERO, 0.0, 0.0);
    for [a, b, c] in tensors.iter().flat_map(net) {
        let normal = (b - a).cross(c - a);
        normals += normal;
        area += normal.length();
        volume += normal.dot(a - middle);
    }
    normals.length() < CLOSED * area && volume < 0.0
}

/// Two triangles for each four neighbouring control points, counter-clockwise.
fn net(p: &Bicubic) -> impl Iterator<Item = [DVec3; 3]> {
    let cells = (0..3).flat_map(|i| (0..3).map(move |j| [i, j]));
    cells.flat_map(|[i, j]| {
        let [a, b, c, d] = [p[i][j], p[i + 1][j], p[i + 1][j + 1], p[i][j + 1]];
        [[a, b, c], [a, c, d]]
    })
}

#[cfg(test)]
#[path = "orientation_tests.rs"]
mod tests;
