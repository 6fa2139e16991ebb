//! Normals at the vertices of tiles' finest surfaces: the same in all tiles of a zoom that meet, and nearly the same from zoom to zoom.
//!
//! ```text
//! a tile and those around it, decoded ─▶ vectors of their triangles, summed at vertices (sums.rs)
//!     ─▶ side   at vertices on sides and in strips, the sums of all tiles there: bit-equal in all of them; at a pole, the ellipsoid's normal
//!     ─▶ inner  at vertices across the strip from a side, the mean of the side's normals there: no edge shows in the shading
//!     ─▶ turned by no more than MOST_TURNED from the normal that the tile above has at the same place, if it has a vertex there
//!     ─▶ two bytes (unit_vector.rs)
//! ```
//! So a vertex begins with the normal of the coarsest surface that it is on. Where tiles of two zooms meet, and when a client refines one, what
//! both have in common is shaded alike, to twice [`MOST_TURNED`] with what rounding to two bytes adds.

mod sums;
mod unit_vector;

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use terrain_core::Mesh;

use sums::{Place, Sums, place_above, place_of};
use terrain_codec::address::TileAddress;
use terrain_codec::tile::Tile;
pub use unit_vector::{oct_decode, oct_encode};

/// Degrees by which a normal turns from one zoom to the next, before it is rounded to two bytes, which is within one degree.
const MOST_TURNED: f64 = 1.0;

/// The finest surface of a tile, which other formats are made of.
pub struct FinestSurface {
    /// The tile.
    pub tile: Arc<Tile>,
    /// Positions in lattice coordinates.
    pub mesh: Arc<Mesh>,
    normals: Option<Normals>,
}

/// Unit vectors, Earth-centred, oct-encoded.
struct Normals {
    at_vertices: Vec<[u8; 2]>,
    at_places: HashMap<Place, [u8; 2]>,
}

impl FinestSurface {
    /// A surface that has no normals.
    #[must_use]
    pub fn unshaded(tile: Tile) -> Self {
        Self {
            mesh: Arc::new(tile.surface(tile.finest())),
            tile: Arc::new(tile),
            normals: None,
        }
    }

    /// The Earth-centred unit normal of a vertex of the mesh; none of an unshaded surface.
    #[must_use]
    pub fn normal(&self, vertex: u32) -> Option<DVec3> {
        let normals = self.normals.as_ref()?;
        Some(oct_decode(normals.at_vertices[vertex as usize]))
    }

    /// That of the vertex at a lattice position, at any height; none where there is no vertex, and of an unshaded surface.
    #[must_use]
    pub fn normal_at(&self, position: DVec3) -> Option<DVec3> {
        self.normal_at_place(place_of(&self.tile, position))
    }

    fn normal_at_place(&self, place: Place) -> Option<DVec3> {
        self.normals.as_ref()?.at_places.get(&place).copied().map(oct_decode)
    }
}

/// Which archive, and which of its tiles.
type Key = (u64, TileAddress);

/// Shaded surfaces of tiles, kept in memory as long as there is room. Any number of threads may ask.
pub struct Shading {
    sums: Cache<Key, Option<Arc<Sums>>, Bytes>,
    surfaces: Cache<Key, Option<Arc<FinestSurface>>, Bytes>,
}

impl Shading {
    /// Keeps about so many bytes.
    #[must_use]
    pub fn new(most_bytes: u64) -> Self {
        let half = most_bytes / 2;
        let usual = usize::try_from(half / USUAL_BYTES).unwrap_or(usize::MAX);
        Self {
            sums: Cache::with_weighter(usual, half, Bytes),
            surfaces: Cache::with_weighter(usual, half, Bytes),
        }
    }

    /// The shaded surface of the tile at `address`, if `read` finds one; `archive` is the number of the archive that it reads. It is asked for the
    /// tiles around, too, and for those above with the tiles around these, as far as they are not in memory.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn surface<E>(
        &self,
        archive: u64,
        address: TileAddress,
        read: &impl Fn(TileAddress) -> Result<Option<Tile>, E>,
    ) -> Result<Option<Arc<FinestSurface>>, E> {
        self.surfaces.get_or_insert_with(&(archive, address), || {
            let sums = |address| self.sums(archive, address, read);
            let Some(own) = sums(address)? else { return Ok(None) };
            let around = address.around().into_iter().map(sums);
            let around: Vec<Arc<Sums>> = around.filter_map(Result::transpose).collect::<Result<_, E>>()?;
            // Those above wait for those further above only: threads never wait for each other in a circle.
            let above = address.parent().map(|address| self.surface(archive, address, read));
            let above = above.transpose()?.flatten();
            Ok(Some(Arc::new(shaded(&own, &around, above.as_deref()))))
        })
    }

    fn sums<E>(
        &self,
        archive: u64,
        address: TileAddress,
        read: &impl Fn(TileAddress) -> Result<Option<Tile>, E>,
    ) -> Result<Option<Arc<Sums>>, E> {
        let make = || Ok(read(address)?.map(|tile| Arc::new(Sums::of(tile))));
        self.sums.get_or_insert_with(&(archive, address), make)
    }
}

fn shaded(own: &Sums, around: &[Arc<Sums>], above: Option<&FinestSurface>) -> FinestSurface {
    let mut all: Vec<&Sums> = around.iter().map(Arc::as_ref).chain([own]).collect();
    // In the order of addresses all tiles at a place find the same bits there.
    all.sort_by_key(|sums| sums.tile.address);
    let turned = |vertex: usize, normal: DVec3| {
        let before = place_above(own.places[vertex]).and_then(|place| above?.normal_at_place(place));
        oct_encode(before.map_or(normal, |before| before.rotate_towards(normal, MOST_TURNED.to_radians())))
    };
    let on_side = |vertex: usize| {
        let place = own.places[vertex];
        let sum = || all.iter().filter_map(|sums| sums.wide.get(&place)).sum::<DVec3>();
        let normal = own.normal_of_pole(vertex).or_else(|| sum().try_normalize())?;
        Some(turned(vertex, normal))
    };
    let count = own.places.len();
    let on_sides: Vec<Option<[u8; 2]>> = (0..count)
        .map(|vertex| own.is_wide(vertex).then(|| on_side(vertex)).flatten())
        .collect();
    let mut across: HashMap<u32, DVec3> = HashMap::new();
    for &[a, b, c] in &own.mesh.triangles {
        for [from, to] in [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]] {
            if let Some(normal) = on_sides[from as usize]
                && !own.is_wide(to as usize)
            {
                *across.entry(to).or_default() += oct_decode(normal);
            }
        }
    }
    let inside = |vertex: usize| {
        let sum = across.get(&(vertex as u32)).copied().unwrap_or(own.area[vertex]);
        turned(vertex, sum.try_normalize().unwrap_or_else(|| own.up(vertex)))
    };
    let at_vertices: Vec<[u8; 2]> = (0..count)
        .map(|vertex| on_sides[vertex].unwrap_or_else(|| inside(vertex)))
        .collect();
    FinestSurface {
        tile: Arc::clone(&own.tile),
        mesh: Arc::clone(&own.mesh),
        normals: Some(Normals {
            at_places: own.places.iter().copied().zip(at_vertices.iter().copied()).collect(),
            at_vertices,
        }),
    }
}

/// What is kept takes as many bytes as this for a vertex, about, of sums and of surfaces each.
const BYTES_A_VERTEX: u64 = 200;
/// And this for a usual tile: the cache makes room for its own books by it.
const USUAL_BYTES: u64 = 1_000 * BYTES_A_VERTEX;

#[derive(Clone)]
struct Bytes;

impl Bytes {
    fn of(mesh: Option<&Mesh>) -> u64 {
        100 + mesh.map_or(0, |mesh| mesh.positions.len() as u64 * BYTES_A_VERTEX)
    }
}

impl Weighter<Key, Option<Arc<Sums>>> for Bytes {
    fn weight(&self, _: &Key, sums: &Option<Arc<Sums>>) -> u64 {
        Self::of(sums.as_ref().map(|sums| sums.mesh.as_ref()))
    }
}

impl Weighter<Key, Option<Arc<FinestSurface>>> for Bytes {
    fn weight(&self, _: &Key, surface: &Option<Arc<FinestSurface>>) -> u64 {
        Self::of(surface.as_ref().map(|surface| surface.mesh.as_ref()))
    }
}

#[cfg(test)]
#[path = "shading_tests.rs"]
pub(crate) mod tests;
