//! From samples to a mesh inside the tolerance: a constrained Delaunay triangulation of the outline, refined where it
//! strays furthest from the reference surface.
//!
//! After M. Garland, P. Heckbert, *Fast polygonal approximation of terrains and height fields*, 1995, with two
//! differences: all triangles that stray too far are split in one round, and points between the samples count, too.
//!
//! ```text
//! triangulate the outline's vertices and segments (spade); all triangles are suspects
//! repeat until there are no suspects:
//!     for each suspect inside the outline:
//!         find its worst point, at samples and (bound = surface) along its edges
//!         if it strays further than the tolerance: insert a point there, or the sample nearest to it
//!     suspects ← triangles at the points inserted, and those that strayed and are still there
//! ```

use std::collections::HashSet;

use glam::{DVec2, DVec3};
use spade::handles::{FaceHandle, FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use thiserror::Error;

use crate::mesh::Mesh;
use crate::reference::{Bound, Deviation, GridPoint, Reference};

/// Plan units: vertices are rounded to whole ones, so an outline may be off by half a diagonal on either side.
const ROUNDING_WIDTH: f64 = 1.5;

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
    let mut suspects: Vec<[FixedVertexHandle; 3]> = surface.triangulation.inner_faces().map(corners_of).collect();
    loop {
        let inside = if outline.has_outside {
            surface.inside(&is_inside)
        } else {
            surface.all()
        };
        if suspects.is_empty() {
            return Ok(surface.mesh(&inside));
        }
        suspects = surface.refine(suspects, &inside);
    }
}

type TriangleHandle<'a> = FaceHandle<'a, InnerTag, Vertex, (), CdtEdge<()>, ()>;

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
    /// most of their area says decides, since close to the outline rounding may tell wrong. A region that is nowhere
    /// wider than rounding lies between an outline that should be straight and its chord: it is outside.
    fn inside(&self, is_inside: &impl Fn(DVec2) -> bool) -> Vec<bool> {
        let mut inside = vec![false; self.triangulation.num_all_faces()];
        let mut seen = inside.clone();
        for face in self.triangulation.inner_faces() {
            if seen[face.index()] {
                continue;
            }
            let region = self.region(face.fix(), &mut seen);
            let (mut vote, mut area) = (0.0, 0.0);
            let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for &face in &region {
                let [a, b, c] = self
                    .triangulation
                    .face(face)
                    .vertices()
                    .map(|vertex| vertex.data().plan);
                let size = (b - a).perp_dot(c - a) / 2.0;
                area += size;
                vote += if is_inside((a + b + c) / 3.0) { size } else { -size };
                (low, high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
            }
            let is_of_surface = vote > 0.0 && area > ROUNDING_WIDTH * low.distance(high);
            region.iter().for_each(|face| inside[face.index()] = is_of_surface);
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

    /// Inserts a point for each suspect that strays too far; gives the next suspects, which may be named twice.
    fn refine(&mut self, suspects: Vec<[FixedVertexHandle; 3]>, inside: &[bool]) -> Vec<[FixedVertexHandle; 3]> {
        let mut seen = vec![false; inside.len()];
        let mut strayed = Vec::new();
        for corners in suspects {
            let Some(face) = self.face(corners) else { continue };
            if inside[face.index()] && !std::mem::replace(&mut seen[face.index()], true) {
                let found = self.deviations(corners.map(|corner| *self.triangulation.vertex(corner).data()));
                if !found.is_empty() {
                    strayed.push((corners, found));
                }
            }
        }
        let mut next = Vec::new();
        let mut has_new_vertex = false;
        for (corners, found) in strayed {
            next.push(corners);
            // The sample next to a place before the place itself, since that is where the surface bends.
            let mut tries = found.iter().flat_map(|found| [found.at.round(), found.at]);
            if let Some(vertex) = tries.find_map(|grid| self.insert_at(grid)) {
                let around = self.triangulation.vertex(vertex).out_edges();
                next.extend(around.filter_map(|edge| edge.face().as_inner()).map(corners_of));
                has_new_vertex = true;
            }
        }
        if has_new_vertex { next } else { Vec::new() }
    }

    /// The triangle of these corners, if it is still there.
    fn face(&self, [a, b, c]: [FixedVertexHandle; 3]) -> Option<FixedFaceHandle<InnerTag>> {
        let edge = self.triangulation.get_edge_from_neighbors(a, b)?;
        let face = edge.face().as_inner()?;
        (edge.next().to().fix() == c).then(|| face.fix())
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

fn corners_of(face: TriangleHandle) -> [FixedVertexHandle; 3] {
    face.vertices().map(|vertex| vertex.fix())
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
