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

/// The same patches, some with rows and columns exchanged.
pub(crate) fn oriented(tensors: &[Bicubic]) -> Vec<Bicubic> {
    let is_turned = turned_to_agree(&neighbours(tensors));
    let agreeing = tensors.iter().zip(is_turned);
    let agreeing: Vec<Bicubic> = agreeing
        .map(|(tensor, is_turned)| if is_turned { transposed(tensor) } else { *tensor })
        .collect();
    if is_inside_out(&agreeing) {
        agreeing.iter().map(transposed).collect()
    } else {
        agreeing
    }
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
    let mut uses: BTreeMap<[[u64; 3]; 4], Vec<(usize, bool)>> = BTreeMap::new();
    for (index, tensor) in tensors.iter().enumerate() {
        for side in sides(tensor) {
            let (curve, is_reversed) = canonical(side.map(|point| point + DVec3::ZERO));
            let has_direction = curve[0] != curve[3] || curve[1] != curve[2];
            if has_direction {
                let key = curve.map(|point| point.to_array().map(f64::to_bits));
                uses.entry(key).or_default().push((index, is_reversed));
            }
        }
    }
    let mut neighbours = vec![Vec::new(); tensors.len()];
    for both in uses.values() {
        if let [(one, way), (other, other_way)] = *both.as_slice() {
            neighbours[one].push((other, way == other_way));
            neighbours[other].push((one, way == other_way));
        }
    }
    neighbours
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
