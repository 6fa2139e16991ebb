//! How far the points of one surface are from another, as a bound that is proven: what a level of detail claims.
//!
//! After M. Guthe, P. Borodin, R. Klein, *Fast and accurate Hausdorff distance calculation between meshes*, 2005. It leans on
//! one fact: the distance from a triangle, as from any convex set, is a convex function, so that over a convex piece of the
//! other surface it is largest at a corner of the piece.
//!
//! ```text
//! piece ← a triangle of the one surface
//! reach ← the largest distance of the piece's corners from the facet of the other one that the triangle before was next to
//! if the reach is small enough: done
//! facet ← the one next to the middle of the piece
//! reach ← the same from that facet, or the middle's distance and the piece's radius: no point of the piece is further off
//! if the reach is small enough, or too many pieces have been looked at: done
//! otherwise cut the piece along the sides of the facet's prism, or, where that cuts little, in two; go on with the parts
//! ```
//! ```text
//!   ┌──────╱╲──────┐   seen along the facet's normal: what is cut off lies over other facets, those across the sides
//!   │     ╱  ╲     │   being tried first; the rest is not further from the facet than its corners are from the
//!   │    ╱    ╲    │   facet's plane
//!   └───╱──────╲───┘
//! ```

use std::collections::VecDeque;

use glam::DVec3;
use smallvec::SmallVec;

use crate::mesh::Mesh;
use crate::space::distance::squared_to_triangle;
use crate::space::facet_tree::{Facet, FacetTree, Nearest};
use crate::topology::half_edges::{HalfEdges, NONE, edges_of};

/// By how much a bound may exceed the largest distance found, as a share of it.
pub const PRECISION: f64 = 1.0 / 64.0;
/// Bounds are not looked for below this share of the diagonal of the box around a surface.
const LEAST: f64 = 1e-7;
/// What rounding may make of a distance, as a share of the largest coordinate.
const ROUNDING: f64 = 1e-14;
/// Nor are bounds looked for below so many times that.
const ROUNDINGS: f64 = 100.0;
/// Corners of a piece that are nearer to a plane than this share of its size count as being on it.
const ON_PLANE: f64 = 1e-9;
/// Pieces of one triangle that are looked at before any bound of the rest is taken.
const MOST_PIECES: usize = 1 << 14;
/// Radius of a piece over that of a facet from which on the piece is halved and not cut to the facet.
const MUCH_LARGER: f64 = 2.0;

/// A surface to measure distances from.
pub struct SurfaceTree {
    facets: FacetTree,
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
        let corners: Vec<Facet> = mesh.triangles.iter().map(|corners| corners.map(position)).collect();
        let (facets, order) = FacetTree::new(&corners);
        let (low, high) = mesh.bounds();
        let largest = low.abs().max(high.abs()).max_element();
        Self {
            facets,
            across: facets_across(mesh, &order),
            least: (low.distance(high) * LEAST).max(largest * ROUNDING * ROUNDINGS),
            rounding: largest * ROUNDING,
        }
    }

    /// The least bound that is looked for.
    pub(crate) fn least(&self) -> f64 {
        self.least
    }

    /// The corners of all triangles. Those that follow each other are near each other.
    #[must_use]
    pub fn facets(&self) -> &[[DVec3; 3]] {
        self.facets.facets()
    }

    /// The largest distance from this surface of the first corners and the middles of `triangles`, which should follow each other
    /// in space; infinite where the surface has no triangles.
    #[must_use]
    pub fn farthest(&self, triangles: &[[DVec3; 3]]) -> f64 {
        let (mut squared, mut expected) = (0.0, 0);
        for point in triangles.iter().flat_map(|&[a, b, c]| [a, (a + b + c) / 3.0]) {
            let Some(nearest) = self.facets.nearest(point, expected, squared) else {
                return f64::INFINITY;
            };
            expected = nearest.facet;
            squared = nearest.squared.max(squared);
        }
        squared.sqrt()
    }

    /// A bound of the distance from this surface of every point of `triangles`, which should follow each other in space: at
    /// most `enough` where that is possible, and hardly more than the largest distance where not. Infinite where the surface
    /// has no triangles.
    #[must_use]
    pub fn bound(&self, triangles: &[[DVec3; 3]], enough: f64) -> f64 {
        let mut search = Search {
            surface: self,
            enough: enough.max(self.least),
            bound: 0.0,
            expected: 0,
            open: VecDeque::new(),
        };
        triangles.iter().for_each(|&corners| search.look_at_triangle(corners));
        search.bound + self.rounding
    }

    /// A facet within `tolerance` of a point; `expected` is looked at first.
    ///
    /// # Errors
    /// The distance of the nearest, where it is more.
    pub(crate) fn facet_within(&self, tolerance: f64, point: DVec3, expected: u32) -> Result<u32, f64> {
        match self.facets.nearest(point, expected, tolerance * tolerance) {
            Some(Nearest { facet, squared }) if squared <= tolerance * tolerance => Ok(facet),
            nearest => Err(nearest.map_or(f64::INFINITY, |nearest| nearest.squared.sqrt())),
        }
    }
}

/// Numbers of the facets across the sides of each. `order` has the triangle of each facet.
fn facets_across(mesh: &Mesh, order: &[u32]) -> Vec<[u32; 3]> {
    let triangles = order.iter().map(|&triangle| mesh.triangles[triangle as usize]);
    let half_edges = HalfEdges::new(mesh.positions.len(), triangles.collect());
    let facet_across = |edge| match half_edges.twin(edge) {
        NONE => NONE,
        twin => twin / 3,
    };
    let facets = (0..).take(order.len());
    facets.map(|facet| edges_of(facet).map(facet_across)).collect()
}

/// The measuring of triangles that follow each other.
struct Search<'a> {
    surface: &'a SurfaceTree,
    /// Bounds need not be better.
    enough: f64,
    /// No point so far is further away.
    bound: f64,
    /// The facet that something was next to the last time.
    expected: u32,
    /// First in, first out: large pieces are looked at before small ones, so that what is far is soon found.
    open: VecDeque<Piece>,
}

impl Search<'_> {
    fn look_at_triangle(&mut self, corners: Facet) {
        self.open.push_back(Piece {
            corners: SmallVec::from_slice(&corners),
            over: self.expected,
        });
        let mut pieces = 0;
        while let Some(piece) = self.open.pop_front() {
            pieces += 1;
            self.look_at(&piece, pieces + self.open.len() < MOST_PIECES);
        }
    }

    /// Bounds the distance of a piece, or opens its parts if it `may_cut`.
    fn look_at(&mut self, piece: &Piece, may_cut: bool) {
        let facets = self.surface.facets.facets();
        let expected = facets.get(piece.over as usize);
        if let Some(reach) = expected
            .map(|facet| piece.reach(facet))
            .filter(|&reach| reach <= self.enough)
        {
            self.bound = self.bound.max(reach);
            return;
        }
        let middle = piece.middle();
        let Some(nearest) = self.surface.facets.nearest(middle, piece.over, 0.0) else {
            self.bound = f64::INFINITY;
            return;
        };
        self.expected = nearest.facet;
        let distance = nearest.squared.sqrt();
        // No bound can be less than this distance, so that none need be better than a little more.
        self.enough = self.enough.max(distance * (1.0 + PRECISION));
        let radius = piece.farthest(|corner| corner.distance_squared(middle));
        let facet = &facets[nearest.facet as usize];
        let reach = piece.reach(facet).min(distance + radius);
        if reach <= self.enough || radius <= self.surface.rounding || !may_cut {
            self.bound = self.bound.max(reach);
        } else if radius > MUCH_LARGER * facet[0].distance(facet[1]).max(facet[0].distance(facet[2])) {
            self.open.extend(piece.halves(nearest.facet));
        } else {
            let across = self.surface.across[nearest.facet as usize];
            self.open
                .extend(piece.cut(nearest.facet, facet, across, self.surface.rounding));
        }
    }
}

/// Corners of a convex, flat polygon.
type Polygon = SmallVec<[DVec3; 7]>;

/// A part of a triangle.
struct Piece {
    corners: Polygon,
    /// Number of the facet that it should be next to, or [`NONE`].
    over: u32,
}

impl Piece {
    fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    /// The largest distance of a corner from a facet.
    fn reach(&self, facet: &Facet) -> f64 {
        self.farthest(|corner| squared_to_triangle(corner, *facet))
    }

    /// The root of the largest of what `squared` gives for the corners.
    fn farthest(&self, squared: impl Fn(DVec3) -> f64) -> f64 {
        let each = self.corners.iter().map(|&corner| squared(corner));
        each.fold(0.0, f64::max).sqrt()
    }

    /// The parts that the sides of a facet's prism cut, at least two; `across` are the facets beyond the sides. What is nearer
    /// to a side than `rounding` is on it.
    fn cut(&self, number: u32, facet: &Facet, across: [u32; 3], rounding: f64) -> SmallVec<[Self; 4]> {
        let mut parts = SmallVec::new();
        let mut inside = Some(self.corners.clone());
        for ((on_side, outwards), beyond) in prism_sides(facet).into_iter().zip(across) {
            let Some(rest) = inside.take() else { break };
            let [below, above] = split(&rest, on_side, outwards, rounding);
            parts.extend(above.map(|corners| Self { corners, over: beyond }));
            inside = below;
        }
        parts.extend(inside.map(|corners| Self { corners, over: number }));
        if parts.len() > 1 { parts } else { self.halves(number) }
    }

    /// Two parts, cut through the middle, across the direction of the farthest corner.
    fn halves(&self, over: u32) -> SmallVec<[Self; 4]> {
        let middle = self.middle();
        let offsets = self.corners.iter().map(|&corner| corner - middle);
        let farthest = offsets.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let direction = farthest.unwrap_or_default().normalize_or_zero();
        let parts = split(&self.corners, middle, direction, 0.0).into_iter().flatten();
        parts.map(|corners| Self { corners, over }).collect()
    }
}

/// The sides of the prism over a facet: a point on each and its direction outwards.
fn prism_sides(&[a, b, c]: &Facet) -> [(DVec3, DVec3); 3] {
    let normal = (b - a).cross(c - a);
    [(a, b), (b, c), (c, a)].map(|(from, to)| (from, (to - from).cross(normal).normalize_or_zero()))
}

/// The parts of a polygon on the two sides of a plane, that which its unit normal points away from first. If there is but
/// one, it is the whole. Corners nearer to the plane than `rounding` count as on it.
fn split(corners: &Polygon, on_plane: DVec3, normal: DVec3, rounding: f64) -> [Option<Polygon>; 2] {
    let squared_sizes = corners.iter().map(|corner| corner.distance_squared(corners[0]));
    let least = (ON_PLANE * squared_sizes.fold(0.0, f64::max).sqrt()).max(rounding);
    let height = |corner: &DVec3| {
        let height = (corner - on_plane).dot(normal);
        if height.abs() > least { height } else { 0.0 }
    };
    let heights: SmallVec<[f64; 7]> = corners.iter().map(height).collect();
    let is_above = heights.iter().any(|&height| height > 0.0);
    let is_below = heights.iter().any(|&height| height < 0.0);
    match (is_below, is_above) {
        (true, true) => [-1.0, 1.0].map(|side| Some(part_above(corners, &heights, side))),
        (false, true) => [None, Some(corners.clone())],
        (_, false) => [Some(corners.clone()), None],
    }
}

/// The part of a polygon where the height, times `side`, is not below 0.
fn part_above(corners: &Polygon, heights: &[f64], side: f64) -> Polygon {
    let mut part = Polygon::new();
    for (place, corner) in corners.iter().enumerate() {
        let following = (place + 1) % corners.len();
        let (own, other) = (heights[place] * side, heights[following] * side);
        if own >= 0.0 {
            part.push(*corner);
        }
        if own.min(other) < 0.0 && own.max(other) > 0.0 {
            part.push(corner.lerp(corners[following], own / (own - other)));
        }
    }
    part
}

#[cfg(test)]
#[path = "hausdorff_tests.rs"]
mod tests;
