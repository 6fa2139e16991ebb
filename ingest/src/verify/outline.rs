//! How far the outline of a tile's mesh is from the outline of the source, in plan view and both ways: samples that
//! the mesh leaves out, and mesh where the source has nothing.

use glam::DVec2;
use rstar::RTree;
use rstar::primitives::Line;
use terrain_core::Mesh;
use terrain_tiles::address::{Side, TileAddress};
use terrain_tiles::ellipsoid::to_geodetic;
use terrain_tiles::tile::Tile;

use super::deviation::Worst;
use super::reference::{Post, Reference, distance};
use super::sides::side_of;
use super::space::{Earth, Space};
use super::surface::{Surface, boundary_edges};
use super::window::Window;

/// The outline of one level of a tile.
pub(super) struct Outline<'a> {
    tile: &'a Tile,
    earth: &'a Earth<'a>,
    mesh: &'a Mesh,
    surface: &'a Surface,
    edges: Vec<[u32; 2]>,
}

impl<'a> Outline<'a> {
    pub(super) fn new(tile: &'a Tile, earth: &'a Earth<'a>, mesh: &'a Mesh, surface: &'a Surface) -> Self {
        Self {
            tile,
            earth,
            mesh,
            surface,
            edges: boundary_edges(&mesh.triangles),
        }
    }

    /// Plan distance of the sample of the source that is farthest from the mesh. Samples that a straight side leaves
    /// to the tile across it are that tile's; `neighbours` says which sides have one.
    pub(super) fn uncovered(&self, window: &Window, covered: &[bool], neighbours: [bool; 4]) -> Worst {
        let left_over: Vec<(usize, usize)> = window
            .posts()
            .filter(|&(index, (column, row))| {
                window.inside[index] && !covered[index] && self.reference().post(column, row) == Post::Surface
            })
            .map(|(_, post)| post)
            .collect();
        let mut worst = Worst::default();
        if left_over.is_empty() {
            return worst;
        }
        let left_to_neighbours = self.bulges(neighbours);
        let pieces = RTree::bulk_load(self.edges.iter().flat_map(|&edge| self.pieces(edge)).collect());
        for (column, row) in left_over {
            let post = DVec2::new(column as f64, row as f64);
            let place = self.reference().grid.georeference.geographic(post);
            if !left_to_neighbours.iter().any(|strip| strip.holds(place)) {
                worst.meet(distance(&pieces, self.reference().on_ellipsoid(post)), post);
            }
        }
        worst
    }

    /// Plan distance from the source's outline of the outline's vertices, and of its points and of `covered_voids`
    /// where the source has nothing.
    pub(super) fn excess(&self, covered_voids: &[(usize, usize)]) -> Worst {
        let mut worst = Worst::default();
        let voids = covered_voids
            .iter()
            .map(|&(column, row)| DVec2::new(column as f64, row as f64));
        let open = self.edges.iter().filter(|&&edge| self.side(edge).is_none());
        let (mut places, mut vertices): (Vec<DVec2>, Vec<u32>) = (voids.collect(), Vec::new());
        for &[from, to] in open {
            let [a, b] = [from, to].map(|end| self.surface.positions[end as usize]);
            let along = [1.0 / 3.0, 0.5, 2.0 / 3.0].map(|part| self.earth.foot(a.lerp(b, part)).grid);
            places.extend(along.into_iter().filter(|&grid| !self.reference().covers(grid)));
            vertices.extend([from, to].into_iter().filter(|&vertex| !self.is_on_the_square(vertex)));
        }
        places.extend(
            vertices
                .into_iter()
                .map(|vertex| self.surface.feet[vertex as usize].grid),
        );
        for grid in places {
            worst.meet(
                self.reference().outline_distance(self.reference().on_ellipsoid(grid)),
                grid,
            );
        }
        worst
    }

    fn reference(&self) -> &Reference<'a> {
        self.earth.reference
    }

    fn side(&self, edge: [u32; 2]) -> Option<Side> {
        side_of(self.tile, edge.map(|end| self.mesh.positions[end as usize]))
    }

    fn is_on_the_square(&self, vertex: u32) -> bool {
        let extent = (1_u64 << self.tile.extent_bits) as f64;
        let position = self.mesh.positions[vertex as usize];
        [position.x, position.y]
            .iter()
            .any(|&value| value == 0.0 || value == extent)
    }

    /// An edge as seen on the ellipsoid, in pieces of at most a cell.
    fn pieces(&self, edge: [u32; 2]) -> impl Iterator<Item = Line<[f64; 3]>> + use<> {
        let [a, b] = edge.map(|end| self.surface.positions[end as usize]);
        let [from, to] = edge.map(|end| self.surface.feet[end as usize].grid);
        let count = (to - from).abs().max_element().ceil().clamp(1.0, 1e6) as usize;
        let points: Vec<[f64; 3]> = (0..=count)
            .map(|i| self.earth.foot(a.lerp(b, i as f64 / count as f64)).grid)
            .map(|grid| self.reference().on_ellipsoid(grid).to_array())
            .collect();
        let lines: Vec<_> = points
            .windows(2)
            .filter(|p| p[0] != p[1])
            .map(|p| Line::new(p[0], p[1]))
            .collect();
        lines.into_iter()
    }

    /// What each side with a neighbour may leave to it: what straight edges along a parallel bulge, and the few lattice units
    /// by which an outline may be moved onto a side.
    fn bulges(&self, neighbours: [bool; 4]) -> Vec<Strip> {
        const MOVED: f64 = 5.0;
        let address = self.tile.address;
        let moved = MOVED * address.degrees() / (1_u64 << self.tile.extent_bits) as f64;
        let (west, south) = (address.west(), address.south());
        let strip = |side: Side| {
            let (is_meridian, degrees) = match side {
                Side::West => (true, west),
                Side::South => (false, south),
                Side::East => (true, west + address.degrees()),
                Side::North => (false, south + address.degrees()),
            };
            let on_it = self.edges.iter().filter(|&&edge| self.side(edge) == Some(side));
            let bulge = on_it.filter(|_| !is_meridian).map(|edge| {
                let [a, b] = edge.map(|end| self.surface.positions[end as usize]);
                (to_geodetic((a + b) / 2.0).latitude - degrees).abs()
            });
            Strip {
                is_meridian,
                degrees,
                width: bulge.fold(moved, f64::max),
            }
        };
        let with_neighbour = Side::ALL.into_iter().filter(|&side| neighbours[side as usize]);
        with_neighbour.map(strip).collect()
    }
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
