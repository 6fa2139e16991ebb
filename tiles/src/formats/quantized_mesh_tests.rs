#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::path::PathBuf;
use std::{env, fs};

use glam::DVec2;
use terrain_codec::address::TileAddress;
use terrain_codec::ellipsoid::{SEMI_MAJOR, SEMI_MINOR, normal, to_earth_centred};
use terrain_codec::tile::Tile;
use terrain_core::Mesh;

use super::fixture::{Random, address, drop_unused, even, from_tile, grid, tile, unmeasured};
use super::*;
use crate::outside::{HeightField, Outside};
use crate::shading::oct_decode;

#[path = "quantized_mesh/ground_tests.rs"]
mod ground;
#[path = "quantized_mesh/sides_tests.rs"]
mod sides;

fn hills(x: f64, y: f64) -> f64 {
    ((x / 3_000.0).sin() * 400.0 + (y / 5_000.0).cos() * 300.0 + 900.0).round() / 64.0
}

/// Encodes, decodes, validates; returns what was decoded.
fn through_bytes(tile: &Tile) -> QuantizedMesh {
    let mesh = from_tile(tile, &[], &Outside::Ellipsoid);
    assert_eq!(validate(&mesh, tile.address), Ok(()));
    let decoded = decode(&encode(&mesh, Extensions::ALL), &QuantizedMeshLimits::default()).unwrap();
    assert_eq!(decoded, mesh);
    decoded
}

#[test]
fn a_mesh_keeps_its_triangles_whether_it_fills_its_square_or_not() {
    let extent = 32_768.0;
    // Oblong cells, all cut the same way and then shaken: many of the cuts are no Delaunay edges.
    let mut mesh = grid(&even(16, extent), &even(9, extent), hills, |_, _| true);
    shake(&mut mesh, &mut Random(1), extent);
    for missing in [0, 1, 20] {
        mesh.triangles.drain(100..100 + missing);
        let quantized = through_bytes(&tile(address(10, 300, 700), 15, &mesh));
        let measured = quantized.measured_triangles.unwrap() as usize;
        let actual = quantized.triangles[..measured].iter().map(|triangle| {
            triangle.map(|vertex| {
                [
                    quantized.vertices[vertex as usize].u,
                    quantized.vertices[vertex as usize].v,
                ]
            })
        });
        let expected = mesh.triangles.iter().map(|triangle| {
            triangle.map(|vertex| {
                let position = mesh.positions[vertex as usize];
                [position.x, position.y].map(|coordinate| (coordinate * 32_767.0 / extent).round() as u16)
            })
        });
        assert_eq!(sorted(actual), sorted(expected), "{missing} missing");
        assert_eq!(quantized.edges.each_ref().map(Vec::len), [10, 17, 10, 17]);
    }
}

/// Triangles by their places, whatever their order and their first corner.
fn sorted(triangles: impl Iterator<Item = [[u16; 2]; 3]>) -> Vec<[[u16; 2]; 3]> {
    let mut all: Vec<_> = triangles
        .map(|mut triangle| {
            let first = (0..3).min_by_key(|&corner| triangle[corner]).unwrap();
            triangle.rotate_left(first);
            triangle
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn heights_that_are_multiples_of_the_step_come_back_exactly() {
    let mesh = grid(&even(16, 32_768.0), &even(16, 32_768.0), hills, |_, _| true);
    let tile = tile(address(10, 300, 700), 15, &mesh);
    let quantized = through_bytes(&tile);
    // The range is about 22 m: a step of 2^-10 m holds 32 m.
    assert_eq!(quantized.heights[1] - quantized.heights[0], 32_767.0 / 1_024.0);
    let mut expected: Vec<f64> = mesh.positions.iter().map(|position| position.z).collect();
    let mut actual: Vec<f64> = (0..quantized.vertices.len())
        .map(|index| quantized.geodetic(tile.address, index).height)
        .collect();
    expected.sort_by(f64::total_cmp);
    actual.sort_by(f64::total_cmp);
    let largest = expected
        .iter()
        .zip(&actual)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(largest < 1e-12, "{largest}");
}

#[test]
fn lines_closer_than_rounding_leave_no_hole_and_stay_off_the_sides() {
    // One coordinate step is 32 lattice units: the second to fourth lines fall together.
    let extent_bits = 20;
    let extent = f64::from(1 << extent_bits);
    let mut lines = even(8, extent);
    lines.extend([4.0, 10.0, 20.0, 70.0, extent - 4.0, extent - 20.0]);
    lines.sort_by(f64::total_cmp);
    let mesh = grid(&lines, &lines, hills, |_, _| true);
    let quantized = through_bytes(&tile(address(5, 3, 4), extent_bits, &mesh));
    // Lines 4, 10 and 20 become one on the west and south, 4 and 20 one on the east and north.
    assert_eq!(quantized.edges.each_ref().map(Vec::len), [12; 4]);
    assert_eq!(quantized.vertices.len(), 12 * 12);
    assert_eq!(quantized.triangles.len(), 2 * 11 * 11);
}

#[test]
fn whatever_is_rounded_or_missing_the_square_is_covered_once() {
    let extent_bits = 22;
    let extent = 1_u32 << extent_bits;
    for seed in 0..150 {
        let mut random = Random(seed);
        let mut lines = || {
            let mut lines = vec![0.0, f64::from(extent)];
            // Clusters: a coarse place and a few units more, so that rounding moves neighbours onto each other.
            lines.extend((0..14).map(|_| f64::from(random.below(6) * (extent / 6) + 1 + random.below(700))));
            lines.sort_by(f64::total_cmp);
            lines.dedup();
            lines
        };
        let (columns, rows) = (lines(), lines());
        let mut mesh = grid(
            &columns,
            &rows,
            |x, y| ((x + 2.0 * y) % 17.0 - 8.0).trunc() * 30.0,
            |_, _| true,
        );
        shake(&mut mesh, &mut random, f64::from(extent));
        if seed % 3 > 0 {
            mesh.triangles.retain(|_| random.below(4) > 0);
            mesh = drop_unused(&mesh);
        }
        let zoom = (seed % 12) as u8;
        let quantized = through_bytes(&tile(address(zoom, 0, 0), extent_bits, &mesh));
        assert!(quantized.measured_triangles > Some(20), "seed {seed}");
    }
}

/// Moves vertices by up to 300 units where all their triangles stay counter-clockwise: no longer a tidy grid.
fn shake(mesh: &mut Mesh, random: &mut Random, extent: f64) {
    for vertex in 0..mesh.positions.len() {
        let old = mesh.positions[vertex];
        if [old.x, old.y].iter().any(|&c| c == 0.0 || c == extent) {
            continue;
        }
        let mut offset = || f64::from(random.below(601)) - 300.0;
        mesh.positions[vertex] = old + DVec3::new(offset(), offset(), 0.0);
        if terrain_core::mesh::validate(mesh).is_err() {
            mesh.positions[vertex] = old;
        }
    }
}

/// A plateau of `height` metres on the middle quarter of a tile, with a hole in its middle.
fn plateau(height: f64) -> (Tile, QuantizedMesh) {
    let lines = even(8, 32_768.0);
    let inside = |line: usize| (2..6).contains(&line);
    let keep = |column: usize, row: usize| inside(column) && inside(row) && (column, row) != (3, 4);
    let tile = tile(address(9, 511, 300), 15, &grid(&lines, &lines, |_, _| height, keep));
    let quantized = through_bytes(&tile);
    (tile, quantized)
}

#[test]
fn neighbours_agree_along_their_side() {
    let extent = 32_768.0;
    let fine = |x: f64, y: f64| hills(x, y) + if x < extent { x / 100.0 } else { extent / 100.0 };
    let west_mesh = grid(&even(8, extent), &even(32, extent), fine, |_, _| true);
    let east_mesh = grid(
        &even(4, extent),
        &even(32, extent),
        |x, y| fine(x + extent, y) + x / 7.0,
        |_, _| true,
    );
    let west = tile(address(11, 9, 5), 15, &west_mesh);
    let east = tile(address(11, 10, 5), 15, &east_mesh);
    let (left, right) = (through_bytes(&west), through_bytes(&east));
    let step = |mesh: &QuantizedMesh| f64::from(mesh.heights[1] - mesh.heights[0]) / f64::from(EXTENT);
    assert!(
        step(&left) < step(&right),
        "the case with different steps is the one to test"
    );
    let side = |mesh: &QuantizedMesh, tile: &Tile, list: usize| -> Vec<(u16, f64)> {
        let vertex = |&index: &u32| {
            (
                mesh.vertices[index as usize].v,
                mesh.geodetic(tile.address, index as usize).height,
            )
        };
        mesh.edges[list].iter().map(vertex).collect()
    };
    let (seen_west, mut seen_east) = (side(&left, &west, 2), side(&right, &east, 0));
    seen_east.reverse();
    assert_eq!(seen_west.len(), 33);
    for ((v_west, height_west), (v_east, height_east)) in seen_west.into_iter().zip(seen_east) {
        assert_eq!(v_west, v_east);
        assert!(
            (height_west - height_east).abs() <= step(&right) / 2.0 + 1e-9,
            "{height_west} {height_east}"
        );
    }
}

#[test]
fn the_bare_ellipsoid_is_valid_at_every_zoom() {
    for (zoom, cells) in [(0, 32), (1, 23), (2, 16), (5, 6), (10, 1), (14, 1)] {
        let address = address(zoom, 1, 0);
        let mesh = unmeasured(address, &[], &Outside::Ellipsoid);
        assert_eq!(validate(&mesh, address), Ok(()));
        assert_eq!(mesh.triangles.len(), 2 * cells * cells, "zoom {zoom}");
        assert_eq!((mesh.heights, mesh.measured_triangles), ([0.0, 0.0], Some(0)));
    }
}

#[test]
fn extensions_that_were_not_asked_for_are_not_there() {
    let mesh = unmeasured(address(3, 0, 0), &[], &Outside::Ellipsoid);
    for names in ["", "watermask", "octvertexnormals", "metadata-measuredtriangles"] {
        let asked = Extensions::named(names.split('-'));
        let there = decode(&encode(&mesh, asked), &QuantizedMeshLimits::default()).unwrap();
        assert_eq!(there.normals.is_some(), names.contains("octvertexnormals"), "{names}");
        assert_eq!(there.water_mask, None, "{names}");
        assert_eq!(
            there.measured_triangles.is_some(),
            names.contains("measuredtriangles"),
            "{names}"
        );
    }
}

#[test]
fn a_water_mask_is_a_byte_or_256_rows_of_256() {
    let mut mesh = unmeasured(address(3, 0, 0), &[], &Outside::Ellipsoid);
    let asked = Extensions::named(["watermask"].into_iter());
    let mixed: Vec<u8> = (0..256 * 256)
        .map(|pixel| if pixel % 300 < 40 { 255 } else { 0 })
        .collect();
    for mask in [vec![0], vec![255], mixed] {
        mesh.water_mask = Some(mask.clone());
        let bytes = encode(&mesh, asked);
        let length = (mask.len() as u32).to_le_bytes();
        let head: Vec<u8> = [2].into_iter().chain(length).collect();
        assert!(bytes.ends_with(&[head, mask.clone()].concat()));
        let limits = QuantizedMeshLimits::default();
        assert_eq!(decode(&bytes, &limits).unwrap().water_mask, Some(mask));
        assert_eq!(
            decode(&encode(&mesh, Extensions::default()), &limits)
                .unwrap()
                .water_mask,
            None
        );
    }
    mesh.water_mask = Some(vec![0; 255 * 255]);
    let wrong = decode(&encode(&mesh, asked), &QuantizedMeshLimits::default());
    assert_eq!(wrong, Err(QuantizedMeshError::BadExtension(2)));
}

#[test]
fn a_tile_of_two_triangles_has_the_bytes_of_the_specification() {
    let mesh = unmeasured(address(12, 4_096, 2_048), &[], &Outside::Ellipsoid);
    let bytes = encode(&mesh, Extensions::default());
    assert_eq!(bytes.len(), 88 + (4 + 4 * 6) + (4 + 6 * 2) + 4 * (4 + 2 * 2));
    assert_eq!(bytes[88..92], [4, 0, 0, 0], "vertices");
    assert_eq!(bytes[116..120], [2, 0, 0, 0], "triangles");
    // Triangles 0 1 2 and 3 1 0: after the first use of 3 the next one never used is 4.
    let codes: Vec<u16> = bytes[120..132]
        .chunks(2)
        .map(|code| u16::from_le_bytes([code[0], code[1]]))
        .collect();
    assert_eq!(codes, [0, 0, 0, 0, 4 - 1, 4]);
    let extended = encode(&mesh, Extensions::ALL);
    assert_eq!(extended[164 + 5 + 2 * 4..], [200, 4, 0, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn more_than_65536_vertices_take_padded_four_byte_indices() {
    // 257 × 257 vertices are odd in number: 92 + 6 n is then no multiple of 4.
    for cells in [256, 257] {
        let lines = even(cells, 32_768.0);
        let mesh = grid(&lines, &lines, hills, |_, _| true);
        let quantized = through_bytes(&tile(address(8, 7, 7), 15, &mesh));
        let vertices = quantized.vertices.len();
        assert_eq!(vertices as u32, (cells + 1) * (cells + 1));
        let count = (92 + 6 * vertices).next_multiple_of(4);
        let bytes = encode(&quantized, Extensions::default());
        assert_eq!(bytes[count..count + 4], (2 * cells * cells).to_le_bytes());
    }
}

#[test]
fn from_wherever_the_occlusion_point_is_hidden_so_is_the_tile() {
    let (tile, mesh) = plateau(3_000.0);
    let scale = DVec3::new(SEMI_MAJOR, SEMI_MAJOR, SEMI_MINOR);
    let vertices: Vec<DVec3> = (0..mesh.vertices.len())
        .map(|index| to_earth_centred(mesh.geodetic(tile.address, index)) / scale)
        .collect();
    let point = mesh.horizon_occlusion_point;
    let mut random = Random(7);
    let mut hidden = 0;
    for _ in 0..20_000 {
        let mut unit = || f64::from(random.below(2_001)) / 1_000.0 - 1.0;
        let distance = 1.001 + unit().abs();
        let Some(viewer) = DVec3::new(unit(), unit(), unit()).try_normalize().map(|v| v * distance) else {
            continue;
        };
        if is_behind_unit_sphere(viewer, point) {
            hidden += 1;
            assert!(
                vertices
                    .iter()
                    .all(|&vertex| vertex.length() < 1.0 || is_behind_unit_sphere(viewer, vertex))
            );
        }
    }
    assert!(hidden > 5_000, "{hidden}");
    assert!(
        point.length() < 1.001,
        "the point is no higher than it must be: {}",
        point.length()
    );
}

fn is_behind_unit_sphere(viewer: DVec3, target: DVec3) -> bool {
    let sight = target - viewer;
    let nearest = viewer + sight * (-viewer.dot(sight) / sight.length_squared()).clamp(0.0, 1.0);
    // The target itself is on or above the sphere: only what the line crosses before counts.
    nearest.length() < 1.0 - 1e-12
}

#[test]
fn flat_ground_has_the_ellipsoids_normals() {
    let address = address(6, 70, 50);
    let mesh = unmeasured(address, &[], &Outside::Ellipsoid);
    for (index, &bytes) in mesh.normals.as_ref().unwrap().iter().enumerate() {
        let place = mesh.geodetic(address, index);
        let up = normal(place.longitude, place.latitude);
        // Half a cell of 0.7° and the rounding of two bytes.
        assert!(oct_decode(bytes).angle_between(up).to_degrees() < 1.5);
    }
}

#[test]
fn slivers_along_a_side_do_not_tilt_its_normals() {
    let extent = 32_768.0;
    let mut lines = even(8, extent);
    lines.insert(1, 4.0);
    // Two metres up within four lattice units of the west side: a slope of some 45°.
    let mesh = grid(
        &lines,
        &even(8, extent),
        |x, _| if x > 0.0 { 2.0 } else { 0.0 },
        |_, _| true,
    );
    let tile = tile(address(11, 9, 1_024), 15, &mesh);
    let quantized = through_bytes(&tile);
    let normals = quantized.normals.as_ref().unwrap();
    for &index in &quantized.edges[0] {
        let place = quantized.geodetic(tile.address, index as usize);
        let up = normal(place.longitude, place.latitude);
        let tilt = oct_decode(normals[index as usize]).angle_between(up).to_degrees();
        assert!(tilt < 2.0, "{tilt}");
    }
}

#[test]
fn every_truncation_is_an_error_and_no_flipped_byte_a_panic() {
    let (_, mesh) = plateau(100.0);
    let bytes = encode(&mesh, Extensions::ALL);
    let extensions = bytes.len() - (5 + 4) - (5 + 2 * mesh.vertices.len());
    let ends = [extensions, bytes.len() - 9, bytes.len()];
    for length in (0..bytes.len()).filter(|length| !ends.contains(length)) {
        assert!(
            decode(&bytes[..length], &QuantizedMeshLimits::default()).is_err(),
            "{length} bytes"
        );
    }
    for position in 0..bytes.len() {
        let mut broken = bytes.clone();
        broken[position] ^= 0xFF;
        drop(decode(&broken, &QuantizedMeshLimits::default()));
    }
}

#[test]
fn what_a_tile_asks_for_is_limited() {
    let (_, mesh) = plateau(100.0);
    let limits = QuantizedMeshLimits {
        vertices: 10,
        triangles: 1_000,
    };
    let error = decode(&encode(&mesh, Extensions::ALL), &limits).unwrap_err();
    assert!(error.to_string().ends_with("vertices, the limit is 10"), "{error}");
    let mut bytes = encode(&mesh, Extensions::ALL);
    bytes[88..92].copy_from_slice(&4_000_000_u32.to_le_bytes());
    assert_eq!(
        decode(&bytes, &QuantizedMeshLimits::default()),
        Err(QuantizedMeshError::Truncated("vertices"))
    );
}

#[test]
fn the_validator_sees_what_is_wrong() {
    let (tile, mesh) = plateau(100.0);
    let fault = |change: fn(&mut QuantizedMesh)| {
        let mut broken = mesh.clone();
        change(&mut broken);
        validate(&broken, tile.address).unwrap_err()
    };
    assert_eq!(
        fault(|mesh| mesh.triangles[3].swap(0, 1)),
        Fault::NotCounterClockwise(3)
    );
    assert!(matches!(fault(|mesh| mesh.triangles.truncate(1)), Fault::WrongArea(..)));
    assert!(matches!(
        fault(|mesh| mesh.triangles.truncate(mesh.triangles.len() - 1)),
        Fault::OpenEdge(..)
    ));
    assert_eq!(
        fault(|mesh| mesh.edges[1].truncate(1)),
        Fault::WrongEdgeList(Side::South)
    );
    assert!(matches!(
        fault(|mesh| mesh.sphere_radius *= 0.99),
        Fault::OutsideSphere(_)
    ));
    assert!(matches!(
        fault(|mesh| mesh.vertices.push(Vertex { u: 5, v: 5, height: 0 })),
        Fault::UnusedVertex(_)
    ));
}

#[test]
fn tiles_of_other_makers_are_read() {
    let folder = env::var_os("TERRAIN_SHARED_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let folder = folder.join("terrain_tiles");
    if !folder.is_dir() {
        println!("skipped: no {}", folder.display());
        return;
    }
    let cases = [
        ("cesium/tile.terrain", 219, 402, false),
        ("cesium/tile.octvertexnormals.terrain", 214, 392, true),
        ("cesium/tile.octvertexnormals.unknownext.terrain", 214, 392, true),
        ("cesium/tile.watermask.terrain", 218, 400, false),
        ("cesium/tile.metadataavailability.terrain", 208, 380, false),
        ("cesium/tile.32bitIndices.terrain", 65_612, 131_103, false),
        ("cesium/9_759_335.terrain", 2_460, 4_755, true),
        ("here/tile-opentin.terrain", 4, 2, false),
    ];
    for (name, vertices, triangles, normals) in cases {
        let mesh = decode(&fs::read(folder.join(name)).unwrap(), &QuantizedMeshLimits::default()).unwrap();
        assert_eq!(
            (mesh.vertices.len(), mesh.triangles.len(), mesh.normals.is_some()),
            (vertices, triangles, normals)
        );
        assert_eq!(mesh.measured_triangles, None);
        let again = decode(&encode(&mesh, Extensions::ALL), &QuantizedMeshLimits::default()).unwrap();
        assert_eq!(again, mesh, "{name}");
    }
    // Its extension has a big-endian length, as the first servers wrote it.
    let legacy = fs::read(folder.join("cesium/tile.vertexnormals.terrain")).unwrap();
    assert_eq!(
        decode(&legacy, &QuantizedMeshLimits::default()),
        Err(QuantizedMeshError::Truncated("extensions"))
    );
}
