//! What the triangles of a tile's finest surface say of normals.
//!
//! ```text
//! area   ← vectors of the triangles, as long as their areas, summed at each vertex; not those of the strips along the tile's sides and along
//!          its children's, which are steps of a few metres that are a few centimetres wide
//! wide   ← at a vertex on a side, or one that has none, all its triangles being in strips: the sums at the vertices beside it
//! ```

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use terrain_core::Mesh;

use terrain_codec::ellipsoid::normal;
use terrain_codec::tile::{STRIP, Tile};

/// Bits of a place along a tile's side by which tiles of finer and coarser lattices know it.
pub(super) const PLACE_BITS: u8 = 40;

/// Column and row of a place on the whole Earth, in 2^[`PLACE_BITS`]ths of a tile; of the two columns of the antimeridian, the first.
pub(super) type Place = [i128; 2];

/// Where a lattice position of a tile is.
pub(super) fn place_of(tile: &Tile, position: DVec3) -> Place {
    let shift = PLACE_BITS - tile.extent_bits.min(PLACE_BITS);
    let columns = 2_i128 << (tile.address.zoom + PLACE_BITS);
    let [x, y] = [(position.x, tile.address.x), (position.y, tile.address.y)]
        .map(|(along, number)| ((along as i128) << shift) + (i128::from(number) << PLACE_BITS));
    [x.rem_euclid(columns), y]
}

/// The same place for tiles of the zoom above; none where their lattice has none.
pub(super) fn place_above(place: Place) -> Option<Place> {
    place
        .iter()
        .all(|along| along % 2 == 0)
        .then(|| place.map(|along| along / 2))
}

/// A tile's finest surface, and sums at its vertices.
pub(super) struct Sums {
    pub(super) tile: Arc<Tile>,
    pub(super) mesh: Arc<Mesh>,
    pub(super) places: Vec<Place>,
    pub(super) area: Vec<DVec3>,
    pub(super) wide: HashMap<Place, DVec3>,
    /// Whether a vertex is on a side, or all its triangles are in strips.
    is_wide: Vec<bool>,
}

impl Sums {
    pub(super) fn of(tile: Tile) -> Self {
        let mesh = tile.surface(tile.finest());
        let positions: Vec<DVec3> = mesh.positions.iter().map(|&at| tile.earth_centred(at)).collect();
        let mut area = vec![DVec3::ZERO; positions.len()];
        let mut is_in_strips = vec![true; positions.len()];
        let extent = (1_i64 << tile.extent_bits) as f64;
        let is_strip = |triangle: &[u32; 3]| {
            let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
            [0.0, extent / 2.0, extent].iter().any(|line| {
                let is_near =
                    |along: fn(&DVec3) -> f64| corners.iter().all(|at| (along(at) - line).abs() <= STRIP as f64);
                is_near(|at| at.x) || is_near(|at| at.y)
            })
        };
        for &triangle in mesh.triangles.iter().filter(|triangle| !is_strip(triangle)) {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            let vector = (b - a).cross(c - a);
            for vertex in triangle {
                area[vertex as usize] += vector;
                is_in_strips[vertex as usize] = false;
            }
        }
        let is_on_side = |at: &DVec3| at.x == 0.0 || at.y == 0.0 || at.x == extent || at.y == extent;
        let vertices = mesh.positions.iter().zip(is_in_strips);
        let is_wide: Vec<bool> = vertices.map(|(at, in_strips)| in_strips || is_on_side(at)).collect();
        let places: Vec<Place> = mesh.positions.iter().map(|&at| place_of(&tile, at)).collect();
        let mut wide: HashMap<Place, DVec3> = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for corners in [[a, b, c], [b, c, a], [c, a, b]] {
                let [vertex, next, last] = corners.map(|corner| corner as usize);
                if is_wide[vertex] {
                    *wide.entry(places[vertex]).or_default() += area[next] + area[last];
                }
            }
        }
        Self {
            tile: Arc::new(tile),
            mesh: Arc::new(mesh),
            places,
            area,
            wide,
            is_wide,
        }
    }

    pub(super) fn is_wide(&self, vertex: usize) -> bool {
        self.is_wide[vertex]
    }

    /// The ellipsoid's normal at a vertex.
    pub(super) fn up(&self, vertex: usize) -> DVec3 {
        let place = self.tile.geodetic(self.mesh.positions[vertex]);
        normal(place.longitude, place.latitude)
    }

    /// The same at a pole alone: triangles are slivers there, and vertices of all tiles are at one place.
    pub(super) fn normal_of_pole(&self, vertex: usize) -> Option<DVec3> {
        let last = 1 << (PLACE_BITS + self.tile.address.zoom);
        match self.places[vertex][1] {
            0 => Some(DVec3::NEG_Z),
            row if row == last => Some(DVec3::Z),
            _ => None,
        }
    }
}
