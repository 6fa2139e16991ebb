//! How far the points of one surface are from another, as a bound that is proven: what a level of detail claims.
//!
//! After M. Guthe, P. Borodin, R. Klein, *Fast and accurate Hausdorff distance calculation between meshes*, 2005. It leans on
//! one fact: the distance from a triangle, as from any convex set, is a convex function, so that over a convex piece of the
//! other surface it is largest at a corner of the piece.
//!
//! ```text
//! piece ← a triangle of the one surface
//! facet ← the triangle of the other one next to the middle of the piece
//! reach ← the largest distance of the piece's corners from the facet: no point of the piece is further off
//! if the reach is small enough: done
//! otherwise cut the piece along the sides of the facet's prism, or, where that cuts nothing, in two; go on with the parts
//! ```
//! ```text
//!   ┌──────╱╲──────┐   seen along the facet's normal: what is cut off lies over other facets, those across the sides
//!   │     ╱  ╲     │   being tried first; the rest is not further from the facet than its corners are from the
//!   │    ╱    ╲    │   facet's plane
//!   └───╱──────╲───┘
//! ```

use std::collections::VecDeque;

use glam::DVec3;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

use crate::distance::squared_to_triangle;
use crate::half_edges::{HalfEdges, NONE, edges_of};
use crate::mesh::Mesh;

/// By how much a bound may exceed the largest distance found, as a share of it.
const PRECISION: f64 = 1.0 / 128.0;
/// Bounds are not looked for below this share of the diagonal of the box around a surface.
const LEAST: f64 = 1e-7;
/// What rounding may make of a distance, as a share of the largest coordinate.
const ROUNDING: f64 = 1e-14;
/// Nor are bounds looked for below so many times that.
const ROUNDINGS: f64 = 100.0;
/// Corners of a piece that are nearer to a plane than this share of its size count as being on it.
const ON_PLANE: f64 = 1e-9;

/// A surface to measure distances from.
pub struct SurfaceTree {
    facets: RTree<Facet>,
    /// The same by number.
    corners: Vec<[DVec3; 3]>,
    /// Numbers of the facets across the sides of each, or [`NONE`].
    across: Vec<[u32; 3]>,
    /// The least bound that is worth work.
    least: f64,
    /// What rounding may add to a distance.
    rounding: f64,
}

impl SurfaceTree {
    /// The surface that the triangles of `mesh` make up, a manifold or not.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let position = |vertex: u32| mesh.positions[vertex as usize];
        let corners: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|corners| corners.map(position)).collect();
        let facets = (0..).zip(&corners).map(|(number, &corners)| Facet { number, corners });
        let half_edges = HalfEdges::new(mesh.positions.len(), mesh.triangles.clone());
        let triangle_across = |edge| match half_edges.twin(edge) {
            NONE => NONE,
            twin => twin / 3,
        };
        let (low, high) = mesh.bounds();
        let largest = low.abs().max(high.abs()).max_element();
        Self {
            facets: RTree::bulk_load(facets.collect()),
            across: (0..)
                .take(corners.len())
                .map(|facet| edges_of(facet).map(triangle_across))
                .collect(),
            corners,
            least: (low.distance(high) * LEAST).max(largest * ROUNDING * ROUNDINGS),
            rounding: largest * ROUNDING,
        }
    }

    /// The least bound that is looked for.
    pub(crate) fn least(&self) -> f64 {
        self.least
    }

    /// Distance of a point; infinite where the surface has no triangles.
    #[must_use]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.nearest(point).1
    }

    /// A bound of the distance from this surface of every point of a triangle: at most `enough` where that is possible, and
    /// hardly more than the largest distance where not. Infinite where the surface has no triangles.
    #[must_use]
    pub fn bound(&self, corners: [DVec3; 3], enough: f64) -> f64 {
        self.search(corners, enough, f64::INFINITY)
    }

    /// Whether every point of a triangle is within `tolerance` of this surface, beyond doubt.
    ///
    /// # Errors
    /// A distance above the tolerance, where there is one or that cannot be ruled out.
    pub(crate) fn holds(&self, corners: [DVec3; 3], tolerance: f64) -> Result<(), f64> {
        let bound = self.search(corners, tolerance - self.rounding, tolerance);
        if bound <= tolerance { Ok(()) } else { Err(bound) }
    }

    /// A bound as [`Self::bound`] has it, or anything above `limit` once it is clear that it will be above.
    fn search(&self, corners: [DVec3; 3], enough: f64, limit: f64) -> f64 {
        let (mut bound, mut enough) = (0.0_f64, enough.max(self.least));
        // First in, first out: large pieces are looked at before small ones, so that what is too far is soon found.
        let mut open = VecDeque::from([Piece::new(corners.to_vec(), NONE)]);
        while let Some(piece) = open.pop_front() {
            let expected = self.corners.get(piece.over as usize);
            if let Some(reach) = expected
                .map(|facet| piece.reach(facet))
                .filter(|&reach| reach <= enough)
            {
                bound = bound.max(reach);
                continue;
            }
            let middle = piece.middle();
            let (Some(facet), distance) = self.nearest(middle) else {
                return f64::INFINITY;
            };
            if distance > limit {
                return distance;
            }
            // No bound can be less than this distance, so that none need be better than a little more.
            enough = enough.max(distance * (1.0 + PRECISION));
            let radius = piece.farthest(|corner| corner.distance_squared(middle));
            let reach = piece.reach(&facet.corners).min(distance + radius);
            if reach <= enough || radius <= self.rounding {
                bound = bound.max(reach);
            } else {
                open.extend(piece.cut(facet, self.across[facet.number as usize], self.rounding));
            }
        }
        bound + self.rounding
    }

    fn nearest(&self, place: DVec3) -> (Option<&Facet>, f64) {
        let facet = self.facets.nearest_neighbor(&place.to_array());
        let distance = facet.map_or(f64::INFINITY, |facet| squared_to_triangle(place, facet.corners).sqrt());
        (facet, distance)
    }
}

/// A triangle of the surface.
#[derive(Clone, Copy)]
struct Facet {
    number: u32,
    corners: [DVec3; 3],
}

impl RTreeObject for Facet {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(self.corners.map(|corner| corner.to_array()).iter())
    }
}

impl PointDistance for Facet {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        squared_to_triangle(DVec3::from_array(*point), self.corners)
    }
}

impl Facet {
    /// The sides of the prism over the facet: a point on each and its direction outwards.
    fn sides(&self) -> [(DVec3, DVec3); 3] {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        [(a, b), (b, c), (c, a)].map(|(from, to)| (from, (to - from).cross(normal).normalize_or_zero()))
    }
}

/// A convex, flat polygon: part of a triangle.
struct Piece {
    corners: Vec<DVec3>,
    /// Number of the facet that it should be next to, or [`NONE`].
    over: u32,
}

impl Piece {
    fn new(corners: Vec<DVec3>, over: u32) -> Self {
        Self { corners, over }
    }

    fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    /// The largest distance of a corner from a facet.
    fn reach(&self, facet: &[DVec3; 3]) -> f64 {
        self.farthest(|corner| squared_to_triangle(corner, *facet))
    }

    /// The root of the largest of what `squared` gives for the corners.
    fn farthest(&self, squared: impl Fn(DVec3) -> f64) -> f64 {
        self.corners
            .iter()
            .map(|&corner| squared(corner))
            .fold(0.0, f64::max)
            .sqrt()
    }

    /// The parts that the sides of a facet's prism cut, at least two; `across` are the facets beyond the sides. What is nearer
    /// to a side than `rounding` is on it.
    fn cut(self, facet: &Facet, across: [u32; 3], rounding: f64) -> Vec<Self> {
        let mut parts = Vec::new();
        let mut inside = Some(self.corners);
        for ((on_side, outwards), beyond) in facet.sides().into_iter().zip(across) {
            let Some(rest) = inside.take() else { break };
            let [below, above] = split(&rest, on_side, outwards, rounding);
            parts.extend(above.map(|part| Self::new(part, beyond)));
            inside = below;
        }
        parts.extend(inside.map(|part| Self::new(part, facet.number)));
        if parts.len() > 1 {
            return parts;
        }
        parts.into_iter().flat_map(Self::halves).collect()
    }

    /// Two parts, cut through the middle, across the direction of the farthest corner.
    fn halves(self) -> impl Iterator<Item = Self> {
        let middle = self.middle();
        let offsets = self.corners.iter().map(|&corner| corner - middle);
        let farthest = offsets.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let direction = farthest.unwrap_or_default().normalize_or_zero();
        let parts = split(&self.corners, middle, direction, 0.0).into_iter().flatten();
        parts.map(move |part| Self::new(part, self.over))
    }
}

/// The parts of a polygon on the two sides of a plane, that which its unit normal points away from first. If there is but
/// one, it is the whole. Corners nearer to the plane than `rounding` count as on it.
fn split(corners: &[DVec3], on_plane: DVec3, normal: DVec3, rounding: f64) -> [Option<Vec<DVec3>>; 2] {
    let size = corners
        .iter()
        .map(|corner| corner.distance_squared(corners[0]))
        .fold(0.0, f64::max)
        .sqrt();
    let height = |&corner: &DVec3| {
        let height = (corner - on_plane).dot(normal);
        let is_off = height.abs() > (ON_PLANE * size).max(rounding);
        if is_off { height } else { 0.0 }
    };
    let is_above = corners.iter().any(|corner| height(corner) > 0.0);
    let is_below = corners.iter().any(|corner| height(corner) < 0.0);
    match (is_below, is_above) {
        (true, true) => [-1.0, 1.0].map(|side| Some(part_above(corners, |corner| height(corner) * side))),
        (false, true) => [None, Some(corners.to_vec())],
        (_, false) => [Some(corners.to_vec()), None],
    }
}

/// The part of a polygon where the height is not below 0.
fn part_above(corners: &[DVec3], height: impl Fn(&DVec3) -> f64) -> Vec<DVec3> {
    let mut part = Vec::with_capacity(corners.len() + 1);
    let following = corners.iter().cycle().skip(1);
    for (corner, following) in corners.iter().zip(following) {
        let (own, other) = (height(corner), height(following));
        if own >= 0.0 {
            part.push(*corner);
        }
        if (own < 0.0 && other > 0.0) || (own > 0.0 && other < 0.0) {
            part.push(corner.lerp(*following, own / (own - other)));
        }
    }
    part
}

#[cfg(test)]
#[path = "hausdorff_tests.rs"]
mod tests;
