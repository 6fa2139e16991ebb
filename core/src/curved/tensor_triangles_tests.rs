#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use crate::curved::tensor::TensorPatch;

fn random_bicubic(random: &mut fastrand::Rng) -> Bicubic {
    let mut point = |i: usize, j: usize| {
        DVec3::new(i as f64, j as f64, 0.0) + 0.6 * DVec3::new(random.f64(), random.f64(), random.f64())
    };
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| point(i, j)))
}

/// The largest distance of points with the same coordinates, on a grid; `places` are the triangles' corners in the domain.
fn measured(tensor: &Bicubic, near: &NearTriangle, place: impl Fn(DVec3) -> [f64; 2]) -> f64 {
    let tensor = TensorPatch::of_bicubic(tensor);
    let steps = 12;
    let places = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| [i, j]));
    let distances = places.map(|step| {
        let [x, y] = step.map(|step| f64::from(step) / f64::from(steps));
        let at = DVec3::new(x, y, 1.0 - x - y);
        let [u, v] = place(at);
        tensor.point(u, v).distance(near.patch.point(at))
    });
    distances.fold(0.0, f64::max)
}

const FIRST: fn(DVec3) -> [f64; 2] = |at| [at.y + at.z, at.z];
const SECOND: fn(DVec3) -> [f64; 2] = |at| [at.y, at.y + at.z];

#[test]
fn triangles_are_no_farther_from_the_patch_than_they_say() {
    let mut random = fastrand::Rng::with_seed(21);
    for _ in 0..20 {
        let tensor = random_bicubic(&mut random);
        let triangles = near_triangles(&tensor);
        for (near, place) in triangles.iter().zip([FIRST, SECOND]) {
            let measured = measured(&tensor, near, place);
            assert!(measured <= near.deviation + 1e-12, "{measured} {}", near.deviation);
            assert!(near.deviation < 4.0 * measured, "{measured} {}", near.deviation);
        }
        assert_eq!(triangles.len(), 2);
    }
}

#[test]
fn a_side_that_is_a_point_makes_one_triangle_wherever_it_is() {
    let mut random = fastrand::Rng::with_seed(22);
    for turns in 0..4 {
        let mut tensor = random_bicubic(&mut random);
        tensor[0] = [tensor[0][0]; 4];
        let turned = quarter_turns(&tensor)[turns];
        let triangles = near_triangles(&turned);
        assert_eq!(triangles.len(), 1);
        let near = triangles[0];
        let measured = measured(&tensor, &near, |at| [1.0 - at.x, at.z / (1.0 - at.x).max(1e-9)]);
        assert!(measured <= near.deviation + 1e-9 && near.deviation < 8.0 * measured);
    }
}

#[test]
fn halving_divides_the_error_by_about_sixteen() {
    let tensor = TensorPatch::of_bicubic(&random_bicubic(&mut fastrand::Rng::with_seed(23)));
    let largest = |times: u32| {
        let pieces = tensor.halved([times, times]);
        let near = pieces.iter().flat_map(|piece| near_triangles(&piece.near_bicubic().0));
        near.map(|near| near.deviation).fold(0.0, f64::max)
    };
    let ratio = largest(3) / largest(4);
    assert!((12.0..20.0).contains(&ratio), "{ratio}");
}

/// At the corners that a triangle shares with its patch it has the patch's normal, which the paper's diagonal has not.
#[test]
fn corners_keep_the_tangent_plane_of_the_patch() {
    let tensor = random_bicubic(&mut fastrand::Rng::with_seed(24));
    let normal = (tensor[1][0] - tensor[0][0])
        .cross(tensor[0][1] - tensor[0][0])
        .normalize();
    let off = |patch: &CubicPatch| patch.normal(DVec3::X).normalize().distance(normal);
    assert!(near_triangles(&tensor).iter().all(|near| off(&near.patch) < 1e-12));
    let printed = crate::curved::tensor::triangles(&tensor);
    assert!(printed.iter().all(|patch| off(patch) > 0.01));
}

#[test]
fn a_patch_of_lower_degree_is_met_exactly() {
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [2.0, 3.0, 0.0]].map(DVec3::from_array);
    let (bicubic, deviation) = TensorPatch::new(points.to_vec(), 2).unwrap().near_bicubic();
    assert_eq!(deviation, 0.0);
    assert!(near_triangles(&bicubic).iter().all(|near| near.deviation < 1e-12));
}
