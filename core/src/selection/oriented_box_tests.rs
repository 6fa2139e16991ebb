use super::*;

fn turned() -> OrientedBox {
    let (x, y) = (DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.8, 0.6, 0.0));
    OrientedBox {
        centre: DVec3::new(1.0, 2.0, 3.0),
        axes: [x, y, DVec3::Z],
        half_sizes: [5.0, 2.0, 1.0],
    }
}

/// Points of a box, those of its surface among them.
fn points(of: OrientedBox) -> impl Iterator<Item = DVec3> + Clone {
    let steps = (0..=8).map(|step| f64::from(step) / 4.0 - 1.0);
    let all = steps.clone().flat_map(move |x| {
        let inner = steps.clone();
        steps.clone().flat_map(move |y| inner.clone().map(move |z| [x, y, z]))
    });
    all.map(move |shares| {
        let along = |k: usize| of.axes[k] * of.half_sizes[k] * shares[k];
        of.centre + along(0) + along(1) + along(2)
    })
}

fn random_points(seed: u64) -> impl Iterator<Item = DVec3> {
    let mut random = fastrand::Rng::with_seed(seed);
    (0..200).map(move |_| DVec3::from([0; 3].map(|_| 30.0 * random.f64() - 15.0)))
}

#[test]
fn the_distance_is_that_of_the_nearest_of_all_points() {
    for eye in random_points(1) {
        let nearest = points(turned())
            .map(|point| point.distance(eye))
            .fold(f64::INFINITY, f64::min);
        let distance = turned().distance(eye);
        // The points are at most 1.25, 0.5 and 0.25 apart.
        assert!(
            distance <= nearest + 1e-9 && nearest <= distance + 0.8,
            "{eye}: {distance}, {nearest}"
        );
    }
    assert_eq!(turned().distance(DVec3::new(1.0, 2.0, 7.0)), 3.0);
    assert_eq!(turned().distance(DVec3::new(2.0, 3.0, 3.5)), 0.0);
}

#[test]
fn a_box_around_points_of_a_box_is_that_box() {
    let around =
        OrientedBox::around(turned().axes, points(turned())).unwrap_or_else(|| unreachable!("there are points"));
    assert!(around.centre.distance(turned().centre) < 1e-12);
    for k in 0..3 {
        assert!((around.half_sizes[k] - turned().half_sizes[k]).abs() < 1e-12);
    }
    assert_eq!(OrientedBox::around(turned().axes, std::iter::empty()), None);
}

#[test]
fn a_box_that_holds_another_is_as_small_as_can_be() {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let corner = |at: DVec3| OrientedBox {
        centre: at,
        axes,
        half_sizes: [1.0; 3],
    };
    let held = corner(DVec3::ZERO).holding(&corner(DVec3::new(4.0, 0.0, -2.0)));
    assert_eq!(
        (held.centre, held.half_sizes),
        (DVec3::new(2.0, 0.0, -1.0), [3.0, 1.0, 2.0])
    );
    let held = corner(DVec3::ZERO).holding(&turned());
    for point in points(turned()).chain(points(corner(DVec3::ZERO))) {
        assert!(held.distance(point) < 1e-9, "{point}");
    }
    assert_eq!(held.holding(&corner(DVec3::ZERO)), held);
}

#[test]
fn from_far_away_along_an_axis_a_face_is_seen() {
    let eye = turned().centre + DVec3::Z * 1000.0;
    assert!((turned().solid_angle(eye) - 4.0 * 5.0 * 2.0 / 1e6).abs() < 1e-15);
    let along = turned().centre + turned().axes[0] * 1000.0;
    assert!((turned().solid_angle(along) - 4.0 * 2.0 * 1.0 / 1e6).abs() < 1e-15);
}
