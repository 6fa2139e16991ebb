use glam::DVec3;

use super::*;

fn check(triangles: &[[u32; 3]]) -> Result<(), ManifoldError> {
    let mesh = Mesh {
        positions: vec![DVec3::ZERO; 7],
        triangles: triangles.to_vec(),
    };
    check_corners(&mesh)?;
    check_stars(&Connectivity::new(&mesh))
}

#[test]
fn disks_spheres_and_lone_vertices_are_manifolds() {
    assert_eq!(check(&[]), Ok(()));
    assert_eq!(check(&[[0, 1, 2], [0, 2, 3], [0, 3, 4]]), Ok(()));
    assert_eq!(check(&[[0, 1, 2], [0, 2, 3], [0, 3, 1]]), Ok(()));
    assert_eq!(check(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]), Ok(()));
}

#[test]
fn the_fault_is_named() {
    assert_eq!(check(&[[0, 1, 2], [0, 3, 3]]), Err(ManifoldError::BadTriangle(1)));
    assert_eq!(check(&[[0, 1, 7]]), Err(ManifoldError::BadTriangle(0)));
    assert_eq!(check(&[[0, 1, 2], [0, 1, 3]]), Err(ManifoldError::Edge(0, 1)));
    assert_eq!(check(&[[0, 1, 2], [2, 0, 3]]), Err(ManifoldError::Edge(2, 0)));
    assert_eq!(check(&[[0, 1, 2], [0, 3, 4]]), Err(ManifoldError::Vertex(0)));
    let closed_and_open = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [0, 4, 5]];
    assert_eq!(check(&closed_and_open), Err(ManifoldError::Vertex(0)));
    let two_closed = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [0, 4, 5], [0, 5, 6], [0, 6, 4]];
    assert_eq!(check(&two_closed), Err(ManifoldError::Vertex(0)));
}
