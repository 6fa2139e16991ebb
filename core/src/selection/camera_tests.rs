use super::*;

const GROUND: Ellipsoid = Ellipsoid {
    centre: DVec3::new(10.0, -20.0, 5.0),
    axis: DVec3::new(0.6, 0.0, 0.8),
    equatorial: 4.0,
    polar: 3.0,
};

fn random_vector(random: &mut fastrand::Rng, reach: f64) -> DVec3 {
    DVec3::from([0; 3].map(|_| reach * (2.0 * random.f64() - 1.0)))
}

fn random_box(random: &mut fastrand::Rng) -> OrientedBox {
    let x = random_vector(random, 1.0).normalize();
    let y = x.any_orthonormal_vector();
    OrientedBox {
        centre: GROUND.centre + random_vector(random, 12.0),
        axes: [x, y, x.cross(y)],
        half_sizes: [0; 3].map(|_| 2.0 * random.f64().powi(3)),
    }
}

fn random_point(of: &OrientedBox, random: &mut fastrand::Rng) -> DVec3 {
    let shares = random_vector(random, 1.0).to_array();
    let along = |k: usize| of.axes[k] * of.half_sizes[k] * shares[k];
    of.centre + along(0) + along(1) + along(2)
}

/// Whether the segment between two points runs through the ellipsoid, by steps along it.
fn runs_through(ellipsoid: &Ellipsoid, [from, to]: [DVec3; 2]) -> bool {
    let is_inside = |point: DVec3| {
        let offset = point - ellipsoid.centre;
        let along = offset.dot(ellipsoid.axis);
        let across = (offset - ellipsoid.axis * along).length();
        (across / ellipsoid.equatorial).powi(2) + (along / ellipsoid.polar).powi(2) < 1.0
    };
    (0..=2000).any(|step| is_inside(from.lerp(to, f64::from(step) / 2000.0)))
}

#[test]
fn what_the_horizon_hides_is_hidden_at_every_point() {
    let mut random = fastrand::Rng::with_seed(3);
    let (mut hidden, mut seen_behind) = (0, 0);
    for _ in 0..2000 {
        let bounds = random_box(&mut random);
        let eye = GROUND.centre + random_vector(&mut random, 15.0);
        let Some(horizon) = Horizon::new(GROUND, eye) else {
            continue;
        };
        let are_hidden = (0..8).all(|_| runs_through(&GROUND, [eye, random_point(&bounds, &mut random)]));
        let is_outside = !runs_through(&GROUND, [bounds.centre; 2]);
        if horizon.hides(&bounds) {
            assert!(are_hidden, "{bounds:?} from {eye}");
            hidden += 1;
        } else if are_hidden && is_outside {
            seen_behind += 1;
        }
    }
    assert!(
        hidden > 150 && hidden > 4 * seen_behind,
        "{hidden} hidden, {seen_behind} not found"
    );
}

#[test]
fn an_eye_in_the_ground_has_no_horizon() {
    assert!(Horizon::new(GROUND, GROUND.centre + DVec3::X).is_none());
    assert!(Horizon::new(GROUND, GROUND.centre + DVec3::X * 5.0).is_some());
}

#[test]
fn a_box_is_out_of_the_picture_where_a_half_space_has_none_of_it() {
    let mut random = fastrand::Rng::with_seed(4);
    let mut counts = [0, 0];
    for _ in 0..1000 {
        let half_space = HalfSpace {
            normal: random_vector(&mut random, 2.0),
            offset: random.f64(),
        };
        let camera = Camera {
            eye: DVec3::ZERO,
            frustum: vec![half_space],
            pixels_per_radian: 1.0,
            farthest: f64::INFINITY,
            ground: None,
        };
        let bounds = OrientedBox {
            centre: random_vector(&mut random, 3.0),
            ..random_box(&mut random)
        };
        let corners = (0..8).map(|bits| {
            let along = |k: usize| bounds.axes[k] * bounds.half_sizes[k] * if bits >> k & 1 == 1 { 1.0 } else { -1.0 };
            bounds.centre + along(0) + along(1) + along(2)
        });
        let farthest = corners.map(|corner| half_space.normal.dot(corner) + half_space.offset);
        let is_in = farthest.fold(f64::NEG_INFINITY, f64::max) > 0.0;
        assert_eq!(camera.sight().sees(&bounds), is_in);
        counts[usize::from(is_in)] += 1;
    }
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
}

#[test]
fn an_error_looks_smaller_from_farther_away_up_to_a_distance() {
    let mut camera = Camera {
        eye: DVec3::ZERO,
        frustum: Vec::new(),
        pixels_per_radian: 500.0,
        farthest: f64::INFINITY,
        ground: None,
    };
    assert_eq!(camera.pixels(2.0, 100.0), 10.0);
    assert_eq!(camera.pixels(2.0, 0.0), f64::INFINITY);
    assert_eq!(camera.pixels(0.0, 0.0), 0.0);
    camera.farthest = 50.0;
    assert_eq!(
        [10.0, 100.0].map(|distance| camera.pixels(2.0, distance)),
        [100.0, 20.0]
    );
}
