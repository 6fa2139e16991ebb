//! A surface on the lattice becomes one on the tile's 32,768 × 32,768 coordinates that covers the whole square.
//!
//! ```text
//! round the vertices; those that meet become one                                                            measured.rs
//! where the outline leaves the square's sides: add ground points outside it, in a grid,
//! and on the sides the points that tiles beside have there                                                   sides.rs
//! constrained Delaunay triangulation of all points, with the outline and then the mesh's edges as constraints
//! triangles inside the rounded outline are measured, the others ground
//! if the ground does not go on from the data: ground triangles get corners of their own, at its height there,
//! and where measured and ground triangles meet is a wall; where they meet at the tile's side, a short slope
//! ```
//!
//! A mesh that survives rounding comes out as it was: its edges are all there is room for (one that fills the square, too,
//! needs no triangulation at all). Where rounding turns
//! triangles over or flattens them, their edges cross others and are left out, and Delaunay triangles take their place:
//! there is no hole and no overlap whatever was rounded.

use std::collections::{HashMap, HashSet};

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use terrain_codec::address::Rectangle;

use super::EXTENT;
use super::measured::{Measured, Outline, Point, directed_edges, is_counter_clockwise};
use super::sides::Sides;
use crate::outside::Outside;

/// Cells along a tile's side in which it is looked up what is outside, at most.
const MOST_CELLS: f64 = 64.0;

/// What part of a tile's side a slope is wide that goes down from the data across a side to the ground.
const SLOPE: u16 = 64;

/// A surface over the whole square.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CompletedSquare {
    pub(super) points: Vec<Point>,
    /// Measured ones first, then ground, then walls.
    pub(super) triangles: Vec<[u32; 3]>,
    /// How many of them are measured.
    pub(super) measured: u32,
}

/// Completes what is `measured` to the whole `rectangle` of a tile by what is `outside`. `beside` gives what is measured in the tiles
/// around, and how many tiles east and north of it they are; it is asked if the data end in this tile.
pub(super) fn complete<E>(
    measured: Measured,
    beside: impl FnOnce() -> Result<Vec<([i64; 2], Measured)>, E>,
    rectangle: Rectangle,
    outside: &Outside,
) -> Result<CompletedSquare, E> {
    if measured.is_whole_and_sound() {
        // Its triangles cover their border's inside once: there is nothing to mend.
        return Ok(CompletedSquare::measured(measured.points, measured.triangles));
    }
    let height = |[u, v]: [u16; 2]| outside.height_in(rectangle, [u, v], EXTENT);
    let whole = measured.outline.is_the_square();
    let sides = if whole {
        Sides::default()
    } else {
        Sides::new(&measured, &beside()?)
    };
    let Measured {
        mut points,
        triangles,
        outline,
    } = measured;
    if !whole {
        let mut known: HashSet<[u16; 2]> = points.iter().map(|point| [point.u, point.v]).collect();
        let mut add = |point: Point| {
            if known.insert([point.u, point.v]) {
                points.push(point);
            }
        };
        sides
            .points
            .iter()
            .filter(|point| outline.is_outside([point.u, point.v]))
            .copied()
            .for_each(&mut add);
        let cells = ground_cells(rectangle, outside.detail());
        let own = ground_points(&outline, cells).filter(|&place| !sides.has_edge_at(place));
        let slopes = (!outside.meets_data()).then(|| sides.feet_of_slopes(EXTENT / SLOPE));
        let slopes = slopes.into_iter().flatten().filter(|&place| outline.is_outside(place));
        let ground = own.chain(slopes).map(|[u, v]| Point {
            u,
            v,
            height: height([u, v]),
            normal: None,
        });
        ground.for_each(&mut add);
    }
    let faces = triangulate(&points, &outline.edges, &triangles);
    let (measured, ground) = faces
        .into_iter()
        .partition(|face| whole || outline.contains_middle(&points, *face));
    Ok(if outside.meets_data() {
        CompletedSquare::beside(points, measured, ground)
    } else {
        join(points, measured, ground, |point| {
            if sides.is_raised(point) {
                point.height
            } else {
                height([point.u, point.v])
            }
        })
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

/// Places outside the outline, on a grid of so many cells a side: ground without them would cut through the globe.
fn ground_points(outline: &Outline, cells: u32) -> impl Iterator<Item = [u16; 2]> {
    let at = move |index: u32| ((index * u32::from(EXTENT) + cells / 2) / cells) as u16;
    let grid = (0..=cells).flat_map(move |row| (0..=cells).map(move |column| [at(column), at(row)]));
    grid.filter(|&place| outline.is_outside(place))
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

/// One surface of measured and ground triangles. A ground triangle's corners are at the height of ground there, whatever the measured
/// surface has; the wall between them closes the step.
fn join(
    mut points: Vec<Point>,
    measured: Vec<[u32; 3]>,
    ground: Vec<[u32; 3]>,
    height: impl Fn(Point) -> f64,
) -> CompletedSquare {
    let mut feet: HashMap<u32, u32> = HashMap::new();
    let mut foot = |top: u32| {
        let point = points[top as usize];
        let height = height(point);
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
