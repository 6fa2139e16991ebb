#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::collapse_log::{Band, Collapse};
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
