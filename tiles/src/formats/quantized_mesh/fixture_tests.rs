//! Tiles of few triangles for tests.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::collections::HashSet;
use std::convert::Infallible;
use std::slice;
use std::sync::Arc;

use glam::DVec3;
use terrain_codec::address::{Rectangle, Side, TileAddress};
use terrain_codec::tile::Tile;
use terrain_core::Mesh;

use super::QuantizedMesh;
use crate::fixture::of_one_level;
use crate::outside::Outside;
use crate::shading::FinestSurface;
use crate::shading::tests::surfaces_of;

/// A tile with `mesh` as its only level.
pub(super) fn tile(address: TileAddress, extent_bits: u8, mesh: &Mesh) -> Tile {
    of_one_level(address, extent_bits, -6, mesh, 1.0)
}

/// The mesh of a tile among others.
pub(in crate::formats) fn from_tile(tile: &Tile, others: &[Tile], outside: &Outside) -> QuantizedMesh {
    let all = surfaces_of(&[others, slice::from_ref(tile)].concat());
    let (own, others) = all.split_last().unwrap();
    QuantizedMesh::from_tile(own, find_in(others), outside).unwrap()
}

/// That of a square without a tile, among tiles.
pub(super) fn unmeasured(address: TileAddress, others: &[Tile], outside: &Outside) -> QuantizedMesh {
    QuantizedMesh::unmeasured(address, find_in(&surfaces_of(others)), outside).unwrap()
}

fn find_in(surfaces: &[Arc<FinestSurface>]) -> impl Fn(TileAddress) -> Result<Option<Arc<FinestSurface>>, Infallible> {
    |address| Ok(surfaces.iter().find(|surface| surface.tile.address == address).cloned())
}

pub(super) fn address(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

/// Two triangles for every cell between `columns` and `rows` that `keep` wants, by column and row.
pub(super) fn grid(
    columns: &[f64],
    rows: &[f64],
    height: impl Fn(f64, f64) -> f64,
    keep: impl Fn(usize, usize) -> bool,
) -> Mesh {
    let width = columns.len() as u32;
    let positions = rows
        .iter()
        .flat_map(|&y| columns.iter().map(move |&x| (x, y)))
        .map(|(x, y)| DVec3::new(x, y, height(x, y)));
    let cells = (0..rows.len() - 1).flat_map(|row| (0..columns.len() - 1).map(move |column| (column, row)));
    let triangles = cells
        .filter(|&(column, row)| keep(column, row))
        .flat_map(|(column, row)| {
            let a = row as u32 * width + column as u32;
            [[a, a + 1, a + width + 1], [a, a + width + 1, a + width]]
        });
    drop_unused(&Mesh {
        positions: positions.collect(),
        triangles: triangles.collect(),
    })
}

pub(super) fn drop_unused(mesh: &Mesh) -> Mesh {
    let mut used: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let number = |vertex: u32| used.binary_search(&vertex).unwrap() as u32;
    Mesh {
        positions: used.iter().map(|&vertex| mesh.positions[vertex as usize]).collect(),
        triangles: mesh.triangles.iter().map(|triangle| triangle.map(number)).collect(),
    }
}

pub(super) fn even(cells: u32, extent: f64) -> Vec<f64> {
    (0..=cells)
        .map(|line| (extent * f64::from(line) / f64::from(cells)).round())
        .collect()
}

/// Longitude and latitude in billionths of a degree, metres, and oct-encoded normals of both ends.
pub(super) type BorderEdge = [([i64; 2], f64, [u8; 2]); 2];

/// The edges of a mesh's border that lie along a side of its square, upright ones not counted.
pub(super) fn border(mesh: &QuantizedMesh, at: impl Into<Rectangle> + Copy, side: Side) -> Vec<BorderEdge> {
    let corners = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let directed: HashSet<[u32; 2]> = mesh.triangles.iter().flat_map(corners).collect();
    let on_side: HashSet<u32> = mesh.edges[side as usize].iter().copied().collect();
    let end = |vertex: u32| {
        let place = mesh.geodetic(at, vertex as usize);
        let plan = [place.longitude, place.latitude].map(|degrees| (degrees * 1e9).round() as i64);
        (plan, place.height, mesh.normals.as_ref().unwrap()[vertex as usize])
    };
    let of_border = directed.iter().filter(|&&[a, b]| !directed.contains(&[b, a]));
    let along = of_border.filter(|edge| edge.iter().all(|vertex| on_side.contains(vertex)));
    let mut along: Vec<_> = along
        .map(|&[a, b]| [end(a), end(b)])
        .filter(|[a, b]| a.0 != b.0)
        .map(|[a, b]| if a.0 < b.0 { [a, b] } else { [b, a] })
        .collect();
    along.sort_by(|a, b| a.partial_cmp(b).unwrap());
    along
}

/// How much of two borders does not meet: edges that are at another place, or higher by more than `most` metres, or have other normals.
pub(super) fn unlike(one: &[BorderEdge], other: &[BorderEdge], most: f64) -> usize {
    let pairs = one.iter().zip(other);
    let is_unlike = |(one, other): (&BorderEdge, &BorderEdge)| {
        let ends = one.iter().zip(other);
        ends.into_iter()
            .any(|(one, other)| one.0 != other.0 || (one.1 - other.1).abs() > most || one.2 != other.2)
    };
    one.len().abs_diff(other.len()) + pairs.filter(|&pair| is_unlike(pair)).count()
}

/// A small generator of random numbers (Numerical Recipes), so that a failure comes again.
pub(super) struct Random(pub(super) u32);

impl Random {
    pub(super) fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(self.0) * u64::from(end)) >> 32) as u32
    }
}
