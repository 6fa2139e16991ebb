//! How far the outline of a tile's mesh is from the outline of the source, in plan view and both ways: samples that
//! the mesh leaves out, and mesh where the source has nothing; also where a hole of the source is closed and there is no outline.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rstar::RTree;
use rstar::primitives::Line;
use terrain_codec::tile::Tile;

use super::breaklines::PlanEdge;
use super::drawing::{Drawing, boundary_edges};
use super::sides::side_of;
use super::source::{Block, Patch, Source};
use super::source_outline::distance;
use super::space::{Earth, Space};
use super::surface::Surface;

/// The outline of one level of a tile.
pub(super) struct Outline {
    edges: Vec<[u32; 2]>,
    /// Grid positions that have to be near the source's outline; if `true`, only where the source has nothing.
    places: Vec<(DVec2, bool)>,
    /// The edges as seen on the ellipsoid, once somebody asks.
    pieces: OnceLock<RTree<Line<[f64; 3]>>>,
}

impl Outline {
    /// `neighbours` says across which sides there is a tile of the same zoom: where there is none, the side is an outline.
    pub(super) fn new(tile: &Tile, earth: &Earth, drawing: &Drawing, surface: &Surface, neighbours: [bool; 4]) -> Self {
        let edges = boundary_edges(&drawing.triangles);
        let side = |edge: &[u32; 2]| side_of(tile, edge.map(|end| drawing.positions[end as usize]));
        let mut places = Vec::new();
        let is_outline = |edge: &&[u32; 2]| side(edge).is_none_or(|side| !neighbours[side as usize]);
        for &[from, to] in edges.iter().filter(is_outline) {
            let [a, b] = [from, to].map(|end| surface.positions[end as usize]);
            let along = [1.0 / 3.0, 0.5, 2.0 / 3.0].map(|part| (earth.foot(a.lerp(b, part)).grid, true));
            let inner = |&vertex: &u32| !is_on_the_square(tile, drawing, vertex);
            let vertices = [from, to].into_iter().filter(inner);
            places.extend(
                along
                    .into_iter()
                    .chain(vertices.map(|v| (surface.feet[v as usize].grid, false))),
            );
        }
        Self {
            edges,
            places,
            pieces: OnceLock::new(),
        }
    }

    /// Plan distance of a point of the ellipsoid, that no triangle covers, from the mesh.
    pub(super) fn distance(&self, earth: &Earth, surface: &Surface, on_ellipsoid: DVec3) -> f64 {
        let pieces = self.pieces.get_or_init(|| self.on_ellipsoid(earth, surface));
        distance(pieces, on_ellipsoid)
    }

    /// The outline's vertices, and its points where the source has nothing, that are in one block of `whole`.
    pub(super) fn beyond(&self, patch: &Patch, whole: &Block) -> impl Iterator<Item = DVec2> {
        let here = self
            .places
            .iter()
            .filter(|(grid, _)| patch.block.contains(whole.nearest(*grid)));
        let outside = here.filter(|(grid, if_uncovered)| !(*if_uncovered && patch.covers(*grid)));
        outside.map(|&(grid, _)| grid)
    }

    fn on_ellipsoid(&self, earth: &Earth, surface: &Surface) -> RTree<Line<[f64; 3]>> {
        RTree::bulk_load(
            self.edges
                .iter()
                .flat_map(|&edge| pieces(earth, surface, edge))
                .collect(),
        )
    }
}

/// All edges of a surface as seen on the ellipsoid.
pub(super) fn plan_edges(earth: &Earth, surface: &Surface) -> Vec<PlanEdge> {
    let edge = |ends: [u32; 2]| PlanEdge {
        ends,
        parts: pieces(earth, surface, ends),
    };
    surface.edges().map(edge).collect()
}

fn is_on_the_square(tile: &Tile, drawing: &Drawing, vertex: u32) -> bool {
    let extent = (1_u64 << tile.extent_bits) as f64;
    let position = drawing.positions[vertex as usize];
    [position.x, position.y]
        .iter()
        .any(|&value| value == 0.0 || value == extent)
}

/// An edge as seen on the ellipsoid, in pieces of at most a cell that are close to it.
fn pieces(earth: &Earth, surface: &Surface, edge: [u32; 2]) -> Vec<Line<[f64; 3]>> {
    let [a, b] = edge.map(|end| surface.positions[end as usize]);
    let [from, to] = edge.map(|end| surface.feet[end as usize].grid);
    let count = Source::pieces((to - from).abs().max_element(), a.distance(b));
    let points: Vec<[f64; 3]> = (0..=count)
        .map(|i| earth.foot(a.lerp(b, i as f64 / count as f64)).grid)
        .map(|grid| earth.source.on_ellipsoid(grid).to_array())
        .collect();
    points
        .windows(2)
        .filter(|p| p[0] != p[1])
        .map(|p| Line::new(p[0], p[1]))
        .collect()
}
