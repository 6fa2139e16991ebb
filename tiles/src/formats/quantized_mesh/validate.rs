//! The one validator that every quantized-mesh tile of ours passes.

use std::collections::HashMap;

use terrain_codec::address::{Rectangle, Side};
use terrain_codec::ellipsoid::to_earth_centred;
use thiserror::Error;

use super::{EXTENT, QuantizedMesh, across_and_along, plan_area};

/// What is wrong with a tile.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum Fault {
    /// Seen from above, the triangle turns clockwise, or a measured one has no area.
    #[error("triangle {0} is not counter-clockwise")]
    NotCounterClockwise(usize),
    /// An edge inside the square that is not shared by two triangles, one each way.
    #[error("there is a hole or an overlap at the edge {0}–{1}")]
    OpenEdge(u32, u32),
    /// The triangles' plan areas do not add up to the square's.
    #[error("the triangles cover {0} of {1} half units of area")]
    WrongArea(i64, i64),
    /// A side's list and the vertices on that side are not the same.
    #[error("the edge list of the {0:?} side is not the vertices on it")]
    WrongEdgeList(Side),
    /// No triangle uses the vertex.
    #[error("vertex {0} is in no triangle")]
    UnusedVertex(usize),
    /// The vertex is outside the bounding sphere.
    #[error("vertex {0} is outside the bounding sphere")]
    OutsideSphere(usize),
}

/// Checks that `mesh` covers the rectangle of a tile exactly once in plan view, without a gap in space, that its edge
/// lists are complete and that its bounding sphere holds every vertex.
///
/// Counter-clockwise triangles whose edges all cancel but for those on the square's sides, and whose areas add up to the
/// square's, cover it once.
///
/// # Errors
/// The first fault.
pub fn validate(mesh: &QuantizedMesh, tile: impl Into<Rectangle>) -> Result<(), Fault> {
    check_orientation(mesh)?;
    check_edges(mesh)?;
    check_sides(mesh)?;
    check_vertices(mesh, tile.into())
}

fn check_orientation(mesh: &QuantizedMesh) -> Result<(), Fault> {
    let measured = mesh.measured_triangles.map_or(0, |count| count as usize);
    let mut total = 0;
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let area = plan_area(&mesh.vertices, *triangle);
        if area < 0 || (area == 0 && index < measured) {
            return Err(Fault::NotCounterClockwise(index));
        }
        total += area;
    }
    let square = 2 * i64::from(EXTENT).pow(2);
    if total == square {
        Ok(())
    } else {
        Err(Fault::WrongArea(total, square))
    }
}

fn check_edges(mesh: &QuantizedMesh) -> Result<(), Fault> {
    let mut balance: HashMap<(u32, u32), (i32, i32)> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (start, end) in [(a, b), (b, c), (c, a)] {
            let count = balance.entry((start.min(end), start.max(end))).or_default();
            count.0 += if start < end { 1 } else { -1 };
            count.1 += 1;
        }
    }
    let mut edges: Vec<_> = balance.into_iter().collect();
    edges.sort_unstable();
    for ((a, b), (sum, uses)) in edges {
        // Ground that touches itself at one corner has two walls that meet in one upright edge.
        let expected = if is_upright(mesh, a, b) { uses } else { 2 };
        let inside = sum == 0 && uses == expected;
        let border = sum.abs() == 1 && on_common_side(mesh, a, b) && (uses == 1 || is_upright(mesh, a, b));
        if !inside && !border {
            return Err(Fault::OpenEdge(a, b));
        }
    }
    Ok(())
}

fn is_upright(mesh: &QuantizedMesh, a: u32, b: u32) -> bool {
    let [p, q] = [a, b].map(|index| mesh.vertices[index as usize]);
    (p.u, p.v) == (q.u, q.v)
}

fn on_common_side(mesh: &QuantizedMesh, a: u32, b: u32) -> bool {
    Side::ALL
        .iter()
        .any(|&side| [a, b].iter().all(|&index| is_on(mesh, side, index)))
}

fn is_on(mesh: &QuantizedMesh, side: Side, index: u32) -> bool {
    across_and_along(side, mesh.vertices[index as usize]).0 == 0
}

fn check_sides(mesh: &QuantizedMesh) -> Result<(), Fault> {
    for (side, list) in Side::ALL.into_iter().zip(&mesh.edges) {
        let mut listed = list.clone();
        listed.sort_unstable();
        let actual = (0..mesh.vertices.len() as u32).filter(|&index| is_on(mesh, side, index));
        let ordered = list.is_sorted_by_key(|&index| across_and_along(side, mesh.vertices[index as usize]).1);
        if !ordered || !actual.eq(listed) {
            return Err(Fault::WrongEdgeList(side));
        }
    }
    Ok(())
}

fn check_vertices(mesh: &QuantizedMesh, tile: Rectangle) -> Result<(), Fault> {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles
        .as_flattened()
        .iter()
        .for_each(|&index| used[index as usize] = true);
    if let Some(index) = used.iter().position(|used| !used) {
        return Err(Fault::UnusedVertex(index));
    }
    let outside = |&index: &usize| {
        let position = to_earth_centred(mesh.geodetic(tile, index));
        position.distance(mesh.sphere_center) > mesh.sphere_radius
    };
    (0..mesh.vertices.len())
        .find(outside)
        .map_or(Ok(()), |index| Err(Fault::OutsideSphere(index)))
}
