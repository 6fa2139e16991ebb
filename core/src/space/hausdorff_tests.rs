use super::*;
use crate::space::simplify::tests::{bumpy_sphere, plate, sampled_distance};

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn bound(from: &Mesh, to: &Mesh, enough: f64) -> f64 {
    let tree = SurfaceTree::new(to);
    tree.bound(SurfaceTree::new(from).facets(), enough)
}

/// A square of side 4 and its middle at a height.
fn tent(height: f64) -> Mesh {
    Mesh {
        positions: vec![
            at(0.0, 0.0, 0.0),
            at(4.0, 0.0, 0.0),
            at(4.0, 4.0, 0.0),
            at(0.0, 4.0, 0.0),
            at(2.0, 2.0, height),
        ],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    }
}

#[test]
fn the_farthest_point_may_be_anywhere_in_a_triangle() {
    let floor = Mesh {
        positions: tent(0.0).positions,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let up = bound(&tent(1.5), &floor, 0.0);
    assert!((1.5..1.5 * 1.01).contains(&up), "{up}");
    // The middle of the floor is next to the slopes of the tent, not to its top: 1.5 × cos 36.87°.
    let down = bound(&floor, &tent(1.5), 0.0);
    assert!((1.2..1.2 * 1.01).contains(&down), "{down}");
}

#[test]
fn a_surface_cut_otherwise_is_the_same_surface() {
    let (fine, coarse) = (plate(12), plate(5));
    assert!(bound(&fine, &coarse, 0.0) <= 1e-6);
    assert!(bound(&coarse, &fine, 0.0) <= 1e-6);
}

#[test]
fn bounds_are_above_what_dense_sampling_finds_and_hardly_above() {
    let (one, other) = (bumpy_sphere(3, 0.1, 1), bumpy_sphere(2, 0.1, 2));
    for (from, to) in [(&one, &other), (&other, &one)] {
        let (bound, sampled) = (bound(from, to, 0.0), sampled_distance(from, to, 24));
        assert!(bound >= sampled && bound < sampled * 1.03, "{bound} {sampled}");
    }
}

#[test]
fn a_triangle_far_from_the_one_before_claims_its_farthest_corner() {
    let [near, far] = [0.0, 100.0].map(|x| [at(x, 0.0, 0.0), at(x + 4.0, 0.0, 0.0), at(x, 4.0, 0.0)]);
    let floor = Mesh {
        positions: [near, far].concat(),
        triangles: vec![[0, 1, 2], [3, 4, 5]],
    };
    let raised = [far[0], far[1], far[2] + DVec3::Z];
    let bound = SurfaceTree::new(&floor).bound(&[near, raised], 1.2);
    assert!((1.0..1.2).contains(&bound), "{bound}");
}

#[test]
fn what_rounding_hides_is_claimed() {
    let mut far = tent(1.5);
    far.positions.iter_mut().for_each(|position| position.x += 1e9);
    let bound = bound(&far, &far, 0.0);
    assert!((1e-6..1e-4).contains(&bound), "{bound}");
}

#[test]
fn corners_on_the_plane_of_a_cut_are_in_both_parts() {
    let square = Polygon::from_slice(&tent(0.0).positions[..4]);
    let diagonal = at(1.0, -1.0, 0.0).normalize();
    for part in split(&square, at(2.0, 2.0, 0.0), diagonal, 0.0) {
        let part = part.map(|corners| corners.to_vec());
        let both = [square[0], square[2]];
        assert!(part.is_some_and(|corners| corners.len() == 3 && both.iter().all(|corner| corners.contains(corner))));
    }
}

#[test]
fn a_bound_that_is_enough_is_not_made_better() {
    let floor = bound(&tent(0.5), &tent(0.0), 0.75);
    assert!((0.5..=0.75).contains(&floor), "{floor}");
    let tree = SurfaceTree::new(&tent(0.0));
    assert!(tree.facet_within(0.51, at(2.0, 2.0, 0.5), NONE).is_ok());
    assert_eq!(tree.facet_within(0.49, at(2.0, 2.0, 0.5), NONE), Err(0.5));
}

#[test]
fn nothing_is_infinitely_far_and_triangles_without_area_are_lines() {
    let empty = SurfaceTree::new(&Mesh::default());
    assert_eq!(empty.farthest(&[[DVec3::ZERO; 3]]), f64::INFINITY);
    assert_eq!(empty.bound(&[[DVec3::ZERO; 3]], 1.0), f64::INFINITY);
    let line = Mesh {
        positions: vec![at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(4.0, 0.0, 0.0)],
        triangles: vec![[0, 1, 2]],
    };
    let off = bound(&tent(0.0), &line, 0.0);
    assert!((4.0..4.04).contains(&off), "{off}");
    assert!(bound(&line, &tent(0.0), 0.0) <= 1e-6);
}
