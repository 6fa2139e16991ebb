//! Normals that neighbours share: along a side they are made from the triangles of all tiles that meet there.
//!
//! ```text
//! area   ← vectors of a tile's triangles as long as their areas, summed at each vertex; not those of the strips along its sides and along
//!          its children's, which are steps of a few metres that are a few centimetres wide
//! wide   ← at a vertex that has none, all its triangles being in strips: those at the vertices beside it
//! side   ← the wide sums of all tiles at the place, in the order of their addresses: bit-equal in all of them
//! pole   ← the ellipsoid's normal
//! inner  ← at vertices across the strip from a side, the mean of the side's normals there: no edge shows in the shading
//! ```

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use terrain_core::Mesh;

use crate::address::{Side, TileAddress};
use crate::ellipsoid::normal;
use crate::tile::{Detail, STRIP, Tile};

/// Bits of a place along a tile's side by which tiles of finer and coarser lattices know it.
const PLACE_BITS: u8 = 40;

/// Column and row of a place on the whole Earth, in 2^[`PLACE_BITS`]ths of a tile; of the two columns of the antimeridian, the first.
type Place = [i128; 2];

/// Surfaces of tiles, with normals that they share where they meet.
pub(in crate::formats) struct SharedNormals<'a> {
    surfaces: BTreeMap<TileAddress, Shaded<'a>>,
    /// By zoom and place, sums of vectors of all these tiles at vertices that are on sides or in strips.
    wide: HashMap<(u8, Place), DVec3>,
}

impl<'a> SharedNormals<'a> {
    /// Of surfaces of tiles at some detail, one of each. Normals at a place are those that all tiles there have if all of them are given.
    pub(in crate::formats) fn of(surfaces: impl IntoIterator<Item = (&'a Tile, Detail)>) -> Self {
        let surfaces: BTreeMap<TileAddress, Shaded> = surfaces
            .into_iter()
            .map(|(tile, detail)| (tile.address, Shaded::new(tile, tile.surface(detail))))
            .collect();
        let mut wide: HashMap<(u8, Place), DVec3> = HashMap::new();
        // In the order of addresses, so that all tiles at a place find the same bits there.
        for (address, surface) in &surfaces {
            for (place, sum) in surface.wide() {
                *wide.entry((address.zoom, place)).or_default() += sum;
            }
        }
        Self { surfaces, wide }
    }

    /// The surface of the tile at `address`, which has to be one of those given, and an Earth-centred unit normal for each of its vertices.
    pub(in crate::formats) fn surface(&self, address: TileAddress) -> (&Mesh, Vec<DVec3>) {
        let surface = &self.surfaces[&address];
        (&surface.mesh, self.normals(surface))
    }

    fn normals(&self, surface: &Shaded) -> Vec<DVec3> {
        let on_sides: Vec<Option<DVec3>> = (0..surface.places.len())
            .map(|vertex| surface.is_wide(vertex).then(|| self.at(surface, vertex)).flatten())
            .collect();
        let mut across: HashMap<u32, DVec3> = HashMap::new();
        for &[a, b, c] in &surface.mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]] {
                if let Some(normal) = on_sides[from as usize]
                    && !surface.is_wide(to as usize)
                {
                    *across.entry(to).or_default() += normal;
                }
            }
        }
        let up = |vertex: usize| {
            let place = surface.tile.geodetic(surface.mesh.positions[vertex]);
            normal(place.longitude, place.latitude)
        };
        let shaded = |vertex: usize| {
            let sum = on_sides[vertex].or_else(|| across.get(&(vertex as u32)).copied());
            let sum = sum.unwrap_or(surface.area[vertex]);
            sum.try_normalize().unwrap_or_else(|| up(vertex))
        };
        (0..surface.places.len()).map(shaded).collect()
    }

    /// The unit normal at a vertex on a side or in a strip.
    fn at(&self, surface: &Shaded, vertex: usize) -> Option<DVec3> {
        let (zoom, place) = (surface.tile.address.zoom, surface.places[vertex]);
        // At a pole, triangles are slivers, and vertices of all tiles are at one place.
        match place[1] {
            0 => Some(DVec3::NEG_Z),
            row if row == 1 << (PLACE_BITS + zoom) => Some(DVec3::Z),
            _ => self.wide.get(&(zoom, place))?.try_normalize(),
        }
    }
}

/// A surface of a tile with what its triangles say of normals.
struct Shaded<'a> {
    tile: &'a Tile,
    mesh: Mesh,
    places: Vec<Place>,
    area: Vec<DVec3>,
    is_on_side: Vec<bool>,
    /// Whether all triangles at a vertex are in strips.
    is_in_strips: Vec<bool>,
}

impl<'a> Shaded<'a> {
    fn new(tile: &'a Tile, mesh: Mesh) -> Self {
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
        let on_side = |at: &DVec3| at.x == 0.0 || at.y == 0.0 || at.x == extent || at.y == extent;
        let shift = PLACE_BITS - tile.extent_bits.min(PLACE_BITS);
        let columns = 2_i128 << (tile.address.zoom + PLACE_BITS);
        let place = |at: &DVec3| {
            let [x, y] = [(at.x, tile.address.x), (at.y, tile.address.y)]
                .map(|(along, number)| ((along as i128) << shift) + (i128::from(number) << PLACE_BITS));
            [x.rem_euclid(columns), y]
        };
        Self {
            is_on_side: mesh.positions.iter().map(on_side).collect(),
            places: mesh.positions.iter().map(place).collect(),
            area,
            is_in_strips,
            tile,
            mesh,
        }
    }

    fn is_wide(&self, vertex: usize) -> bool {
        self.is_on_side[vertex] || self.is_in_strips[vertex]
    }

    /// Sums at the vertices beside those on sides and those that are in strips.
    fn wide(&self) -> HashMap<Place, DVec3> {
        let mut sums: HashMap<Place, DVec3> = HashMap::new();
        for &[a, b, c] in &self.mesh.triangles {
            for corners in [[a, b, c], [b, c, a], [c, a, b]] {
                let [vertex, next, last] = corners.map(|corner| corner as usize);
                if self.is_wide(vertex) {
                    *sums.entry(self.places[vertex]).or_default() += self.area[next] + self.area[last];
                }
            }
        }
        sums
    }
}

/// The addresses of the tiles around one, those that there can be.
#[must_use]
pub fn addresses_around(address: TileAddress) -> Vec<TileAddress> {
    let beside = |address: Option<TileAddress>, side: Side| address.and_then(|address| address.neighbour(side));
    let all = [Side::South, Side::North].into_iter().flat_map(|side| {
        let row = beside(Some(address), side);
        [row, beside(row, Side::West), beside(row, Side::East)]
    });
    let row = [beside(Some(address), Side::West), beside(Some(address), Side::East)];
    let mut around: Vec<TileAddress> = all.chain(row).flatten().filter(|&other| other != address).collect();
    around.sort_unstable();
    around.dedup();
    around
}

#[cfg(test)]
#[path = "normals_tests.rs"]
mod tests;
