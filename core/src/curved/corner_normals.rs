//! A normal for each corner of each triangle, for fitting patches: one for all corners of a vertex between which the surface is
//! smooth, so that creases are where normals differ and nowhere else.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::topology::half_edges::{HalfEdges, NONE, edges_of, next, previous};

/// Normals from the triangles of an oriented manifold: those around a vertex, weighted by their angles there (G. Thürmer,
/// C. Wüthrich, *Computing vertex normals from polygonal facets*, 1998). Edges whose triangles meet at more than `crease`
/// radians part them. Zero where triangles without area are all there is.
#[must_use]
pub fn from_triangles(mesh: &Mesh, crease: f64) -> Vec<[DVec3; 3]> {
    let faces: Vec<DVec3> = mesh
        .triangles
        .iter()
        .map(|&corners| face_normal(mesh, corners))
        .collect();
    let topology = HalfEdges::new(mesh.positions.len(), mesh.triangles.clone());
    let is_smooth = |edge: u32| {
        let [own, across] = [edge, topology.twin(edge)].map(|edge| faces[edge as usize / 3]);
        own == DVec3::ZERO || across == DVec3::ZERO || own.angle_between(across) <= crease
    };
    let weighted = |corner: u32| {
        let at = |edge: u32| mesh.positions[topology.origin(edge) as usize];
        let [onwards, back] = [next(corner), previous(corner)].map(|edge| at(edge) - at(corner));
        let angle = onwards.cross(back).length().atan2(onwards.dot(back));
        faces[corner as usize / 3] * angle
    };
    shared(&topology, is_smooth, weighted)
}

/// Given normals, made one where they differ by no more than `same` radians on both ends of an edge; all of any length above 0.
#[must_use]
pub fn from_corners(mesh: &Mesh, normals: &[[DVec3; 3]], same: f64) -> Vec<[DVec3; 3]> {
    let topology = HalfEdges::new(mesh.positions.len(), mesh.triangles.clone());
    let normal = |corner: u32| normals[corner as usize / 3][corner as usize % 3].normalize_or_zero();
    let is_same = |one: u32, other: u32| normal(one).angle_between(normal(other)) <= same;
    let is_smooth = |edge: u32| {
        let twin = topology.twin(edge);
        is_same(edge, next(twin)) && is_same(next(edge), twin)
    };
    shared(&topology, is_smooth, normal)
}

/// The sum over each smooth fan, at all of its corners.
fn shared(topology: &HalfEdges, is_smooth: impl Fn(u32) -> bool, normal: impl Fn(u32) -> DVec3) -> Vec<[DVec3; 3]> {
    let fans = smooth_fans(topology, is_smooth);
    let mut sums = vec![DVec3::ZERO; fans.len()];
    for (corner, &fan) in (0..).zip(&fans) {
        sums[fan as usize] += normal(corner);
    }
    let of_corner = |corner: u32| sums[fans[corner as usize] as usize].normalize_or_zero();
    (0..topology.triangle_slots())
        .map(|triangle| edges_of(triangle).map(of_corner))
        .collect()
}

fn face_normal(mesh: &Mesh, corners: [u32; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// For each corner, which has the number of the half-edge that leaves it, the least of those that smooth edges join it to.
/// Edges on the boundary are not asked for.
pub(crate) fn smooth_fans(topology: &HalfEdges, is_smooth: impl Fn(u32) -> bool) -> Vec<u32> {
    let mut fans: Vec<u32> = (0..3 * topology.triangle_slots()).collect();
    for edge in 0..fans.len() as u32 {
        let twin = topology.twin(edge);
        if twin != NONE && is_smooth(edge) {
            join(&mut fans, edge, next(twin));
            join(&mut fans, next(edge), twin);
        }
    }
    (0..fans.len() as u32)
        .map(|corner| first_of(&mut fans, corner))
        .collect()
}

fn join(fans: &mut [u32], one: u32, other: u32) {
    let [one, other] = [one, other].map(|corner| first_of(fans, corner));
    fans[one.max(other) as usize] = one.min(other);
}

/// The first of a corner's fan; halves the way to it.
fn first_of(fans: &mut [u32], mut corner: u32) -> u32 {
    while fans[corner as usize] != corner {
        let beyond = fans[fans[corner as usize] as usize];
        fans[corner as usize] = beyond;
        corner = beyond;
    }
    corner
}

#[cfg(test)]
#[path = "corner_normals_tests.rs"]
mod tests;
