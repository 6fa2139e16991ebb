//! A surface as half-edges, its boundaries closed by virtual triangles, so that everything after it works on closed
//! surfaces only.
//!
//! ```text
//!          ∞               half-edge 3t + k runs from corner k of triangle t to the next one;
//!        ╱ │ ╲             along each boundary edge a → b lies a virtual triangle (b, a, ∞);
//!     c ── b ── a          each boundary loop has a virtual vertex ∞ of its own, numbered on from the real ones;
//!      ╲ ╱   ╲ ╱           virtual triangles stand behind the real ones
//! ```

use std::collections::HashMap;

use thiserror::Error;

use crate::topology::half_edges::{HalfEdges, next};

/// A triangle has three half-edges and at most three virtual neighbours.
const MOST_TRIANGLES: u32 = u32::MAX / 12;

/// Why triangles are no surface that can be split.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SurfaceError {
    /// A corner is no vertex, or two corners are one.
    #[error("triangle {0} has a corner out of range or one vertex twice")]
    BadTriangle(usize),
    /// Two triangles run along an edge in the same direction.
    #[error("edge {0}–{1} is used twice in the same direction")]
    Edge(u32, u32),
    /// The triangles around a vertex are several fans.
    #[error("the triangles around vertex {0} fall into parts that share nothing else")]
    Vertex(u32),
    /// Indices of 32 bits do not suffice.
    #[error("more than {} triangles", MOST_TRIANGLES)]
    TooLarge,
}

/// An oriented 2-manifold, with or without boundaries.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedSurface {
    vertex_count: u32,
    triangle_count: u32,
    /// Of the real triangles, then of the virtual ones.
    half_edges: HalfEdges,
}

impl ClosedSurface {
    /// The surface of `triangles`, counter-clockwise corners among `vertex_count` vertices.
    ///
    /// # Errors
    /// When it is no oriented 2-manifold.
    pub fn new(vertex_count: u32, triangles: &[[u32; 3]]) -> Result<Self, SurfaceError> {
        if triangles.len() > MOST_TRIANGLES as usize {
            return Err(SurfaceError::TooLarge);
        }
        let is_bad = |&[a, b, c]: &[u32; 3]| a == b || b == c || c == a || a.max(b).max(c) >= vertex_count;
        if let Some(triangle) = triangles.iter().position(is_bad) {
            return Err(SurfaceError::BadTriangle(triangle));
        }
        let mut closed = triangles.to_vec();
        close_boundaries(vertex_count, &mut closed)?;
        Self::from_closed(vertex_count, triangles.len() as u32, closed)
    }

    /// A surface whose boundaries have been closed: the first `triangle_count` of `triangles` are real, vertices from
    /// `vertex_count` on virtual.
    pub(super) fn from_closed(
        vertex_count: u32,
        triangle_count: u32,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, SurfaceError> {
        directed_edges(&triangles)?;
        let last = triangles.as_flattened().iter().copied().max();
        let closed_vertex_count = last.map_or(0, |vertex| vertex + 1).max(vertex_count);
        let half_edges = HalfEdges::new(closed_vertex_count as usize, triangles);
        if let Some((from, to)) = half_edges.boundary().next() {
            return Err(SurfaceError::Edge(from, to));
        }
        let surface = Self {
            vertex_count,
            triangle_count,
            half_edges,
        };
        surface.check_fans()?;
        Ok(surface)
    }

    /// How many vertices there are, virtual ones not counted.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// The triangles, virtual ones left out.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.closed_triangles()[..self.triangle_count as usize]
    }

    /// All edges, smaller vertex first, in growing order.
    #[must_use]
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let half_edges = 0..self.half_edge_count() as u32;
        let ends = half_edges.map(|half_edge| [self.origin(half_edge), self.target(half_edge)]);
        let mut edges: Vec<[u32; 2]> = ends.filter(|&[from, to]| from < to && !self.is_virtual(to)).collect();
        edges.sort_unstable();
        edges
    }

    pub(super) fn closed_triangles(&self) -> &[[u32; 3]] {
        self.half_edges.triangles()
    }

    pub(super) fn is_virtual(&self, vertex: u32) -> bool {
        vertex >= self.vertex_count
    }

    /// One past the last virtual vertex.
    pub(super) fn closed_vertex_count(&self) -> u32 {
        self.half_edges.vertex_slots()
    }

    pub(super) fn half_edge_count(&self) -> usize {
        3 * self.closed_triangles().len()
    }

    pub(super) fn origin(&self, half_edge: u32) -> u32 {
        self.half_edges.origin(half_edge)
    }

    pub(super) fn target(&self, half_edge: u32) -> u32 {
        self.half_edges.end(half_edge)
    }

    pub(super) fn opposite(&self, half_edge: u32) -> u32 {
        self.half_edges.twin(half_edge)
    }

    /// For each vertex, virtual ones as well, one half-edge that leaves it, where there is any.
    pub(super) fn leaving(&self) -> Vec<Option<u32>> {
        let vertices = 0..self.closed_vertex_count();
        vertices.map(|vertex| self.half_edges.leaving(vertex).next()).collect()
    }

    /// The half-edges that leave the vertex that `first` leaves, clockwise.
    pub(super) fn fan(&self, first: u32) -> impl Iterator<Item = u32> + '_ {
        let turn = move |&half_edge: &u32| Some(next(self.opposite(half_edge))).filter(|&turned| turned != first);
        std::iter::successors(Some(first), turn)
    }

    fn check_fans(&self) -> Result<(), SurfaceError> {
        let leaving = self.leaving();
        let mut degrees = vec![0; leaving.len()];
        let corners = self.closed_triangles().as_flattened();
        corners.iter().for_each(|&vertex| degrees[vertex as usize] += 1);
        for first in leaving.into_iter().flatten() {
            let vertex = self.origin(first);
            if self.fan(first).count() != degrees[vertex as usize] {
                return Err(SurfaceError::Vertex(vertex));
            }
        }
        Ok(())
    }
}

fn directed_edges(triangles: &[[u32; 3]]) -> Result<HashMap<(u32, u32), u32>, SurfaceError> {
    let mut half_edges = HashMap::with_capacity(triangles.len() * 3);
    for (triangle, &[a, b, c]) in (0..).zip(triangles) {
        for (corner, edge) in (0..).zip([(a, b), (b, c), (c, a)]) {
            if half_edges.insert(edge, 3 * triangle + corner).is_some() {
                return Err(SurfaceError::Edge(edge.0, edge.1));
            }
        }
    }
    Ok(half_edges)
}

/// Appends a virtual triangle for each boundary edge, loop by loop.
fn close_boundaries(vertex_count: u32, triangles: &mut Vec<[u32; 3]>) -> Result<(), SurfaceError> {
    let half_edges = directed_edges(triangles)?;
    let directed = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let boundary: Vec<(u32, u32)> = directed.filter(|&(a, b)| !half_edges.contains_key(&(b, a))).collect();
    let mut onward = HashMap::with_capacity(boundary.len());
    for &(from, to) in &boundary {
        if onward.insert(from, to).is_some() {
            return Err(SurfaceError::Vertex(from));
        }
    }
    let mut infinity = vertex_count;
    for (start, _) in boundary {
        let mut from = start;
        while let Some(to) = onward.remove(&from) {
            triangles.push([to, from, infinity]);
            from = to;
        }
        infinity += u32::from(triangles.last().is_some_and(|corners| corners[2] == infinity));
    }
    Ok(())
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
