//! How far the outline of a tile's mesh is from the outline of the source, in plan view and both ways: samples that
//! the mesh leaves out, and mesh where the source has nothing.

use std::sync::OnceLock;

use anyhow::Result;
use glam::DVec2;
use rstar::RTree;
use rstar::primitives::Line;
use terrain_tiles::address::{Side, TileAddress};
use terrain_tiles::ellipsoid::to_geodetic;
use terrain_tiles::tile::Tile;

use super::deviation::Worst;
use super::drawing::{Drawing, boundary_edges};
use super::sides::{MOVED_ONTO_A_SIDE, side_of};
use super::source::{Block, Patch, Source};
use super::source_outline::{NearOutline, distance};
use super::space::{Earth, Space};
use super::surface::Surface;

/// The outline of one level of a tile.
pub(super) struct Outline {
    edges: Vec<[u32; 2]>,
    /// Grid positions that have to be near the source's outline; if `true`, only where the source has nothing.
    places: Vec<(DVec2, bool)>,
    /// What is left to the tiles across its sides.
    strips: Vec<Strip>,
    /// The edges as seen on the ellipsoid, once somebody asks.
    pieces: OnceLock<RTree<Line<[f64; 3]>>>,
}

impl Outline {
    /// `neighbours` says across which sides there is a tile of the same zoom.
    pub(super) fn new(tile: &Tile, earth: &Earth, drawing: &Drawing, surface: &Surface, neighbours: [bool; 4]) -> Self {
        let edges = boundary_edges(&drawing.triangles);
        let side = |edge: &[u32; 2]| side_of(tile, edge.map(|end| drawing.positions[end as usize]));
        let mut places = Vec::new();
        for &[from, to] in edges.iter().filter(|edge| side(edge).is_none()) {
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
        let strips = strips(tile, neighbours, |wanted| {
            let on_it = edges.iter().filter(move |edge| side(edge) == Some(wanted));
            let middle = |edge: &[u32; 2]| {
                let [a, b] = edge.map(|end| surface.positions[end as usize]);
                to_geodetic((a + b) / 2.0).latitude
            };
            on_it.map(middle).collect()
        });
        Self {
            edges,
            places,
            strips,
            pieces: OnceLock::new(),
        }
    }

    /// Plan distance of the farthest of `left_out`, posts that no triangle covers, from the mesh. Those that a straight
    /// side leaves to the tile across it are that tile's.
    pub(super) fn uncovered(&self, earth: &Earth, surface: &Surface, left_out: &[(usize, usize)]) -> Worst {
        let mut worst = Worst::default();
        for &(column, row) in left_out {
            let post = DVec2::new(column as f64, row as f64);
            let place = earth.source.georeference.geographic(post);
            if !self.strips.iter().any(|strip| strip.holds(place)) {
                let pieces = self.pieces.get_or_init(|| self.on_ellipsoid(earth, surface));
                worst.meet(distance(pieces, earth.source.on_ellipsoid(post)), post);
            }
        }
        worst
    }

    /// Plan distance from the source's outline of the outline's vertices, and of its points and of `covered_voids`
    /// where the source has nothing; those in one block of `whole`.
    pub(super) fn excess(
        &self,
        source: &Source,
        patch: &Patch,
        whole: &Block,
        covered_voids: &[(usize, usize)],
        near: &mut NearOutline,
    ) -> Result<Worst> {
        let mut worst = Worst::default();
        let voids = covered_voids
            .iter()
            .map(|&(column, row)| DVec2::new(column as f64, row as f64));
        let here = self
            .places
            .iter()
            .filter(|(grid, _)| patch.block.contains(whole.nearest(*grid)));
        let outside = here.filter(|(grid, if_uncovered)| !(*if_uncovered && patch.covers(*grid)));
        for grid in voids.chain(outside.map(|(grid, _)| *grid)) {
            worst.meet(near.distance(source.on_ellipsoid(grid))?, grid);
        }
        Ok(worst)
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

fn is_on_the_square(tile: &Tile, drawing: &Drawing, vertex: u32) -> bool {
    let extent = (1_u64 << tile.extent_bits) as f64;
    let position = drawing.positions[vertex as usize];
    [position.x, position.y]
        .iter()
        .any(|&value| value == 0.0 || value == extent)
}

/// An edge as seen on the ellipsoid, in pieces of at most a cell.
fn pieces(earth: &Earth, surface: &Surface, edge: [u32; 2]) -> Vec<Line<[f64; 3]>> {
    let [a, b] = edge.map(|end| surface.positions[end as usize]);
    let [from, to] = edge.map(|end| surface.feet[end as usize].grid);
    let count = (to - from).abs().max_element().ceil().clamp(1.0, 1e6) as usize;
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

/// What each side with a neighbour may leave to it: what straight edges along a parallel bulge, and the few lattice units by
/// which an outline may be moved onto a side. `latitudes` gives those of the middles of the edges on a side.
fn strips(tile: &Tile, neighbours: [bool; 4], latitudes: impl Fn(Side) -> Vec<f64>) -> Vec<Strip> {
    let address = tile.address;
    let moved = MOVED_ONTO_A_SIDE * address.degrees() / (1_u64 << tile.extent_bits) as f64;
    let (west, south) = (address.west(), address.south());
    let strip = |side: Side| {
        let (is_meridian, degrees) = match side {
            Side::West => (true, west),
            Side::South => (false, south),
            Side::East => (true, west + address.degrees()),
            Side::North => (false, south + address.degrees()),
        };
        let middles = if is_meridian { Vec::new() } else { latitudes(side) };
        let bulges = middles.into_iter().map(|middle| (middle - degrees).abs());
        Strip {
            is_meridian,
            degrees,
            width: bulges.fold(moved, f64::max),
        }
    };
    let with_neighbour = Side::ALL.into_iter().filter(|&side| neighbours[side as usize]);
    with_neighbour.map(strip).collect()
}

/// Places so close to a meridian or a parallel.
struct Strip {
    is_meridian: bool,
    degrees: f64,
    width: f64,
}

impl Strip {
    fn holds(&self, place: DVec2) -> bool {
        let off = if self.is_meridian {
            let off = place.x - self.degrees;
            off - (off / 360.0).round() * 360.0
        } else {
            place.y - self.degrees
        };
        off.abs() <= self.width
    }
}

/// Which sides of a tile have a neighbour of the same zoom among the tiles for which `exists` holds.
pub(super) fn neighbours(address: TileAddress, exists: impl Fn(TileAddress) -> bool) -> [bool; 4] {
    Side::ALL.map(|side| address.neighbour(side).is_some_and(&exists))
}
