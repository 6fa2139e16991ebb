//! A second, slow reader of tiles, written from the words of the format's description alone, against [`Tile::surface`].

use std::collections::BTreeSet;
use std::io::Read;

use glam::DVec3;
use terrain_core::Mesh;
use terrain_tiles::codec::encode;
use terrain_tiles::tile::Detail;

use super::fixture::{LEAF, ROOT, Sample};

/// x, y in lattice units, height in steps.
type Position = [i64; 3];

struct Entry {
    offset: usize,
    length: usize,
    vertices: usize,
    triangles: usize,
}

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

struct Numbers {
    bytes: Vec<u8>,
    at: usize,
}

impl Numbers {
    fn unsigned(&mut self) -> i64 {
        let mut value = 0;
        for place in (0..).step_by(7) {
            let byte = self.bytes[self.at];
            self.at += 1;
            value |= i64::from(byte % 128) << place;
            if byte < 128 {
                break;
            }
        }
        value
    }

    fn signed(&mut self) -> i64 {
        let code = self.unsigned();
        if code % 2 == 0 { code / 2 } else { -(code + 1) / 2 }
    }

    fn difference_from(&mut self, base: Position) -> Position {
        base.map(|value| value + self.signed())
    }
}

fn read(bytes: &[u8]) -> SlowTile {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&bytes[..4], b"SPTL");
    let count = usize::from(u16::from_le_bytes([bytes[24], bytes[25]]));
    let entries = (0..count).map(|level| 32 + 32 * level).map(|at| Entry {
        offset: word(at + 4),
        length: word(at + 8),
        vertices: word(at + 12),
        triangles: word(at + 16),
    });
    let mut tile = SlowTile {
        vertices: Vec::new(),
        triangles: Vec::new(),
        ends: Vec::new(),
    };
    let mut current: Vec<Position> = Vec::new();
    for entry in entries {
        let mut inflated = Vec::new();
        let packed = &bytes[entry.offset..entry.offset + entry.length];
        flate2::read::DeflateDecoder::new(packed)
            .read_to_end(&mut inflated)
            .unwrap();
        let mut numbers = Numbers { bytes: inflated, at: 0 };
        let mut own = [0; 3];
        for index in tile.vertices.len()..entry.vertices {
            own = numbers.difference_from(own);
            let mut vertex = Vertex {
                own,
                representative: index,
                restores: own,
            };
            if !tile.ends.is_empty() {
                vertex.representative = index - numbers.unsigned() as usize;
                vertex.restores = numbers.difference_from(current[vertex.representative]);
                current[vertex.representative] = vertex.restores;
            }
            current.push(own);
            tile.vertices.push(vertex);
        }
        let mut first = 0;
        for _ in tile.triangles.len()..entry.triangles {
            first += numbers.signed();
            let second = first + numbers.signed();
            let third = second + numbers.signed();
            tile.triangles
                .push([first, second, third].map(|corner| corner as usize));
        }
        assert_eq!(numbers.at, numbers.bytes.len(), "bytes left over");
        tile.ends.push((entry.vertices, entry.triangles));
    }
    tile
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

fn triangles(mesh: &Mesh, step: f64) -> BTreeSet<[Position; 3]> {
    let place = |p: DVec3| [p.x as i64, p.y as i64, (p.z / step) as i64];
    mesh.triangles
        .iter()
        .map(|t| t.map(|corner| place(mesh.positions[corner as usize])))
        .collect()
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
                triangles(&surface, super::fixture::HEIGHT_STEP),
                expected,
                "{address} {levels:?}"
            );
            sizes.insert(expected.len());
        }
        assert!(sizes.len() >= 2, "{address} has one surface only");
    }
}
