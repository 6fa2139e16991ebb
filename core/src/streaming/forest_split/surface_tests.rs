#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

#[test]
fn a_closed_surface_has_no_virtual_vertex() {
    let surface = ClosedSurface::new(4, &TETRAHEDRON).unwrap();
    assert_eq!(surface.closed_vertex_count(), 4);
    assert_eq!(surface.edges(), [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
}

#[test]
fn each_boundary_loop_gets_a_virtual_vertex_of_its_own() {
    let two_apart = [[0, 1, 2], [3, 4, 5]];
    let surface = ClosedSurface::new(7, &two_apart).unwrap();
    assert_eq!(surface.closed_vertex_count(), 9);
    assert_eq!(surface.triangles(), two_apart);
    assert_eq!(surface.closed_triangles().len(), 8);
    assert_eq!(surface.edges().len(), 6, "virtual edges are not counted");
}

#[test]
fn a_fan_goes_once_around_its_vertex() {
    let surface = ClosedSurface::new(4, &TETRAHEDRON[..3]).unwrap();
    let leaving = surface.leaving();
    let targets: Vec<u32> = surface
        .fan(leaving[1].unwrap())
        .map(|half_edge| surface.target(half_edge))
        .collect();
    assert_eq!(targets, [0, 3, 2]);
    let at_boundary: Vec<u32> = surface
        .fan(leaving[0].unwrap())
        .map(|half_edge| surface.target(half_edge))
        .collect();
    assert_eq!(at_boundary, [2, 4, 3, 1], "through the virtual vertex 4");
}

#[test]
fn what_is_no_manifold_is_refused() {
    let refusal = |triangles: &[[u32; 3]]| ClosedSurface::new(7, triangles).unwrap_err();
    assert_eq!(refusal(&[[0, 1, 1]]), SurfaceError::BadTriangle(0));
    assert_eq!(refusal(&[[0, 1, 2], [0, 1, 7]]), SurfaceError::BadTriangle(1));
    assert_eq!(refusal(&[[0, 1, 2], [0, 1, 3]]), SurfaceError::Edge(0, 1));
    assert_eq!(refusal(&[[0, 1, 2], [0, 3, 4]]), SurfaceError::Vertex(0));
    let other = TETRAHEDRON.map(|corners| corners.map(|vertex| if vertex == 0 { 0 } else { vertex + 3 }));
    assert_eq!(refusal(&[TETRAHEDRON, other].concat()), SurfaceError::Vertex(0));
}
