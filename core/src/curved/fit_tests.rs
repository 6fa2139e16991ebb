use super::*;

#[test]
fn curves_leave_their_ends_in_the_tangent_planes() {
    let corners = [DVec3::ZERO, DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 3.0, 2.0)];
    let normals = [DVec3::new(0.1, 0.2, 1.0), DVec3::new(-0.3, 0.0, 1.0), DVec3::Z].map(DVec3::normalize);
    let patch = first_pass(corners, normals.map(|normal| [Tangent::Plane(normal); 2]));
    for (corner, beside) in [[0, 1], [0, 2], [1, 3], [1, 7], [2, 5], [2, 8]].map(|[c, p]| (c, patch.points[p])) {
        assert!(normals[corner].dot(beside - corners[corner]).abs() < 1e-15);
    }
    // Before it was projected, the point was a third of the way.
    assert!(
        (patch.points[1] - (corners[1] - corners[0]) / 3.0)
            .cross(normals[0])
            .length()
            < 1e-15
    );
}

/// Three faces of a box-like corner: planes x = 0.1, y = 0.2 and z = 0.3 through flat curves.
#[test]
fn three_planes_meet_and_two_and_one_are_projected_onto() {
    let planes = [(DVec3::X, 0.1), (DVec3::Y, 0.2), (DVec3::Z, 0.3)];
    assert_eq!(meeting(planes), Some(DVec3::new(0.1, 0.2, 0.3)));
    assert_eq!(nearest_of_line(planes[0], planes[1]), Some(DVec3::new(0.1, 0.2, 0.0)));
    assert_eq!(meeting([planes[0], planes[0], planes[1]]), None);
    assert_eq!(nearest_of_line(planes[0], planes[0]), None);
}

#[test]
fn a_flat_patch_keeps_its_centre() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let patch = first_pass(corners, [[Tangent::Plane(DVec3::Z); 2]; 3]);
    let across = [
        DVec3::new(1.0, -1.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(-1.0, 0.3, 0.0),
    ];
    assert_eq!(
        refined_centre(&patch, across.map(Some)),
        (patch.points[CENTRE], Refined::Singular)
    );
    assert_eq!(
        refined_centre(&patch, [None; 3]),
        (patch.points[CENTRE], Refined::Unchanged)
    );
}
