use super::*;

/// On a sphere of the Earth's mean radius, degrees.
fn on_sphere(longitude: f64, latitude: f64) -> DVec3 {
    let [longitude, latitude] = [longitude, latitude].map(f64::to_radians);
    DVec3::new(
        longitude.cos() * latitude.cos(),
        longitude.sin() * latitude.cos(),
        latitude.sin(),
    ) * EARTH_RADIUS
}

/// The nearest of many points of the edge, seen from above.
fn brute_force(place: DVec3, [from, to]: [DVec3; 2]) -> f64 {
    let along = (0..=100_000).map(|step| from.lerp(to, f64::from(step) / 1e5).normalize() * EARTH_RADIUS);
    along.map(|point| point.distance(place)).fold(f64::INFINITY, f64::min)
}

#[test]
fn on_the_earth_no_distance_is_too_small_and_none_much_too_large() {
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..200 {
        let size = 10_f64.powf(random.f64() * 3.0 - 2.0);
        let middle = [random.f64() * 360.0, random.f64() * 178.0 - 89.0];
        let mut beside = || {
            on_sphere(
                middle[0] + size * random.f64(),
                (middle[1] + size * random.f64()).min(90.0),
            )
        };
        let (place, edge) = (beside(), [beside(), beside()]);
        let (bound, exact) = (distance_on_earth(place, edge), brute_force(place, edge));
        let length = edge[0].distance(edge[1]);
        let slack = FLATTENING * length * (length + 4.0 * HIGHEST) / EARTH_RADIUS;
        assert!(bound >= exact - 1e-6, "{bound} m for {exact} m");
        assert!(bound <= exact * 1.02 + slack, "{bound} m for {exact} m");
    }
}

#[test]
fn an_edge_along_a_parallel_bulges_towards_the_pole() {
    let distance = distance_on_earth(on_sphere(1.0, 60.0), [on_sphere(0.0, 60.0), on_sphere(2.0, 60.0)]);
    // The square of half the length, times the tangent of the latitude, over twice the radius.
    let half = on_sphere(1.0, 60.0).distance(on_sphere(0.0, 60.0));
    let bulge = half * half * 3.0_f64.sqrt() / (2.0 * EARTH_RADIUS);
    assert!((distance - bulge).abs() < 0.02 * bulge, "{distance} m for {bulge} m");
}

#[test]
fn what_is_beyond_the_horizon_is_as_far_as_its_ends() {
    let (place, far) = (on_sphere(0.0, 0.0), [on_sphere(100.0, 0.0), on_sphere(180.0, 10.0)]);
    assert_eq!(distance_on_earth(place, far), place.distance(far[0]));
}

#[test]
fn a_plane_has_no_horizon() {
    let ground = Ground::Plane(DVec2::new(3.0, 1.0));
    let [from, to] = [DVec2::ZERO, DVec2::X].map(|plan| ground.place(plan));
    assert_eq!(ground.distance(ground.place(DVec2::new(0.5, 2.0)), [from, to]), 2.0);
    assert_eq!(ground.distance(ground.place(DVec2::new(3.0, 0.0)), [from, to]), 6.0);
}
