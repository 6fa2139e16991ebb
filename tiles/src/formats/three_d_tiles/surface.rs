//! What of a tile is drawn, in space.

use glam::DVec3;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{normal, to_earth_centred};
use terrain_codec::tile::Detail;
use terrain_core::Mesh;

use super::packing::{Packing, half_diagonal};
use crate::formats::quantized_mesh::QuantizedMesh;
use crate::shading::{FinestSurface, oct_decode};

/// A surface in space whose positions are whole numbers of [`TileSurface::step`] from the Earth's centre: tiles of one zoom have them
/// from one lattice, and meet without a crack.
#[derive(Clone, Debug, PartialEq)]
pub struct TileSurface {
    /// Metres that positions are multiples of, along each axis: a power of two.
    pub step: f64,
    /// Earth-centred metres.
    pub positions: Vec<DVec3>,
    /// As many Earth-centred unit normals: those of the ellipsoid where nobody has shaded the surface.
    pub normals: Vec<DVec3>,
    /// Three vertices a triangle, counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices on each side, in the order of [`Side::ALL`](terrain_codec::address::Side::ALL), each list clockwise around the tile; none of a
    /// surface that does not cover the tile's square.
    pub sides: Option<[Vec<u32>; 4]>,
    /// How far the source may be from the triangles, in metres along the vertical, certified; none where nobody has certified it.
    pub error: Option<f64>,
}

impl TileSurface {
    /// A finest surface, no more.
    #[must_use]
    pub fn measured(surface: &FinestSurface, packing: Packing) -> Self {
        Self::of(surface, &surface.mesh, surface.tile.finest(), packing)
    }

    /// The surface of the tile whose finest is `finest` at a detail with the finest interior.
    #[must_use]
    pub fn at(finest: &FinestSurface, detail: Detail, packing: Packing) -> Self {
        Self::of(finest, &finest.tile.surface(detail), detail, packing)
    }

    fn of(finest: &FinestSurface, mesh: &Mesh, detail: Detail, packing: Packing) -> Self {
        let tile = &finest.tile;
        let exact: Vec<DVec3> = mesh.positions.iter().map(|&at| tile.earth_centred(at)).collect();
        let step = packing.step(tile.address);
        let ups: Vec<DVec3> = mesh
            .positions
            .iter()
            .map(|&at| tile.geodetic(at))
            .map(|place| normal(place.longitude, place.latitude))
            .collect();
        let at_vertices = mesh.positions.iter().map(|&at| finest.normal_at(at));
        let normals = at_vertices.zip(&ups).map(|(found, &up)| found.unwrap_or(up));
        let surface = Self {
            step,
            positions: rounded(&exact, step),
            normals: normals.collect(),
            triangles: mesh.triangles.clone(),
            sides: None,
            error: None,
        };
        let error = tile.error(detail) + surface.rounding_error(&ups);
        Self {
            error: error.is_finite().then_some(error),
            ..surface
        }
    }

    /// All of the square at `address`, as `mesh` completes it.
    #[must_use]
    pub fn whole_square(mesh: &QuantizedMesh, address: TileAddress, packing: Packing) -> Self {
        let places = (0..mesh.vertices.len()).map(|index| mesh.geodetic(address, index));
        let exact: Vec<DVec3> = places.map(to_earth_centred).collect();
        let normals = mesh.normals.iter().flatten().map(|&bytes| oct_decode(bytes));
        let step = packing.step(address);
        Self {
            step,
            positions: rounded(&exact, step),
            normals: normals.collect(),
            triangles: mesh.triangles.clone(),
            sides: Some(mesh.edges.clone()),
            error: None,
        }
    }

    /// How far in space rounding may have moved a place, metres.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        half_diagonal(self.step)
    }

    /// How far along the vertical rounding may have moved a triangle: as far across it, which is more the steeper it is. `ups` are the
    /// ellipsoid's normals at the vertices.
    fn rounding_error(&self, ups: &[DVec3]) -> f64 {
        let upwards = |&[a, b, c]: &[u32; 3]| {
            let [p, q, r] = [a, b, c].map(|vertex| self.positions[vertex as usize]);
            let across = (q - p).cross(r - p).normalize_or_zero();
            across.dot(ups[a as usize])
        };
        let flattest = self.triangles.iter().map(upwards).fold(1.0, f64::min);
        self.rounding() / flattest.max(0.0)
    }
}

fn rounded(exact: &[DVec3], step: f64) -> Vec<DVec3> {
    exact.iter().map(|&at| (at / step).round() * step).collect()
}
