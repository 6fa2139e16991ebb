//! Whether a set of triangles is an oriented 2-manifold: the star of every vertex a disk, or half a disk at the
//! boundary (Surface Partitions §1.1).

use thiserror::Error;

use crate::mesh::Mesh;
use crate::topology::connectivity::Connectivity;

/// Why a mesh is not a 2-manifold.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum ManifoldError {
    /// A corner points past the vertex array, or two corners are one vertex.
    #[error("triangle {0} does not have three different vertices of the mesh")]
    BadTriangle(u32),
    /// More than two triangles share the edge, or two of them run along it in one direction.
    #[error("edge {0}–{1} is used twice in the same direction")]
    Edge(u32, u32),
    /// The triangles around the vertex are several fans.
    #[error("the surface around vertex {0} falls into parts that share nothing else")]
    Vertex(u32),
}

/// Checks that every triangle has three different vertices of the mesh.
///
/// # Errors
/// [`ManifoldError::BadTriangle`], for the first that has not.
pub fn check_corners(mesh: &Mesh) -> Result<(), ManifoldError> {
    let is_bad = |&[a, b, c]: &[u32; 3]| {
        let last = a.max(b).max(c) as usize;
        a == b || b == c || c == a || last >= mesh.positions.len()
    };
    match mesh.triangles.iter().position(is_bad) {
        Some(triangle) => Err(ManifoldError::BadTriangle(triangle as u32)),
        None => Ok(()),
    }
}

/// Checks the star of every vertex, in time that grows with the number of triangles.
///
/// # Errors
/// The first fault, by vertex.
pub fn check_stars(connectivity: &Connectivity) -> Result<(), ManifoldError> {
    let mut fan = Fan::new(connectivity.vertex_count());
    (0..connectivity.vertex_count() as u32).try_for_each(|vertex| fan.check(connectivity, vertex))
}

/// The triangles around one vertex as steps from neighbour to neighbour, counter-clockwise.
struct Fan {
    /// For each neighbour the next one, and the vertex that it was noted for.
    next: Vec<(u32, u32)>,
    /// The vertex for which each neighbour was found to have a previous one.
    has_previous: Vec<u32>,
}

impl Fan {
    fn new(vertex_count: usize) -> Self {
        Self {
            next: vec![(u32::MAX, u32::MAX); vertex_count],
            has_previous: vec![u32::MAX; vertex_count],
        }
    }

    fn check(&mut self, connectivity: &Connectivity, vertex: u32) -> Result<(), ManifoldError> {
        let mut triangle_count = 0;
        for triangle in connectivity.star(vertex) {
            let (from, to) = neighbours(connectivity.corners(triangle), vertex);
            if self.next[from as usize].1 == vertex {
                return Err(ManifoldError::Edge(vertex, from));
            }
            if self.has_previous[to as usize] == vertex {
                return Err(ManifoldError::Edge(to, vertex));
            }
            self.next[from as usize] = (to, vertex);
            self.has_previous[to as usize] = vertex;
            triangle_count += 1;
        }
        if self.steps_in_first_part(connectivity, vertex) == triangle_count {
            Ok(())
        } else {
            Err(ManifoldError::Vertex(vertex))
        }
    }

    /// Steps from where a fan begins, or once around.
    fn steps_in_first_part(&self, connectivity: &Connectivity, vertex: u32) -> usize {
        let starts = || {
            connectivity
                .star(vertex)
                .map(|t| neighbours(connectivity.corners(t), vertex).0)
        };
        let begin = starts().find(|&from| self.has_previous[from as usize] != vertex);
        let Some(begin) = begin.or_else(|| starts().next()) else {
            return 0;
        };
        let step = |&at: &u32| {
            let (to, owner) = self.next[at as usize];
            (owner == vertex).then_some(to)
        };
        let visited = std::iter::successors(step(&begin), |at| step(at).filter(|_| *at != begin));
        visited.count()
    }
}

/// The corners after `vertex`, in order.
fn neighbours([a, b, c]: [u32; 3], vertex: u32) -> (u32, u32) {
    match vertex {
        _ if vertex == a => (b, c),
        _ if vertex == b => (c, a),
        _ => (a, b),
    }
}

#[cfg(test)]
#[path = "manifold_tests.rs"]
mod tests;
