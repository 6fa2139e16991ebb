//! The constrained Delaunay triangulation of an outline: what a surface begins with before it is refined.

use glam::{DVec2, DVec3};
use spade::handles::{FaceHandle, FixedFaceHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use thiserror::Error;

use crate::mesh::Mesh;

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

/// Triangulates `outline`. `is_inside` tells whether a plan position, never one on the outline, belongs to the surface.
///
/// # Errors
/// When the outline is none.
pub fn triangulate(outline: &Outline, is_inside: impl Fn(DVec2) -> bool) -> Result<Mesh, TriangulateError> {
    let triangulation = constrained(outline)?;
    let inside = if outline.has_outside {
        inside(&triangulation, &is_inside)
    } else {
        vec![true; triangulation.num_all_faces()]
    };
    let mut numbers = vec![u32::MAX; triangulation.num_vertices()];
    let mut mesh = Mesh::default();
    for face in triangulation.inner_faces().filter(|face| inside[face.index()]) {
        mesh.triangles.push(face.vertices().map(|vertex| {
            let number = &mut numbers[vertex.index()];
            if *number == u32::MAX {
                *number = mesh.positions.len() as u32;
                mesh.positions.push(vertex.data().0);
            }
            *number
        }));
    }
    Ok(mesh)
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

type Constrained = ConstrainedDelaunayTriangulation<Vertex>;
type TriangleHandle<'a> = FaceHandle<'a, InnerTag, Vertex, (), CdtEdge<()>, ()>;

struct Vertex(DVec3);

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        Point2::new(self.0.x, self.0.y)
    }
}

fn constrained(outline: &Outline) -> Result<Constrained, TriangulateError> {
    let mut triangulation = Constrained::new();
    let mut handles = Vec::with_capacity(outline.vertices.len());
    for (index, &vertex) in outline.vertices.iter().enumerate() {
        let handle = triangulation.insert(Vertex(vertex));
        handles.push(handle.map_err(|_| TriangulateError::Coordinate(index))?);
    }
    for &[a, b] in &outline.segments {
        let (from, to) = (handles[a as usize], handles[b as usize]);
        if from != to && !triangulation.can_add_constraint(from, to) {
            return Err(TriangulateError::Crossing(a, b));
        }
        triangulation.add_constraint(from, to);
    }
    Ok(triangulation)
}

/// For each face whether it is of the surface: faces joined across edges that are no segments are alike, and what
/// most of their area says decides, since close to the outline rounding may tell wrong. A region that is nowhere
/// wider than rounding lies between an outline that should be straight and its chord: it is outside.
fn inside(triangulation: &Constrained, is_inside: &impl Fn(DVec2) -> bool) -> Vec<bool> {
    let mut inside = vec![false; triangulation.num_all_faces()];
    let mut seen = inside.clone();
    for face in triangulation.inner_faces() {
        if seen[face.index()] {
            continue;
        }
        let region = region(triangulation, face.fix(), &mut seen);
        let (mut vote, mut area) = (0.0, 0.0);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &face in &region {
            let [a, b, c] = plan_corners(triangulation.face(face));
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

fn plan_corners(face: TriangleHandle) -> [DVec2; 3] {
    face.vertices().map(|vertex| vertex.data().0.truncate())
}

fn region(
    triangulation: &Constrained,
    start: FixedFaceHandle<InnerTag>,
    seen: &mut [bool],
) -> Vec<FixedFaceHandle<InnerTag>> {
    let mut region = vec![start];
    seen[start.index()] = true;
    let mut next = 0;
    while next < region.len() {
        for edge in triangulation.face(region[next]).adjacent_edges() {
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
