//! The constrained Delaunay triangulation of an outline: what a surface begins with before it is refined.

use glam::{DVec2, DVec3};
use spade::handles::{
    DirectedEdgeHandle, FaceHandle, FixedDirectedEdgeHandle, FixedFaceHandle, FixedVertexHandle, InnerTag,
};
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
    /// The same, but there is surface on both sides of them, or on none.
    pub breaklines: Vec<[u32; 2]>,
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

/// What an outline becomes.
#[derive(Clone, Debug, Default)]
pub struct Triangulated {
    /// The surface.
    pub mesh: Mesh,
    /// Ends in plan of the edges that breaklines became; some may be no edges of the surface.
    pub breaklines: Vec<[DVec2; 2]>,
}

/// Triangulates `outline`. `is_inside` tells whether a plan position, never one on the outline, belongs to the surface.
///
/// # Errors
/// When the outline is none.
pub fn triangulate(outline: &Outline, is_inside: impl Fn(DVec2) -> bool) -> Result<Triangulated, TriangulateError> {
    let (triangulation, handles) = constrained(outline, &[])?;
    let inside = if outline.has_outside {
        let mut bounds = vec![false; triangulation.num_directed_edges()];
        for edge in edges_of(&triangulation, &handles, &outline.segments) {
            bounds[edge.index()] = true;
            bounds[edge.rev().index()] = true;
        }
        inside(&triangulation, |edge| bounds[edge.index()], &is_inside)
    } else {
        vec![true; triangulation.num_all_faces()]
    };
    Ok(Triangulated {
        mesh: mesh_of(&triangulation, &inside),
        breaklines: breaklines(&triangulation, &handles, outline),
    })
}

/// Ends in plan of the edges that breaklines became.
fn breaklines(triangulation: &Constrained, handles: &[FixedVertexHandle], outline: &Outline) -> Vec<[DVec2; 2]> {
    let edges = edges_of(triangulation, handles, &outline.breaklines);
    let ends = |edge: FixedDirectedEdgeHandle| triangulation.directed_edge(edge).vertices();
    edges
        .map(|edge| ends(edge).map(|end| end.data().0.truncate()))
        .collect()
}

/// The faces that are inside.
fn mesh_of(triangulation: &Constrained, inside: &[bool]) -> Mesh {
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
    mesh
}

/// Triangulates what is to the left of `boundary`, segments between vertices of `outline` like its own ones, of which some
/// may lie outside. Where segments of both directions coincide, there is no boundary.
///
/// # Errors
/// When a vertex cannot be triangulated or segments cross.
pub fn triangulate_beside(outline: &Outline, boundary: &[[u32; 2]]) -> Result<Triangulated, TriangulateError> {
    let (triangulation, handles) = constrained(outline, boundary)?;
    let mut turns = vec![0_i32; triangulation.num_directed_edges()];
    for edge in edges_of(&triangulation, &handles, boundary) {
        turns[edge.index()] += 1;
        turns[edge.rev().index()] -= 1;
    }
    let mut inside = vec![false; triangulation.num_all_faces()];
    let mut seen = inside.clone();
    for face in triangulation.inner_faces() {
        if seen[face.index()] {
            continue;
        }
        let region = region(&triangulation, face.fix(), &mut seen, |edge| turns[edge.index()] != 0);
        let edges = region
            .iter()
            .flat_map(|&face| triangulation.face(face).adjacent_edges());
        let is_left = edges.map(|edge| turns[edge.fix().index()]).sum::<i32>() > 0;
        region.iter().for_each(|face| inside[face.index()] = is_left);
    }
    Ok(Triangulated {
        mesh: mesh_of(&triangulation, &inside),
        breaklines: breaklines(&triangulation, &handles, outline),
    })
}

/// The edges that segments between vertices became.
fn edges_of<'a>(
    triangulation: &'a Constrained,
    handles: &'a [FixedVertexHandle],
    segments: &'a [[u32; 2]],
) -> impl Iterator<Item = FixedDirectedEdgeHandle> + 'a {
    segments
        .iter()
        .flat_map(|&[from, to]| edges_along(triangulation, handles[from as usize], handles[to as usize]))
}

/// The edges that a segment became: more than one where it runs through vertices.
fn edges_along(
    triangulation: &Constrained,
    from: FixedVertexHandle,
    to: FixedVertexHandle,
) -> Vec<FixedDirectedEdgeHandle> {
    let plan = |vertex: FixedVertexHandle| triangulation.vertex(vertex).data().0.truncate();
    let (mut edges, mut at) = (Vec::new(), from);
    while at != to {
        let way = plan(to) - plan(at);
        let follows = |edge: &DirectedEdgeHandle<Vertex, (), CdtEdge<()>, ()>| {
            let step = plan(edge.to().fix()) - plan(at);
            edge.is_constraint_edge() && step.perp_dot(way) == 0.0 && step.dot(way) > 0.0
        };
        let Some(edge) = triangulation.vertex(at).out_edges().find(follows) else {
            break;
        };
        edges.push(edge.fix());
        at = edge.to().fix();
    }
    edges
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

/// The triangulation of an outline with further segments.
fn constrained(
    outline: &Outline,
    boundary: &[[u32; 2]],
) -> Result<(Constrained, Vec<FixedVertexHandle>), TriangulateError> {
    let mut triangulation = Constrained::new();
    let mut handles = Vec::with_capacity(outline.vertices.len());
    for (index, &vertex) in outline.vertices.iter().enumerate() {
        let handle = triangulation.insert(Vertex(vertex));
        handles.push(handle.map_err(|_| TriangulateError::Coordinate(index))?);
    }
    let lines = outline.segments.iter().chain(boundary).chain(&outline.breaklines);
    for &[a, b] in lines {
        let (from, to) = (handles[a as usize], handles[b as usize]);
        if from != to && !triangulation.can_add_constraint(from, to) {
            return Err(TriangulateError::Crossing(a, b));
        }
        triangulation.add_constraint(from, to);
    }
    Ok((triangulation, handles))
}

/// For each face whether it is of the surface: faces joined across edges that do not bound are alike, and what
/// most of their area says decides, since close to the outline rounding may tell wrong. A region that is nowhere
/// wider than rounding lies between an outline that should be straight and its chord: it is outside.
fn inside(
    triangulation: &Constrained,
    bounds: impl Fn(FixedDirectedEdgeHandle) -> bool,
    is_inside: &impl Fn(DVec2) -> bool,
) -> Vec<bool> {
    let mut inside = vec![false; triangulation.num_all_faces()];
    let mut seen = inside.clone();
    for face in triangulation.inner_faces() {
        if seen[face.index()] {
            continue;
        }
        let region = region(triangulation, face.fix(), &mut seen, &bounds);
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
    is_boundary: impl Fn(FixedDirectedEdgeHandle) -> bool,
) -> Vec<FixedFaceHandle<InnerTag>> {
    let mut region = vec![start];
    seen[start.index()] = true;
    let mut next = 0;
    while next < region.len() {
        for edge in triangulation.face(region[next]).adjacent_edges() {
            let across = edge.rev().face();
            if let Some(face) = across.as_inner().filter(|_| !is_boundary(edge.fix()))
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
