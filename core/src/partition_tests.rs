#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::path::PathBuf;

use serde_json::Value;

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

fn vector_files() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/vectors");
    let Ok(entries) = folder.read_dir() else {
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.file_name().unwrap().to_string_lossy().contains("partition_"));
    files.retain(|path| !path.to_string_lossy().contains("multilevel"));
    files.sort();
    files
}

fn position(value: &Value) -> DVec3 {
    let coordinates: Vec<f64> = value.as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
    DVec3::from_slice(&coordinates)
}

fn triangles(value: &Value) -> Vec<[u32; 3]> {
    serde_json::from_value(value.clone()).unwrap()
}

/// The vector's own collapses as a log of one band for each level, so that every level can be drawn.
fn log_of(vector: &Value, positions: &[DVec3]) -> CollapseLog {
    let mut current = positions.to_vec();
    let collapses = vector["collapses"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
        .map(|(index, pair)| {
            let [blue, red]: [u32; 2] = serde_json::from_value(pair.clone()).unwrap();
            let red_before = current[red as usize];
            let moved = vector["moved"].get(index.to_string());
            let red_after = moved.map_or(red_before, position);
            current[red as usize] = red_after;
            Collapse {
                blue,
                red,
                red_before,
                red_after,
            }
        });
    let collapses: Vec<Collapse> = collapses.collect();
    let end = collapses.len();
    CollapseLog {
        collapses,
        bands: vec![Band { end, error: 0.0 }],
    }
}

#[test]
fn levels_and_surfaces_agree_with_an_independent_reference() {
    let files = vector_files();
    if files.is_empty() {
        println!("skipped: no reference vectors beside the project");
    }
    for file in files {
        let vector: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let expected = &vector["expected"];
        let positions: Vec<DVec3> = vector["positions"].as_array().unwrap().iter().map(position).collect();
        let mesh = Mesh {
            positions,
            triangles: triangles(&vector["triangles"]),
        };
        let log = log_of(&vector, &mesh.positions);
        let replay = Replay::run(&mesh, &log);
        let level_list = |key: &str| serde_json::from_value::<Vec<u32>>(expected[key].clone()).unwrap();
        assert_eq!(replay.vertex_levels, level_list("vertex_level"), "{}", file.display());
        assert_eq!(
            replay.triangle_levels,
            level_list("triangle_level"),
            "{}",
            file.display()
        );
        assert_eq!(
            replay.representatives,
            level_list("representative"),
            "{}",
            file.display()
        );
        let partition = SurfacePartition::from_log(&mesh, &log, 0.0).unwrap();
        validate(&partition).unwrap();
        let order: Vec<u32> = serde_json::from_value(expected["sorted"]["vertex_order"].clone()).unwrap();
        let coarsest = expected["levels"].as_u64().unwrap().to_string();
        for (level, key) in [(0, coarsest.as_str()), (1, "1")] {
            let own = partition.lod(level);
            let in_original_ids = own.triangles.iter().map(|t| t.map(|v| order[v as usize])).collect();
            let reference = rotated_and_sorted(triangles(&expected["lods"][key]));
            assert_eq!(
                rotated_and_sorted(in_original_ids),
                reference,
                "{} level {key}",
                file.display()
            );
        }
    }
}
