#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn field() -> HeightField {
    HeightField {
        bounds: [175.0, -10.0, 185.0, 10.0],
        columns: 3,
        decimetres: vec![0, 10, 20, 100, 110, 120],
    }
}

#[test]
fn heights_are_bilinear_whatever_turn_a_longitude_is_on_and_0_beside_the_grid() {
    let field = field();
    assert_eq!(field.height(175.0, -10.0), 0.0);
    assert_eq!(field.height(185.0, 10.0), 12.0);
    assert_eq!(field.height(-175.0, 10.0), 12.0);
    assert_eq!(field.height(-180.0, 0.0), 6.0);
    assert_eq!(field.height(177.5, -5.0), 3.0);
    for (longitude, latitude) in [(174.9, 0.0), (-174.9, 0.0), (180.0, 10.1), (0.0, 0.0)] {
        assert_eq!(field.height(longitude, latitude), 0.0);
    }
}

#[test]
fn a_field_without_cells_is_0() {
    for decimetres in [vec![], vec![5], vec![5, 5]] {
        let empty = HeightField {
            columns: decimetres.len(),
            decimetres,
            ..field()
        };
        assert_eq!(empty.height(180.0, 0.0), 0.0);
    }
}

#[test]
fn it_is_kept_as_json_and_missing_means_the_ellipsoid() {
    let outside = Outside::Extend { field: field() };
    let text = serde_json::to_string(&outside).unwrap();
    assert!(text.contains(r#""policy":"extend""#), "{text}");
    assert_eq!(serde_json::from_str::<Outside>(&text).unwrap(), outside);
    assert_eq!(Outside::default(), Outside::Ellipsoid);
}

#[test]
fn normals_are_the_same_bits_on_both_sides_of_the_antimeridian() {
    for outside in [Outside::Ellipsoid, Outside::Extend { field: field() }] {
        for v in 0..=32 {
            let [west, east] = [(7, 32), (0, 0)].map(|(x, u)| {
                let tile = TileAddress::new(2, x, 1).unwrap();
                outside.normal(tile.into(), [u, v], 32)
            });
            assert_eq!(west.to_array().map(f64::to_bits), east.to_array().map(f64::to_bits));
        }
    }
}
