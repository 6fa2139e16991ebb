use super::*;

/// A cube of twelve triangles.
fn cube() -> Mesh {
    let positions = (0..8).map(|vertex| {
        DVec3::new(
            f64::from(vertex & 1),
            f64::from(vertex >> 1 & 1),
            f64::from(vertex >> 2),
        )
    });
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Mesh {
        positions: positions.collect(),
        triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

#[test]
fn a_cube_has_creases_or_round_corners_as_the_angle_says() {
    let mesh = cube();
    let sharp = from_triangles(&mesh, 1.0);
    for (corners, normals) in mesh.triangles.iter().zip(&sharp) {
        assert!(
            normals
                .iter()
                .all(|normal| normal.distance(face_normal(&mesh, *corners)) < 1e-12)
        );
    }
    let round = from_triangles(&mesh, 2.0);
    for (corners, normals) in mesh.triangles.iter().zip(&round) {
        for (&corner, normal) in corners.iter().zip(normals) {
            // Weighted by angles, both triangles of a side count as one.
            let outwards = (mesh.positions[corner as usize] - DVec3::splat(0.5)).normalize();
            assert!(normal.distance(outwards) < 1e-12, "{normal} {outwards}");
        }
    }
}

#[test]
fn given_normals_that_nearly_agree_are_one_to_the_bit() {
    let mesh = cube();
    let mut given = from_triangles(&mesh, 2.0);
    for (index, normal) in given.as_flattened_mut().iter_mut().enumerate() {
        *normal = *normal * 3.0 + DVec3::splat(1e-4 * (index % 7) as f64);
    }
    let made = from_corners(&mesh, &given, 0.02);
    let mut at: Vec<Option<DVec3>> = vec![None; 8];
    for (&corner, normal) in mesh.triangles.as_flattened().iter().zip(made.as_flattened()) {
        assert_eq!(*at[corner as usize].get_or_insert(*normal), *normal);
    }
    let apart = from_corners(&mesh, &from_triangles(&mesh, 1.0), 0.02);
    assert_eq!(apart[0][0], DVec3::NEG_Z);
}
