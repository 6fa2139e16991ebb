#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use crate::damage;
use crate::filled::Filled;
use crate::progressive::tests::assert_same_levels;
use glam::DVec3;
use terrain_core::{Band, Collapse, CollapseLog, Mesh};

use super::*;

/// A 4 × 4 grid on a 48-unit tile whose west side and interior lose a vertex each.
pub(crate) fn small_tile() -> Tile {
    let height = |i: u32| f64::from(i * i % 7) * 0.25;
    let positions = (0..16)
        .map(|i| DVec3::new(f64::from(i % 4) * 16.0, f64::from(i / 4) * 16.0, height(i)))
        .collect();
    let quads = (0..9_u32).map(|i| i / 3 * 4 + i % 3);
    let triangles = quads.flat_map(|a| [[a, a + 1, a + 5], [a, a + 5, a + 4]]).collect();
    let mesh = Mesh { positions, triangles };
    let at = |v: u32| mesh.positions[v as usize];
    let west = Collapse {
        blue: 4,
        red: 8,
        red_before: at(8),
        red_after: at(8),
        closes_hole: false,
    };
    let interior = Collapse {
        blue: 5,
        red: 6,
        red_before: at(6),
        red_after: at(6) + DVec3::Z,
        closes_hole: false,
    };
    let band = |end, error| Band { end, error };
    let bands = vec![band(0, 1.0), band(0, 1.0), band(0, 1.0), band(1, 1.5), band(2, 2.0)];
    let log = CollapseLog {
        collapses: vec![west, interior],
        bands,
    };
    Tile {
        address: TileAddress::new(3, 5, 2).unwrap(),
        extent_bits: 6,
        height_exponent: -2,
        sampling: None,
        lineage: Lineage::default(),
        breaklines: Vec::new(),
        filled: Filled::default(),
        partition: SurfacePartition::from_log(&mesh, &log, 1.0).unwrap(),
        outline_errors: vec![0.5, 0.25, 0.0, 0.0, 0.0, 0.0],
    }
}

/// Asserts that two tiles are the same but for the order of vertices and triangles in a level.
fn assert_same(one: &Tile, other: &Tile) {
    let rest = |tile: &Tile| Tile {
        partition: SurfacePartition::default(),
        ..tile.clone()
    };
    assert_eq!(rest(one), rest(other));
    assert_same_levels(&one.partition, &other.partition);
}

#[test]
fn a_tile_comes_back_as_it_was() {
    let tile = small_tile();
    assert_same(
        &decode(&encode(&tile).unwrap(), &LevelLimits::default()).unwrap(),
        &tile,
    );
}

#[test]
fn samples_are_stored_and_shorten_a_tile_whose_vertices_they_are() {
    let plain = small_tile();
    let sampling = Sampling {
        origin: [0.0; 2],
        step: [16.0; 2],
    };
    let sampled = Tile {
        sampling: Some(sampling),
        ..plain.clone()
    };
    let bytes = encode(&sampled).unwrap();
    assert_same(&decode(&bytes, &LevelLimits::default()).unwrap(), &sampled);
    assert!(
        bytes.len() - 32 < encode(&plain).unwrap().len(),
        "but for the four numbers that tell them"
    );
}

#[test]
fn bytes_written_by_version_2_are_read_for_ever() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/small_v3.spt");
    let golden = std::fs::read(file).unwrap();
    assert_same(&decode(&golden, &LevelLimits::default()).unwrap(), &small_tile());
    assert_eq!(
        encode(&small_tile()).unwrap(),
        golden,
        "the encoder still makes the same of it"
    );
}

/// The arrays of a tile as a browser has them: positions, restored positions, representatives, corners.
fn arrays(tile: &Tile) -> Vec<u8> {
    let partition = &tile.partition;
    let positions = partition.positions.iter().chain(&partition.blue_positions);
    let coordinates = positions.flat_map(|position| position.to_array());
    let mut bytes: Vec<u8> = coordinates.flat_map(f64::to_le_bytes).collect();
    let indices = partition
        .representatives
        .iter()
        .chain(partition.triangles.as_flattened());
    bytes.extend(indices.flat_map(|index| index.to_le_bytes()));
    bytes
}

#[test]
fn a_real_tile_decodes_to_the_arrays_that_were_recorded() {
    let golden = |name: &str| format!("{}/golden/{name}", env!("CARGO_MANIFEST_DIR"));
    let tile = decode(
        &std::fs::read(golden("jacksboro_v3.spt")).unwrap(),
        &LevelLimits::default(),
    )
    .unwrap();
    assert!(arrays(&tile) == std::fs::read(golden("jacksboro_v3.arrays")).unwrap());
    assert_eq!(tile.partition.triangles.len(), 1671);
}

#[test]
fn a_tile_whose_holes_open_decodes_to_the_arrays_that_were_recorded() {
    let golden = |name: &str| std::fs::read(format!("{}/golden/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let bytes = golden("holes_v4.spt");
    assert_eq!(bytes[4], VERSION_WITH_HOLES);
    let tile = decode(&bytes, &LevelLimits::default()).unwrap();
    assert!(arrays(&tile) == golden("holes_v4.arrays"));
    let edges = |detail| terrain_core::mesh::boundary_edges(&tile.surface(detail).triangles).len();
    let [coarsest, finest] = [edges(tile.coarsest()), edges(tile.finest())];
    assert!(finest > 2 * coarsest, "{coarsest} edges of outlines, then {finest}");
    assert_same(
        &decode(&encode(&tile).unwrap(), &LevelLimits::default()).unwrap(),
        &tile,
    );
}

#[test]
fn edges_along_breaklines_come_back_whether_holes_open_or_not() {
    let holes = std::fs::read(format!("{}/golden/holes_v4.spt", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let with_holes = decode(&holes, &LevelLimits::default()).unwrap();
    for (tile, flags) in [(small_tile(), 0), (with_holes, OPENS_HOLES)] {
        let breaklines = vec![[[3, 40], [64, 0]], [[64, 0], [7, 7]]];
        let tile = Tile { breaklines, ..tile };
        let bytes = encode(&tile).unwrap();
        assert_eq!([bytes[4], bytes[24] & OPENS_HOLES], [VERSION_WITH_BREAKLINES, flags]);
        assert_same(&decode(&bytes, &LevelLimits::default()).unwrap(), &tile);
    }
    let outside = Tile {
        breaklines: vec![[[0, 0], [65, 0]]],
        ..small_tile()
    };
    let read = decode(&encode(&outside).unwrap(), &LevelLimits::default());
    assert_eq!(read.unwrap_err(), DecodeError::OutOfRange("an edge along a breakline"));
}

#[test]
fn the_header_and_the_directory_stand_where_the_specification_says() {
    let mut tile = small_tile();
    tile.lineage = Lineage {
        name: 0x0102_0304_0506_0708_090a_0b0c_0d0e_0f10,
        coarsest_measured: 1.5,
        outline_strayed: 0.25,
    };
    let bytes = encode(&tile).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(&bytes[..8], b"SPTL\x03\x03\x06\xfe");
    assert_eq!([8, 12, 16, 20].map(word), [5, 2, 0, 5]);
    assert_eq!(bytes[24], 0, "no samples");
    assert_eq!(bytes[25..41], (1..=16).collect::<Vec<u8>>(), "the name");
    assert_eq!([41, 45].map(word), [1.5_f32.to_bits(), 0.25_f32.to_bits()]);
    assert_eq!(bytes[49..52], [6, 3, 1], "six levels, the base is one triangle");
    assert_eq!(bytes[53], 14, "vertices of level 0");
    assert_eq!(bytes[54], 26, "15 triangles are 13 fewer than two a vertex");
    let tile = decode(&bytes, &LevelLimits::default()).unwrap();
    let vertices: Vec<u32> = tile.partition.levels.iter().map(|level| level.vertex_end).collect();
    assert_eq!(vertices, [14, 15, 16, 16, 16, 16]);
}

/// Area in plan of all triangles, in lattice units; none may be clockwise.
fn plan_area(mesh: &Mesh) -> f64 {
    let areas = mesh.triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        (b - a).cross(c - a).z / 2.0
    });
    areas.inspect(|&area| assert!(area > 0.0)).sum()
}

/// Height of a mesh over each vertex of another, as far as it is off.
fn largest_difference(coarse: &Mesh, fine: &Mesh) -> f64 {
    let height = |at: DVec3| {
        coarse.triangles.iter().find_map(|corners| {
            let corners = corners.map(|corner| coarse.positions[corner as usize]);
            let weights = [0, 1, 2].map(|k| {
                let [a, b] = [corners[(k + 1) % 3] - at, corners[(k + 2) % 3] - at];
                a.x * b.y - a.y * b.x
            });
            let area: f64 = weights.iter().sum();
            let weighted = weights.iter().zip(corners).map(|(weight, corner)| weight * corner.z);
            weights
                .iter()
                .all(|&weight| weight >= 0.0)
                .then(|| weighted.sum::<f64>() / area)
        })
    };
    let differences = fine.positions.iter().map(|&at| (height(at).unwrap() - at.z).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn the_first_tenth_of_a_tile_draws_its_whole_square() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/square_v3.spt");
    let bytes = std::fs::read(file).unwrap();
    let whole = decode(&bytes, &LevelLimits::default()).unwrap();
    let tenth = decode_prefix(&bytes[..bytes.len() / 10], &LevelLimits::default()).unwrap();
    partition::validate(&tenth.partition).unwrap();
    let (fine, coarse) = (whole.surface(whole.finest()), tenth.surface(tenth.finest()));
    terrain_core::mesh::validate(&coarse).unwrap();
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/square_v3_tenth.arrays");
    assert!(arrays(&tenth) == std::fs::read(golden).unwrap(), "as it was recorded");
    let square = f64::from(whole.extent_bits).exp2().powi(2);
    assert_eq!([plan_area(&fine), plan_area(&coarse)], [square; 2]);
    let relief = fine
        .positions
        .iter()
        .fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at.z), high.max(at.z)));
    let error = largest_difference(&coarse, &fine);
    assert!(
        error < (relief.1 - relief.0) / 2.0,
        "{error} m of {relief:?} by {} triangles",
        coarse.triangles.len()
    );
}

#[test]
fn a_prefix_of_any_length_is_a_surface_or_an_error() {
    let bytes = encode(&small_tile()).unwrap();
    let mut shown = 0;
    for length in 0..=bytes.len() {
        let Ok(tile) = decode_prefix(&bytes[..length], &LevelLimits::default()) else {
            continue;
        };
        terrain_core::mesh::validate(&tile.surface(tile.finest())).unwrap();
        assert!(tile.partition.triangles.len() >= shown, "{length} bytes");
        shown = tile.partition.triangles.len();
    }
    assert_eq!(shown, 18);
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = encode(&small_tile()).unwrap();
    for length in 0..bytes.len() {
        assert!(
            decode(&bytes[..length], &LevelLimits::default()).is_err(),
            "{length} of {} bytes",
            bytes.len()
        );
    }
}

/// What a whole decoder finds.
fn partition_of(bytes: &[u8]) -> Option<SurfacePartition> {
    Some(decode(bytes, &LevelLimits::default()).ok()?.partition)
}

#[test]
fn a_flipped_bit_anywhere_gives_a_tile_or_an_error_and_no_panic() {
    damage::hold_with_flipped_bits(&encode(&small_tile()).unwrap(), partition_of);
}

#[test]
fn more_than_the_limits_allow_is_refused() {
    let bytes = encode(&small_tile()).unwrap();
    let limits = LevelLimits {
        vertices: 15,
        ..LevelLimits::default()
    };
    assert_eq!(
        decode(&bytes, &limits),
        Err(DecodeError::Limit("the number of vertices"))
    );
}

#[test]
fn the_head_is_what_the_whole_tile_says() {
    let tile = small_tile();
    let bytes = encode(&tile).unwrap();
    let head = decode_head(&bytes[..bytes.len() - 1], &LevelLimits::default()).unwrap();
    assert_eq!(head.triangles, tile.surface(tile.finest()).triangles.len());
    assert_eq!(head.errors, [1.0, 2.0]);
    assert_eq!(head.outline_error, 0.5);
    assert_eq!(head.heights, [0.0, 1.25]);
    assert_eq!((head.address, head.lineage), (tile.address, tile.lineage));
}

#[test]
fn an_error_is_rounded_up_to_single_precision() {
    assert!(f64::from(rounded_up(0.1)) >= 0.1 && rounded_up(0.1) <= 0.100_000_01);
    assert_eq!(rounded_up(2.0), 2.0);
}

#[test]
fn sides_can_be_left_out_of_the_finest_interior_only() {
    let tile = small_tile();
    assert_eq!(tile.interior_levels(), 2);
    let without_west = tile.surface(crate::tile::Detail {
        interior: 1,
        fine_sides: [false, true, true, true],
    });
    assert_eq!(without_west.triangles.len(), 17);
    assert_eq!(tile.surface(tile.finest()).triangles.len(), 18);
    assert_eq!(tile.surface(tile.coarsest()).triangles.len(), 15);
    terrain_core::mesh::validate(&without_west).unwrap();
}

#[test]
fn damaged_seeds_of_the_fuzz_target_give_a_tile_or_an_error_and_no_panic() {
    let seeds = damage::seeds("spt");
    assert!(seeds.len() >= 2, "the corpus has a hand-made and a real tile");
    damage::hold_with_damaged_seeds(&seeds, partition_of);
}

/// A tile of many levels, with lines and filled ground in its header.
fn long_headed() -> Vec<u8> {
    let square = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/golden/square_v3.spt")).unwrap();
    let mut tile = decode(&square, &LevelLimits::default()).unwrap();
    tile.breaklines = vec![[[3, 40], [64, 0]]; 5];
    tile.filled.fill(glam::DVec2::splat(0.25), glam::DVec2::splat(0.5));
    encode(&tile).unwrap()
}

/// Bytes of a tile's first level.
fn first_length(bytes: &[u8]) -> usize {
    read_head(bytes, &LevelLimits::default()).unwrap().1[0].length
}

#[test]
fn a_tile_that_comes_in_pieces_is_decoded_on_to_the_same_as_a_whole_one() {
    let bytes = long_headed();
    let limits = LevelLimits::default();
    let start = TileDecoder::new(&bytes, &limits).unwrap();
    let (header, ends) = (start.ends().next().unwrap() - first_length(&bytes), start.ends());
    assert_eq!(start.ends().last(), Some(bytes.len()));
    let mut decoder = TileDecoder::new(&bytes[..header], &limits).unwrap();
    assert_eq!(
        decoder.tile().unwrap_err(),
        DecodeError::Damaged(progressive::Damaged(0))
    );
    for (level, end) in ends.enumerate() {
        // A byte short of the level, then it and the beginning of the next one.
        for end in [end - 1, (end + 5).min(bytes.len())] {
            let there = decoder.bytes_there();
            if let Some(piece) = bytes.get(there..end) {
                decoder.add(piece).unwrap();
            }
        }
        assert!(decoder.levels_there() > level);
        if decoder.levels_there() == level + 1 {
            assert_same(
                &decoder.tile().unwrap(),
                &decode_prefix(&bytes[..end], &limits).unwrap(),
            );
        }
    }
    assert!(decoder.is_whole());
    assert_same(&decoder.tile().unwrap(), &decode(&bytes, &limits).unwrap());
    let more = decoder.add(&[0]).unwrap_err();
    assert_eq!(
        more,
        DecodeError::OutOfRange("the number of bytes after the last level")
    );
}

#[test]
fn a_header_that_is_cut_anywhere_is_told_from_one_that_is_wrong() {
    let bytes = long_headed();
    let whole = TileDecoder::new(&bytes, &LevelLimits::default()).unwrap();
    let start = whole.ends().next().unwrap() - first_length(&bytes);
    for length in 0..start {
        let error = TileDecoder::new(&bytes[..length], &LevelLimits::default()).unwrap_err();
        assert_eq!(error, DecodeError::Truncated(length));
    }
    assert!(TileDecoder::new(&bytes[..start], &LevelLimits::default()).is_ok());
}
