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

#[test]
fn surfaces_that_touch_in_a_vertex_are_parted_there_and_nowhere_else() {
    let tetrahedron = |corners: [u32; 4]| {
        let [a, b, c, d] = corners;
        [[a, b, c], [a, c, d], [a, d, b], [d, c, b]]
    };
    let mesh = Mesh {
        positions: (0..7).map(|vertex| DVec3::splat(f64::from(vertex))).collect(),
        triangles: [tetrahedron([0, 1, 2, 3]), tetrahedron([4, 5, 6, 0])].concat(),
    };
    assert_eq!(check_stars(&Connectivity::new(&mesh)), Err(ManifoldError::Vertex(0)));
    let (parted, originals) = parted_at_vertices(&mesh);
    assert_eq!(originals, [0, 1, 2, 3, 4, 5, 6, 0]);
    assert_eq!(parted.positions[7], mesh.positions[0]);
    assert_eq!(parted.triangles[..4], mesh.triangles[..4]);
    assert_eq!(check_stars(&Connectivity::new(&parted)), Ok(()));
    assert_eq!(parted_at_vertices(&parted).0, parted);
}

#[test]
fn parting_at_vertices_leaves_edges_of_three_triangles_as_they_are() {
    let mesh = Mesh {
        positions: vec![DVec3::ZERO; 5],
        triangles: vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]],
    };
    let (parted, _) = parted_at_vertices(&mesh);
    assert!(parted.triangles[0][..2] == [0, 1] && parted.positions.len() <= 7);
}
