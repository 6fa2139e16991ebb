#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

/// A patch whose corners are a unit right triangle and whose other control points are up to 0.1 beside those of the flat one.
fn bulged_patch(random: &mut fastrand::Rng) -> CubicPatch {
    let flat = [
        (0, 0),
        (1, 0),
        (0, 1),
        (2, 0),
        (1, 1),
        (0, 2),
        (3, 0),
        (2, 1),
        (1, 2),
        (0, 3),
    ];
    let mut around = || 0.2 * random.f64() - 0.1;
    let points = flat.map(|(x, y)| {
        let flat = DVec3::new(f64::from(x), f64::from(y), 0.0) / 3.0;
        flat + DVec3::new(around(), around(), around())
    });
    CubicPatch { points }
}

fn places(random: &mut fastrand::Rng) -> [f64; 3] {
    [(); 3].map(|()| 0.2 + 0.6 * random.f64())
}

#[test]
fn parts_of_one_patch_are_merged_exactly() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..100 {
        let patch = bulged_patch(&mut random);
        let [t, t2, other] = places(&mut random);
        let at = DVec3::new(t, t2, other) / (t + t2 + other);
        let star = patch.star(at);
        let two = patch.split_first_curve(t);
        let [lower, third] = {
            let [first, second] = patch.rotated().split_first_curve(t2);
            [first.rotated().rotated(), second.rotated().rotated()]
        };
        let [first, second] = lower.split_first_curve(t);
        let all = [
            merge_star(star.each_ref()).unwrap(),
            merge_two(&two[0], &two[1]).unwrap(),
            merge_two_t([&first, &second, &third]).unwrap(),
        ];
        for merged in all {
            assert!(merged.patch.deviation(&patch) < 1e-12);
            assert!(merged.deviation() < 1e-12);
        }
    }
}

#[test]
fn a_triangle_in_a_triangle_is_merged_exactly_where_the_centre_is_the_average() {
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..100 {
        let given = bulged_patch(&mut random);
        let [ab, bc, ca] = [0, 1, 2]
            .map(|index| given.curve(index))
            .map(|curve| [curve[1], curve[2]]);
        let patch = with_average_centre([given.points[0], given.points[6], given.points[9]], [ab, bc, ca]);
        let faces = triangle_in_triangle(&patch, places(&mut random));
        let merged = merge_triangle_in_triangle(faces.each_ref()).unwrap();
        assert!(merged.patch.deviation(&patch) < 1e-12);
        assert!(merged.deviation() < 1e-12);
    }
}

/// What the centre of a T is off by its parts share, so that moving it either way makes it worse.
#[test]
fn a_centre_deviates_least_from_both_parts() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..50 {
        let mut parts = bulged_patch(&mut random).split_first_curve(0.3);
        parts[0].points[CENTRE].z += 0.1;
        let merged = merge_two(&parts[0], &parts[1]).unwrap();
        let squares = |patch: &CubicPatch| {
            let again = patch.split_first_curve(0.3);
            let pairs = again.iter().zip(&parts);
            pairs
                .map(|(a, b)| a.points[CENTRE].distance_squared(b.points[CENTRE]))
                .sum::<f64>()
        };
        for step in [-1e-3, 1e-3] {
            let mut moved = merged.patch;
            moved.points[CENTRE].z += step;
            assert!(squares(&moved) > squares(&merged.patch));
        }
    }
}

/// The surface over a parallelogram (2s + t/2, t) whose height s − s² + 2(t − t²) is 0 at all four corners: a patch of it has
/// the blossom's values as its control points.
fn patch_of_a_paraboloid(corners: [[f64; 2]; 3]) -> CubicPatch {
    const PLACES: [[usize; 3]; 10] = [
        [0, 0, 0],
        [0, 0, 1],
        [0, 0, 2],
        [0, 1, 1],
        [0, 1, 2],
        [0, 2, 2],
        [1, 1, 1],
        [1, 1, 2],
        [1, 2, 2],
        [2, 2, 2],
    ];
    let polar = |p: f64, q: f64| (p + q) / 2.0 - p * q;
    let height = |[p, q]: [[f64; 2]; 2]| polar(p[0], q[0]) + 2.0 * polar(p[1], q[1]);
    let points = PLACES.map(|places| {
        let [p, q, r] = places.map(|place| corners[place]);
        let [s, t] = [0, 1].map(|axis| (p[axis] + q[axis] + r[axis]) / 3.0);
        let up = (height([p, q]) + height([q, r]) + height([r, p])) / 3.0;
        DVec3::new(2.0 * s + 0.5 * t, t, up)
    });
    CubicPatch { points }
}

#[test]
fn a_diagonal_of_one_surface_over_coplanar_corners_is_swapped_exactly() {
    let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let faces = [[b, c, a], [c, b, d]].map(patch_of_a_paraboloid);
    let swapped = swap_diagonal(faces.each_ref()).unwrap();
    let wanted = [[a, b, d], [d, c, a]].map(patch_of_a_paraboloid);
    for (patch, wanted) in swapped.patches.iter().zip(&wanted) {
        assert!(patch.deviation(wanted) < 1e-12);
    }
    assert!(
        swapped
            .deviations
            .as_flattened()
            .iter()
            .all(|&deviation| deviation < 1e-12)
    );
    assert!((swapped.along_old - 0.5).abs() < 1e-12 && (swapped.along_new - 0.5).abs() < 1e-12);
}

#[test]
fn what_cannot_be_merged_is_refused() {
    let mut random = fastrand::Rng::with_seed(5);
    let patch = bulged_patch(&mut random);
    let folded = CubicPatch {
        points: [DVec3::ZERO; 10],
    };
    assert_eq!(merge_two(&folded, &folded), None);
    assert_eq!(merge_star([&folded; 3]), None);
    assert_eq!(swap_diagonal([&patch, &patch]), None);
}
