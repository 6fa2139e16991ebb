//! An edge to collapse, and whether topology lets it.

use crate::topology::half_edges::HalfEdges;

/// An edge to collapse.
#[derive(Clone, Copy)]
pub(crate) struct Edge {
    pub(crate) blue: u32,
    pub(crate) red: u32,
    /// The place of red around blue.
    pub(crate) index: usize,
    pub(crate) is_on_boundary: bool,
    /// The third vertex of the hole that the collapse closes; only for those who ask for that.
    pub(crate) closes: Option<u32>,
}

impl Edge {
    /// From a vertex to the one numbered `index` of its `around` neighbours.
    pub(crate) fn new(connectivity: &HalfEdges, blue: u32, around: &[u32], index: usize) -> Self {
        let is_at_an_end = index == 0 || index + 1 == around.len();
        Self {
            blue,
            red: around[index],
            index,
            is_on_boundary: is_at_an_end && connectivity.is_boundary(blue),
            closes: None,
        }
    }
}

/// The link condition with its boundary part (T. Dey et al., *Topology preserving edge contraction*, 1999): endpoints
/// share no neighbour but those of the edge's own triangles, no interior edge joins two vertices of the boundary, and
/// the last triangle stays, as does a tetrahedron.
pub(crate) fn link_allows(connectivity: &HalfEdges, edge: Edge, around_blue: &[u32], around_red: &[u32]) -> bool {
    let shared = around_blue.iter().filter(|vertex| around_red.contains(vertex)).count();
    let triangles = if edge.is_on_boundary { 1 } else { 2 };
    let are_on_boundary = [edge.blue, edge.red].map(|vertex| connectivity.is_boundary(vertex));
    let pinches = !edge.is_on_boundary && are_on_boundary == [true; 2];
    let is_last = match are_on_boundary {
        [false, false] => around_blue.len() == 3 && around_red.len() == 3,
        _ => edge.is_on_boundary && around_blue.len() == 2 && around_red.len() == 2,
    };
    shared == triangles && !pinches && !is_last
}

/// The link condition of a collapse that closes a hole of three vertices: that of an interior edge, with the hole as the
/// triangle on its other side. The boundary must pass each of the three once.
pub(crate) fn link_allows_closing(around_blue: &[u32], around_red: &[u32]) -> bool {
    let shared = around_blue.iter().filter(|vertex| around_red.contains(vertex)).count();
    let is_last = around_blue.len() == 3 && around_red.len() == 3;
    shared == 2 && !is_last
}

#[cfg(test)]
#[path = "edge_collapse_tests.rs"]
mod tests;
