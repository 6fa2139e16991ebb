//! Ground completes the square.

use super::*;

#[test]
fn ground_completes_the_square_and_walls_close_the_step() {
    let (tile, mesh) = plateau(100.0);
    assert_eq!(mesh.measured_triangles, Some(2 * 15));
    let areas: Vec<i64> = mesh
        .triangles
        .iter()
        .map(|triangle| plan_area(&mesh.vertices, *triangle))
        .collect();
    let covered: i64 = areas[..30].iter().sum();
    let (side, cell) = (i64::from(EXTENT), 4_096_i64);
    assert!((covered - 2 * 15 * cell * cell).abs() < 8 * side, "{covered}");
    // 16 rim edges outside and 4 around the hole, two triangles each.
    assert_eq!(areas.iter().filter(|&&area| area == 0).count(), 2 * 20);
    let heights: Vec<f64> = (0..mesh.vertices.len())
        .map(|index| mesh.geodetic(tile.address, index).height)
        .collect();
    assert!(
        heights.iter().all(|height| [0.0, 100.0].contains(height)),
        "{heights:?}"
    );
}

#[test]
fn walls_face_the_ground_below_a_plateau_and_the_pit_where_it_is_sunk() {
    for (height, outwards) in [(100.0, 1.0), (-100.0, -1.0)] {
        let (_, mesh) = plateau(height);
        let local = |index: u32| {
            let vertex = mesh.vertices[index as usize];
            DVec3::new(f64::from(vertex.u), f64::from(vertex.v), f64::from(vertex.height))
        };
        let rim = mesh
            .triangles
            .iter()
            .filter(|triangle| plan_area(&mesh.vertices, **triangle) == 0);
        for triangle in rim {
            let [a, b, c] = triangle.map(local);
            let normal = (b - a).cross(c - a).truncate();
            let middle = ((a + b + c) / 3.0).truncate();
            // The hole is the cell from 3/8 to 4/8 and 4/8 to 5/8; the plateau's centre is 1/2, 1/2.
            let hole = DVec2::new(3.5, 4.5) * 4_096.0;
            let around_hole = (middle - hole).abs().max_element() < 2_100.0;
            let away = if around_hole {
                hole - middle
            } else {
                middle - DVec2::splat(16_384.0)
            };
            assert!(normal.dot(away) * outwards > 0.0, "{triangle:?}");
        }
    }
}

#[test]
fn ground_that_reaches_a_side_is_listed_with_the_step_in_order() {
    let lines = even(8, 32_768.0);
    // Measured from the middle northwards, and so beside it: both sides have ground up to there, both at the middle, measured beyond.
    let at = |x: u32| {
        let mesh = grid(&lines, &lines, |_, _| 50.0, |_, row| row >= 4);
        tile(address(12, x, 0), 15, &drop_unused(&mesh))
    };
    let (tile, beside) = (at(1), [at(0), at(2)]);
    let mesh = from_tile(&tile, &beside, &Outside::Ellipsoid);
    assert_eq!(validate(&mesh, tile.address), Ok(()));
    let step = |side: usize| -> Vec<(u16, f64)> {
        let vertex = |&index: &u32| {
            (
                mesh.vertices[index as usize].v,
                mesh.geodetic(tile.address, index as usize).height,
            )
        };
        mesh.edges[side].iter().map(vertex).collect()
    };
    let measured = [
        (16_384, 50.0),
        (20_479, 50.0),
        (24_575, 50.0),
        (28_671, 50.0),
        (32_767, 50.0),
    ];
    let mut west = vec![(0, 0.0), (16_384, 0.0)];
    west.extend(measured);
    assert_eq!(step(0), west);
    west.reverse();
    assert_eq!(step(2), west, "the east side runs southwards");
}

/// Ground around 400 m over the tile and its neighbours.
fn around(address: TileAddress) -> Outside {
    let size = address.degrees();
    Outside::Extend {
        field: HeightField {
            bounds: [
                address.west() - size,
                address.south() - size,
                address.west() + 2.0 * size,
                address.south() + 2.0 * size,
            ],
            columns: 4,
            decimetres: (0..16).map(|node| 4_000 + 10 * node).collect(),
        },
    }
}

#[test]
fn ground_that_goes_on_meets_the_data_without_a_wall() {
    let address = address(10, 300, 700);
    let extent = 32_768.0;
    let island = |column: usize, row: usize| (3..9).contains(&column) && (2..7).contains(&row);
    let mesh = grid(&even(16, extent), &even(9, extent), hills, island);
    let outside = around(address);
    let quantized = from_tile(&tile(address, 15, &mesh), &[], &outside);
    assert_eq!(validate(&quantized, address), Ok(()));
    let measured = quantized.measured_triangles.unwrap() as usize;
    assert!(measured < quantized.triangles.len());
    let area = |triangle: &[u32; 3]| plan_area(&quantized.vertices, *triangle);
    assert!(quantized.triangles.iter().all(|triangle| area(triangle) > 0));
    let height = |index: u32| quantized.geodetic(address, index as usize).height;
    let corners = quantized.edges.iter().flatten().map(|&vertex| height(vertex));
    assert!(corners.clone().all(|height| (404.0..411.0).contains(&height)));
    let walled = from_tile(&tile(address, 15, &mesh), &[], &Outside::Ellipsoid);
    let walls = walled
        .triangles
        .iter()
        .filter(|triangle| plan_area(&walled.vertices, **triangle) == 0);
    assert!(walls.count() > 0);
}
