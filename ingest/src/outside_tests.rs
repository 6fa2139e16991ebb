use super::*;

/// A square of outline at 500 m around 10° E, 50° N.
fn square() -> (Vec<DVec3>, [f64; 4]) {
    let along = (0..=100).map(|index| f64::from(index) / 100.0);
    let sides = along.flat_map(|t| [[t, 0.0], [t, 1.0], [0.0, t], [1.0, t]]);
    let outline = sides.map(|[x, y]| DVec3::new(10.0 + x, 50.0 + y, 500.0));
    (outline.collect(), [10.0, 50.0, 11.0, 51.0])
}

fn at(field: &HeightField, longitude: f64, latitude: f64) -> f64 {
    let rows = field.decimetres.len() / field.columns;
    let [west, south, east, north] = field.bounds;
    let x = (longitude - west) / (east - west) * (field.columns - 1) as f64;
    let y = (latitude - south) / (north - south) * (rows - 1) as f64;
    f64::from(field.decimetres[y.round() as usize * field.columns + x.round() as usize]) / 10.0
}

#[test]
fn heights_go_on_from_the_outline_and_come_down_to_0() {
    let (outline, bounds) = square();
    let field = extended(&outline, bounds);
    assert!((at(&field, 10.0, 50.5) - 500.0).abs() < 1.0);
    assert!((at(&field, 10.5, 50.5) - 500.0).abs() < 350.0);
    let beside = [11.1, 11.3, 11.5].map(|longitude| at(&field, longitude, 50.5));
    assert!(
        beside[0] < 500.0 && beside[0] > beside[1] && beside[1] > beside[2] && beside[2] > 0.0,
        "{beside:?}"
    );
    for (longitude, latitude) in [(9.0, 50.5), (12.0, 50.5), (9.0, 49.0), (12.0, 52.0)] {
        assert_eq!(at(&field, longitude, latitude), 0.0);
    }
}

#[test]
fn data_over_the_antimeridian_and_at_a_pole_keep_their_field_on_the_earth() {
    let outline = [DVec3::new(-179.5, 89.0, 100.0), DVec3::new(179.5, 89.5, 100.0)];
    let field = extended(&outline, [179.0, 88.0, 181.0, 90.0]);
    assert_eq!(field.bounds, [177.0, 86.0, 183.0, 90.0]);
    assert!((at(&field, 180.5, 89.0) - 100.0).abs() < 1.0 && (at(&field, 179.5, 89.5) - 100.0).abs() < 1.0);
}

#[test]
fn data_without_an_outline_leave_a_field_of_0() {
    let field = extended(&[], [-180.0, -90.0, 180.0, 90.0]);
    assert!(field.decimetres.iter().all(|&height| height == 0));
}

#[test]
fn the_sea_level_is_that_of_the_grid() {
    let field = sea_level(|longitude, latitude| (latitude > -80.0).then_some(longitude / 10.0));
    assert_eq!(at(&field, 100.0, 0.0), 10.0);
    assert_eq!(at(&field, 100.0, -90.0), 0.0);
}
