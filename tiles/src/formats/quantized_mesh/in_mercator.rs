//! Quantized-mesh in Web Mercator: surfaces of tiles of the geographic scheme, cut along its meridians and parallels.
//!
//! ```text
//! tiles for the squares that a tile of Web Mercator reaches into ─▶ their triangles, flat in space, cut at its sides
//!     ─▶ one mesh, on a lattice of its own ─▶ completed and rounded as any tile
//! ```
//! Zoom z + 1 of Web Mercator has the columns of zoom z of the geographic scheme, and tiles that are nowhere higher: their numbers lose
//! nothing. Where an edge is cut follows from its two ends alone, so that tiles on both sides have the same vertices.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use terrain_codec::address::{Rectangle, TileAddress};
use terrain_codec::ellipsoid::to_geodetic;
use terrain_core::Mesh;

use super::QuantizedMesh;
use super::measured::Measured;
use super::square;
use crate::mercator;
use crate::outside::Outside;
use crate::shading::FinestSurface;
use crate::tile_file::SquareTile;

/// A tile's side is 2^`LATTICE_BITS` units of the lattice that cut surfaces are on.
const LATTICE_BITS: u8 = 30;
/// Degrees along a side of a root of the geographic scheme, in which places are counted here from the south-west corner of the Earth.
const ROOT: f64 = 180.0;
/// Steps of the secant method, at most: edges are nearly straight on the ellipsoid, and two or three do.
const STEPS: usize = 16;
/// Degrees of latitude by which a cut may miss a parallel: a tenth of a micrometre.
const ON_PARALLEL: f64 = 1e-12;

/// The squares of the geographic scheme that a tile of Web Mercator reaches into.
#[must_use]
pub fn addresses_under(tile: SquareTile) -> Vec<TileAddress> {
    let zoom = tile.zoom.saturating_sub(1);
    let Rectangle {
        west,
        south,
        width,
        height,
    } = tile.into();
    let degrees = ROOT / f64::from(1_u32 << zoom);
    let range = |from: f64, to: f64| (from / degrees).floor() as u32..(to / degrees).ceil() as u32;
    let columns = range(west + 180.0, west + width + 180.0);
    let rows = range(south + 90.0, south + height + 90.0);
    rows.flat_map(|y| columns.clone().filter_map(move |x| TileAddress::new(zoom, x, y)))
        .collect()
}

/// The squares of the geographic scheme that make a tile of Web Mercator: those that it reaches into, and those around.
#[must_use]
pub fn addresses_for(tile: SquareTile) -> Vec<TileAddress> {
    let under = addresses_under(tile);
    let around = under.iter().flat_map(|address| address.around());
    let mut all: Vec<TileAddress> = around.chain(under.iter().copied()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

impl QuantizedMesh {
    /// The finest surfaces over a tile of Web Mercator, completed by what is `outside`. `standing` gives the surface of the tile that stands
    /// for a square, if there is one; it is asked once for each square of [`addresses_under`], and for those around only where the data end.
    ///
    /// # Errors
    /// Those of `standing`.
    pub fn in_mercator<E>(
        tile: SquareTile,
        standing: impl Fn(TileAddress) -> Result<Option<Arc<FinestSurface>>, E>,
        outside: &Outside,
    ) -> Result<Self, E> {
        let known: RefCell<HashMap<TileAddress, Option<Arc<FinestSurface>>>> = RefCell::default();
        let standing = |address| {
            if let Some(found) = known.borrow().get(&address) {
                return Ok(found.clone());
            }
            let found = standing(address)?;
            known.borrow_mut().insert(address, found.clone());
            Ok(found)
        };
        let measured = |square: SquareTile| {
            // A leaf may stand for several squares.
            let mut surfaces = BTreeMap::new();
            for address in addresses_under(square) {
                if let Some(surface) = standing(address)? {
                    surfaces.insert(surface.tile.address, surface);
                }
            }
            let mut cut = Cut::new(square);
            surfaces.values().for_each(|surface| cut.add(surface));
            let normal = |vertex: u32| cut.normals[vertex as usize];
            Ok(Measured::new(&cut.mesh, normal, LATTICE_BITS))
        };
        let around = || {
            beside(tile)
                .map(|(offset, other)| Ok((offset, measured(other)?)))
                .collect()
        };
        let rectangle = tile.into();
        let surface = square::complete(measured(tile)?, around, rectangle, outside)?;
        Ok(Self::from_surface(rectangle, surface, outside))
    }
}

/// The tiles around one, and how many columns and rows they are east and north of it.
fn beside(tile: SquareTile) -> impl Iterator<Item = ([i64; 2], SquareTile)> {
    let count = 1_i64 << tile.zoom;
    let offsets = (-1..=1).flat_map(|north| (-1..=1).map(move |east| [east, north]));
    offsets
        .filter(|offset| *offset != [0, 0])
        .filter_map(move |[east, north]| {
            let x = (i64::from(tile.x) + east).rem_euclid(count) as u32;
            let y = i64::from(tile.y) - north;
            let other = |y: i64| SquareTile { x, y: y as u32, ..tile };
            (0..count).contains(&y).then(|| ([east, north], other(y)))
        })
}

/// A corner of a triangle that is being cut.
#[derive(Clone, Copy)]
struct Corner {
    /// East and north of the Earth's south-west corner, in [`ROOT`]s.
    place: DVec2,
    /// Earth-centred metres.
    space: DVec3,
    /// Metres.
    height: f64,
    /// Of unit length, if the surface is shaded.
    normal: Option<DVec3>,
}

/// Triangles within a rectangle, as a mesh.
struct Cut {
    /// Least and greatest places.
    low: DVec2,
    high: DVec2,
    mesh: Mesh,
    normals: Vec<Option<DVec3>>,
    vertices: HashMap<[u64; 2], u32>,
}

impl Cut {
    fn new(tile: SquareTile) -> Self {
        let column = |x: u32| f64::from(x) * 2.0 / f64::from(1_u32 << tile.zoom);
        let row = |part: f64| (mercator::latitude(tile, part) + 90.0) / ROOT;
        Self {
            low: DVec2::new(column(tile.x), row(1.0)),
            high: DVec2::new(column(tile.x + 1), row(0.0)),
            mesh: Mesh::default(),
            normals: Vec::new(),
            vertices: HashMap::new(),
        }
    }

    /// Adds what is in the rectangle of a surface.
    fn add(&mut self, surface: &FinestSurface) {
        let FinestSurface { tile, mesh, .. } = surface;
        let address = tile.address;
        let side = 1.0 / f64::from(1_u32 << address.zoom);
        let first = DVec2::new(f64::from(address.x), f64::from(address.y)) * side;
        if first.cmpge(self.high).any() || (first + side).cmple(self.low).any() {
            return;
        }
        let unit = side / (1_u64 << tile.extent_bits) as f64;
        let corner = |vertex: u32| {
            let position = mesh.positions[vertex as usize];
            Corner {
                place: first + position.truncate() * unit,
                space: tile.earth_centred(position),
                height: position.z,
                normal: surface.normal(vertex),
            }
        };
        for triangle in &mesh.triangles {
            self.add_triangle(triangle.map(corner));
        }
    }

    fn add_triangle(&mut self, corners: [Corner; 3]) {
        let mut polygon = corners.to_vec();
        for axis in [1, 0] {
            polygon = clipped(&polygon, axis, self.low[axis], |at, line| at >= line);
            polygon = clipped(&polygon, axis, self.high[axis], |at, line| at <= line);
        }
        let mut ring: Vec<u32> = polygon.into_iter().map(|corner| self.vertex(corner)).collect();
        ring.dedup();
        for index in 2..ring.len() {
            let triangle = [ring[0], ring[index - 1], ring[index]];
            let [a, b, c] = triangle.map(|vertex| self.mesh.positions[vertex as usize].truncate());
            if (b - a).perp_dot(c - a) != 0.0 {
                self.mesh.triangles.push(triangle);
            }
        }
    }

    /// The vertex at a corner's place on the lattice. What is not on a side stays off it.
    fn vertex(&mut self, corner: Corner) -> u32 {
        let extent = (1_u64 << LATTICE_BITS) as f64;
        let along = |axis: usize| {
            let (at, low, high) = (corner.place[axis], self.low[axis], self.high[axis]);
            match ((at - low) / (high - low) * extent).round() {
                _ if at == low => 0.0,
                _ if at == high => extent,
                inside => inside.clamp(1.0, extent - 1.0),
            }
        };
        let place = [along(0), along(1)];
        let (mesh, normals) = (&mut self.mesh, &mut self.normals);
        *self.vertices.entry(place.map(|at| at as u64)).or_insert_with(|| {
            mesh.positions.push(DVec3::new(place[0], place[1], corner.height));
            normals.push(corner.normal);
            mesh.positions.len() as u32 - 1
        })
    }
}

/// The part of a convex polygon that is on the inner side of a line across an axis, as `is_inside` says of a place and the line. After
/// I. Sutherland, G. Hodgman, *Reentrant polygon clipping*, 1974.
fn clipped(polygon: &[Corner], axis: usize, line: f64, is_inside: impl Fn(f64, f64) -> bool) -> Vec<Corner> {
    let at = |corner: &Corner| corner.place[axis];
    let next = polygon.iter().cycle().skip(1);
    let mut inner = Vec::with_capacity(polygon.len() + 1);
    for (corner, next) in polygon.iter().zip(next) {
        let is_in = [corner, next].map(|corner| is_inside(at(corner), line));
        if is_in[0] {
            inner.push(*corner);
        }
        if is_in[0] != is_in[1] && at(corner) != line && at(next) != line {
            inner.push(crossing(corner, next, axis, line));
        }
    }
    inner
}

/// Where the edge between two corners, straight in space, meets a meridian (axis 0) or a parallel (axis 1).
fn crossing(a: &Corner, b: &Corner, axis: usize, line: f64) -> Corner {
    let order = a.place.x.total_cmp(&b.place.x).then(a.place.y.total_cmp(&b.place.y));
    let (a, b) = if order.is_gt() { (b, a) } else { (a, b) };
    let along = |t: f64| to_geodetic(a.space.lerp(b.space, t));
    let t = if axis == 0 {
        let (sine, cosine) = (line * ROOT - 180.0).to_radians().sin_cos();
        let across = DVec3::new(-sine, cosine, 0.0);
        across.dot(a.space) / across.dot(a.space - b.space)
    } else {
        let parallel = line * ROOT - 90.0;
        root((line - a.place.y) / (b.place.y - a.place.y), |t| {
            along(t).latitude - parallel
        })
    };
    let t = t.clamp(0.0, 1.0);
    let found = along(t);
    let mut place = a.place.lerp(b.place, t);
    if axis == 0 {
        place.y = (found.latitude + 90.0) / ROOT;
    } else {
        // Longitudes begin anew at the antimeridian.
        let east = (found.longitude + 180.0) / ROOT;
        place.x = east + 2.0 * ((place.x - east) / 2.0).round();
    }
    place[axis] = line;
    Corner {
        place,
        space: a.space.lerp(b.space, t),
        height: found.height,
        normal: a
            .normal
            .zip(b.normal)
            .map(|(a, b)| a.lerp(b, t).try_normalize().unwrap_or(a)),
    }
}

/// Where a function from 0 to 1 that is nearly straight is 0, by the secant method from a place near it.
fn root(near: f64, function: impl Fn(f64) -> f64) -> f64 {
    let mut before = (0.0, function(0.0));
    let mut now = (near, function(near));
    for _ in 0..STEPS {
        let slope = (now.1 - before.1) / (now.0 - before.0);
        if now.1.abs() <= ON_PARALLEL || slope == 0.0 || !slope.is_finite() {
            break;
        }
        let next = (now.0 - now.1 / slope).clamp(0.0, 1.0);
        before = now;
        now = (next, function(next));
    }
    now.0
}

#[cfg(test)]
#[path = "in_mercator_tests.rs"]
mod tests;
