//! Where data end at a tile's side, the tile across meets them.

use terrain_codec::ellipsoid::Geodetic;

use super::super::fixture::{border, unlike};
use super::*;
use crate::shading::FinestSurface;

#[test]
fn what_is_beside_the_data_meets_them_where_they_end_at_a_side() {
    let lines = even(16, 32_768.0);
    let mesh = grid(&lines, &lines, |x, y| hills(x, y) + 4000.0, |_, _| true);
    let data = tile(address(6, 63, 20), 15, &mesh);
    let fine = through_bytes(&data);
    let field = HeightField {
        bounds: [-180.0, -90.0, 180.0, 90.0],
        columns: 3,
        decimetres: vec![20_000; 9],
    };
    for outside in [Outside::Ellipsoid, Outside::Extend { field }] {
        for (side, opposite) in [
            (Side::South, Side::North),
            (Side::West, Side::East),
            (Side::North, Side::South),
            (Side::East, Side::West),
        ] {
            let at = data.address.neighbour(side).unwrap();
            let beside = unmeasured(at, std::slice::from_ref(&data), &outside);
            assert_eq!(validate(&beside, at), Ok(()), "{side:?}");
            let (expected, found) = (of_side(&fine, data.address, side), of_side(&beside, at, opposite));
            if outside == Outside::Ellipsoid {
                // The slope down from the data ends a 64th of a tile from them, and nothing inside is higher than the ground.
                let places = (0..beside.vertices.len()).map(|vertex| beside.geodetic(at, vertex));
                let inside: Vec<Geodetic> = places.filter(|place| place.height < 1.0).collect();
                let is_near = |[longitude, latitude, _]: [f64; 3]| {
                    let apart = |place: &Geodetic| {
                        (place.longitude - longitude)
                            .abs()
                            .max((place.latitude - latitude).abs())
                    };
                    inside.iter().any(|place| apart(place) < at.degrees() / 60.0)
                };
                assert!(
                    found.iter().copied().filter(|place| place[2] > 1.0).all(is_near),
                    "{side:?}"
                );
                assert_eq!(
                    beside.vertices.len() - inside.len(),
                    found.iter().filter(|place| place[2] > 1.0).count()
                );
            }
            assert_eq!(expected.len(), found.len(), "{side:?}");
            for (one, other) in expected.iter().zip(&found) {
                let apart = [0, 1, 2].map(|axis| (one[axis] - other[axis]).abs());
                assert!(
                    apart[0] < 1e-9 && apart[1] < 1e-9 && apart[2] < 0.2,
                    "{one:?} {other:?}"
                );
            }
        }
        // Across a corner, the corner alone is known.
        let across = address(6, 62, 19);
        let beside = unmeasured(across, std::slice::from_ref(&data), &outside);
        assert_eq!(validate(&beside, across), Ok(()));
        let [corner, other] = [(address(6, 63, 20).west(), 3000.0), (across.west(), 0.0)].map(|(west, least)| {
            let corners = of_side(&beside, across, Side::North);
            let found = corners
                .into_iter()
                .find(|place| (place[0] - west).abs() < 1e-9)
                .unwrap();
            (found[2], least)
        });
        assert!(corner.0 > corner.1 && other.0 < 3000.0, "{corner:?} {other:?}");
    }
}

#[test]
fn a_tile_that_fills_its_square_asks_for_none_beside_it() {
    for (bits, extent) in [(15, 32_768.0), (30, f64::from(1 << 30))] {
        let lines = even(16, extent);
        let asks = |keep: &dyn Fn(usize, usize) -> bool| {
            let height = |x: f64, y: f64| hills(x / extent * 32_768.0, y / extent * 32_768.0);
            let mesh = drop_unused(&grid(&lines, &lines, height, keep));
            let own = FinestSurface::unshaded(tile(address(6, 63, 20), bits, &mesh));
            // What is beside is asked for by failing.
            QuantizedMesh::from_tile(&own, |_| Err(()), &Outside::Ellipsoid).is_err()
        };
        assert!(!asks(&|_, _| true));
        assert!(asks(&|column, _| column > 0));
        assert!(asks(&|column, row| column > 0 || row / 2 != 2));
    }
}

/// Longitude, latitude and height of the vertices on a side, in order.
fn of_side(mesh: &QuantizedMesh, at: TileAddress, side: Side) -> Vec<[f64; 3]> {
    let edge = mesh.edges[side as usize].iter();
    let places = edge.map(|&vertex| mesh.geodetic(at, vertex as usize));
    let mut places: Vec<[f64; 3]> = places
        .map(|place| [place.longitude, place.latitude, place.height])
        .collect();
    places.sort_by(|a, b| a.partial_cmp(b).unwrap());
    places
}

#[test]
fn tiles_of_which_one_has_data_at_a_side_where_the_other_has_none_meet() {
    let lines = even(16, 32_768.0);
    let field = HeightField {
        bounds: [-180.0, -90.0, 180.0, 90.0],
        columns: 3,
        decimetres: vec![20_000; 9],
    };
    for (seed, outside) in (0..8).flat_map(|seed| {
        [
            (seed, Outside::Ellipsoid),
            (seed, Outside::Extend { field: field.clone() }),
        ]
    }) {
        let mut random = Random(seed);
        // Cells of half a tile's width each are there or not; so data end at sides, and meet at corners alone.
        let addresses = (20..23).flat_map(|y| (62..66).map(move |x| address(6, x, y)));
        let tiles: Vec<Tile> = addresses
            .filter_map(|at| {
                let blocks = [0; 16].map(|_| random.below(2) == 0);
                let height =
                    |x: f64, y: f64| hills(x + f64::from(at.x) * 32_768.0, y + f64::from(at.y) * 32_768.0) + 4000.0;
                let keep = |column: usize, row: usize| blocks[column / 4 + row / 4 * 4];
                let mesh = grid(&lines, &lines, height, keep);
                (!mesh.triangles.is_empty()).then(|| tile(at, 15, &drop_unused(&mesh)))
            })
            .collect();
        let made = |at: TileAddress| {
            let around = at.around();
            let beside: Vec<Tile> = tiles
                .iter()
                .filter(|tile| around.contains(&tile.address))
                .cloned()
                .collect();
            let mesh = match tiles.iter().find(|tile| tile.address == at) {
                Some(tile) => from_tile(tile, &beside, &outside),
                None => unmeasured(at, &beside, &outside),
            };
            assert_eq!(validate(&mesh, at), Ok(()), "{at}");
            mesh
        };
        for (at, side, opposite) in (20..23)
            .flat_map(|y| (61..66).map(move |x| address(6, x, y)))
            .flat_map(|at| [(at, Side::East, Side::West), (at, Side::North, Side::South)])
        {
            let other = at.neighbour(side).unwrap();
            let (here, there) = (border(&made(at), at, side), border(&made(other), other, opposite));
            assert_eq!(
                unlike(&here, &there, 0.2),
                0,
                "{seed}: {at} {side:?}: {here:?} {there:?}"
            );
        }
    }
}
