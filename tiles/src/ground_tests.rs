#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_codec::ellipsoid::to_geodetic;
use terrain_core::Mesh;

use super::*;
use crate::fixture::of_one_level;

/// A grid of `cells` a side with a hole of one cell, on the tile at `zoom`.
fn tile(zoom: u8, cells: u32, height: impl Fn(u32, u32) -> f64) -> Tile {
    let address = TileAddress::new(zoom, (1 << zoom) + 1, (1 << zoom) * 11 / 16).unwrap();
    grid(address, cells, height, |place| cells == 1 || place != (1, 1))
}

/// A grid of `cells` a side, of those that are there, on the tile at an address.
pub(super) fn grid(
    address: TileAddress,
    cells: u32,
    height: impl Fn(u32, u32) -> f64,
    has_cell: impl Fn((u32, u32)) -> bool,
) -> Tile {
    let extent = f64::from(1 << 12);
    let lines = || 0..=cells;
    let at = |line: u32| (extent * f64::from(line) / f64::from(cells)).round();
    let positions = lines().flat_map(|y| lines().map(move |x| (x, y)));
    let cell = |x: u32, y: u32| {
        let corner = y * (cells + 1) + x;
        [
            [corner, corner + 1, corner + cells + 2],
            [corner, corner + cells + 2, corner + cells + 1],
        ]
    };
    let places = (0..cells).flat_map(|y| (0..cells).map(move |x| (x, y)));
    let mesh = Mesh {
        positions: positions.map(|(x, y)| DVec3::new(at(x), at(y), height(x, y))).collect(),
        triangles: places
            .filter(|&place| has_cell(place))
            .flat_map(|(x, y)| cell(x, y))
            .collect(),
    };
    of_one_level(address, 12, -6, &mesh, 1.5)
}

fn hills(x: u32, y: u32) -> f64 {
    f64::from((x * 7919 + y * 104_729) % 1000)
}

/// Heights at places of the surface, found without the index and without the formula: points inside triangles, in space.
#[test]
fn points_of_triangles_in_space_have_their_heights() {
    for zoom in [3, 4, 9, 14] {
        let tile = tile(zoom, 13, hills);
        let ground = Ground::of(&tile);
        assert!((ground.error() - 1.5).abs() < 1e-6);
        let mesh = tile.surface(tile.finest());
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| tile.earth_centred(mesh.positions[vertex as usize]));
            for weights in [[0.98, 0.01, 0.01], [0.2, 0.3, 0.5], [0.01, 0.495, 0.495]] {
                let point = to_geodetic(a * weights[0] + b * weights[1] + c * weights[2]);
                let found = ground.height(point.longitude, point.latitude).unwrap();
                assert!((found - point.height).abs() < 1e-6, "zoom {zoom}: {found} {point:?}");
            }
        }
    }
}

#[test]
fn edges_are_straight_in_space_and_not_in_degrees() {
    let tile = tile(4, 1, |_, _| 0.0);
    let ground = Ground::of(&tile);
    let (west, south, side) = (tile.address.west(), tile.address.south(), tile.address.degrees());
    let middle = ground.height(west + side / 2.0, south + side / 2.0).unwrap();
    assert!(
        middle < -5_000.0,
        "a chord over a thousand kilometres runs {middle} m below the ellipsoid"
    );
    // The northern side bulges northwards, the southern one, too.
    assert!(ground.height(west + side / 2.0, south + side * 1.001).is_some());
    assert!(ground.height(west + side / 2.0, south + side * 0.001).is_none());
    assert!(ground.reach > 0.001);
}

#[test]
fn there_is_no_height_in_a_hole_nor_far_outside() {
    let tile = tile(12, 8, hills);
    let ground = Ground::of(&tile);
    let at = |x: f64, y: f64| {
        let side = tile.address.degrees();
        ground.height(tile.address.west() + x * side, tile.address.south() + y * side)
    };
    assert!(at(0.1, 0.1).is_some());
    assert_eq!(at(1.5 / 8.0, 1.5 / 8.0), None);
    assert_eq!(at(-0.5, 0.5), None);
    assert_eq!(at(0.5, 7.0), None);
    assert_eq!(at(f64::NAN, 0.5), None);
}
