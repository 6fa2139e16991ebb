//! The rules of the height field that a collapse must pass before its heights are looked at, one function each.

use glam::DVec2;

use crate::height_field::rules::VertexKind;
use crate::height_field::surface::Surface;
use crate::topology::edge_collapse::Edge;

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
        // Which neighbour is the next one along it, the breakline knows.
        VertexKind::Breakline => true,
        VertexKind::Fixed | VertexKind::Border => false,
    }
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
