//! What is measured over a tile, in its 32,768 × 32,768 coordinates, and the outline of that.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use terrain_core::Mesh;

use super::EXTENT;
use crate::shading::FinestSurface;

/// A vertex: plan position in coordinates of the format, height in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) u: u16,
    pub(super) v: u16,
    pub(super) height: f64,
    /// Earth-centred unit normal, of measured ones, if they are shaded.
    pub(super) normal: Option<DVec3>,
}

/// Column and row in a tile's coordinates, which go on beside it.
pub(super) type Place = [i64; 2];

/// Where a point of a tile is for one that the tile is so many tiles `east` and `north` of.
pub(super) fn seen_at(offset: [i64; 2], point: Point) -> Place {
    let [east, north] = offset.map(|tiles| tiles * i64::from(EXTENT));
    [i64::from(point.u) + east, i64::from(point.v) + north]
}

/// What is measured over a tile, in coordinates of the format.
pub(super) struct Measured {
    pub(super) points: Vec<Point>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) outline: Outline,
}

impl Measured {
    pub(super) fn of(surface: &FinestSurface) -> Self {
        Self::new(&surface.mesh, |vertex| surface.normal(vertex), surface.tile.extent_bits)
    }

    /// `mesh`, on a lattice of 2^`extent_bits` units a side, with the normals of its vertices.
    pub(super) fn new(mesh: &Mesh, normal: impl Fn(u32) -> Option<DVec3>, extent_bits: u8) -> Self {
        let (points, triangles) = snap(mesh, normal, extent_bits);
        Self {
            outline: Outline::of(&points, &mesh.triangles, &triangles),
            points,
            triangles,
        }
    }

    /// Where nothing is.
    pub(super) fn nothing() -> Self {
        Self {
            points: Vec::new(),
            triangles: Vec::new(),
            outline: Outline::of(&[], &[], &[]),
        }
    }

    pub(super) fn is_whole_and_sound(&self) -> bool {
        let is_sound = |&triangle: &[u32; 3]| is_counter_clockwise(&self.points, triangle);
        self.outline.is_the_square() && self.triangles.iter().all(is_sound)
    }

    /// Its outline's edges along the sides of tiles, as seen from a tile that it is so many tiles `east` and `north` of.
    pub(super) fn edges_along_sides(&self, offset: [i64; 2]) -> impl Iterator<Item = [Place; 2]> {
        let is_along = |[a, b]: &[Place; 2]| (0..2).any(|axis| a[axis] == b[axis] && a[axis] % i64::from(EXTENT) == 0);
        let edges = self.outline.edges.iter();
        let edges = edges.map(move |edge| edge.map(|end| seen_at(offset, self.points[end as usize])));
        edges.filter(is_along)
    }
}

/// The points that the mesh's triangles use, rounded, and the triangles on them. Where several vertices fall on one
/// place, the first from the west, then from the south, gives the height: along a side that is the same one for both
/// tiles.
fn snap(mesh: &Mesh, normal: impl Fn(u32) -> Option<DVec3>, extent_bits: u8) -> (Vec<Point>, Vec<[u32; 3]>) {
    let position = |vertex: u32| mesh.positions[vertex as usize];
    let mut used = mesh.triangles.as_flattened().to_vec();
    used.sort_by(|&a, &b| {
        let (p, q) = (position(a), position(b));
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.cmp(&b))
    });
    used.dedup();
    let mut points = Vec::new();
    let mut places = HashMap::new();
    let mut numbers = vec![0; mesh.positions.len()];
    for vertex in used {
        let (height, normal) = (position(vertex).z, normal(vertex));
        let [u, v] = [position(vertex).x, position(vertex).y].map(|coordinate| round(coordinate, extent_bits));
        numbers[vertex as usize] = *places.entry((u, v)).or_insert_with(|| {
            points.push(Point { u, v, height, normal });
            points.len() as u32 - 1
        });
    }
    let triangles = mesh
        .triangles
        .iter()
        .map(|triangle| triangle.map(|vertex| numbers[vertex as usize]))
        .collect();
    (points, triangles)
}

/// A lattice coordinate of 0…2^`extent_bits` in 0…[`EXTENT`]. What is not on a side stays off it. It depends on nothing
/// but the place on the lattice, so that neighbours round alike.
fn round(coordinate: f64, extent_bits: u8) -> u16 {
    let extent = 1_u64 << extent_bits;
    let lattice = (coordinate as u64).min(extent);
    let nearest = (lattice * u64::from(EXTENT) + extent / 2) >> extent_bits;
    let (first, last) = match lattice {
        0 => (0, 0),
        _ if lattice == extent => (EXTENT, EXTENT),
        _ => (1, EXTENT - 1),
    };
    (nearest as u16).clamp(first, last)
}

/// Plan coordinates times three, so that the middle of a triangle is a whole number, too.
type Triple = (i64, i64);

fn triple(point: Point) -> Triple {
    (i64::from(point.u) * 3, i64::from(point.v) * 3)
}

/// The border of the rounded mesh, counter-clockwise around it.
pub(super) struct Outline {
    pub(super) edges: Vec<[u32; 2]>,
    lines: Vec<[Triple; 2]>,
    /// The lines again, in every band of [`BAND`] rows that they touch: an outline may have tens of thousands.
    bands: Vec<Vec<[Triple; 2]>>,
}

/// Height of a band, in triple coordinates.
const BAND: i64 = 3 * 128;

fn band(row: i64) -> usize {
    (row / BAND) as usize
}

impl Outline {
    /// From the mesh's own triangles, which say where its border is, and from the rounded ones on `points`.
    fn of(points: &[Point], original: &[[u32; 3]], rounded: &[[u32; 3]]) -> Self {
        let sides: HashSet<[u32; 2]> = original.iter().flat_map(directed_edges).collect();
        let pairs = original
            .iter()
            .flat_map(directed_edges)
            .zip(rounded.iter().flat_map(directed_edges));
        let edges: Vec<[u32; 2]> = pairs
            .filter(|([a, b], [start, end])| !sides.contains(&[*b, *a]) && start != end)
            .map(|(_, edge)| edge)
            .collect();
        let lines: Vec<[Triple; 2]> = edges
            .iter()
            .map(|edge| edge.map(|point| triple(points[point as usize])))
            .collect();
        let mut bands = vec![Vec::new(); band(3 * i64::from(EXTENT)) + 1];
        for &line in &lines {
            let [a, b] = line.map(|(_, row)| band(row));
            bands[a.min(b)..=a.max(b)].iter_mut().for_each(|band| band.push(line));
        }
        Self { edges, lines, bands }
    }

    /// Whether the mesh covers the whole square: it has a border, all of it on the square's.
    pub(super) fn is_the_square(&self) -> bool {
        let far = 3 * i64::from(EXTENT);
        let on_side = |[a, b]: &[Triple; 2]| (a.0 == b.0 && a.0 % far == 0) || (a.1 == b.1 && a.1 % far == 0);
        !self.lines.is_empty() && self.lines.iter().all(on_side)
    }

    /// Whether a place is neither inside the outline nor on it.
    pub(super) fn is_outside(&self, [u, v]: [u16; 2]) -> bool {
        self.winding((i64::from(u) * 3, i64::from(v) * 3)) == Some(0)
    }

    pub(super) fn contains_middle(&self, points: &[Point], face: [u32; 3]) -> bool {
        let [a, b, c] = face.map(|point| triple(points[point as usize]));
        self.winding(((a.0 + b.0 + c.0) / 3, (a.1 + b.1 + c.1) / 3))
            .is_some_and(|turns| turns > 0)
    }

    /// How often the outline goes around `point`, exactly; nothing when the point is on it. After D. Sunday, *Inclusion of
    /// a point in a polygon*, 2001: upward edges with the point to their left less downward ones with it to their right.
    fn winding(&self, point: Triple) -> Option<i32> {
        let mut turns = 0;
        for &[a, b] in &self.bands[band(point.1)] {
            if point.1 < a.1.min(b.1) || point.1 > a.1.max(b.1) {
                continue;
            }
            let left = (b.0 - a.0) * (point.1 - a.1) - (point.0 - a.0) * (b.1 - a.1);
            if left == 0 && point.0 >= a.0.min(b.0) && point.0 <= a.0.max(b.0) {
                return None;
            }
            turns += i32::from(a.1 <= point.1 && b.1 > point.1 && left > 0);
            turns -= i32::from(a.1 > point.1 && b.1 <= point.1 && left < 0);
        }
        Some(turns)
    }
}

pub(super) fn is_counter_clockwise(points: &[Point], triangle: [u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|point| triple(points[point as usize]));
    (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1) > 0
}

pub(super) fn directed_edges(triangle: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *triangle;
    [[a, b], [b, c], [c, a]]
}
