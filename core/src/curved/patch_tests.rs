#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

/// A patch of random control points from 0 to 1.
pub(crate) fn random_patch(random: &mut fastrand::Rng) -> CubicPatch {
    CubicPatch {
        points: [(); 10].map(|()| DVec3::new(random.f64(), random.f64(), random.f64())),
    }
}

fn random_place(random: &mut fastrand::Rng) -> DVec3 {
    let at = DVec3::new(random.f64(), random.f64(), random.f64());
    at / (at.x + at.y + at.z)
}

/// Bernstein's form, equation (2) of the paper.
fn by_bernstein(patch: &CubicPatch, at: DVec3) -> DVec3 {
    const EXPONENTS: [[i32; 3]; 10] = [
        [3, 0, 0],
        [2, 1, 0],
        [2, 0, 1],
        [1, 2, 0],
        [1, 1, 1],
        [1, 0, 2],
        [0, 3, 0],
        [0, 2, 1],
        [0, 1, 2],
        [0, 0, 3],
    ];
    let factorial = |n: i32| f64::from((1..=n).product::<i32>());
    let terms = EXPONENTS.iter().zip(&patch.points).map(|(&[i, j, k], &point)| {
        let ways = 6.0 / (factorial(i) * factorial(j) * factorial(k));
        ways * at.x.powi(i) * at.y.powi(j) * at.z.powi(k) * point
    });
    terms.sum()
}

#[test]
fn points_are_those_of_bernsteins_form() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..100 {
        let (patch, at) = (random_patch(&mut random), random_place(&mut random));
        assert!(patch.point(at).distance(by_bernstein(&patch, at)) < 1e-14);
        let turned = DVec3::new(at.y, at.z, at.x);
        assert!(patch.rotated().point(turned).distance(patch.point(at)) < 1e-14);
    }
}

#[test]
fn normals_are_across_both_derivatives() {
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..100 {
        let (patch, at) = (random_patch(&mut random), random_place(&mut random));
        let normal = patch.normal(at).normalize();
        for along in [DVec3::new(1.0, -1.0, 0.0), DVec3::new(0.0, 1.0, -1.0)] {
            let step = 1e-5 * along;
            let derivative = (by_bernstein(&patch, at + step) - by_bernstein(&patch, at - step)) / 2e-5;
            assert!(normal.dot(derivative).abs() < 1e-8 * derivative.length().max(1.0));
        }
    }
}

#[test]
fn parts_are_the_patch_over_their_triangles() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..50 {
        let patch = random_patch(&mut random);
        let places = [(); 3].map(|()| random_place(&mut random));
        let part = patch.part(places);
        let at = random_place(&mut random);
        let inside = at.x * places[0] + at.y * places[1] + at.z * places[2];
        assert!(part.point(at).distance(patch.point(inside)) < 1e-13);
    }
}

#[test]
fn a_curve_is_split_like_any_part() {
    let mut random = fastrand::Rng::with_seed(4);
    for _ in 0..50 {
        let (patch, t) = (random_patch(&mut random), random.f64());
        let [a, b, c] = [DVec3::X, DVec3::Y, DVec3::Z];
        let cut = a.lerp(b, t);
        let [first, second] = patch.split_first_curve(t);
        assert!(first.deviation(&patch.part([a, cut, c])) < 1e-14);
        assert!(second.deviation(&patch.part([cut, b, c])) < 1e-14);
        let (left, right) = split_cubic(patch.curve(0), t);
        assert_eq!((left, right), (first.curve(0), second.curve(0)));
    }
}

#[test]
fn no_points_of_two_patches_are_farther_apart_than_their_deviation() {
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..50 {
        let [one, other] = [(); 2].map(|()| random_patch(&mut random));
        let farthest = (0..100).map(|_| random_place(&mut random));
        let farthest = farthest.map(|at| one.point(at).distance(other.point(at)));
        assert!(farthest.max_by(f64::total_cmp).unwrap() <= one.deviation(&other));
    }
}
