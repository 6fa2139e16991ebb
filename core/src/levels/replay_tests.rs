#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::topology::connectivity::LinkFault;
use crate::topology::manifold::ManifoldError;

fn log(mesh: &Mesh, pairs: &[[u32; 2]]) -> CollapseLog {
    let listed = |&[blue, red]: &[u32; 2]| ListedCollapse {
        blue,
        red,
        moved_to: None,
    };
    let list: Vec<ListedCollapse> = pairs.iter().map(listed).collect();
    to_log(&list, &mesh.positions, 3.0).unwrap()
}

fn mesh(vertex_count: usize, triangles: &[[u32; 3]]) -> Mesh {
    Mesh {
        positions: vec![DVec3::ZERO; vertex_count],
        triangles: triangles.to_vec(),
    }
}

/// Two rows of four vertices.
fn strip() -> Mesh {
    mesh(8, &[[0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6]])
}

fn replayed(mesh: &Mesh, log: &CollapseLog, demand: Demand) -> Result<Replay, LogError> {
    Replay::run(mesh, log, demand, |_| ())
}

#[test]
fn stars_that_touch_are_of_different_levels() {
    let mesh = strip();
    let replay = replayed(&mesh, &log(&mesh, &[[0, 1], [3, 2], [4, 5]]), Demand::Consistent).unwrap();
    assert_eq!(replay.collapse_levels, [1, 2, 2]);
    assert_eq!(replay.top_level, 3);
    assert_eq!(replay.vertex_levels, [1, 3, 3, 2, 2, 3, 3, 3]);
    assert_eq!(replay.triangle_levels, [1, 2, 3, 3, 2, 3]);
    assert_eq!(replay.vertex_order(), [1, 2, 5, 6, 7, 3, 4, 0]);
    assert_eq!(replay.counts_from(&replay.vertex_levels), [8, 8, 7, 5, 0]);
}

#[test]
fn a_band_raises_the_floor_of_the_next() {
    let mesh = strip();
    let mut log = log(&mesh, &[[0, 1], [7, 3]]);
    log.bands.insert(0, crate::Band { end: 1, error: 1.0 });
    let replay = replayed(&mesh, &log, Demand::Consistent).unwrap();
    assert_eq!(replay.collapse_levels, [1, 2]);
    let batches = |batches: Vec<Batch>| batches.iter().map(|b| (b.first_level, b.error)).collect::<Vec<_>>();
    assert_eq!(batches(replay.band_batches(&log, 0.5)), [(1, 0.5), (2, 1.0), (3, 3.0)]);
    assert_eq!(batches(replay.level_batches(&log, 0.5)), [(1, 0.5), (2, 1.0), (3, 3.0)]);
}

#[test]
fn a_level_inside_a_band_has_the_error_of_the_band() {
    let mesh = strip();
    let log = log(&mesh, &[[0, 1], [4, 5], [1, 2]]);
    let replay = replayed(&mesh, &log, Demand::Consistent).unwrap();
    assert_eq!(replay.collapse_levels, [1, 2, 3]);
    let errors: Vec<f64> = replay.level_batches(&log, 0.5).iter().map(|b| b.error).collect();
    assert_eq!(errors, [0.5, 3.0, 3.0, 3.0]);
}

#[test]
fn a_removed_triangle_is_represented_by_the_one_behind_the_blue_side() {
    let mesh = strip();
    let representatives = |pair| {
        let replay = replayed(&mesh, &log(&mesh, &[pair]), Demand::Consistent).unwrap();
        replay.triangle_representatives
    };
    assert_eq!(representatives([0, 1])[0], Some(1));
    assert_eq!(representatives([1, 0])[0], Some(3));
    assert_eq!(
        representatives([4, 0])[1],
        Some(0),
        "at the boundary, the one behind the red side"
    );
    assert_eq!(representatives([1, 0])[3], Some(3));
}

#[test]
fn a_collapse_that_fails_the_link_condition_is_refused_with_index_and_reason() {
    let mesh = strip();
    let refused = replayed(&mesh, &log(&mesh, &[[0, 4], [1, 6]]), Demand::Consistent).unwrap_err();
    let fault = LinkFault::JoinsBoundary;
    assert_eq!(
        refused,
        LogError::Invalid {
            index: 1,
            blue: 1,
            red: 6,
            fault
        }
    );
    assert_eq!(
        refused.to_string(),
        "collapse 1, 1 → 6: an interior edge between two vertices of the boundary"
    );
    assert!(replayed(&mesh, &log(&mesh, &[[0, 4], [1, 6]]), Demand::Drawable).is_ok());
}

#[test]
fn a_surface_that_is_no_manifold_can_be_drawn_but_is_not_called_consistent() {
    let bowtie = mesh(7, &[[0, 1, 2], [0, 5, 1], [2, 3, 4], [3, 6, 4]]);
    let log = log(&bowtie, &[[5, 0], [0, 1], [2, 3]]);
    let fault = ManifoldError::Vertex(2);
    assert_eq!(
        replayed(&bowtie, &log, Demand::Consistent),
        Err(LogError::NotManifold(fault))
    );
    let drawn = replayed(&bowtie, &log, Demand::Drawable).unwrap();
    assert_eq!(drawn.collapse_levels, [1, 2, 1]);
    let beyond = mesh(2, &[[0, 1, 2]]);
    let fault = ManifoldError::BadTriangle(0);
    assert_eq!(
        replayed(&beyond, &CollapseLog::default(), Demand::Drawable),
        Err(LogError::NotManifold(fault))
    );
}
