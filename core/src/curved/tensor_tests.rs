#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn random_tensor(random: &mut fastrand::Rng, rows: usize, columns: usize) -> TensorPatch {
    let mut point = || DVec3::new(random.f64(), random.f64(), random.f64());
    TensorPatch::new((0..rows * columns).map(|_| point()).collect(), columns).unwrap()
}

#[test]
fn patches_of_lower_degree_are_elevated_exactly() {
    let mut random = fastrand::Rng::with_seed(1);
    for (rows, columns) in [(2, 2), (2, 3), (3, 2), (4, 3), (4, 4)] {
        let given = random_tensor(&mut random, rows, columns);
        let (bicubic, deviation) = given.near_bicubic();
        assert_eq!(deviation, 0.0);
        let bicubic = TensorPatch::of_bicubic(&bicubic);
        for _ in 0..20 {
            let (u, v) = (random.f64(), random.f64());
            assert!(given.point(u, v).distance(bicubic.point(u, v)) < 1e-14);
        }
    }
}

/// From either end a side becomes the same, to the bit, so that patches of low degree meet.
#[test]
fn a_side_is_elevated_the_same_from_both_ends() {
    let mut random = fastrand::Rng::with_seed(4);
    for count in 2..6 {
        let curve: Vec<DVec3> = (0..count)
            .map(|_| DVec3::new(random.f64(), random.f64(), random.f64()))
            .collect();
        let back: Vec<DVec3> = curve.iter().rev().copied().collect();
        let mut there = as_cubic(&back);
        there.reverse();
        assert_eq!(as_cubic(&curve), there);
    }
}

#[test]
fn patches_of_higher_degree_are_as_near_as_said_and_nearer_when_halved() {
    let mut random = fastrand::Rng::with_seed(2);
    let given = random_tensor(&mut random, 6, 3);
    let claimed = [1, 3].map(|halvings: u32| {
        let pieces = given.halved([halvings; 2]);
        assert_eq!(pieces.len(), 1 << (2 * halvings));
        let (bicubic, claimed) = pieces[0].near_bicubic();
        let near = TensorPatch::of_bicubic(&bicubic);
        let side = f64::from(1 << halvings);
        let places = (0..100).map(|place| (f64::from(place % 10) / 9.0, f64::from(place / 10) / 9.0));
        let distances = places.map(|(u, v)| near.point(u, v).distance(given.point(u / side, v / side)));
        let measured = distances.fold(0.0, f64::max);
        assert!(measured <= claimed && claimed < 4.0 * measured, "{measured} {claimed}");
        claimed
    });
    assert!(claimed[1] < claimed[0] / 100.0, "{claimed:?}");
}

#[test]
fn both_triangles_have_the_patchs_sides_and_share_its_diagonal() {
    let mut random = fastrand::Rng::with_seed(3);
    let bicubic = random_tensor(&mut random, 4, 4).near_bicubic().0;
    let [lower, upper] = triangles(&bicubic);
    assert_eq!(lower.curve(1), bicubic[3]);
    assert_eq!(lower.curve(0), [0, 1, 2, 3].map(|i| bicubic[i][0]));
    assert_eq!(upper.curve(2), [3, 2, 1, 0].map(|j| bicubic[0][j]));
    let mut back = lower.curve(2);
    back.reverse();
    assert_eq!(upper.curve(0), back);
    assert_eq!(back, diagonal(&bicubic));
}

#[test]
fn shapes_that_are_no_patch_are_refused() {
    for (count, columns) in [(4, 1), (5, 2), (2, 2), (0, 0)] {
        let refused = TensorPatch::new(vec![DVec3::ZERO; count], columns);
        assert_eq!(refused, Err(TensorError::Shape { points: count, columns }));
    }
    assert_eq!(TensorPatch::new(vec![DVec3::NAN; 4], 2), Err(TensorError::NotFinite));
}
