#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{east_north_up, to_earth_centred, to_geodetic};

use super::*;

fn grid(extent: [f64; 2], spacing: f64, size: Option<u32>) -> Grid {
    Grid::new([DVec2::ZERO, DVec2::from_array(extent)], spacing, size).unwrap()
}

#[test]
fn posts_are_no_further_apart_than_was_asked() {
    for (extent, size, tiles) in [
        ([2000.0, 1000.0], None, (257, [1, 1])),
        ([2560.0, 1000.0], None, (257, [1, 1])),
        ([2561.0, 1000.0], None, (513, [1, 1])),
        ([100_000.0, 10_250.0], None, (1025, [10, 2])),
        ([2000.0, 1000.0], Some(65), (65, [4, 2])),
    ] {
        let grid = grid(extent, 10.0, size);
        assert_eq!((grid.size, grid.tiles.to_array()), tiles, "{extent:?}");
        assert!(grid.spacing().max_element() <= 10.0);
    }
    assert!(Grid::new([DVec2::ZERO, DVec2::splat(1e9)], 1.0, None).is_err());
}

#[test]
fn tiles_share_outer_posts_and_fill_the_rectangle() {
    let grid = grid([2001.7, 1234.5], 3.3, Some(65));
    let last = grid.tiles - 1;
    assert_eq!(grid.rectangle(UVec2::ZERO)[0], grid.low);
    assert!((grid.rectangle(last)[1] - grid.high).length() < 1e-9);
    for tile in grid.all().filter(|tile| tile.x < last.x && tile.y < last.y) {
        assert_eq!(grid.rectangle(tile)[1], grid.rectangle(tile + 1)[0]);
    }
}

#[test]
fn the_rectangle_is_inside_the_box_at_all_heights() {
    let origin = DVec2::new(7.4, 60.2);
    let tile = TileAddress::new(8, 266, 213).unwrap();
    let frame = Frame::new(origin, &[tile], [-400.0, 9000.0], false).unwrap();
    let area @ [west, south, east, north] = [7.0, 60.0, 8.0, 60.6];
    let [low, high] = inside(&frame, area, [-400.0, 9000.0], 0.0).unwrap();
    let turn = east_north_up(origin.x, origin.y);
    let of =
        |x: f64, y: f64, z: f64| to_geodetic(to_earth_centred(at(origin, 0.0)) + turn * DVec2::new(x, y).extend(z));
    for part in (0..=100).map(|part| f64::from(part) / 100.0) {
        let DVec2 { x, y } = low.lerp(high, part);
        for place in [
            of(x, low.y, 0.0),
            of(x, high.y, 0.0),
            of(low.x, y, 0.0),
            of(high.x, y, 0.0),
        ] {
            assert!((west - 1e-6..east + 1e-6).contains(&place.longitude), "{place:?}");
            assert!((south - 1e-6..north + 1e-6).contains(&place.latitude), "{place:?}");
        }
    }
    assert!(high.x - low.x > 53_000.0 && high.y - low.y > 66_000.0, "{low} {high}");
    assert!(inside(&frame, [7.0, 60.0, 7.0, 60.6], [0.0, 1.0], 0.0).is_err());
}
