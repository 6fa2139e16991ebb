//! Quantized-mesh 1.0, the terrain tiles of CesiumJS, cesium-native and others: encoder here, decoder in [`decode`].
//!
//! After *quantized-mesh-1.0 terrain format*, Analytical Graphics 2013, with its extensions 1 (oct-encoded normals) and 2 (water
//! mask) and one of ours, 200 (how many of the triangles are measured); `docs/formats/quantized-mesh.md` has the layout and says
//! how a tile of ours becomes one of these:
//!
//! ```text
//! the finest surface ─▶ round to 0…32767, complete to the whole square ─▶ number vertices by first use
//!     ─▶ round heights to a power-of-two step ─▶ normals, bounding sphere, horizon occlusion point ─▶ bytes
//! ```

pub(super) mod bounds;
mod decode;
mod encode;
#[cfg(test)]
#[path = "quantized_mesh/fixture_tests.rs"]
pub(super) mod fixture;
mod from_tile;
mod in_mercator;
mod measured;
mod sides;
mod square;
mod validate;

use glam::DVec3;

pub use decode::{QuantizedMeshError, QuantizedMeshLimits, decode};
pub use encode::{Extensions, encode};
pub use in_mercator::{addresses_for, addresses_under};
pub use validate::{Fault, validate};

use terrain_codec::address::{Rectangle, Side};
use terrain_codec::ellipsoid::Geodetic;

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
    /// Where there is water, as [`crate::water::Water::mask`] has it; none where the tile has no such extension.
    pub water_mask: Option<Vec<u8>>,
    /// How many of the triangles, from the first, are measured; the rest completes the square. Tiles of other makers do
    /// not say.
    pub measured_triangles: Option<u32>,
}

impl QuantizedMesh {
    /// Longitude, latitude and height of vertex `index` of this mesh of a tile, as clients work them out.
    ///
    /// # Panics
    /// When there is no such vertex.
    #[must_use]
    pub fn geodetic(&self, tile: impl Into<Rectangle>, index: usize) -> Geodetic {
        geodetic(tile.into(), self.heights, self.vertices[index])
    }
}

fn geodetic(tile: Rectangle, heights: [f32; 2], vertex: Vertex) -> Geodetic {
    let fraction = |coordinate: u16| f64::from(coordinate) / f64::from(EXTENT);
    let [lowest, highest] = heights.map(f64::from);
    let [longitude, latitude] = tile.place([vertex.u, vertex.v].map(fraction));
    Geodetic {
        longitude,
        latitude,
        height: lowest + fraction(vertex.height) * (highest - lowest),
    }
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

#[cfg(test)]
#[path = "quantized_mesh_tests.rs"]
mod tests;
