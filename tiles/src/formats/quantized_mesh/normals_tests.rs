#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use terrain_core::{Band, CollapseLog, SurfacePartition};

use super::*;
use crate::filled::Filled;
use crate::tile::Lineage;

const EXTENT: f64 = 1024.0;

/// Eight by eight cells and a strip of four units along each side, all of them on one surface over the whole Earth.
fn tile(zoom: u8, x: u32, y: u32) -> Tile {
    let mut lines: Vec<f64> = (0..=8).map(|line| f64::from(line) * 128.0).collect();
    lines.splice(1..1, [4.0]);
    lines.insert(9, EXTENT - 4.0);
    tile_of(zoom, x, y, &lines, |u, v| {
        let (x, y) = (f64::from(x) + u / EXTENT, f64::from(y) + v / EXTENT);
        (4000.0 * ((2.0 * x).sin() + (3.0 * y).cos())).round()
    })
}

/// Cells between `lines` in both directions; `height` is that of places in it.
fn tile_of(zoom: u8, x: u32, y: u32, lines: &[f64], height: impl Fn(f64, f64) -> f64 + Copy) -> Tile {
    let address = TileAddress::new(zoom, x, y).unwrap();
    let width = lines.len() as u32;
    let positions = lines
        .iter()
        .flat_map(|&v| lines.iter().map(move |&u| DVec3::new(u, v, height(u, v))));
    let cells = (0..width - 1).flat_map(|row| (0..width - 1).map(move |column| row * width + column));
    let mesh = Mesh {
        positions: positions.collect(),
        triangles: cells
            .flat_map(|a| [[a, a + 1, a + width + 1], [a, a + width + 1, a + width]])
            .collect(),
    };
    let log = CollapseLog {
        collapses: Vec::new(),
        bands: vec![Band { end: 0, error: 1.0 }; 4],
    };
    Tile {
        address,
        extent_bits: 10,
        height_exponent: 0,
        sampling: None,
        lineage: Lineage::default(),
        breaklines: Vec::new(),
        filled: Filled::default(),
        outline_errors: vec![0.0; 5],
        partition: SurfacePartition::from_log(&mesh, &log, 0.0).unwrap(),
    }
}

fn shaded(tile: &Tile) -> Vec<(Place, DVec3)> {
    let beside: Vec<Tile> = addresses_around(tile.address)
        .into_iter()
        .map(|address| self::tile(address.zoom, address.x, address.y))
        .collect();
    let shared = SharedNormals::of(beside.iter().chain([tile]).map(|tile| (tile, tile.finest())));
    let (_, normals) = shared.surface(tile.address);
    shared.surfaces[&tile.address]
        .places
        .iter()
        .copied()
        .zip(normals)
        .collect()
}

#[test]
fn normals_on_a_side_are_the_same_bits_in_all_tiles_there() {
    for (a, b, shared) in [
        (tile(5, 20, 10), tile(5, 21, 10), 11),
        (tile(5, 20, 10), tile(5, 20, 11), 11),
        (tile(5, 20, 10), tile(5, 21, 11), 1),
    ] {
        let of_b: HashMap<Place, DVec3> = shaded(&b).into_iter().collect();
        let both = shaded(&a)
            .into_iter()
            .filter_map(|(place, normal)| Some((normal, *of_b.get(&place)?)));
        let both: Vec<(DVec3, DVec3)> = both.collect();
        assert_eq!(both.len(), shared);
        assert!(both.iter().all(|(a, b)| a == b));
    }
}

#[test]
fn the_antimeridian_is_a_side_like_others() {
    let (west, east) = (tile(3, 15, 3), tile(3, 0, 3));
    let of_east = shaded(&east);
    let mut shared = 0;
    for (place, normal) in shaded(&west).into_iter().filter(|(place, _)| place[0] == 0) {
        let there = of_east.iter().find(|(other, _)| *other == place).unwrap();
        assert_eq!(there.1, normal, "{place:?}");
        shared += 1;
    }
    assert_eq!(shared, 11);
}

#[test]
fn across_the_strip_the_normal_hardly_changes() {
    let tile = tile(5, 20, 10);
    let all: HashMap<Place, DVec3> = shaded(&tile).into_iter().collect();
    let unit = 1_i128 << (PLACE_BITS - 10);
    let [left, bottom] = [20_i128 << PLACE_BITS, 10_i128 << PLACE_BITS];
    for along in 2..8 {
        let side = all[&[left, bottom + along * 128 * unit]];
        let inner = all[&[left + 4 * unit, bottom + along * 128 * unit]];
        assert!(side.angle_between(inner).to_degrees() < 10.0);
    }
}

#[test]
fn steps_in_strips_along_sides_and_along_those_of_children_do_not_tilt_normals() {
    let lines = [
        0.0, 4.0, 128.0, 256.0, 384.0, 508.0, 512.0, 516.0, 640.0, 768.0, 896.0, 1020.0, 1024.0,
    ];
    let is_inside = |along: f64| ![0.0, EXTENT / 2.0, EXTENT].contains(&along);
    let height = |u: f64, v: f64| if is_inside(u) && is_inside(v) { 40.0 } else { 0.0 };
    let stepped = |x: u32, y: u32| tile_of(14, x, y, &lines, height);
    let own = stepped(9000, 11_000);
    let beside: Vec<Tile> = addresses_around(own.address)
        .into_iter()
        .map(|address| stepped(address.x, address.y))
        .collect();
    let shared = SharedNormals::of(beside.iter().chain([&own]).map(|tile| (tile, tile.finest())));
    let (mesh, normals) = shared.surface(own.address);
    for (&at, found) in mesh.positions.iter().zip(normals) {
        let place = own.geodetic(at);
        let tilt = found
            .dot(normal(place.longitude, place.latitude))
            .min(1.0)
            .acos()
            .to_degrees();
        assert!(tilt < 0.1, "{tilt}° at {at}");
    }
}

#[test]
fn tiles_around_are_those_of_the_scheme() {
    let numbers = |zoom, x, y| addresses_around(TileAddress::new(zoom, x, y).unwrap()).len();
    assert_eq!(
        [numbers(0, 0, 0), numbers(1, 0, 0), numbers(2, 0, 0), numbers(2, 3, 1)],
        [1, 5, 5, 8]
    );
}

#[test]
fn at_a_pole_all_tiles_have_the_normal_of_the_ellipsoid() {
    for (y, expected) in [(0, DVec3::NEG_Z), (7, DVec3::Z)] {
        let tile = tile(3, 5, y);
        let row = i128::from(if y == 0 { 0 } else { 8_u32 }) << PLACE_BITS;
        let normals = shaded(&tile);
        let at_pole: Vec<_> = normals.into_iter().filter(|(place, _)| place[1] == row).collect();
        assert_eq!(at_pole.len(), 11);
        assert!(at_pole.iter().all(|&(_, normal)| normal == expected), "{at_pole:?}");
    }
}
