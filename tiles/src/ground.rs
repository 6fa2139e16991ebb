//! Heights of a tile's finest surface at places on the Earth: where the ellipsoid's normal meets a triangle that is flat in space,
//! which is the surface that its errors are certified of.
//!
//! ```text
//! place ─▶ cell of a grid over the tile ─▶ triangles that reach into it ─▶ the one that the normal meets ─▶ height
//! places ─▶ sorted by the tile that they are in ─▶ the ground of each, or of one beside it ─▶ answers
//! ```

pub mod line;

use std::ops::Deref;

use glam::{DVec2, DVec3};
use terrain_core::topology::compressed_rows::CompressedRows;

use terrain_codec::address::{MAX_ZOOM, Side, TileAddress};
use terrain_codec::ellipsoid::{Geodetic, east_north_up, normal, to_earth_centred};
use terrain_codec::filled::Filled;
use terrain_codec::tile::Tile;

/// Cells of the grid hold so many triangles on average.
const TRIANGLES_PER_CELL: f64 = 1.0;
/// Largest number of cells along a side.
const MOST_CELLS: usize = 1 << 10;
/// By so much of a triangle a normal may pass beside it, for rounding.
const SLACK: f64 = 1e-7;
/// Further than this part of its side no tile's triangles reach out of it, but for those of the two roots.
const FARTHEST_REACH: f64 = 0.25;

/// Degrees: where something is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// East of Greenwich, −180 to 180.
    pub longitude: f64,
    /// North of the equator.
    pub latitude: f64,
}

impl Place {
    /// That of a longitude which may be beyond ±180.
    #[must_use]
    pub fn turned(longitude: f64, latitude: f64) -> Self {
        Self {
            longitude: (longitude + 180.0).rem_euclid(360.0) - 180.0,
            latitude,
        }
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Metres above what the tile's heights are above.
    pub height: f64,
    /// Unit normal: east, north, up.
    pub normal: DVec3,
}

/// A tile's finest surface, ready to be asked for heights.
pub struct Ground {
    address: TileAddress,
    error: f64,
    filled: Filled,
    /// Earth-centred metres from `origin`.
    positions: Vec<DVec3>,
    origin: DVec3,
    triangles: Vec<[u32; 3]>,
    /// Cells along a side.
    cells: usize,
    /// Each cell's triangles, cells row by row from the south.
    members: CompressedRows,
    /// How far beyond its square triangles may reach, in parts of its side: edges that are straight in space bulge in plan.
    reach: f64,
}

impl Ground {
    /// The finest surface of `tile`.
    #[must_use]
    pub fn of(tile: &Tile) -> Self {
        let mesh = tile.surface(tile.finest());
        let places: Vec<Geodetic> = mesh.positions.iter().map(|&position| tile.geodetic(position)).collect();
        let origin = places.first().map_or(DVec3::ZERO, |&place| to_earth_centred(place));
        let fractions: Vec<DVec2> = places
            .iter()
            .map(|place| fraction(tile.address, place.longitude, place.latitude))
            .collect();
        let cells = ((mesh.triangles.len() as f64 / TRIANGLES_PER_CELL).sqrt().ceil() as usize).clamp(1, MOST_CELLS);
        let boxes: Vec<[DVec2; 2]> = mesh
            .triangles
            .iter()
            .map(|triangle| plan_box(tile.address, triangle.map(|vertex| fractions[vertex as usize])))
            .collect();
        let outside = boxes
            .iter()
            .map(|[low, high]| (-low.min_element()).max(high.max_element() - 1.0));
        let reach = outside.fold(0.0, f64::max);
        let members = sort_into_cells(&boxes, cells);
        Self {
            address: tile.address,
            error: tile.finest_error(),
            filled: tile.filled.clone(),
            positions: places.iter().map(|&place| to_earth_centred(place) - origin).collect(),
            origin,
            triangles: mesh.triangles,
            cells,
            members,
            reach,
        }
    }

    /// Certified vertical error of the surface, metres.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Whether the ground at degrees of longitude and latitude was not measured, as far as the tile knows: the source has a void there
    /// that was filled. No error is certified of such ground.
    #[must_use]
    pub fn is_filled(&self, longitude: f64, latitude: f64) -> bool {
        self.filled.has(fraction(self.address, longitude, latitude))
    }

    /// Bytes in memory, about.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of_val(&*self.positions) + size_of_val(&*self.triangles) + self.members.size()
    }

    /// Metres above what the tile's heights are above, at degrees of longitude and latitude; none where no triangle is.
    #[must_use]
    pub fn height(&self, longitude: f64, latitude: f64) -> Option<f64> {
        self.found(longitude, latitude).map(|(_, height)| height)
    }

    /// The height and the normal there.
    #[must_use]
    pub fn point(&self, longitude: f64, latitude: f64) -> Option<Point> {
        let (triangle, height) = self.found(longitude, latitude)?;
        let local = east_north_up(longitude, latitude).transpose();
        Some(Point {
            height,
            normal: (local * self.across(triangle)).normalize(),
        })
    }

    /// A vector across a triangle, upwards, Earth-centred.
    fn across(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize]);
        (b - a).cross(c - a)
    }

    /// The triangle at a place, and the height of it.
    fn found(&self, longitude: f64, latitude: f64) -> Option<(u32, f64)> {
        let foot = Geodetic {
            longitude,
            latitude,
            height: 0.0,
        };
        let foot = to_earth_centred(foot) - self.origin;
        let up = normal(longitude, latitude);
        let hits = self
            .candidates(fraction(self.address, longitude, latitude))
            .iter()
            .filter_map(|&triangle| Some((triangle, self.hit(triangle, foot, up)?)));
        // Beside an edge two triangles may be hit, for rounding: the one that is hit further inside counts.
        hits.max_by(|(_, (one, _)), (_, (other, _))| one.total_cmp(other))
            .filter(|(_, (inside, _))| *inside >= -SLACK)
            .map(|(triangle, (_, height))| (triangle, height))
    }

    /// Triangles that may be over a place of the tile, or just beside it.
    fn candidates(&self, fraction: DVec2) -> &[u32] {
        let cell = cell_of(fraction, self.cells);
        self.members.row((cell[1] * self.cells + cell[0]) as u32)
    }

    /// Least barycentric coordinate of where the line along `up` through `foot` meets the triangle's plane, and how far up
    /// that is. After T. Möller and B. Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997.
    fn hit(&self, triangle: u32, foot: DVec3, up: DVec3) -> Option<(f64, f64)> {
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let across = up.cross(ac);
        let volume = ab.dot(across);
        // An upright triangle is met nowhere or everywhere.
        if volume.abs() <= f64::EPSILON * ab.length() * ac.length() {
            return None;
        }
        let from_a = foot - a;
        let second = from_a.dot(across) / volume;
        let cross = from_a.cross(ab);
        let third = up.dot(cross) / volume;
        let inside = second.min(third).min(1.0 - second - third);
        Some((inside, ac.dot(cross) / volume))
    }
}

/// The tile of `zoom` that a place of the Earth is in, degrees.
#[must_use]
pub fn tile_at(zoom: u8, longitude: f64, latitude: f64) -> TileAddress {
    let zoom = zoom.min(MAX_ZOOM);
    let rows = f64::from(1_u32 << zoom);
    let index = |degrees: f64, count: f64| (degrees * rows / 180.0).floor().clamp(0.0, count - 1.0) as u32;
    TileAddress {
        zoom,
        x: index(longitude + 180.0, 2.0 * rows),
        y: index(latitude + 90.0, rows),
    }
}

/// What `ask` finds at places on the surfaces of `zoom`, in their order. Each tile that places are in is fetched once by `ground_at`.
///
/// # Errors
/// What `ground_at` says.
pub fn answers<G: Deref<Target = Ground> + Clone, A, E>(
    zoom: u8,
    places: &[Place],
    mut ground_at: impl FnMut(TileAddress) -> Result<Option<G>, E>,
    ask: impl Fn(&Ground, Place) -> Option<A>,
) -> Result<Vec<Option<A>>, E> {
    let mut answers: Vec<Option<A>> = places.iter().map(|_| None).collect();
    let tiles = places
        .iter()
        .map(|place| tile_at(zoom, place.longitude, place.latitude));
    let mut order: Vec<(TileAddress, usize)> = tiles.zip(0..).collect();
    order.sort_unstable();
    for run in order.chunk_by(|(one, _), (next, _)| one == next) {
        let address = run[0].0;
        let own = ground_at(address)?;
        for &(_, index) in run {
            let mut fetch = |other| {
                if other == address {
                    Ok(own.clone())
                } else {
                    ground_at(other)
                }
            };
            answers[index] = answer(address, places[index], &mut fetch, |ground| ask(ground, places[index]))?;
        }
    }
    Ok(answers)
}

/// What `ask` finds at a place in the surface of its tile, at `address`, or else in one beside it: of edges that are straight in space,
/// some bulge into this square.
///
/// # Errors
/// What `ground_at` says.
pub fn answer<G: Deref<Target = Ground>, A, E>(
    address: TileAddress,
    place: Place,
    mut ground_at: impl FnMut(TileAddress) -> Result<Option<G>, E>,
    ask: impl Fn(&Ground) -> Option<A>,
) -> Result<Option<A>, E> {
    if let Some(found) = ground_at(address)?.and_then(|ground| ask(&ground)) {
        return Ok(Some(found));
    }
    for (neighbour, distance) in beside(address, place.latitude) {
        if let Some(ground) = ground_at(neighbour)?
            && distance <= ground.reach
            && let Some(found) = ask(&ground)
        {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// Neighbours of a tile that may reach to a latitude inside it, since edges that are straight in space bulge in plan; and how far they
/// have to, in parts of a side.
fn beside(address: TileAddress, latitude: f64) -> impl Iterator<Item = (TileAddress, f64)> {
    let up = (latitude - address.south()) / address.degrees();
    let near = [(Side::South, up), (Side::North, 1.0 - up)].into_iter();
    near.filter(|(_, distance)| *distance < FARTHEST_REACH)
        .filter_map(move |(side, distance)| Some((address.neighbour(side)?, distance)))
}

/// 0 to 1 from the tile's west side to its east side, and from south to north.
fn fraction(address: TileAddress, longitude: f64, latitude: f64) -> DVec2 {
    DVec2::new(longitude - address.west(), latitude - address.south()) / address.degrees()
}

fn cell_of(fraction: DVec2, cells: usize) -> [usize; 2] {
    // Out of range, also where it is no number, floats become the nearest integer that there is.
    (fraction * cells as f64)
        .to_array()
        .map(|cell| (cell as usize).min(cells - 1))
}

/// Box in plan around a triangle that is flat in space, in parts of the tile's side.
fn plan_box(address: TileAddress, corners: [DVec2; 3]) -> [DVec2; 2] {
    let low = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let radians = address.degrees().to_radians();
    let extent = (high - low).max_element() * radians;
    let margin = bulge(extent, [low.y, high.y].map(|y| address.south() + y * address.degrees())) / radians;
    [low - margin, high + margin]
}

/// How far from a straight line in degrees a line may be that is straight in space, over `extent` radians: never further than d²/4,
/// times the tangent of the latitude where that is more than 45°; next to a pole never further than d. Latitudes are those of its
/// ends, degrees.
fn bulge(extent: f64, latitudes: [f64; 2]) -> f64 {
    let [one, other] = latitudes.map(|latitude| latitude.to_radians().abs());
    (extent * extent / 4.0 * (1.0 + one.max(other).tan().abs())).min(extent)
}

/// Each cell's triangles, cells row by row.
fn sort_into_cells(boxes: &[[DVec2; 2]], cells: usize) -> CompressedRows {
    let covered = |[low, high]: [DVec2; 2]| {
        let ([west, south], [east, north]) = (cell_of(low, cells), cell_of(high, cells));
        (south..=north).flat_map(move |row| (west..=east).map(move |column| (row * cells + column) as u32))
    };
    let triangles = (0..).zip(boxes);
    let pairs = triangles.flat_map(|(triangle, &extent)| covered(extent).map(move |cell| (cell, triangle)));
    CompressedRows::sorted(cells * cells, pairs)
}

#[cfg(test)]
#[path = "ground_tests.rs"]
mod tests;
