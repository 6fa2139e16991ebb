//! The rules that a collapse must pass before its heights are looked at, one function each.

use glam::DVec2;

use crate::height_field::collapse::Edge;
use crate::height_field::simplify::VertexKind;
use crate::height_field::surface::Surface;
use crate::topology::half_edges::HalfEdges;

/// The table of [`VertexKind`].
pub(crate) fn kinds_allow(surface: &Surface, kinds: &[VertexKind], edge: Edge) -> bool {
    let (from, to) = (surface.plan(edge.blue), surface.plan(edge.red));
    let target = kinds[edge.red as usize];
    match kinds[edge.blue as usize] {
        _ if target == VertexKind::Border => false,
        VertexKind::Free => true,
        VertexKind::OnColumn => from.x == to.x && matches!(target, VertexKind::OnColumn | VertexKind::Fixed),
        VertexKind::OnRow => from.y == to.y && matches!(target, VertexKind::OnRow | VertexKind::Fixed),
        VertexKind::Outline => edge.is_on_boundary,
        VertexKind::Fixed | VertexKind::Border => false,
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

/// Whether a triangle is counter-clockwise in plan and at least `least_altitude` high.
///
/// Plan coordinates are whole numbers, so the area is exact up to 2^26 units; beyond, an altitude of a unit is far more
/// than rounding can hide.
pub(crate) fn is_upright(a: DVec2, b: DVec2, c: DVec2, least_altitude: f64) -> bool {
    let longest = a
        .distance_squared(b)
        .max(b.distance_squared(c))
        .max(c.distance_squared(a));
    let area = (b - a).perp_dot(c - a);
    area > 0.0 && area * area >= least_altitude * least_altitude * longest
}
