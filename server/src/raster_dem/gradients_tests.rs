use super::*;

#[test]
fn a_plane_has_its_gradient_however_few_of_its_heights_are_measured() {
    let plane = |y: usize, x: usize| 100.0 + 3.0 * x as f64 - 5.0 * y as f64;
    let whole = gradient(|y, x| Some(plane(y, x)), [30.0, 20.0]);
    let half = gradient(|y, x| (x + y < 6).then(|| plane(y, x)), [30.0, 20.0]);
    for [east, north] in [whole, half] {
        assert!(
            (east - 0.1).abs() < 1e-12 && (north - 0.25).abs() < 1e-12,
            "{east} {north}"
        );
    }
    assert_eq!(gradient(|_, _| None, [1.0; 2]), [0.0; 2]);
    assert_eq!(gradient(|y, _| (y == 3).then_some(1.0), [1.0; 2]), [0.0; 2]);
}

#[test]
fn colours_tell_normals() {
    assert_eq!(colour([0.0, 0.0]), [128, 128, 0]);
    for slope in [-20.0, -0.3, -0.004, 0.02, 0.5, 3.0] {
        let [red, green, _] = colour([slope, 0.0]);
        let root = (f64::from(red) - 128.0) / 127.0;
        let normal = root * root.abs();
        assert!((normal + slope / slope.hypot(1.0)).abs() < 0.01, "{slope}: {normal}");
        assert_eq!(green, 128);
    }
}

#[test]
fn tiles_ask_for_the_same_places_along_their_common_side() {
    let [west, east] = [1090, 1091].map(|x| TileAddress { zoom: 11, x, y: 1436 });
    let [west, east]: [Vec<Place>; 2] = [west, east].map(|address| corners(address).collect());
    for row in 0..ROW {
        for column in 0..=2 * REACH as usize {
            assert_eq!(west[row * ROW + CELLS as usize + column], east[row * ROW + column]);
        }
    }
    let last = corners(TileAddress { zoom: 0, x: 1, y: 0 })
        .next()
        .unwrap_or_else(|| unreachable!());
    assert_eq!(last.latitude, 90.0);
}
