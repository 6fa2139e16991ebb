#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::levels::collapse_log::{Band, Collapse};
use crate::mesh;

/// Two rows of three vertices; the middle ones of both rows collapse to the left, in two bands.
fn strip() -> (Mesh, CollapseLog) {
    let positions = (0..6)
        .map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3), f64::from(i * i)))
        .collect();
    let mesh = Mesh {
        positions,
        triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
    };
    let lifted = mesh.positions[3] + DVec3::Z;
    let keep = |blue, red: u32| Collapse {
        blue,
        red,
        red_before: mesh.positions[red as usize],
        red_after: mesh.positions[red as usize],
        closes_hole: false,
    };
    let collapses = vec![
        keep(1, 0),
        Collapse {
            red_after: lifted,
            ..keep(4, 3)
        },
    ];
    let bands = vec![Band { end: 1, error: 2.0 }, Band { end: 2, error: 5.0 }];
    (mesh, CollapseLog { collapses, bands })
}

#[test]
fn levels_of_a_strip_are_its_bands_coarsest_first() {
    let (mesh, log) = strip();
    let partition = SurfacePartition::from_log(&mesh, &log, 0.5).unwrap();
    validate(&partition).unwrap();
    let ends: Vec<_> = partition
        .levels
        .iter()
        .map(|l| (l.vertex_end, l.triangle_end, l.error))
        .collect();
    assert_eq!(ends, [(4, 2, 5.0), (5, 3, 2.0), (6, 4, 0.5)]);
    assert_eq!(partition.representatives, [0, 1, 2, 3, 2, 0]);
}

#[test]
fn a_moved_red_vertex_is_given_back_by_the_level_that_undoes_the_collapse() {
    let (mesh, log) = strip();
    let partition = SurfacePartition::from_log(&mesh, &log, 0.5).unwrap();
    assert_eq!(partition.lod(0).positions[2].z, 10.0);
    assert_eq!(partition.lod(1).positions[2].z, 9.0);
    for level in 0..3 {
        mesh::validate(&partition.lod(level)).unwrap();
    }
}

#[test]
fn the_finest_level_is_the_mesh_itself() {
    let (mesh, log) = strip();
    let finest = SurfacePartition::from_log(&mesh, &log, 0.5).unwrap().lod(2);
    assert_eq!(drawn(&finest), drawn(&mesh));
}

#[test]
fn a_log_that_uses_a_removed_vertex_is_refused_with_its_index() {
    let (mesh, mut log) = strip();
    log.collapses[1].red = 1;
    log.collapses[1].red_before = mesh.positions[1];
    assert_eq!(
        SurfacePartition::from_log(&mesh, &log, 0.0),
        Err(LogError::Removed(1, 1))
    );
}

/// A closed surface of `36` vertices and twice as many triangles: a torus of six squares by six.
fn torus() -> Mesh {
    let at = |row: u32, column: u32| 6 * (row % 6) + column % 6;
    let squares = (0..6).flat_map(|row| (0..6).map(move |column| (row, column)));
    let halves = |(row, column)| {
        let [a, b] = [at(row, column), at(row, column + 1)];
        let [c, d] = [at(row + 1, column + 1), at(row + 1, column)];
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        positions: vec![DVec3::ZERO; 36],
        triangles: squares.flat_map(halves).collect(),
    }
}

#[test]
fn a_closed_surface_takes_less_than_forty_bytes_a_vertex_where_the_mesh_takes_thirty_six() {
    let mesh = torus();
    let listed = [[0, 1], [14, 15], [28, 29]].map(|[blue, red]| ListedCollapse {
        blue,
        red,
        moved_to: None,
    });
    let log = to_log(&listed, &mesh.positions, 1.0).unwrap();
    let replay = Replay::run(&mesh, &log, Demand::Consistent, |_| ()).unwrap();
    let partition = SurfacePartition::from_replay(&mesh, &replay, &replay.level_batches(&log, 0.0)).unwrap();
    let expected = Storage {
        mesh: 36 * 36,
        representatives: 3 * 4,
        blue_positions: 3 * 12,
        blue_positions_whole: 36 * 12,
    };
    assert_eq!(partition.storage(), expected);
    assert!(expected.mesh + expected.representatives < 40 * 36);
}

#[test]
fn batches_begin_with_level_one_and_grow_to_the_highest() {
    let (mesh, log) = strip();
    let replay = Replay::run(&mesh, &log, Demand::Consistent, |_| ()).unwrap();
    assert_eq!(replay.top_level, 3);
    let merged = |first_levels: &[u32]| {
        let batch = |&first_level: &u32| Batch {
            first_level,
            error: 0.0,
        };
        let batches: Vec<Batch> = first_levels.iter().map(batch).collect();
        SurfacePartition::from_replay(&mesh, &replay, &batches).map(|partition| partition.levels.len())
    };
    assert_eq!(merged(&[1, 3]), Ok(2));
    assert_eq!(merged(&[]), Err(PartitionError::BadBatch(0)));
    assert_eq!(merged(&[2, 3]), Err(PartitionError::BadBatch(0)));
    assert_eq!(merged(&[1, 3, 2]), Err(PartitionError::BadBatch(2)));
    assert_eq!(merged(&[1, 4]), Err(PartitionError::BadBatch(1)));
}

/// Triangles as corner positions, each from its smallest corner on, sorted.
fn drawn(mesh: &Mesh) -> Vec<[[i64; 3]; 3]> {
    let corner = |v: u32| mesh.positions[v as usize].to_array().map(|c| (c * 1e6).round() as i64);
    rotated_and_sorted(mesh.triangles.iter().map(|t| t.map(corner)).collect())
}

fn rotated_and_sorted<T: Ord + Copy>(mut triangles: Vec<[T; 3]>) -> Vec<[T; 3]> {
    for triangle in &mut triangles {
        let smallest = (0..3).min_by_key(|&i| triangle[i]).unwrap();
        triangle.rotate_left(smallest);
    }
    triangles.sort_unstable();
    triangles
}
