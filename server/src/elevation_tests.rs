#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::forms::{MOST_PLACES, places_in};
use super::*;

fn place(longitude: f64, latitude: f64) -> Place {
    Place { longitude, latitude }
}

/// The example of Google's description of the format.
#[test]
fn an_encoded_polyline_has_the_places_that_its_description_tells() {
    let places = places_in("enc:_p~iF~ps|U_ulLnnqC_mqNvxq`@").unwrap();
    let expected = [place(-120.2, 38.5), place(-120.95, 40.7), place(-126.453, 43.252)];
    for (one, other) in places.iter().zip(expected) {
        assert!((one.longitude - other.longitude).abs() < 1e-9 && (one.latitude - other.latitude).abs() < 1e-9);
    }
    assert_eq!(places.len(), 3);
}

#[test]
fn places_are_on_the_earth_and_the_wrong_one_is_named() {
    assert_eq!(
        places_in("1,190|2,-190").unwrap(),
        [place(-170.0, 1.0), place(170.0, 2.0)]
    );
    for (text, reason) in [
        ("1,2|91,0", "place 1 is not on the Earth: longitude 0, latitude 91"),
        ("1,2|3", "place 1, “3”, is no latitude,longitude"),
        ("NaN,2", "place 0 is not on the Earth: longitude 2, latitude NaN"),
        ("", "place 0, “”, is no latitude,longitude"),
    ] {
        assert_eq!(places_in(text).unwrap_err().to_string(), reason);
    }
    let many = vec!["0,0"; MOST_PLACES + 1].join("|");
    assert!(places_in(&many).unwrap_err().to_string().contains("10000"));
}

/// A degree of the equator is 111,319.49 m, one of the meridian at the equator 110,574.39 m.
#[test]
fn stations_lie_evenly_along_the_path_round_its_corners() {
    let corners = [place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0)];
    let stations = path::samples(&corners, 5).unwrap();
    let length = stations[4].1;
    assert!((length - 111_319.490_8 - 110_574.388_6).abs() < 0.01, "{length}");
    for (index, (_, distance)) in stations.iter().enumerate() {
        assert!((distance - length * index as f64 / 4.0).abs() < 1e-6);
    }
    let near = |one: Place, other: Place| (one.longitude - other.longitude).hypot(one.latitude - other.latitude) < 0.01;
    assert!(near(stations[1].0, place(0.498, 0.0)) && near(stations[3].0, place(1.0, 0.498)));
    assert!(near(stations[4].0, corners[2]));
    let spaced = path::spaced(&corners, 1_000.0).unwrap();
    assert_eq!(spaced.len(), 223);
    for spacing in [0.0, -1.0, f64::NAN, 1.0] {
        assert!(path::spaced(&corners, spacing).is_err(), "{spacing}");
    }
}
