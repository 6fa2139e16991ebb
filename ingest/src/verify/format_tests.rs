//! What the format's description says of drawing, taken word by word and slowly, against [`Tile::surface`].

use std::collections::BTreeSet;

use glam::DVec3;
use terrain_codec::LevelLimits;
use terrain_codec::spt::{decode, encode};
use terrain_codec::tile::Detail;
use terrain_core::Mesh;

use super::fixture::{LEAF, ROOT, Sample};

/// x, y in lattice units, height in steps.
type Position = [i64; 3];

struct Vertex {
    own: Position,
    representative: usize,
    restores: Position,
}

/// All that is in the bytes, and the number of vertices and triangles by the end of each level.
struct SlowTile {
    vertices: Vec<Vertex>,
    triangles: Vec<[usize; 3]>,
    ends: Vec<(usize, usize)>,
}

fn read(bytes: &[u8]) -> SlowTile {
    let tile = decode(bytes, &LevelLimits::default()).unwrap();
    let partition = tile.partition;
    let vertex = |index: usize| Vertex {
        own: place(partition.positions[index]),
        representative: partition.representatives[index] as usize,
        restores: place(partition.blue_positions[index]),
    };
    let ends = partition.levels.iter();
    SlowTile {
        vertices: (0..partition.positions.len()).map(vertex).collect(),
        triangles: partition
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| corner as usize))
            .collect(),
        ends: ends
            .map(|level| (level.vertex_end as usize, level.triangle_end as usize))
            .collect(),
    }
}

fn place(p: DVec3) -> Position {
    [p.x as i64, p.y as i64, (p.z / super::fixture::HEIGHT_STEP) as i64]
}

impl SlowTile {
    fn is_drawn(&self, vertex: usize, levels: &[usize]) -> bool {
        let level = self.ends.iter().position(|end| vertex < end.0).unwrap();
        levels.contains(&level)
    }

    /// Follows representatives to a vertex that is drawn, then looks for the last drawn vertex that restores its place.
    fn place(&self, corner: usize, levels: &[usize]) -> Position {
        let mut vertex = corner;
        while !self.is_drawn(vertex, levels) {
            vertex = self.vertices[vertex].representative;
        }
        let moves = |&other: &usize| self.vertices[other].representative == vertex && self.is_drawn(other, levels);
        let last = (vertex + 1..self.vertices.len()).rev().find(moves);
        last.map_or(self.vertices[vertex].own, |other| self.vertices[other].restores)
    }

    fn triangles(&self, levels: &[usize]) -> BTreeSet<[Position; 3]> {
        let level_of = |triangle: usize| self.ends.iter().position(|end| triangle < end.1).unwrap();
        let drawn = (0..self.triangles.len()).filter(|&triangle| levels.contains(&level_of(triangle)));
        drawn
            .map(|triangle| self.triangles[triangle].map(|corner| self.place(corner, levels)))
            .collect()
    }
}

fn triangles(mesh: &Mesh) -> BTreeSet<[Position; 3]> {
    mesh.triangles
        .iter()
        .map(|t| t.map(|corner| place(mesh.positions[corner as usize])))
        .collect()
}

/// Triangles that begin with their smallest corner.
fn turned(triangles: BTreeSet<[Position; 3]>) -> BTreeSet<[Position; 3]> {
    let turn = |mut corners: [Position; 3]| {
        let least = (0..3).min_by_key(|&at| corners[at]).unwrap_or(0);
        corners.rotate_left(least);
        corners
    };
    triangles.into_iter().map(turn).collect()
}

#[test]
fn every_level_and_every_set_of_sides_is_what_the_description_says() {
    let sample = Sample::of(|column, row| (column * column + 3 * row) as f32);
    for address in [LEAF, ROOT] {
        let tile = &sample.tiles[&address];
        let slow = read(&encode(tile).unwrap());
        let interior = tile.interior_levels();
        let mut sizes = BTreeSet::new();
        for (last, sides) in (0..interior).flat_map(|last| (0..16).map(move |sides: usize| (last, sides))) {
            let fine_sides = [0, 1, 2, 3].map(|side| sides >> side & 1 == 1);
            let shown = (0..4)
                .filter(|&side| fine_sides[side] && last + 1 == interior)
                .map(|side| interior + side);
            let levels: Vec<usize> = (0..=last).chain(shown).collect();
            let expected = slow.triangles(&levels);
            let surface = tile.surface(Detail {
                interior: last,
                fine_sides,
            });
            assert_eq!(
                turned(triangles(&surface)),
                turned(expected.clone()),
                "{address} {levels:?}"
            );
            sizes.insert(expected.len());
        }
        assert!(sizes.len() >= 2, "{address} has one surface only");
    }
}
