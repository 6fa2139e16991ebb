#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::convert::Infallible;

use terrain_codec::address::{Side, standing_for};
use terrain_codec::ellipsoid::to_earth_centred;
use terrain_codec::tile::Tile;

use super::super::fixture::{Random, border, drop_unused, even, grid, tile, unlike};
use super::super::{EXTENT, QuantizedMeshLimits, decode, encode, validate};
use super::*;
use crate::formats::quantized_mesh::Extensions;
use crate::ground::Ground;
use crate::outside::HeightField;
use crate::shading::tests::surfaces_of;

const EXTENT_BITS: u8 = 15;
const UNITS: f64 = 32_768.0;

/// Tiles of a zoom with hills that go on from one to the next, each with other triangles; with holes, at their sides, too, if `ragged`.
fn hills(zoom: u8, columns: std::ops::Range<u32>, rows: std::ops::Range<u32>, ragged: bool) -> Vec<Tile> {
    let mut random = Random(7);
    let mut tiles = Vec::new();
    for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
        let address = TileAddress::new(zoom, x, y).unwrap();
        let height = |u: f64, v: f64| {
            let at = [f64::from(x) + u / UNITS, f64::from(y) + v / UNITS];
            (at[0] * 5.0).sin() * 400.0 + (at[1] * 7.0).cos() * 300.0 + 900.0
        };
        let mut mesh = grid(&even(8, UNITS), &even(8, UNITS), height, |_, _| true);
        // Inner vertices leave the grid: edges are cut at all angles.
        for position in &mut mesh.positions {
            let is_inner = [position.x, position.y].iter().all(|&at| at != 0.0 && at != UNITS);
            if is_inner {
                let mut shaken = |at: f64| at + f64::from(random.below(2_001)) - 1_000.0;
                let (u, v) = (shaken(position.x), shaken(position.y));
                *position = DVec3::new(u, v, height(u, v));
            }
        }
        if ragged {
            mesh.triangles.retain(|_| random.below(3) > 0);
            mesh = drop_unused(&mesh);
        }
        tiles.push(tile(address, EXTENT_BITS, &mesh));
    }
    tiles
}

/// Encoded, decoded and valid.
fn made(square: SquareTile, tiles: &[Tile], outside: &Outside) -> QuantizedMesh {
    let surfaces = surfaces_of(tiles);
    let is_there = |address| tiles.iter().any(|tile| tile.address == address);
    let standing = |address| {
        let standing = standing_for(address, is_there);
        let surface = surfaces.iter().find(|surface| Some(surface.tile.address) == standing);
        Ok::<_, Infallible>(surface.cloned())
    };
    let mesh = QuantizedMesh::in_mercator(square, standing, outside).unwrap();
    assert_eq!(validate(&mesh, square), Ok(()), "{square:?}");
    decode(&encode(&mesh, Extensions::ALL), &QuantizedMeshLimits::default()).unwrap()
}

/// Longitude and latitude in billionths of a degree and height of the vertices on a side.
fn side(mesh: &QuantizedMesh, square: SquareTile, side: Side) -> Vec<([i64; 2], f64)> {
    let vertex = |&index: &u32| {
        let place = mesh.geodetic(square, index as usize);
        let plan = [place.longitude, place.latitude].map(|degrees| (degrees * 1e9).round() as i64);
        (plan, place.height)
    };
    let mut vertices: Vec<_> = mesh.edges[side as usize].iter().map(vertex).collect();
    vertices.sort_by(|a, b| a.partial_cmp(b).unwrap());
    vertices
}

fn step(mesh: &QuantizedMesh) -> f64 {
    f64::from(mesh.heights[1] - mesh.heights[0]) / f64::from(EXTENT)
}

fn somewhere_at_49_degrees() -> [std::ops::Range<u32>; 2] {
    let zoom = 9;
    let first = TileAddress { zoom, x: 300, y: 395 };
    assert!((48.0..50.0).contains(&first.south()));
    [300..304, 395..398]
}

/// Tiles of Web Mercator that reach into some tiles.
fn over(tiles: &[Tile]) -> Vec<SquareTile> {
    let mut squares: Vec<SquareTile> = tiles
        .iter()
        .flat_map(|tile| mercator::tiles_over(tile.address, tile.address.zoom + 1))
        .collect();
    squares.sort_unstable();
    squares.dedup();
    squares
}

#[test]
fn the_surface_stays_where_it_is() {
    let [columns, rows] = somewhere_at_49_degrees();
    let tiles = hills(9, columns, rows, false);
    let grounds: Vec<Ground> = tiles.iter().map(Ground::of).collect();
    let mut random = Random(3);
    let mut measured = 0;
    for square in over(&tiles) {
        let mesh = made(square, &tiles, &Outside::Ellipsoid);
        let count = mesh.measured_triangles.unwrap() as usize;
        for triangle in &mesh.triangles[..count] {
            let corners = triangle.map(|vertex| to_earth_centred(mesh.geodetic(square, vertex as usize)));
            let mut weights = [0; 3].map(|_| f64::from(random.below(1_000)) + 1.0);
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= sum);
            let place = to_geodetic((0..3).map(|corner| corners[corner] * weights[corner]).sum());
            let found = grounds
                .iter()
                .find_map(|ground| ground.height(place.longitude, place.latitude));
            // Rounding moves a corner by up to a metre along slopes of up to a sixth, and up by half a step.
            let difference = (found.unwrap() - place.height).abs();
            assert!(difference < 0.3 + step(&mesh), "{square:?}: {difference} m");
            measured += 1;
        }
    }
    assert!(measured > 1_000, "{measured}");
}

#[test]
fn tiles_meet_at_their_sides() {
    let [columns, rows] = somewhere_at_49_degrees();
    let field = HeightField {
        bounds: [-180.0, -90.0, 180.0, 90.0],
        columns: 3,
        decimetres: vec![20_000; 9],
    };
    for (ragged, outside) in [
        (false, Outside::Ellipsoid),
        (true, Outside::Ellipsoid),
        (true, Outside::Extend { field }),
    ] {
        let tiles = hills(9, columns.clone(), rows.clone(), ragged);
        let squares = over(&tiles);
        let meshes: Vec<QuantizedMesh> = squares.iter().map(|&square| made(square, &tiles, &outside)).collect();
        let find = |x: u32, y: u32| squares.iter().position(|square| (square.x, square.y) == (x, y));
        let mut met = 0;
        for (one, &square) in squares.iter().enumerate() {
            let beside = [
                (find(square.x + 1, square.y), Side::East, Side::West),
                (find(square.x, square.y + 1), Side::South, Side::North),
            ];
            for (other, own, opposite) in beside {
                let Some(other) = other else { continue };
                let (here, there) = (
                    border(&meshes[one], square, own),
                    border(&meshes[other], squares[other], opposite),
                );
                let most = step(&meshes[one]).max(step(&meshes[other])) / 2.0 + 1e-6;
                assert_eq!(unlike(&here, &there, most), 0, "{square:?} {own:?}: {here:?} {there:?}");
                met += here.len();
            }
        }
        assert!(met > 300, "{met}");
    }
}

#[test]
fn what_is_beside_the_data_meets_them() {
    // Data that end at the equator, where a row of both schemes begins.
    let tiles = hills(4, 10..12, 8..9, false);
    let north = SquareTile { zoom: 5, x: 10, y: 15 };
    let south = SquareTile { y: 16, ..north };
    let [data, bare] = [north, south].map(|square| made(square, &tiles, &Outside::Ellipsoid));
    assert!(data.measured_triangles > Some(100) && bare.measured_triangles == Some(0));
    let meets = |vertices: Vec<([i64; 2], f64)>| -> Vec<[i64; 2]> { vertices.iter().map(|vertex| vertex.0).collect() };
    assert_eq!(
        meets(side(&data, north, Side::South)),
        meets(side(&bare, south, Side::North))
    );
    let lowest = |vertices: Vec<([i64; 2], f64)>| vertices.iter().map(|vertex| vertex.1).fold(f64::INFINITY, f64::min);
    assert!(lowest(side(&bare, south, Side::North)) > 100.0);
}

#[test]
fn the_whole_earth_and_its_quarters_are_whole() {
    let tiles = hills(0, 0..2, 0..1, false);
    let root = SquareTile { zoom: 0, x: 0, y: 0 };
    assert_eq!(addresses_under(root).len(), 2);
    let mesh = made(root, &tiles, &Outside::Ellipsoid);
    assert_eq!(mesh.measured_triangles, Some(mesh.triangles.len() as u32));
    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let quarter = made(SquareTile { zoom: 1, x, y }, &tiles, &Outside::Ellipsoid);
        assert_eq!(quarter.measured_triangles, Some(quarter.triangles.len() as u32));
    }
}

#[test]
fn a_leaf_above_stands_for_squares_that_have_no_tile() {
    let tiles = [hills(5, 20..21, 20..21, false), hills(6, 42..43, 40..41, false)].concat();
    let mut found = 0;
    for square in mercator::tiles_over(tiles[0].address, 7) {
        let mesh = made(square, &tiles, &Outside::Ellipsoid);
        found += u32::from(mesh.measured_triangles > Some(20));
    }
    assert!(found >= 4, "{found}");
}

#[test]
fn a_tile_reaches_into_the_squares_that_it_has_a_part_of() {
    for zoom in 0..7_u8 {
        for (x, y) in (0..1 << zoom).flat_map(|y| (0..1 << zoom).map(move |x| (x, y))) {
            let square = SquareTile { zoom, x, y };
            let own = Rectangle::from(square);
            let has_a_part = |address: &TileAddress| {
                let other = Rectangle::from(*address);
                let shared = |from: f64, length: f64, other: f64, other_length: f64| {
                    (from + length).min(other + other_length) - from.max(other) > 1e-9
                };
                shared(own.west, own.width, other.west, other.width)
                    && shared(own.south, own.height, other.south, other.height)
            };
            let zoom = zoom.saturating_sub(1);
            let all = (0..1 << zoom).flat_map(|y| (0..2 << zoom).map(move |x| TileAddress { zoom, x, y }));
            let expected: Vec<TileAddress> = all.filter(has_a_part).collect();
            assert_eq!(addresses_under(square), expected, "{square:?}");
        }
    }
}
