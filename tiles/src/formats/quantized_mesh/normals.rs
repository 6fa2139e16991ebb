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

use std::collections::HashMap;

use glam::DVec3;
use terrain_core::Mesh;

use crate::address::{Side, TileAddress};
use crate::ellipsoid::normal;
use crate::tile::{STRIP, Tile};

/// Bits of a place along a tile's side by which tiles of finer and coarser lattices know it.
const PLACE_BITS: u8 = 40;

/// Column and row of a place on the whole Earth, in 2^[`PLACE_BITS`]ths of a tile.
type Place = [i128; 2];

/// The finest surface of a tile with what its triangles say of normals.
struct Shaded<'a> {
    address: TileAddress,
    mesh: &'a Mesh,
    places: Vec<Place>,
    area: Vec<DVec3>,
    is_on_side: Vec<bool>,
    /// Whether all triangles at a vertex are in strips.
    is_in_strips: Vec<bool>,
}

impl<'a> Shaded<'a> {
    /// `mesh` is the tile's finest surface.
    fn new(tile: &Tile, mesh: &'a Mesh) -> Self {
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
        let address = tile.address;
        let place = |at: &DVec3| {
            [(at.x, address.x), (at.y, address.y)]
                .map(|(along, number)| ((along as i128) << shift) + (i128::from(number) << PLACE_BITS))
        };
        Self {
            address,
            is_on_side: mesh.positions.iter().map(on_side).collect(),
            places: mesh.positions.iter().map(place).collect(),
            area,
            is_in_strips,
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

/// A unit normal, Earth-centred, for each vertex of `mesh`, the finest surface of `tile`; `beside` are the tiles around it, those that
/// there are.
pub(in crate::formats) fn shared_normals<'a>(
    tile: &Tile,
    mesh: &Mesh,
    beside: impl IntoIterator<Item = &'a Tile>,
) -> Vec<DVec3> {
    let own = Shaded::new(tile, mesh);
    let along_sides = side_normals(&own, beside);
    let side_normal = |vertex: usize| along_sides.get(&own.places[vertex]).copied();
    let mut across: HashMap<u32, DVec3> = HashMap::new();
    for &[a, b, c] in &own.mesh.triangles {
        for [from, to] in [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]] {
            if let Some(normal) = side_normal(from as usize)
                && !own.is_wide(to as usize)
            {
                *across.entry(to).or_default() += normal;
            }
        }
    }
    let up = |vertex: usize| {
        let place = tile.geodetic(own.mesh.positions[vertex]);
        normal(place.longitude, place.latitude)
    };
    let shaded = |vertex: usize| {
        let sum = side_normal(vertex).or_else(|| across.get(&(vertex as u32)).copied());
        let sum = sum.unwrap_or(own.area[vertex]);
        sum.try_normalize().unwrap_or_else(|| up(vertex))
    };
    (0..own.mesh.positions.len()).map(shaded).collect()
}

/// Unit normals at the places of a tile that are on its sides or in strips.
fn side_normals<'a>(own: &Shaded, beside: impl IntoIterator<Item = &'a Tile>) -> HashMap<Place, DVec3> {
    let columns = i128::from(2_u64 << own.address.zoom) << PLACE_BITS;
    let mut tiles: Vec<(TileAddress, HashMap<Place, DVec3>)> = beside
        .into_iter()
        .map(|tile| (tile.address, Shaded::new(tile, &tile.surface(tile.finest())).wide()))
        .collect();
    tiles.push((own.address, own.wide()));
    tiles.sort_by_key(|&(address, _)| address);
    let wide = (0..own.places.len()).filter(|&vertex| own.is_wide(vertex));
    let rows = i128::from(1_u64 << own.address.zoom) << PLACE_BITS;
    let summed = |&place: &Place| {
        // At a pole, triangles are slivers, and vertices of all tiles are at one place.
        if place[1] == 0 || place[1] == rows {
            return Some((place, if place[1] == 0 { DVec3::NEG_Z } else { DVec3::Z }));
        }
        // The antimeridian is the first column and the one after the last.
        let turned = [[place[0] + columns, place[1]], [place[0] - columns, place[1]]];
        let all = tiles.iter().flat_map(|(_, wide)| {
            [place, turned[0], turned[1]]
                .into_iter()
                .filter_map(|place| wide.get(&place))
        });
        all.copied()
            .sum::<DVec3>()
            .try_normalize()
            .map(|normal| (place, normal))
    };
    wide.filter_map(|vertex| summed(&own.places[vertex])).collect()
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
