//! Parts surfaces that touch: those that share vertices and nothing else, and those that share whole edges.
//!
//! ```text
//! along each edge, turning about it: a triangle behind which there is inside is the partner of the one that closes it
//! around each vertex: triangles that follow each other across partners are a fan, and each fan gets a vertex of its own
//! where two half-edges still run side by side, a fan meets itself: choose partners with outside between them there, and repeat
//! ```
//! ```text
//!   ╲ inside ╱    Four triangles along an edge, seen from its end. Their fronts look outwards, so that each knows on which of
//!    ╲      ╱     its sides there is inside: the upper two are partners, and the lower two. That parts two bodies; a body
//!     ╲    ╱      that touches itself there ceases to.
//!      edge
//!     ╱    ╲
//!    ╱      ╲
//!   ╱ inside ╲
//! ```

use crate::mesh::Mesh;
use crate::topology::half_edges::{NONE, edges_of, next, previous};
use crate::topology::manifold::ManifoldError;

/// The same triangles, which have three different vertices each, with a vertex for every fan. Tells the mesh's vertex for each
/// one; the first ones are the same. No boundary arises. Where a fan meets itself both ways, what comes out is no manifold.
///
/// # Errors
/// An edge of several triangles of which more run along it in one direction than in the other.
pub fn parted(mesh: &Mesh) -> Result<(Mesh, Vec<u32>), ManifoldError> {
    let inside = vec![false; 3 * mesh.triangles.len()];
    let (first, originals) = with_fans(mesh, &partners(mesh, &inside)?);
    let meets_itself = meets_itself(&first);
    if meets_itself.contains(&true) {
        return Ok(with_fans(mesh, &partners(mesh, &meets_itself)?));
    }
    Ok((first, originals))
}

/// The triangles with a vertex for every fan, and the mesh's vertex for each one.
fn with_fans(mesh: &Mesh, partners: &[u32]) -> (Mesh, Vec<u32>) {
    let mut originals: Vec<u32> = (0..).take(mesh.positions.len()).collect();
    let mut has_fan = vec![false; mesh.positions.len()];
    let mut corners = vec![NONE; 3 * mesh.triangles.len()];
    for edge in 0..corners.len() as u32 {
        if corners[edge as usize] == NONE {
            let original = origin(mesh, edge);
            let mut vertex = original;
            if std::mem::replace(&mut has_fan[original as usize], true) {
                vertex = originals.len() as u32;
                originals.push(original);
            }
            fan_of(partners, edge, |edge| corners[edge as usize] = vertex);
        }
    }
    let positions = originals.iter().map(|&vertex| mesh.positions[vertex as usize]);
    let parted = Mesh {
        positions: positions.collect(),
        triangles: corners.as_chunks::<3>().0.to_vec(),
    };
    (parted, originals)
}

/// Tells the half-edges that another one runs beside, from the same vertex to the same vertex.
fn meets_itself(mesh: &Mesh) -> Vec<bool> {
    let ends = |edge| ends(mesh, edge);
    let edges = sorted_by_key(mesh, ends);
    let mut found = vec![false; edges.len()];
    let runs = edges.chunk_by(|&a, &b| ends(a) == ends(b));
    for &edge in runs.filter(|beside| beside.len() > 1).flatten() {
        found[edge as usize] = true;
    }
    found
}

/// Visits the half-edges that leave a vertex in one fan: from `start` counter-clockwise, then clockwise.
fn fan_of(partners: &[u32], start: u32, mut visit: impl FnMut(u32)) {
    let across = |edge: u32| partners[edge as usize];
    visit(start);
    let mut edge = across(previous(start));
    while edge != NONE && edge != start {
        visit(edge);
        edge = across(previous(edge));
    }
    let mut partner = if edge == NONE { across(start) } else { NONE };
    while partner != NONE {
        visit(next(partner));
        partner = across(next(partner));
    }
}

/// For each half-edge the one of the triangle that the surface goes on with, or [`NONE`] at the boundary. Between partners
/// there is inside, but outside between those along an edge of which any `is_outside`.
fn partners(mesh: &Mesh, is_outside: &[bool]) -> Result<Vec<u32>, ManifoldError> {
    let either_way = |edge| {
        let (from, to) = ends(mesh, edge);
        (from.min(to), from.max(to))
    };
    let edges = sorted_by_key(mesh, either_way);
    let mut partners = vec![NONE; edges.len()];
    for around in edges.chunk_by(|&a, &b| either_way(a) == either_way(b)) {
        let forward = around.iter().filter(|&&edge| is_inside_before(mesh, edge)).count();
        match around.len() {
            1 => {}
            count if 2 * forward == count => {
                let is_outside = around.iter().any(|&edge| is_outside[edge as usize]);
                pair(mesh, around, is_outside, &mut partners);
            }
            _ => {
                let (from, to) = either_way(around[0]);
                return Err(ManifoldError::Edge(from, to));
            }
        }
    }
    Ok(partners)
}

/// Pairs the half-edges along one edge, as many each way, like brackets that open and close what is inside, or outside.
fn pair(mesh: &Mesh, around: &[u32], is_outside: bool, partners: &mut [u32]) {
    let closes = |edge: u32| is_inside_before(mesh, edge) != is_outside;
    let around = by_angle(mesh, around, closes);
    let mut open = Vec::new();
    // Twice around: what is left open by the first turn is closed in the second.
    for turn in 0..2 {
        for &edge in &around {
            if !closes(edge) {
                open.extend((turn == 0).then_some(edge));
            } else if partners[edge as usize] == NONE
                && let Some(other) = open.pop()
            {
                partners[edge as usize] = other;
                partners[other as usize] = edge;
            }
        }
    }
}

/// The half-edges along one edge in the order of a turn about it, counter-clockwise seen from its larger end; of several at
/// one angle those come first that close something.
fn by_angle(mesh: &Mesh, around: &[u32], closes: impl Fn(u32) -> bool) -> Vec<u32> {
    let position = |edge: u32| mesh.positions[origin(mesh, edge) as usize];
    let first = around[0];
    let ends = [position(first), position(next(first))];
    let [from, to] = if is_inside_before(mesh, first) {
        ends
    } else {
        [ends[1], ends[0]]
    };
    let axis = (to - from).normalize_or_zero();
    let arm = |edge: u32| (position(previous(edge)) - from).reject_from_normalized(axis);
    let (right, up) = (arm(first), axis.cross(arm(first)));
    let turn = |edge: u32| quarters(arm(edge).dot(right), arm(edge).dot(up));
    let mut sorted: Vec<(f64, bool, u32)> = around.iter().map(|&edge| (turn(edge), !closes(edge), edge)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    sorted.into_iter().map(|(_, _, edge)| edge).collect()
}

/// Grows with the angle of a direction, from 0 to 4 for a whole turn.
fn quarters(x: f64, y: f64) -> f64 {
    let along = x / (x.abs() + y.abs());
    if y < 0.0 { 3.0 + along } else { 1.0 - along }
}

/// Whether a turn about the edge, counter-clockwise seen from its larger end, comes to the back of the triangle, which is
/// inside. That is so if the half-edge runs to the larger end.
fn is_inside_before(mesh: &Mesh, edge: u32) -> bool {
    let (from, to) = ends(mesh, edge);
    from < to
}

/// All half-edges, those next to each other that have the same key.
fn sorted_by_key(mesh: &Mesh, key: impl Fn(u32) -> (u32, u32)) -> Vec<u32> {
    let mut edges: Vec<u32> = (0..mesh.triangles.len() as u32).flat_map(edges_of).collect();
    edges.sort_by_key(|&edge| key(edge));
    edges
}

/// Where a half-edge begins and ends.
fn ends(mesh: &Mesh, edge: u32) -> (u32, u32) {
    (origin(mesh, edge), origin(mesh, next(edge)))
}

fn origin(mesh: &Mesh, edge: u32) -> u32 {
    mesh.triangles.as_flattened()[edge as usize]
}

#[cfg(test)]
#[path = "parting_tests.rs"]
mod tests;
