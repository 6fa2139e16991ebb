#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn random_tensor(random: &mut fastrand::Rng, rows: usize, columns: usize) -> TensorPatch {
    let mut point = || DVec3::new(random.f64(), random.f64(), random.f64());
    TensorPatch::new((0..rows * columns).map(|_| point()).collect(), columns).unwrap()
}

fn as_tensor(bicubic: &Bicubic) -> TensorPatch {
    TensorPatch::new(bicubic.as_flattened().to_vec(), 4).unwrap()
}

#[test]
fn patches_of_lower_degree_are_elevated_exactly() {
    let mut random = fastrand::Rng::with_seed(1);
    for (rows, columns) in [(2, 2), (2, 3), (3, 2), (4, 3), (4, 4)] {
        let given = random_tensor(&mut random, rows, columns);
        let bicubics = given.bicubics(3);
        assert_eq!(bicubics.len(), 1);
        let bicubic = as_tensor(&bicubics[0]);
        for _ in 0..20 {
            let (u, v) = (random.f64(), random.f64());
            assert!(given.point(u, v).distance(bicubic.point(u, v)) < 1e-14);
        }
    }
}

#[test]
fn patches_of_higher_degree_come_nearer_with_every_halving() {
    let mut random = fastrand::Rng::with_seed(2);
    let given = random_tensor(&mut random, 6, 3);
    let farthest = |halvings: u32| {
        let pieces = given.bicubics(halvings);
        assert_eq!(pieces.len(), 1 << (2 * halvings));
        let first = as_tensor(&pieces[0]);
        let side = f64::from(1 << halvings);
        let places = (0..100).map(|place| (f64::from(place % 10) / 9.0, f64::from(place / 10) / 9.0));
        let distances = places.map(|(u, v)| first.point(u, v).distance(given.point(u / side, v / side)));
        distances.fold(0.0, f64::max)
    };
    assert!(farthest(3) < farthest(1) / 100.0, "{} {}", farthest(3), farthest(1));
}

#[test]
fn both_triangles_have_the_patchs_sides_and_share_its_diagonal() {
    let mut random = fastrand::Rng::with_seed(3);
    let bicubic = random_tensor(&mut random, 4, 4).bicubics(0)[0];
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
