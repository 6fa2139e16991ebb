//! A tile as a client draws it, from the decoded arrays and the words of `docs/formats/spt.md` alone, and what keeps it
//! from being drawn.
//!
//! ```text
//! take the positions as stored
//! for each vertex v that is shown, beyond level 0, by growing index: put its representative at v's restored position
//! for each triangle that is shown: replace each corner by its representative until that is shown
//! ```

use std::collections::HashSet;

use glam::DVec3;
use robust::{Coord, orient2d};
use terrain_codec::tile::Tile;

/// Levels of a tile that are its sides: west, south, east and north, the last ones.
const SIDES: usize = 4;

/// Lattice units around the Earth as a power of two, less one, that are whole numbers of an `f64` with room to spare.
const MOST_BITS: u8 = 48;

/// Triangles over positions: lattice coordinates of a tile, or those of a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Drawing {
    pub(super) positions: Vec<DVec3>,
    /// Counter-clockwise from above.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// What of a tile is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shown {
    /// The finest interior level, 0 the coarsest.
    pub(super) interior: usize,
    /// Which sides are fine, in the order of their levels; only on the finest interior.
    pub(super) fine_sides: [bool; 4],
}

pub(super) fn interior_levels(tile: &Tile) -> usize {
    tile.partition.levels.len().saturating_sub(SIDES)
}

/// Everything.
pub(super) fn finest(tile: &Tile) -> Shown {
    Shown {
        interior: interior_levels(tile).saturating_sub(1),
        fine_sides: [true; 4],
    }
}

/// An interior level with coarse sides.
pub(super) fn coarse_sided(interior: usize) -> Shown {
    Shown {
        interior,
        fine_sides: [false; 4],
    }
}

/// The surface of a sound tile.
pub(super) fn draw(tile: &Tile, shown: Shown) -> Drawing {
    let (partition, interior) = (&tile.partition, interior_levels(tile));
    let is_shown = |level: usize| level <= shown.interior || (level >= interior && shown.fine_sides[level - interior]);
    let runs: Vec<_> = (0..partition.levels.len()).filter(|&level| is_shown(level)).collect();
    let start = |level: usize| level.checked_sub(1).map(|before| partition.levels[before]);

    let mut numbers: Vec<Option<u32>> = vec![None; partition.positions.len()];
    let mut positions = Vec::new();
    for &level in &runs {
        let first = start(level).map_or(0, |before| before.vertex_end as usize);
        for vertex in first..partition.levels[level].vertex_end as usize {
            numbers[vertex] = Some(positions.len() as u32);
            positions.push(partition.positions[vertex]);
            if let Some(parent) = numbers[partition.representatives[vertex] as usize].filter(|_| level > 0) {
                positions[parent as usize] = partition.blue_positions[vertex];
            }
        }
    }
    let place = |corner: u32| {
        let mut vertex = corner as usize;
        loop {
            match numbers[vertex] {
                Some(number) => break number,
                None => vertex = partition.representatives[vertex] as usize,
            }
        }
    };
    let of_level = |&level: &usize| {
        let first = start(level).map_or(0, |before| before.triangle_end as usize);
        &partition.triangles[first..partition.levels[level].triangle_end as usize]
    };
    let triangles = runs
        .iter()
        .flat_map(of_level)
        .map(|corners| corners.map(place))
        .collect();
    Drawing { positions, triangles }
}

/// What keeps a tile from being drawn at all.
pub(super) fn unsound(tile: &Tile) -> Option<String> {
    let partition = &tile.partition;
    let (levels, count) = (&partition.levels, partition.positions.len());
    if levels.len() <= SIDES || tile.outline_errors.len() != levels.len() {
        let outlines = tile.outline_errors.len();
        return Some(format!("has {} levels and {outlines} outline errors", levels.len()));
    }
    if partition.representatives.len() != count || partition.blue_positions.len() != count {
        return Some("has not one representative for each vertex".to_owned());
    }
    let ends = levels
        .iter()
        .map(|level| [level.vertex_end as usize, level.triangle_end as usize]);
    let complete = ends.clone().next_back() == Some([count, partition.triangles.len()]);
    if !complete
        || !ends
            .clone()
            .zip(ends.skip(1))
            .all(|(a, b)| a[0] <= b[0] && a[1] <= b[1])
    {
        return Some("has levels that do not end where they should".to_owned());
    }
    let claims = || {
        levels
            .iter()
            .map(|level| level.error)
            .chain(tile.outline_errors.iter().copied())
    };
    if !claims().all(f64::is_finite) {
        return Some("claims an error that is no number of metres".to_owned());
    }
    if !levels.is_sorted_by(|coarse, fine| coarse.error >= fine.error) {
        return Some("claims a larger error for a finer level".to_owned());
    }
    let coarsest = levels[0].vertex_end as usize;
    let is_led_back = |(vertex, &other): (usize, &u32)| match other as usize {
        itself if itself == vertex => vertex < coarsest,
        other => other < vertex && vertex >= coarsest,
    };
    if !partition.representatives.iter().enumerate().all(is_led_back) {
        return Some("has a vertex whose representative does not come before it".to_owned());
    }
    let mut corners = partition.triangles.iter().flatten();
    if !corners.all(|&corner| (corner as usize) < count) {
        return Some("has a triangle with a corner that is not there".to_owned());
    }
    off_lattice(tile)
}

fn off_lattice(tile: &Tile) -> Option<String> {
    let bits = tile.address.zoom + tile.extent_bits;
    if bits > MOST_BITS {
        return Some(format!("has a lattice of {bits} bits"));
    }
    let extent = (1_u64 << tile.extent_bits) as f64;
    let on_lattice = |value: f64| (0.0..=extent).contains(&value) && value.fract() == 0.0;
    let partition = &tile.partition;
    let mut vertices = partition.positions.iter().chain(&partition.blue_positions);
    let all = vertices.all(|p| on_lattice(p.x) && on_lattice(p.y) && p.z.is_finite());
    (!all).then(|| "has a vertex off its lattice".to_owned())
}

/// What keeps triangles from being a surface seen from above: an edge that two of them run along in one direction, or
/// a triangle that is not counter-clockwise, by exact arithmetic.
pub(super) fn no_surface(drawing: &Drawing) -> Option<String> {
    let mut seen = HashSet::with_capacity(3 * drawing.triangles.len());
    for (index, &[a, b, c]) in drawing.triangles.iter().enumerate() {
        let corners = [a, b, c].map(|corner| drawing.positions.get(corner as usize));
        let [Some(p), Some(q), Some(r)] = corners else {
            return Some(format!("triangle {index} has a corner that is not there"));
        };
        if ![p, q, r].iter().all(|corner| corner.is_finite()) {
            return Some(format!("triangle {index} has a corner that is not finite"));
        }
        let plan = |corner: &DVec3| Coord {
            x: corner.x,
            y: corner.y,
        };
        if orient2d(plan(p), plan(q), plan(r)) <= 0.0 {
            return Some(format!("triangle {index} is not counter-clockwise"));
        }
        if let Some([a, b]) = [[a, b], [b, c], [c, a]].into_iter().find(|&edge| !seen.insert(edge)) {
            return Some(format!("two triangles run along edge {a}–{b} in one direction"));
        }
    }
    None
}

/// Directed edges that no other triangle runs along in the other direction, in the order of the triangles.
pub(super) fn boundary_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let directed = || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: HashSet<[u32; 2]> = directed().collect();
    directed().filter(|&[a, b]| !all.contains(&[b, a])).collect()
}

#[cfg(test)]
#[path = "drawing_tests.rs"]
mod tests;
