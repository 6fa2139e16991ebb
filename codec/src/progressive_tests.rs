#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use terrain_core::levels::collapse_log::{Band, Collapse, CollapseLog};
use terrain_core::levels::view_refinement::ViewRefinement;
use terrain_core::mesh::Mesh;

/// A hilly square of `side`² vertices, and a log that collapses every other vertex of each row into the next, moving it midway.
pub(crate) fn hills(side: u32) -> SurfacePartition {
    let at = |x: u32, y: u32| {
        let height = ((x * 7919 + y * 104_729) % 97 + x * y) % 200;
        DVec3::new(f64::from(16 * x), f64::from(16 * y), f64::from(height))
    };
    let number = |x: u32, y: u32| y * side + x;
    let mut triangles = Vec::new();
    for (x, y) in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y))) {
        let [a, b, c, d] = [number(x, y), number(x + 1, y), number(x + 1, y + 1), number(x, y + 1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let mesh = Mesh {
        positions: (0..side * side).map(|v| at(v % side, v / side)).collect(),
        triangles,
    };
    let mut log = CollapseLog::default();
    for y in (2..side - 2).step_by(3) {
        for x in (2..side - 3).step_by(4) {
            let [red_before, blue_position] = [at(x + 1, y), at(x, y)];
            let red_after = ((red_before + blue_position) / 2.0).round();
            log.collapses.push(Collapse {
                blue: number(x, y),
                red: number(x + 1, y),
                red_before,
                red_after,
                closes_hole: false,
            });
        }
        log.bands.push(Band {
            end: log.collapses.len(),
            error: f64::from(y),
        });
    }
    SurfacePartition::from_log(&mesh, &log, 0.0).unwrap()
}

pub(crate) fn frame(partition: &SurfacePartition) -> Frame {
    let positions = partition.positions.iter().chain(&partition.blue_positions);
    Frame {
        bounds: [
            DVec3::ZERO,
            positions.fold(DVec3::ZERO, |high, &position| high.max(position)),
        ],
        is_height_field: true,
        sampling: None,
    }
}

/// A surface whose vertices and triangles are sorted, so that their order makes no difference.
fn sorted(mesh: &Mesh) -> Vec<[[i64; 3]; 3]> {
    let corner = |vertex: u32| mesh.positions[vertex as usize].as_i64vec3().to_array();
    let mut triangles: Vec<[[i64; 3]; 3]> = mesh.triangles.iter().map(|corners| corners.map(corner)).collect();
    for corners in &mut triangles {
        let least = (0..3).min_by_key(|&at| corners[at]).unwrap();
        corners.rotate_left(least);
    }
    triangles.sort_unstable();
    triangles
}

/// Asserts that two partitions draw the same at every level.
pub(crate) fn assert_same_levels(one: &SurfacePartition, other: &SurfacePartition) {
    assert_eq!(one.levels, other.levels);
    for level in 0..one.levels.len() {
        assert!(sorted(&one.lod(level)) == sorted(&other.lod(level)), "level {level}");
    }
}

/// Decodes levels, of which the last may be cut.
fn decode(start: Start, runs: &[Run], boundary_from: usize, frame: &Frame) -> Result<SurfacePartition, Damaged> {
    let mut decoder = LevelsDecoder::new(start, boundary_from, frame.clone());
    for run in runs {
        decoder.add(run)?;
    }
    decoder.into_partition()
}

fn decoded(coded: &Coded, partition: &SurfacePartition, frame: &Frame) -> Result<SurfacePartition, Damaged> {
    decode(coded.start, &runs(coded, partition), partition.levels.len(), frame)
}

fn runs<'a>(coded: &'a Coded, partition: &SurfacePartition) -> Vec<Run<'a>> {
    let run = |(bytes, &level): (&'a Vec<u8>, &Level)| Run {
        bytes,
        is_cut: false,
        level,
    };
    coded.levels.iter().zip(&partition.levels).map(run).collect()
}

#[test]
fn every_level_of_a_height_field_comes_back() {
    let partition = hills(30);
    let frame = frame(&partition);
    let coded = encode(&partition, partition.levels.len(), &frame).unwrap();
    let decoded = decoded(&coded, &partition, &frame).unwrap();
    assert_same_levels(&partition, &decoded);
    partition::validate(&decoded).unwrap();
    assert_eq!(coded.start.triangles, 1, "the square comes down to one triangle");
}

#[test]
fn every_level_comes_back_without_the_plan_view_of_a_height_field() {
    let partition = hills(30);
    let frame = Frame {
        is_height_field: false,
        ..frame(&partition)
    };
    let coded = encode(&partition, partition.levels.len(), &frame).unwrap();
    assert_same_levels(&partition, &decoded(&coded, &partition, &frame).unwrap());
}

#[test]
fn a_prefix_of_the_levels_is_a_partition() {
    let partition = hills(20);
    let frame = frame(&partition);
    let coded = encode(&partition, partition.levels.len(), &frame).unwrap();
    let prefix = decode(coded.start, &runs(&coded, &partition)[..3], 99, &frame).unwrap();
    partition::validate(&prefix).unwrap();
    assert!(sorted(&prefix.lod(2)) == sorted(&partition.lod(2)));
}

#[test]
fn a_position_off_the_lattice_is_refused() {
    let mut partition = hills(10);
    let frame = frame(&partition);
    partition.positions[3].x += 0.5;
    assert_eq!(
        encode(&partition, partition.levels.len(), &frame),
        Err(Uncodable::OffLattice(3))
    );
}

#[test]
fn a_level_cut_anywhere_is_a_surface_of_the_splits_that_are_there() {
    let partition = hills(20);
    let frame = frame(&partition);
    let coded = encode(&partition, partition.levels.len(), &frame).unwrap();
    let whole = runs(&coded, &partition)[0];
    let mut before = 0;
    for length in 60..whole.bytes.len() {
        let run = Run {
            bytes: &whole.bytes[..length],
            is_cut: true,
            ..whole
        };
        let cut = decode(coded.start, &[run], 99, &frame).unwrap();
        partition::validate(&cut).unwrap();
        let surface = cut.lod(0);
        terrain_core::mesh::validate(&surface).unwrap();
        assert!((before..=whole.level.triangle_end as usize).contains(&surface.triangles.len()));
        before = surface.triangles.len();
    }
    assert!(before > 9 * whole.level.triangle_end as usize / 10, "{before}");
}

/// A square with a hole of three vertices in every fourth cell of every fourth row. Each is closed by another one of the six collapses
/// that do.
fn pierced(side: u32) -> SurfacePartition {
    let at = |x: u32, y: u32| DVec3::new(f64::from(16 * x), f64::from(16 * y), f64::from((x * y) % 7));
    let number = |x: u32, y: u32| y * side + x;
    let mut mesh = Mesh {
        positions: (0..side * side).map(|v| at(v % side, v / side)).collect(),
        triangles: Vec::new(),
    };
    let mut holes = Vec::new();
    for (x, y) in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y))) {
        let [a, b, c, d] = [number(x, y), number(x + 1, y), number(x + 1, y + 1), number(x, y + 1)];
        let is_hole = x % 4 == 2 && y % 4 == 2 && x + 3 < side && y + 3 < side;
        mesh.triangles.push([a, c, d]);
        if is_hole {
            holes.push([a, b, c]);
        } else {
            mesh.triangles.push([a, b, c]);
        }
    }
    let ways = [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]];
    let mut log = CollapseLog::default();
    for (index, hole) in holes.iter().enumerate() {
        let [blue, red] = ways[index % ways.len()].map(|corner| hole[corner]);
        let red_before = mesh.positions[red as usize];
        log.collapses.push(Collapse {
            blue,
            red,
            red_before,
            red_after: red_before + DVec3::Z,
            closes_hole: true,
        });
    }
    let end = log.collapses.len();
    log.bands.push(Band { end, error: 1.0 });
    SurfacePartition::from_log(&mesh, &log, 0.0).unwrap()
}

#[test]
fn holes_that_open_from_level_to_level_come_back() {
    let partition = pierced(30);
    for is_height_field in [true, false] {
        let frame = Frame {
            is_height_field,
            ..frame(&partition)
        };
        let coded = encode(&partition, partition.levels.len(), &frame).unwrap();
        assert!(coded.start.opens_holes);
        assert_eq!(coded.start.triangles, 1, "the closed square comes down to one triangle");
        let decoded = decoded(&coded, &partition, &frame).unwrap();
        assert_same_levels(&partition, &decoded);
        let holes = |level: usize| {
            let mesh = decoded.lod(level);
            terrain_core::mesh::boundary_edges(&mesh.triangles).len() as u32 - 4 * 29
        };
        assert_eq!([0, 1].map(holes), [0, 3 * 49]);
        let surface = decoded.lod(1);
        terrain_core::mesh::validate(&surface).unwrap();
        let (_, log) = decoded.to_log();
        assert_eq!(log.collapses.iter().filter(|collapse| collapse.closes_hole).count(), 49);
        assert!(ViewRefinement::new(&decoded).is_ok(), "each opens its hole alone");
    }
}

#[test]
fn surfaces_whose_holes_stay_are_told_to_open_none() {
    let partition = hills(20);
    let coded = encode(&partition, partition.levels.len(), &frame(&partition)).unwrap();
    assert!(!coded.start.opens_holes);
}
