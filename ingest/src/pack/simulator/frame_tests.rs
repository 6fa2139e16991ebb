#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_tiles::ellipsoid::SEMI_MAJOR;

use super::*;

const HEIGHTS: [f64; 2] = [0.0, 1000.0];

fn tile(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

#[test]
fn the_earth_curves_away_below() {
    let frame = Frame::new(DVec2::ZERO, &[tile(10, 1024, 512)], HEIGHTS).unwrap();
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
        let frame = Frame::new(origin, &[address], HEIGHTS).unwrap();
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
    assert!(Frame::new(DVec2::ZERO, &[tile(0, 1, 0)], HEIGHTS).is_err());
    assert!(Frame::new(DVec2::new(7.0, 0.0), &[tile(10, 1024, 512)], HEIGHTS).is_err());
}

#[test]
fn whoever_goes_up_aslant_meets_steep_ground_later() {
    let frame = Frame::new(DVec2::ZERO, &[tile(8, 257, 128)], HEIGHTS).unwrap();
    assert!((frame.leaning(0.0) - 1.0 - frame.tilt.sin() * frame.tilt.tan()).abs() < 1e-12);
    assert!(frame.leaning(1.0) > 1.0 + frame.tilt.sin());
    assert_eq!(frame.leaning(f64::INFINITY), f64::INFINITY);
}
