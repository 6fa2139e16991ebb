//! A triangle mesh as two flat arrays, and the one validator that every mesh passes.

use std::collections::HashMap;

use glam::DVec3;
use thiserror::Error;

/// Vertices and triangles. Positions are in whatever local frame the maker chose (metres, lattice units, grid
/// cells); triangles are counter-clockwise seen from above (from +z).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// One position a vertex.
    pub positions: Vec<DVec3>,
    /// Three vertex indices a triangle, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The smallest and the largest coordinates; infinite, and the wrong way round, where there are no vertices.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let wider = |(low, high): (DVec3, DVec3), &at: &DVec3| (low.min(at), high.max(at));
        self.positions.iter().fold(nowhere, wider)
    }
}

/// Why a mesh is not a terrain surface.
#[derive(Debug, Error, PartialEq)]
pub enum MeshError {
    /// A corner points past the vertex array.
    #[error("triangle {triangle} uses vertex {vertex}, but there are {count}")]
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The index it uses.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// Two corners are one vertex.
    #[error("triangle {0} uses a vertex twice")]
    Degenerate(usize),
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} is not finite")]
    NotFinite(usize),
    /// More than two triangles share an edge, or two of them run along it in one direction.
    #[error("edge {0}–{1} is used twice in the same direction")]
    NonManifoldEdge(u32, u32),
    /// Seen from above the triangle is clockwise or has no area.
    #[error("triangle {0} is not counter-clockwise in plan view")]
    NotCounterClockwise(usize),
}

/// Checks that `mesh` is an oriented 2-manifold edge by edge and that every triangle is counter-clockwise in plan
/// view, by exact arithmetic on the coordinates.
///
/// # Errors
/// The first fault, by triangle order.
pub fn validate(mesh: &Mesh) -> Result<(), MeshError> {
    validate_topology(mesh.positions.len(), &mesh.triangles)?;
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite(vertex));
    }
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        if plan_orientation(a, b, c) <= 0.0 {
            return Err(MeshError::NotCounterClockwise(index));
        }
    }
    Ok(())
}

/// The part of [`validate`] that needs no coordinates; it holds for surfaces that are no height fields, too.
///
/// # Errors
/// The first fault, by triangle order.
pub fn validate_topology(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    let mut seen = HashMap::with_capacity(triangles.len() * 3);
    for (index, triangle) in triangles.iter().enumerate() {
        if let Some(&vertex) = triangle.iter().find(|&&v| v as usize >= vertex_count) {
            return Err(MeshError::IndexOutOfRange {
                triangle: index,
                vertex,
                count: vertex_count,
            });
        }
        let [a, b, c] = *triangle;
        if a == b || b == c || c == a {
            return Err(MeshError::Degenerate(index));
        }
        for edge in [(a, b), (b, c), (c, a)] {
            if seen.insert(edge, index).is_some() {
                return Err(MeshError::NonManifoldEdge(edge.0, edge.1));
            }
        }
    }
    Ok(())
}

/// Directed edges that run along one triangle alone: the surface is to their left. Sorted by their ends.
#[must_use]
pub fn boundary_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32)> {
    let edges = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
    let mut all: Vec<((u32, u32), bool)> = triangles
        .iter()
        .flat_map(edges)
        .map(|(a, b)| ((a.min(b), a.max(b)), a < b))
        .collect();
    all.sort_unstable();
    let alone = all.chunk_by(|a, b| a.0 == b.0).filter(|edges| edges.len() == 1);
    alone
        .map(|edges| match edges[0] {
            (ends, true) => ends,
            ((a, b), false) => (b, a),
        })
        .collect()
}

/// Gives every fan of triangles that meets others in nothing but a vertex a vertex of its own, so that the star of each
/// is a disk or half a disk. Vertices for which `is_shared` holds are left alone.
///
/// ```text
///   ╲ A │          ╲ A │
///    ╲  │           ╲  │
///     ╲ v ───   ▶    ╲ v   v' ───
///       │  B ╲              │  B ╲
/// ```
pub fn separate_fans(mesh: &mut Mesh, is_shared: impl Fn(DVec3) -> bool) {
    let directed = |index: usize, &[a, b, c]: &[u32; 3]| [((a, b), index), ((b, c), index), ((c, a), index)];
    let edges: HashMap<(u32, u32), usize> = mesh
        .triangles
        .iter()
        .enumerate()
        .flat_map(|(index, corners)| directed(index, corners))
        .collect();
    let mut begins: Vec<(u32, u32)> = edges
        .keys()
        .copied()
        .filter(|&(a, b)| !edges.contains_key(&(b, a)))
        .collect();
    begins.sort_unstable();
    for pair in begins.windows(2) {
        let (vertex, first) = pair[1];
        if pair[0].0 != vertex || is_shared(mesh.positions[vertex as usize]) {
            continue;
        }
        let own = mesh.positions.len() as u32;
        mesh.positions.push(mesh.positions[vertex as usize]);
        let mut next = edges.get(&(vertex, first));
        while let Some(&triangle) = next {
            let corners = &mut mesh.triangles[triangle];
            let at = corners.iter().position(|&corner| corner == vertex).unwrap_or(0);
            corners[at] = own;
            next = edges.get(&(vertex, corners[(at + 2) % 3]));
        }
    }
}

/// Twice the signed plan-view area's sign, exactly: positive where `a → b → c` turns left.
#[must_use]
pub fn plan_orientation(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let coordinate = |p: DVec3| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coordinate(a), coordinate(b), coordinate(c))
}

#[cfg(test)]
#[path = "mesh_tests.rs"]
pub(crate) mod tests;
