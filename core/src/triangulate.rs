//! From samples to a mesh inside the tolerance: a constrained Delaunay triangulation of the outline, refined where it
//! strays furthest from the reference surface.
//!
//! After M. Garland, P. Heckbert, *Fast polygonal approximation of terrains and height fields*, 1995, with two
//! differences: all triangles that stray too far are split in one round, and points between the samples count, too.
//!
//! ```text
//! triangulate the outline's vertices and segments (spade); all vertices are new
//! repeat until no vertex is new:
//!     for each triangle inside the outline at a new vertex (insertion makes no others):
//!         find its worst point, at samples and (bound = surface) along its edges
//!         if it strays further than the tolerance: note the point
//!     insert the points noted: these are the new vertices
//! ```

use std::collections::HashSet;

use glam::{DVec2, DVec3};
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use thiserror::Error;

use crate::mesh::Mesh;
use crate::reference::{Bound, Deviation, GridPoint, Reference};

/// The vertices and segments that a triangulation must have.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Plan position and height of each.
    pub vertices: Vec<DVec3>,
    /// Pairs of vertices joined by an edge; they may touch, but not cross.
    pub segments: Vec<[u32; 2]>,
    /// Whether some of the convex hull is outside, so that faces must be told apart.
    pub has_outside: bool,
}

/// How a mesh is refined.
#[derive(Clone, Copy, Debug)]
pub struct Refinement {
    /// Metres that no point may stray.
    pub tolerance: f64,
    /// Heights are multiples of this, metres; 0 leaves them as they are.
    pub height_step: f64,
    /// A frame whose inside is kept free of new points but for its inner line.
    pub frame: Option<Frame>,
}

/// The square `0 … extent` in plan, and the width of the strip along its sides that holds no vertices inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Length of the sides.
    pub extent: f64,
    /// Width of the strip.
    pub width: f64,
}

impl Frame {
    /// Moves a point in the strip onto its inner line.
    #[must_use]
    pub fn push_in(&self, plan: DVec2) -> DVec2 {
        plan.clamp(DVec2::splat(self.width), DVec2::splat(self.extent - self.width))
    }

    /// Whether both points lie on one and the same side of the square.
    #[must_use]
    pub fn along_side(&self, a: DVec2, b: DVec2) -> bool {
        let on = |p: f64, q: f64| p == q && (p == 0.0 || p == self.extent);
        on(a.x, b.x) || on(a.y, b.y)
    }
}

/// Why an outline cannot be triangulated.
#[derive(Debug, Error, PartialEq)]
pub enum TriangulateError {
    /// spade takes no coordinate that is NaN, infinite or absurdly small.
    #[error("vertex {0} of the outline cannot be triangulated")]
    Coordinate(usize),
    /// Two segments cross.
    #[error("segment {0}–{1} of the outline crosses another")]
    Crossing(u32, u32),
}

/// Triangulates `outline` and refines it until no point of the reference is further than the tolerance away.
/// `is_inside` tells whether a plan position, never one on the outline, belongs to the surface.
///
/// # Errors
/// When the outline is none.
pub fn triangulate(
    outline: &Outline,
    reference: &Reference,
    refinement: Refinement,
    is_inside: impl Fn(DVec2) -> bool,
) -> Result<Mesh, TriangulateError> {
    let mut surface = Surface::new(outline, reference, refinement)?;
    let mut new_vertices: Vec<FixedVertexHandle> = surface.triangulation.fixed_vertices().collect();
    loop {
        let inside = if outline.has_outside {
            surface.inside(&is_inside)
        } else {
            surface.all()
        };
        if new_vertices.is_empty() {
            return Ok(surface.mesh(&inside));
        }
        let points = surface.worst_points(&new_vertices, &inside);
        new_vertices = points.into_iter().filter_map(|tries| surface.insert(tries)).collect();
    }
}

#[derive(Clone, Copy)]
struct Vertex {
    plan: DVec2,
    point: GridPoint,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        Point2::new(self.plan.x, self.plan.y)
    }
}

struct Surface<'a> {
    triangulation: ConstrainedDelaunayTriangulation<Vertex>,
    reference: &'a Reference<'a>,
    refinement: Refinement,
    taken: HashSet<[u64; 2]>,
}

impl<'a> Surface<'a> {
    fn new(outline: &Outline, reference: &'a Reference<'a>, refinement: Refinement) -> Result<Self, TriangulateError> {
        let mut surface = Self {
            triangulation: ConstrainedDelaunayTriangulation::new(),
            reference,
            refinement,
            taken: HashSet::new(),
        };
        let mut handles = Vec::with_capacity(outline.vertices.len());
        for (index, vertex) in outline.vertices.iter().enumerate() {
            let plan = vertex.truncate();
            let point = GridPoint {
                grid: reference.plan.grid(plan),
                height: vertex.z,
            };
            surface.taken.insert(key(plan));
            let handle = surface.triangulation.insert(Vertex { plan, point });
            handles.push(handle.map_err(|_| TriangulateError::Coordinate(index))?);
        }
        for &[a, b] in &outline.segments {
            let (from, to) = (handles[a as usize], handles[b as usize]);
            if from != to && !surface.triangulation.can_add_constraint(from, to) {
                return Err(TriangulateError::Crossing(a, b));
            }
            surface.triangulation.add_constraint(from, to);
        }
        Ok(surface)
    }

    fn all(&self) -> Vec<bool> {
        vec![true; self.triangulation.num_all_faces()]
    }

    /// For each face whether it is of the surface: faces joined across edges that are no segments are alike, and what
    /// most of their area says decides, since close to the outline rounding may tell wrong.
    fn inside(&self, is_inside: &impl Fn(DVec2) -> bool) -> Vec<bool> {
        let mut inside = vec![false; self.triangulation.num_all_faces()];
        let mut seen = inside.clone();
        for face in self.triangulation.inner_faces() {
            if seen[face.index()] {
                continue;
            }
            let region = self.region(face.fix(), &mut seen);
            let vote: f64 = region
                .iter()
                .map(|&face| {
                    let [a, b, c] = self
                        .triangulation
                        .face(face)
                        .vertices()
                        .map(|vertex| vertex.data().plan);
                    let area = (b - a).perp_dot(c - a);
                    if is_inside((a + b + c) / 3.0) { area } else { -area }
                })
                .sum();
            region.iter().for_each(|face| inside[face.index()] = vote > 0.0);
        }
        inside
    }

    fn region(&self, start: FixedFaceHandle<InnerTag>, seen: &mut [bool]) -> Vec<FixedFaceHandle<InnerTag>> {
        let mut region = vec![start];
        seen[start.index()] = true;
        let mut next = 0;
        while next < region.len() {
            for edge in self.triangulation.face(region[next]).adjacent_edges() {
                let across = edge.rev().face();
                if let Some(face) = across.as_inner().filter(|_| !edge.is_constraint_edge())
                    && !seen[face.index()]
                {
                    seen[face.index()] = true;
                    region.push(face.fix());
                }
            }
            next += 1;
        }
        region
    }

    /// For each triangle at a new vertex that strays too far, the points to try, most urgent first: the sample next to
    /// a place before the place itself, since that is where the surface bends.
    fn worst_points(&self, new_vertices: &[FixedVertexHandle], inside: &[bool]) -> Vec<Vec<DVec2>> {
        let mut seen = vec![false; inside.len()];
        let mut points = Vec::new();
        for &vertex in new_vertices {
            for edge in self.triangulation.vertex(vertex).out_edges() {
                let Some(face) = edge.face().as_inner() else { continue };
                if inside[face.index()] && !std::mem::replace(&mut seen[face.index()], true) {
                    let found = self.deviations(face.vertices().map(|vertex| *vertex.data()));
                    if !found.is_empty() {
                        points.push(found.iter().flat_map(|found| [found.at.round(), found.at]).collect());
                    }
                }
            }
        }
        points
    }

    /// Where a triangle strays too far, the worst first.
    fn deviations(&self, corners: [Vertex; 3]) -> Vec<Deviation> {
        let mut found = vec![self.reference.triangle_deviation(corners.map(|corner| corner.point))];
        if self.reference.bound == Bound::Surface {
            for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
                if !self.is_fixed(&from, &to) {
                    found.push(self.reference.edge_deviation(from.point, to.point));
                }
            }
        }
        found.retain(|deviation| deviation.size > self.refinement.tolerance);
        found.sort_by(|a, b| b.size.total_cmp(&a.size));
        found
    }

    fn is_fixed(&self, a: &Vertex, b: &Vertex) -> bool {
        self.refinement
            .frame
            .is_some_and(|frame| frame.along_side(a.plan, b.plan))
    }

    /// Inserts the first of the points that is not there yet.
    fn insert(&mut self, tries: Vec<DVec2>) -> Option<FixedVertexHandle> {
        tries.into_iter().find_map(|grid| self.insert_at(grid))
    }

    fn insert_at(&mut self, grid: DVec2) -> Option<FixedVertexHandle> {
        let rounded = self.reference.plan.plan(grid).round();
        let plan = self.refinement.frame.map_or(rounded, |frame| frame.push_in(rounded));
        let grid = self.reference.plan.grid(plan);
        let height = stepped(self.reference.height_near(grid)?, self.refinement.height_step);
        if !self.taken.insert(key(plan)) {
            return None;
        }
        self.triangulation
            .insert(Vertex {
                plan,
                point: GridPoint { grid, height },
            })
            .ok()
    }

    fn mesh(&self, inside: &[bool]) -> Mesh {
        let mut numbers = vec![u32::MAX; self.triangulation.num_vertices()];
        let mut mesh = Mesh::default();
        for face in self.triangulation.inner_faces().filter(|face| inside[face.index()]) {
            mesh.triangles.push(face.vertices().map(|vertex| {
                let number = &mut numbers[vertex.index()];
                if *number == u32::MAX {
                    *number = mesh.positions.len() as u32;
                    mesh.positions
                        .push(vertex.data().plan.extend(vertex.data().point.height));
                }
                *number
            }));
        }
        mesh
    }
}

/// The multiple of `step` nearest to a height; the height itself where there is no step.
#[must_use]
pub fn stepped(height: f64, step: f64) -> f64 {
    if step > 0.0 {
        (height / step).round() * step
    } else {
        height
    }
}

fn key(plan: DVec2) -> [u64; 2] {
    [plan.x, plan.y].map(|coordinate| (coordinate + 0.0).to_bits())
}
