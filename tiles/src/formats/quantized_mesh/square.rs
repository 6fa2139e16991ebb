//! A surface on the lattice becomes one on the tile's 32,768 × 32,768 coordinates that covers the whole square.
//!
//! ```text
//! round the vertices; those that meet become one
//! where the outline leaves the square's sides: add ground points, in a grid, outside it
//! constrained Delaunay triangulation of all points, with the outline and then the mesh's edges as constraints
//! triangles inside the rounded outline are measured, the others ground
//! if the ground does not go on from the data: ground triangles get corners of their own, at its height there,
//! and where measured and ground triangles meet is a wall
//! ```
//!
//! A mesh that survives rounding comes out as it was: its edges are all there is room for (one that fills the square, too,
//! needs no triangulation at all). Where rounding turns
//! triangles over or flattens them, their edges cross others and are left out, and Delaunay triangles take their place:
//! there is no hole and no overlap whatever was rounded.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use terrain_core::Mesh;

use super::EXTENT;
use crate::address::Rectangle;
use crate::outside::Outside;

/// Cells along a tile's side in which it is looked up what is outside, at most.
const MOST_CELLS: f64 = 64.0;

/// A vertex: plan position in coordinates of the format, height in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) u: u16,
    pub(super) v: u16,
    pub(super) height: f64,
    /// Earth-centred unit normal, of measured ones.
    pub(super) normal: Option<DVec3>,
}

/// A surface over the whole square.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CompletedSquare {
    pub(super) points: Vec<Point>,
    /// Measured ones first, then ground, then walls.
    pub(super) triangles: Vec<[u32; 3]>,
    /// How many of them are measured.
    pub(super) measured: u32,
}

/// Completes `mesh`, on a lattice of 2^`extent_bits` units a side, with a normal for each vertex, to the whole `rectangle` of a tile by
/// what is `outside`.
pub(super) fn complete(
    mesh: &Mesh,
    normals: &[DVec3],
    extent_bits: u8,
    rectangle: Rectangle,
    outside: &Outside,
) -> CompletedSquare {
    let (mut points, triangles) = snap(mesh, normals, extent_bits);
    let outline = Outline::of(&points, &mesh.triangles, &triangles);
    let whole = outline.is_the_square();
    if whole
        && triangles
            .iter()
            .all(|triangle| is_counter_clockwise(&points, *triangle))
    {
        // Its triangles cover their border's inside once: there is nothing to mend.
        return CompletedSquare::measured(points, triangles);
    }
    let height = |[u, v]: [u16; 2]| outside.height_in(rectangle, [u, v], EXTENT);
    if !whole {
        let cells = ground_cells(rectangle, outside.detail());
        points.extend(ground_points(&outline, cells).map(|[u, v]| Point {
            u,
            v,
            height: height([u, v]),
            normal: None,
        }));
    }
    let faces = triangulate(&points, &outline.edges, &triangles);
    let (measured, ground) = faces
        .into_iter()
        .partition(|face| whole || outline.contains_middle(&points, *face));
    if outside.meets_data() {
        CompletedSquare::beside(points, measured, ground)
    } else {
        join(points, measured, ground, height)
    }
}

/// The `rectangle` of a tile, where nothing is measured but points that tiles beside it have on its sides.
pub(super) fn unmeasured(rectangle: Rectangle, shared: Vec<Point>, outside: &Outside) -> CompletedSquare {
    let sides = [0, EXTENT];
    // A tile beside has all its points of a side here, but one across a corner has the corner alone.
    let has = |is_on: &dyn Fn(&Point) -> bool| shared.iter().any(is_on);
    let columns = sides.map(|side| has(&|point| point.u == side && !sides.contains(&point.v)));
    let rows = sides.map(|side| has(&|point| point.v == side && !sides.contains(&point.u)));
    let is_shared =
        |[u, v]: [u16; 2]| (0..2).any(|end| u == sides[end] && columns[end] || v == sides[end] && rows[end]);
    let nothing = Outline::of(&[], &[], &[]);
    let ground = ground_points(&nothing, ground_cells(rectangle, outside.detail())).filter(|&place| !is_shared(place));
    let own = ground.map(|[u, v]| Point {
        u,
        v,
        height: outside.height_in(rectangle, [u, v], EXTENT),
        normal: None,
    });
    let mut known = HashSet::new();
    let points: Vec<Point> = shared
        .into_iter()
        .chain(own)
        .filter(|point| known.insert((point.u, point.v)))
        .collect();
    let triangles = triangulate(&points, &[], &[]);
    CompletedSquare::beside(points, Vec::new(), triangles)
}

/// Those of a tile's points that are on the sides of another one of its zoom, in that one's coordinates: the tile is so many `east` and
/// `north` of it.
pub(super) fn seen_from([east, north]: [i64; 2], points: Vec<Point>) -> impl Iterator<Item = Point> {
    let moved = move |coordinate: u16, squares: i64| {
        u16::try_from(i64::from(coordinate) + squares * i64::from(EXTENT))
            .ok()
            .filter(|&coordinate| coordinate <= EXTENT)
    };
    points.into_iter().filter_map(move |point| {
        let (u, v) = (moved(point.u, east)?, moved(point.v, north)?);
        Some(Point { u, v, ..point })
    })
}

impl CompletedSquare {
    fn measured(points: Vec<Point>, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            measured: triangles.len() as u32,
            points,
            triangles,
        }
    }

    /// With ground that has the heights of the measured surface where both meet.
    fn beside(points: Vec<Point>, measured: Vec<[u32; 3]>, ground: Vec<[u32; 3]>) -> Self {
        let count = measured.len() as u32;
        Self {
            points,
            triangles: [measured, ground].concat(),
            measured: count,
        }
    }
}

/// The points that the mesh's triangles use, rounded, and the triangles on them. Where several vertices fall on one
/// place, the first from the west, then from the south, gives the height: along a side that is the same one for both
/// tiles.
fn snap(mesh: &Mesh, normals: &[DVec3], extent_bits: u8) -> (Vec<Point>, Vec<[u32; 3]>) {
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
        let (height, normal) = (position(vertex).z, Some(normals[vertex as usize]));
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
struct Outline {
    edges: Vec<[u32; 2]>,
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
    fn is_the_square(&self) -> bool {
        let far = 3 * i64::from(EXTENT);
        let on_side = |[a, b]: &[Triple; 2]| (a.0 == b.0 && a.0 % far == 0) || (a.1 == b.1 && a.1 % far == 0);
        !self.lines.is_empty() && self.lines.iter().all(on_side)
    }

    fn contains_middle(&self, points: &[Point], face: [u32; 3]) -> bool {
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

/// Places outside the outline, on a grid of so many cells a side: ground without them would cut through the globe.
fn ground_points(outline: &Outline, cells: u32) -> impl Iterator<Item = [u16; 2]> {
    let at = move |index: u32| ((index * u32::from(EXTENT) + cells / 2) / cells) as u16;
    let grid = (0..=cells).flat_map(move |row| (0..=cells).map(move |column| [at(column), at(row)]));
    grid.filter(|&[u, v]| outline.winding((i64::from(u) * 3, i64::from(v) * 3)) == Some(0))
}

/// The same in all tiles of a zoom: cells are 5.6° wide at zoom 0 and shrink to a tile at zoom 10, where they bulge 4 m; or as wide as
/// what is outside is known in `detail`, in degrees.
fn ground_cells(rectangle: Rectangle, detail: Option<f64>) -> u32 {
    let of_globe = (32.0 * (rectangle.width / 180.0).sqrt()).ceil() as u32;
    let of_detail = detail.map_or(1, |degrees| (rectangle.width / degrees).clamp(1.0, MOST_CELLS) as u32);
    of_globe.max(of_detail)
}

/// All points, triangulated, with as many of the edges as there is room for: the outline first, then those of triangles
/// that are still counter-clockwise.
fn triangulate(points: &[Point], outline: &[[u32; 2]], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let positions = points
        .iter()
        .map(|point| Point2::new(f64::from(point.u), f64::from(point.v)))
        .collect();
    let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(positions, Vec::new())
        .expect("coordinates are whole numbers up to 32,767");
    let vertices: Vec<_> = triangulation.fixed_vertices().collect();
    let sound = triangles
        .iter()
        .filter(|triangle| is_counter_clockwise(points, **triangle));
    let inner = sound.flat_map(directed_edges).filter(|[a, b]| a < b);
    for [start, end] in outline.iter().copied().chain(inner) {
        triangulation.try_add_constraint(vertices[start as usize], vertices[end as usize]);
    }
    triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.index() as u32))
        .collect()
}

/// One surface of measured and ground triangles. A ground triangle's corners are at the ground's height, whatever the measured
/// surface has there; the wall between them closes the step.
fn join(
    mut points: Vec<Point>,
    measured: Vec<[u32; 3]>,
    ground: Vec<[u32; 3]>,
    height: impl Fn([u16; 2]) -> f64,
) -> CompletedSquare {
    let mut feet: HashMap<u32, u32> = HashMap::new();
    let mut foot = |top: u32| {
        let point = points[top as usize];
        let height = height([point.u, point.v]);
        if point.height == height {
            return top;
        }
        *feet.entry(top).or_insert_with(|| {
            points.push(Point {
                height,
                normal: None,
                ..point
            });
            points.len() as u32 - 1
        })
    };
    let ground_edges: HashSet<[u32; 2]> = ground.iter().flat_map(directed_edges).collect();
    let rims = measured
        .iter()
        .flat_map(directed_edges)
        .filter(|[a, b]| ground_edges.contains(&[*b, *a]));
    let walls: Vec<[u32; 3]> = rims.flat_map(|[a, b]| wall([a, b], [foot(a), foot(b)])).collect();
    let ground = ground.iter().map(|triangle| triangle.map(&mut foot)).collect();
    let count = measured.len() as u32;
    CompletedSquare {
        triangles: [measured, ground, walls].concat(),
        points,
        measured: count,
    }
}

/// The wall below the edge a → b of a measured triangle, seen from the ground outside. Where the surface is below the
/// ground the same wall faces inwards.
///
/// ```text
///  a ───── b      corners that are one point
///  │ ╲     │      leave one triangle, or none
///  │   ╲   │
///  a₀ ──── b₀
/// ```
fn wall([a, b]: [u32; 2], [foot_a, foot_b]: [u32; 2]) -> impl Iterator<Item = [u32; 3]> {
    let both = [[a, foot_a, foot_b], [a, foot_b, b]];
    both.into_iter().filter(|[p, q, r]| p != q && q != r && r != p)
}

fn is_counter_clockwise(points: &[Point], triangle: [u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|point| triple(points[point as usize]));
    (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1) > 0
}

fn directed_edges(triangle: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *triangle;
    [[a, b], [b, c], [c, a]]
}
