#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use crate::curved::patch::split_cubic;
use crate::curved::patch::tests::random_patch;

const STEPS: u32 = 12;

/// Coordinates of a lattice on the domain.
fn lattice(steps: u32) -> impl Iterator<Item = DVec3> {
    let rows = (0..=steps).flat_map(move |i| (0..=steps - i).map(move |j| [i, j, steps - i - j]));
    rows.map(move |place| DVec3::from_array(place.map(f64::from)) / f64::from(steps))
}

/// The largest distance between points of a patch over a triangle and of the flat triangle with the same corners.
fn sampled(patch: &CubicPatch, places: [DVec3; 3]) -> f64 {
    let corners = places.map(|place| patch.point(place));
    let mix = |three: [DVec3; 3], at: DVec3| at.x * three[0] + at.y * three[1] + at.z * three[2];
    let distances = lattice(STEPS).map(|at| patch.point(mix(places, at)).distance(mix(corners, at)));
    distances.fold(0.0, f64::max)
}

#[test]
fn no_chord_is_farther_from_its_curve_than_the_bound() {
    let mut random = fastrand::Rng::with_seed(1);
    let mut closest: f64 = 0.0;
    for _ in 0..200 {
        let curve = random_patch(&mut random).curve(0);
        for pieces in [1, 2, 5] {
            let bound = chord_error(curve) / f64::from(pieces * pieces);
            let at = |step: u32| split_cubic(curve, f64::from(step) / f64::from(pieces * STEPS)).0[3];
            let ends = |step: u32| [step / STEPS, (step / STEPS + 1).min(pieces)].map(|piece| at(piece * STEPS));
            let off = |step: u32| {
                let [from, to] = ends(step);
                at(step).distance(from.lerp(to, f64::from(step % STEPS) / f64::from(STEPS)))
            };
            let farthest = (0..pieces * STEPS).map(off).fold(0.0, f64::max);
            assert!(farthest <= bound * 1.000_001, "{farthest} {bound}");
            closest = closest.max(farthest / bound);
        }
    }
    assert!(closest > 0.8, "the bound is of use: {closest}");
}

#[test]
fn no_triangle_of_a_lattice_is_farther_from_its_patch_than_the_bound() {
    let mut random = fastrand::Rng::with_seed(2);
    let mut closest: f64 = 0.0;
    for _ in 0..50 {
        let patch = random_patch(&mut random);
        for steps in [1, 3] {
            let bound = triangle_error(&patch) / f64::from(steps * steps);
            let size = 1.0 / f64::from(steps);
            let corners = lattice(steps).filter(|at| at.x > size / 2.0);
            let triangles = corners.map(|a| {
                [
                    a,
                    a + size * DVec3::new(-1.0, 1.0, 0.0),
                    a + size * DVec3::new(-1.0, 0.0, 1.0),
                ]
            });
            let farthest = triangles.map(|places| sampled(&patch, places)).fold(0.0, f64::max);
            assert!(farthest <= bound, "{farthest} {bound}");
            closest = closest.max(farthest / bound);
        }
    }
    assert!(closest > 0.3, "the bound is of use: {closest}");
}

#[test]
fn the_bound_of_a_part_holds_for_any_triangle() {
    let mut random = fastrand::Rng::with_seed(3);
    let mut closest: f64 = 0.0;
    for _ in 0..200 {
        let patch = random_patch(&mut random);
        let places = [(); 3].map(|()| {
            let at = DVec3::new(random.f64(), random.f64(), random.f64());
            at / at.element_sum()
        });
        let (farthest, bound) = (sampled(&patch, places), part_error(&patch, places));
        assert!(farthest <= bound, "{farthest} {bound}");
        closest = closest.max(farthest / bound);
    }
    assert!(closest > 0.6, "the bound is of use: {closest}");
}

#[test]
fn factors_fall_with_the_distance_and_never_below_one() {
    let patch = random_patch(&mut fastrand::Rng::with_seed(4));
    let view = |distance: f64| View {
        eye: DVec3::new(0.0, 0.0, distance),
        focal_length: 1000.0,
        tolerance: 0.5,
        nearest: 0.01,
    };
    let factors: Vec<f64> = (0..60)
        .map(|step| view(4.0 * f64::from(step).exp2()).patch_factor(&patch))
        .collect();
    assert!(factors.windows(2).all(|pair| pair[1] <= pair[0]), "{factors:?}");
    assert!(factors[0] > 20.0 && *factors.last().unwrap() == 1.0, "{factors:?}");
    assert!(view(5.0).curve_factor(patch.curve(0)) > view(10.0).curve_factor(patch.curve(0)));
}
