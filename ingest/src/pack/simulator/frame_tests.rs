#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_codec::ellipsoid::SEMI_MAJOR;

use super::*;

const HEIGHTS: [f64; 2] = [0.0, 1000.0];

fn tile(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

#[test]
fn the_earth_curves_away_below() {
    let frame = Frame::new(DVec2::ZERO, &[tile(10, 1024, 512)], HEIGHTS, false).unwrap();
    let east = frame.local(at(DVec2::new(1.0, 0.0), 0.0));
    let (sine, cosine) = 1_f64.to_radians().sin_cos();
    assert!(
        (east - SEMI_MAJOR * DVec3::new(sine, 0.0, cosine - 1.0)).length() < 1e-8,
        "{east}"
    );
    assert!((frame.local(at(DVec2::ZERO, 12.5)) - DVec3::new(0.0, 0.0, 12.5)).length() < 1e-8);
    assert!(frame.local(at(DVec2::new(0.0, 0.1), 0.0)).y > 11_000.0);
    assert!((frame.up(east) - DVec3::new(sine, 0.0, cosine)).length() < 1e-14);
}

#[test]
fn single_precision_holds_a_tile_about_its_middle() {
    for zoom in [6, 8, 11, 15] {
        let address = tile(zoom, 1 << zoom, 1 << (zoom - 1));
        let origin = DVec2::new(address.west(), address.south());
        let frame = Frame::new(origin, &[address], HEIGHTS, false).unwrap();
        let [middle, corner] = [0.5, 1.0].map(|part| origin + part * address.degrees());
        let offset = frame.rounded(frame.local(at(middle, 500.0)));
        for place in [
            at(corner, 1000.0),
            at(origin, 0.0),
            at(DVec2::new(corner.x, origin.y), 333.3),
        ] {
            let exact = frame.rounded(frame.local(place)) - offset;
            assert_eq!(exact.as_vec3().as_dvec3(), exact, "zoom {zoom}");
        }
    }
}

#[test]
fn ground_that_is_far_from_the_origin_is_refused() {
    assert!(Frame::new(DVec2::ZERO, &[tile(0, 1, 0)], HEIGHTS, false).is_err());
    assert!(Frame::new(DVec2::new(7.0, 0.0), &[tile(10, 1024, 512)], HEIGHTS, false).is_err());
}

#[test]
fn whoever_goes_up_aslant_meets_steep_ground_later() {
    let frame = Frame::new(DVec2::ZERO, &[tile(8, 257, 128)], HEIGHTS, false).unwrap();
    assert!((frame.leaning(0.0) - 1.0 - frame.tilt.sin() * frame.tilt.tan()).abs() < 1e-12);
    assert!(frame.leaning(1.0) > 1.0 + frame.tilt.sin());
    assert_eq!(frame.leaning(f64::INFINITY), f64::INFINITY);
}

#[test]
fn ground_that_is_nowhere_on_the_earth_stays_flat() {
    let address = tile(10, 1024, 512);
    let origin = DVec2::splat(0.01);
    let frame = Frame::new(origin, &[address], HEIGHTS, true).unwrap();
    // The series of the transverse Mercator projection beside its meridian and the equator, after J. Snyder, *Map projections*, 1987.
    let on_plane = |place: DVec2| {
        let [longitude, latitude] = place.to_array().map(f64::to_radians);
        let squared = 2.0 / 298.257_223_563 - 1.0 / 298.257_223_563_f64.powi(2);
        let across = longitude * latitude.cos();
        let prime = SEMI_MAJOR / (1.0 - squared * latitude.sin().powi(2)).sqrt();
        let second = squared / (1.0 - squared) * latitude.cos().powi(2);
        let along_meridian = SEMI_MAJOR
            * ((1.0 - squared / 4.0 - 3.0 * squared.powi(2) / 64.0) * latitude
                - (3.0 * squared / 8.0 + 3.0 * squared.powi(2) / 32.0) * (2.0 * latitude).sin()
                + 15.0 * squared.powi(2) / 256.0 * (4.0 * latitude).sin());
        let turned = latitude.tan().powi(2);
        DVec2::new(
            prime * (across + (1.0 - turned + second) * across.powi(3) / 6.0),
            along_meridian + prime * latitude.tan() * across * across / 2.0,
        )
    };
    for place in [DVec2::ZERO, DVec2::new(0.17, 0.001), DVec2::new(0.1, 0.16), origin] {
        let expected = (on_plane(place) - on_plane(origin)).extend(123.5);
        let found = frame.local(at(place, 123.5));
        assert!((found - expected).length() < 1e-3, "{found} {expected}");
    }
    assert!((frame.origin_on_plane().unwrap() - on_plane(origin)).length() < 1e-3);
    assert_eq!((frame.tilt, frame.up(DVec3::new(1e4, 1e4, 0.0))), (0.0, DVec3::Z));
    // A triangle of a kilometre around a circle of 577 m: 577² / 2 R.
    assert!((frame.bend(1000.0) - 0.0261).abs() < 1e-3, "{}", frame.bend(1000.0));
}
