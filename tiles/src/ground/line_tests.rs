#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::convert::Infallible;

use terrain_codec::ellipsoid::{east_north_up, to_earth_centred};
use terrain_codec::tile::Tile;

use super::super::tests::grid;
use super::*;

const CELLS: u32 = 9;
const HEIGHTS: [f64; 2] = [-500.0, 2_000.0];

fn height(x: u32, y: u32) -> f64 {
    ((u64::from(x) * 7919 + u64::from(y) * 104_729) % 1000) as f64
}

/// A grid of cells on the tile at an address, whose sides are those of its neighbours.
fn tile(address: TileAddress) -> Tile {
    let around = (2 << address.zoom) * CELLS;
    let node = |x: u32, y: u32| height((address.x * CELLS + x) % around, address.y * CELLS + y);
    grid(address, CELLS, node, |_| true)
}

/// All tiles of the 4 × 4 squares around one.
fn tiles(zoom: u8, x: u32, y: u32) -> Vec<Tile> {
    let around = 2_u32 << zoom;
    let square = |row: u32| move |column: u32| (column, row);
    let places = (0..4).flat_map(|row| (0..4).map(square(row)));
    places
        .map(|(column, row)| {
            tile(TileAddress {
                zoom,
                x: (x + column) % around,
                y: y + row,
            })
        })
        .collect()
}

/// The highest point of the line on any triangle of the tiles, in metres along it, by solving for it and the triangle's two edges.
fn by_brute_force(tiles: &[Tile], point: DVec3, up: DVec3) -> Option<f64> {
    let of_tile = |tile: &Tile| {
        let mesh = tile.surface(tile.finest());
        let positions: Vec<DVec3> = mesh.positions.iter().map(|&at| tile.earth_centred(at)).collect();
        let of_triangle = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            let solved = glam::DMat3::from_cols(b - a, c - a, -up).inverse() * (point - a);
            let inside = solved.x.min(solved.y).min(1.0 - solved.x - solved.y);
            (inside >= -1e-9).then_some(solved.z)
        };
        mesh.triangles.iter().filter_map(of_triangle).max_by(f64::total_cmp)
    };
    tiles.iter().filter_map(of_tile).max_by(f64::total_cmp)
}

/// Lines that lean by up to 40° in all directions, through the middles of four tiles, over sides and corners.
fn compare(zoom: u8, x: u32, y: u32) {
    let tiles = tiles(zoom, x, y);
    let grounds: Vec<Ground> = tiles.iter().map(Ground::of).collect();
    let ground_at = |address: TileAddress| Ok::<_, Infallible>(grounds.iter().find(|ground| ground.address == address));
    let middle = TileAddress::new(zoom, (x + 2) % (2 << zoom), y + 2).unwrap();
    let (mut crossed, mut missed) = (0, 0);
    for number in 0..400_u32 {
        let share = |prime: u32| f64::from(number * prime % 400) / 400.0 - 0.5;
        let (longitude, latitude) = (
            middle.west() + 0.02 * share(7) * middle.degrees(),
            middle.south() + 1.9 * share(151) * middle.degrees(),
        );
        let foot = Geodetic {
            longitude,
            latitude,
            height: 0.0,
        };
        let (tilt, azimuth) = (0.7 * (share(37) + 0.5), 6.3 * share(93));
        let axes = east_north_up(longitude, latitude);
        let up = axes * DVec3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
        let point = to_earth_centred(foot) + 12_345.0 * up;
        let line = Line::through(point, up).unwrap();
        let away = line.place() - DVec2::new(longitude, latitude);
        let turned = (away.x - 360.0 * (away.x / 360.0).round()) * latitude.to_radians().cos();
        assert!(turned.abs() + away.y.abs() < 1e-7);
        let met = line.meet(zoom, HEIGHTS, ground_at).unwrap();
        let expected = by_brute_force(&tiles, point, up);
        match (met, expected) {
            (Some(met), Some(expected)) => {
                assert!((met.along - expected).abs() < 1e-4, "{number}: {met:?} {expected}");
                assert!((met.normal.length() - 1.0).abs() < 1e-12);
            }
            (None, None) => missed += 1,
            other => panic!("{number}: {other:?}"),
        }
        let there = to_geodetic(point + expected.unwrap_or(-12_345.0) * up);
        let columns = [longitude, there.longitude].map(|degrees| (degrees / middle.degrees()).floor());
        crossed += usize::from(columns[0] != columns[1]);
    }
    // Next to a pole, lines go over more tiles than there are here.
    assert!(
        missed == 0 || y + 4 == 1 << zoom && missed < 300,
        "{missed} lines meet nothing"
    );
    assert!(crossed > 3 || zoom < 8, "{crossed} lines go over a side");
}

#[test]
fn lines_meet_the_same_point_as_by_looking_at_all_triangles() {
    compare(5, 40, 20);
    compare(8, 300, 190);
    compare(12, 5_000, 3_000);
    compare(15, 40_000, 20_000);
}

#[test]
fn lines_meet_the_ground_at_the_antimeridian_and_near_a_pole() {
    compare(9, 1_022, 300);
    compare(12, 8_190, 2_000);
    compare(12, 400, 4_092);
}

#[test]
fn an_upright_line_meets_what_the_vertical_meets_and_errs_by_no_more() {
    let address = TileAddress::new(11, 2_500, 1_500).unwrap();
    let ground = Ground::of(&tile(address));
    for share in [0.1, 0.37, 0.61, 0.93] {
        let (longitude, latitude) = (
            address.west() + share * address.degrees(),
            address.south() + (1.0 - share * share) * address.degrees(),
        );
        let origin = Geodetic {
            longitude,
            latitude,
            height: 100.0,
        };
        let line = Line::through(to_earth_centred(origin), normal(longitude, latitude)).unwrap();
        let met = line
            .meet(11, HEIGHTS, |other| {
                Ok::<_, Infallible>((other == address).then_some(&ground))
            })
            .unwrap()
            .unwrap();
        let point = ground.point(longitude, latitude).unwrap();
        assert!((met.along + 100.0 - point.height).abs() < 1e-6);
        assert!((met.error - ground.error()).abs() < 1e-6 * ground.error());
        let local = east_north_up(longitude, latitude).transpose() * met.normal;
        assert!(local.distance(point.normal) < 1e-9);
    }
}

/// On a slope of a metre a metre, a line that leans by 30° towards the slope goes 1 / (cos 30° − sin 30°) = 2.73 errors to come out.
#[test]
fn the_error_grows_with_the_tilt_and_the_slope() {
    let address = TileAddress::new(14, 20_000, 8_192).unwrap();
    let side = address.degrees() * 111_319.49;
    let slope = |x: f64| x / f64::from(1 << 12) * side;
    let mut steep = tile(address);
    for position in &mut steep.partition.positions {
        position.z = slope(position.x);
    }
    let ground = Ground::of(&steep);
    let (longitude, latitude) = (
        address.west() + address.degrees() / 2.0,
        address.south() + address.degrees() / 2.0,
    );
    let middle = Geodetic {
        longitude,
        latitude,
        height: side / 2.0,
    };
    let axes = east_north_up(longitude, latitude);
    let error = |degrees: f64| {
        let tilt = degrees.to_radians();
        let line = Line::through(to_earth_centred(middle), axes * DVec3::new(tilt.sin(), 0.0, tilt.cos())).unwrap();
        let met = line.meet(14, [0.0, side], |other| {
            Ok::<_, Infallible>((other == address).then_some(&ground))
        });
        let met = met.unwrap().unwrap();
        // Nearly along the slope, a line meets it anywhere.
        assert!(met.along.abs() < 0.1 || degrees > 44.0, "{met:?}");
        met.error / ground.error()
    };
    assert!((error(30.0) - 2.732).abs() < 0.02, "{}", error(30.0));
    assert!((error(1.0) - 1.0178).abs() < 1e-3, "{}", error(1.0));
    assert!((error(40.0) - 8.12).abs() < 0.1, "{}", error(40.0));
    assert_eq!(error(44.9), f64::INFINITY);
}

#[test]
fn what_does_not_come_down_is_no_line() {
    let origin = to_earth_centred(Geodetic {
        longitude: 7.0,
        latitude: 46.0,
        height: 0.0,
    });
    let axes = east_north_up(7.0, 46.0);
    let through = |east: f64| Line::through(origin + axes * DVec3::new(east, 0.0, 0.0), axes.z_axis);
    assert!(through(4_000e3).is_some());
    for east in [4_700e3, 6_300e3, 7_000e3, 1e9, f64::INFINITY, f64::NAN] {
        assert!(through(east).is_none(), "{east}");
    }
}
