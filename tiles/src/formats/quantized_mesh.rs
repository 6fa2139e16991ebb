//! Quantized-mesh 1.0, the terrain tiles of CesiumJS, cesium-native and others: encoder here, decoder in [`decode`].
//!
//! After *quantized-mesh-1.0 terrain format*, Analytical Graphics 2013, with its extension 1 (oct-encoded normals) and
//! one of ours, 200 (how many of the triangles are measured); `docs/formats/quantized-mesh.md` has the layout and says
//! how a tile of ours becomes one of these:
//!
//! ```text
//! the finest surface ─▶ round to 0…32767, complete to the whole square ─▶ number vertices by first use
//!     ─▶ round heights to a power-of-two step ─▶ normals, bounding sphere, horizon occlusion point ─▶ bytes
//! ```

mod bounds;
mod decode;
mod encode;
mod square;
mod validate;

use glam::DVec3;

pub use decode::{QuantizedMeshError, QuantizedMeshLimits, decode};
pub use encode::encode;
pub use validate::{Fault, validate};

use crate::address::{Side, TileAddress};
use crate::ellipsoid::{Geodetic, normal, to_earth_centred};
use crate::tile::Tile;
use square::CompletedSquare;

/// Largest value of a vertex coordinate: the east and the north side, and the largest height.
pub const EXTENT: u16 = 32_767;

/// A vertex in fractions of the tile's square and of its range of heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Vertex {
    /// 0 on the west side, [`EXTENT`] on the east side.
    pub u: u16,
    /// 0 on the south side, [`EXTENT`] on the north side.
    pub v: u16,
    /// 0 at the lowest height, [`EXTENT`] at the highest.
    pub height: u16,
}

/// What a quantized-mesh tile says.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantizedMesh {
    /// Earth-centred metres; clients place the tile's vertices relative to it.
    pub center: DVec3,
    /// Metres above the ellipsoid that heights 0 and [`EXTENT`] stand for.
    pub heights: [f32; 2],
    /// Centre in Earth-centred metres of a sphere around all vertices.
    pub sphere_center: DVec3,
    /// Its radius in metres.
    pub sphere_radius: f64,
    /// When this point is behind the ellipsoid, so is the whole tile. Earth-centred, each axis in units of the
    /// ellipsoid's semi-axis along it.
    pub horizon_occlusion_point: DVec3,
    /// In the order in which the triangles use them first.
    pub vertices: Vec<Vertex>,
    /// Counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices on each side, in the order of [`Side::ALL`]: the west one northwards, then on clockwise around the
    /// tile, the order in which clients hang skirts on them.
    pub edges: [Vec<u32>; 4],
    /// A unit vector for each vertex, oct-encoded, Earth-centred; none where the tile has no such extension.
    pub normals: Option<Vec<[u8; 2]>>,
    /// How many of the triangles, from the first, are measured; the rest completes the square. Tiles of other makers do
    /// not say.
    pub measured_triangles: Option<u32>,
}

impl QuantizedMesh {
    /// The finest surface of `tile`, completed to its whole square at height 0.
    #[must_use]
    pub fn from_tile(tile: &Tile) -> Self {
        let mesh = tile.surface(tile.finest());
        Self::from_surface(
            tile.address,
            square::complete(&mesh, tile.extent_bits, tile.address.zoom),
        )
    }

    /// The bare ellipsoid over the square of `address`: height 0, nothing measured.
    #[must_use]
    pub fn ellipsoid(address: TileAddress) -> Self {
        let nothing = terrain_core::Mesh::default();
        Self::from_surface(address, square::complete(&nothing, 1, address.zoom))
    }

    fn from_surface(address: TileAddress, surface: CompletedSquare) -> Self {
        let surface = number_by_first_use(surface);
        let scale = HeightScale::over(surface.points.iter().map(|point| point.height));
        let vertices: Vec<Vertex> = surface
            .points
            .iter()
            .map(|point| Vertex {
                u: point.u,
                v: point.v,
                height: scale.round(point.height),
            })
            .collect();
        let heights = scale.ends();
        let positions: Vec<DVec3> = vertices
            .iter()
            .map(|vertex| to_earth_centred(geodetic(address, heights, *vertex)))
            .collect();
        let (sphere_center, sphere_radius) = bounds::sphere(&positions);
        let normals = vertex_normals(address, &vertices, &positions, &surface.triangles);
        Self {
            center: sphere_center,
            heights,
            sphere_center,
            sphere_radius,
            horizon_occlusion_point: bounds::horizon_occlusion_point(sphere_center, &positions),
            edges: edge_lists(&vertices, &surface.triangles),
            vertices,
            triangles: surface.triangles,
            normals: Some(normals.into_iter().map(bounds::oct_encode).collect()),
            measured_triangles: Some(surface.measured),
        }
    }

    /// Longitude, latitude and height of vertex `index` of this mesh at `address`, as clients work them out.
    ///
    /// # Panics
    /// When there is no such vertex.
    #[must_use]
    pub fn geodetic(&self, address: TileAddress, index: usize) -> Geodetic {
        geodetic(address, self.heights, self.vertices[index])
    }
}

/// Unit normal of the oct-encoded `bytes`.
#[must_use]
pub fn oct_decode(bytes: [u8; 2]) -> DVec3 {
    bounds::oct_decode(bytes)
}

fn geodetic(address: TileAddress, heights: [f32; 2], vertex: Vertex) -> Geodetic {
    let fraction = |coordinate: u16| f64::from(coordinate) / f64::from(EXTENT);
    let [lowest, highest] = heights.map(f64::from);
    Geodetic {
        longitude: address.west() + fraction(vertex.u) * address.degrees(),
        latitude: address.south() + fraction(vertex.v) * address.degrees(),
        height: lowest + fraction(vertex.height) * (highest - lowest),
    }
}

/// Renumbers the vertices in the order in which the triangles use them, which is what high-water-mark coding wants;
/// those that no triangle uses go.
fn number_by_first_use(surface: CompletedSquare) -> CompletedSquare {
    let mut numbers = vec![u32::MAX; surface.points.len()];
    let mut points = Vec::with_capacity(surface.points.len());
    let mut number = |old: u32| {
        let slot = &mut numbers[old as usize];
        if *slot == u32::MAX {
            *slot = points.len() as u32;
            points.push(surface.points[old as usize]);
        }
        *slot
    };
    let triangles = surface
        .triangles
        .iter()
        .map(|triangle| triangle.map(&mut number))
        .collect();
    CompletedSquare {
        points,
        triangles,
        measured: surface.measured,
    }
}

/// How metres become 0…[`EXTENT`]: in whole steps of a power of two, counted from height 0. Tiles with one step agree
/// bit for bit where they share a vertex, and exactly with the source when the step divides its own; tiles with
/// different steps differ by half the larger one at most.
struct HeightScale {
    /// Metres.
    step: f64,
    /// The lowest height in steps from 0.
    lowest: f64,
    /// The highest height in steps from 0.
    highest: f64,
}

impl HeightScale {
    /// Below a thousandth of a millimetre a finer step is of no use.
    const SMALLEST_EXPONENT: i32 = -20;

    /// The smallest step in which the range fits. Both ends are then exact in the header's `f32`, too, whose 24 bits
    /// hold any count of steps below 2^24.
    fn over(heights: impl Iterator<Item = f64>) -> Self {
        let (lowest, highest) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        let mut step = f64::from(Self::SMALLEST_EXPONENT).exp2();
        loop {
            let scale = Self {
                step,
                lowest: (lowest / step).floor(),
                highest: (highest / step).ceil(),
            };
            let fits = scale.highest - scale.lowest <= f64::from(EXTENT);
            let exact = scale.lowest.abs() + f64::from(EXTENT) < f64::from(1 << 24);
            // Not a number and infinity never fit; they end here.
            if (fits && exact) || step > f64::from(1 << 24) {
                return scale;
            }
            step *= 2.0;
        }
    }

    fn round(&self, height: f64) -> u16 {
        (height / self.step - self.lowest).round() as u16
    }

    /// What 0 and [`EXTENT`] stand for; the same where all heights are one.
    fn ends(&self) -> [f32; 2] {
        let span = if self.highest > self.lowest {
            f64::from(EXTENT)
        } else {
            0.0
        };
        [self.lowest, self.lowest + span].map(|steps| (steps * self.step) as f32)
    }
}

/// Averages of the triangles around each vertex, weighted by area. Walls do not count: they would darken the rim of the
/// ground they stand on. On a side the neighbouring vertices' triangles count, too: a side's own may all be slivers, whose
/// slope says nothing and would show as a line along the tile's border. At a pole, where a side is one point, the ellipsoid's normal steps in.
fn vertex_normals(
    address: TileAddress,
    vertices: &[Vertex],
    positions: &[DVec3],
    triangles: &[[u32; 3]],
) -> Vec<DVec3> {
    let level = || triangles.iter().filter(|triangle| plan_area(vertices, **triangle) > 0);
    let mut sums = vec![DVec3::ZERO; vertices.len()];
    for triangle in level() {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let area_vector = (b - a).cross(c - a);
        triangle.iter().for_each(|&vertex| sums[vertex as usize] += area_vector);
    }
    let around = sums.clone();
    for &[a, b, c] in level() {
        for [vertex, next, last] in
            [[a, b, c], [b, c, a], [c, a, b]].map(|corners| corners.map(|corner| corner as usize))
        {
            if is_on_any_side(vertices[vertex]) {
                sums[vertex] += around[next] + around[last];
            }
        }
    }
    let up = |vertex: &Vertex| {
        let place = geodetic(address, [0.0; 2], *vertex);
        normal(place.longitude, place.latitude)
    };
    sums.iter()
        .zip(vertices)
        .map(|(sum, vertex)| sum.try_normalize().unwrap_or_else(|| up(vertex)))
        .collect()
}

/// Twice the area in plan view, in squared coordinate units; 0 for a wall, negative for a triangle seen from below.
fn plan_area(vertices: &[Vertex], triangle: [u32; 3]) -> i64 {
    let [a, b, c] = triangle.map(|vertex| {
        let Vertex { u, v, .. } = vertices[vertex as usize];
        (i64::from(u), i64::from(v))
    });
    (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1)
}

/// A vertex's coordinate across the side (0 or [`EXTENT`] when it is on it) and along it, growing clockwise around the
/// tile as seen from above.
fn across_and_along(side: Side, vertex: Vertex) -> (u16, u16) {
    match side {
        Side::West => (vertex.u, vertex.v),
        Side::North => (EXTENT - vertex.v, vertex.u),
        Side::East => (EXTENT - vertex.u, EXTENT - vertex.v),
        Side::South => (vertex.v, EXTENT - vertex.u),
    }
}

fn is_on_any_side(vertex: Vertex) -> bool {
    Side::ALL.iter().any(|&side| across_and_along(side, vertex).0 == 0)
}

/// The vertices on each side. Where measured ground ends at a fill, two are at one place; the one that belongs to the
/// part before it comes first, so that a skirt follows the step.
fn edge_lists(vertices: &[Vertex], triangles: &[[u32; 3]]) -> [Vec<u32>; 4] {
    Side::ALL.map(|side| {
        let place = |index: u32| across_and_along(side, vertices[index as usize]);
        let on_side = |index: u32| place(index).0 == 0;
        let mut rank = vec![1_u8; vertices.len()];
        let directed = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        for (start, end) in directed.filter(|&(a, b)| on_side(a) && on_side(b)) {
            // Counter-clockwise triangles run against the clock on the tile's border; walls run nowhere.
            if place(start).1 > place(end).1 {
                rank[start as usize] = 0;
                if rank[end as usize] != 0 {
                    rank[end as usize] = 2;
                }
            }
        }
        let mut list: Vec<u32> = (0..vertices.len() as u32).filter(|&index| on_side(index)).collect();
        list.sort_by_key(|&index| (place(index).1, rank[index as usize]));
        list
    })
}

#[cfg(test)]
#[path = "quantized_mesh_tests.rs"]
mod tests;
