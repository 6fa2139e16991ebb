#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::streaming::multilevel::{LevelView, MultilevelLimits, to_ascii};

/// Two squares of two triangles each that share nothing but the vertex 4 in their middle: no manifold.
///
/// ```text
///        5 ── 6
///  2 ──  4 ── 3'     2, 3 to the left, 5, 6 to the right of 4
/// ```
const POSITIONS: [[f64; 2]; 7] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [3.0, 1.0],
    [1.0, 1.0],
    [1.0, 2.0],
    [3.0, 2.0],
];
const TRIANGLES: [[u32; 3]; 4] = [[0, 1, 4], [0, 4, 2], [4, 3, 6], [4, 6, 5]];

fn step(positions: &[[f64; 2]], mapping: &[u32]) -> Clustering<2> {
    Clustering {
        positions: positions.to_vec(),
        mapping: mapping.to_vec(),
    }
}

/// 1, 4 and 5 become one vertex, then 0 and 2.
fn steps() -> [Clustering<2>; 2] {
    let first = step(
        &[[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [3.0, 1.0], [3.0, 2.0]],
        &[0, 1, 2, 3, 1, 1, 4],
    );
    let second = step(&[[0.0, 0.75], [1.0, 1.0], [3.0, 1.0], [3.0, 2.0]], &[0, 1, 0, 2, 3]);
    [first, second]
}

#[test]
fn the_ancestor_nearest_to_the_cluster_stays() {
    let clustered = clustered_mesh(&POSITIONS, &TRIANGLES, &steps()).unwrap();
    assert_eq!(clustered.vertex_order, [2, 3, 4, 6, 0, 1, 5]);
    let representatives: Vec<_> = clustered.mesh.representatives().collect();
    assert_eq!(representatives, [(4, 0), (5, 2), (6, 2)]);
}

#[test]
fn a_triangle_has_the_level_of_the_clustering_that_makes_it_degenerate() {
    let clustered = clustered_mesh(&POSITIONS, &TRIANGLES, &steps()).unwrap();
    assert_eq!(clustered.triangle_order, [2, 1, 0, 3]);
    let counts: Vec<_> = (0..3)
        .map(|level| clustered.mesh.end(level).unwrap().triangles)
        .collect();
    assert_eq!(counts, [4, 2, 1]);
}

#[test]
fn every_level_is_the_clustered_mesh_at_the_ancestors() {
    let clustered = clustered_mesh(&POSITIONS, &TRIANGLES, &steps()).unwrap();
    let mut view = LevelView::default();
    view.set_level(&clustered.mesh, 1).unwrap();
    let original = |vertex: u32| clustered.vertex_order[vertex as usize];
    let triangles: Vec<_> = view.triangles().iter().map(|corners| corners.map(original)).collect();
    assert_eq!(triangles, [[4, 3, 6], [0, 4, 2]]);
    view.set_level(&clustered.mesh, 2).unwrap();
    assert_eq!(view.positions(), [[0.0, 1.0], [3.0, 1.0], [1.0, 1.0], [3.0, 2.0]]);
}

#[test]
fn equally_near_ancestors_leave_the_first_of_them() {
    let all_in_one = step(&[[1.0, 0.5]], &[0, 0, 0]);
    let clustered = clustered_mesh(&[[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]], &[[0, 1, 2]], &[all_in_one]).unwrap();
    assert_eq!(clustered.vertex_order, [0, 1, 2]);
    assert_eq!(clustered.mesh.end(1).unwrap().triangles, 0);
}

#[test]
fn nearness_is_that_of_the_mesh_before_not_of_the_one_that_was_given() {
    let positions = [0.0, 1.0, 2.0, 3.0].map(|x| [x, x * x]);
    let first = step(&[[0.9, 0.9], positions[2], positions[3]], &[0, 0, 1, 2]);
    let second = step(&[[1.0, 1.5], positions[3]], &[0, 0, 1]);
    let clustered = clustered_mesh(&positions, &[[0, 2, 3], [1, 2, 3]], &[first, second]).unwrap();
    // 1 stands for the first two, which are then nearer to what they become than 2 is.
    assert_eq!(clustered.vertex_order, [1, 3, 2, 0]);
}

#[test]
fn triangles_that_come_to_lie_on_each_other_stay() {
    let folded = step(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], &[0, 1, 2, 2]);
    let positions = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 2.0]];
    let clustered = clustered_mesh(&positions, &[[0, 1, 2], [0, 1, 3]], &[folded]).unwrap();
    let mut view = LevelView::default();
    view.set_level(&clustered.mesh, 1).unwrap();
    assert_eq!(view.triangles(), [[0, 1, 2], [0, 1, 2]]);
}

#[test]
fn what_is_written_of_a_clustered_mesh_draws_the_same_levels() {
    let mut clustered = clustered_mesh(&POSITIONS, &TRIANGLES, &steps()).unwrap();
    let read = MultilevelMesh::<2>::from_ascii(&to_ascii(&clustered.mesh), MultilevelLimits::default()).unwrap();
    let (mut whole, mut needed) = (LevelView::default(), LevelView::default());
    for level in 0..3 {
        whole.set_level(&clustered.mesh, level).unwrap();
        needed.set_level(&read, level).unwrap();
        assert_eq!(
            (whole.triangles(), whole.positions()),
            (needed.triangles(), needed.positions())
        );
    }
    clustered.mesh.keep_needed_representatives();
    let needed: Vec<_> = clustered.mesh.representatives().collect();
    assert_eq!(read.representatives().collect::<Vec<_>>(), needed);
}

#[test]
fn clusterings_that_do_not_fit_are_refused() {
    let refusal = |clustering| clustered_mesh(&POSITIONS, &TRIANGLES, &[clustering]).unwrap_err();
    let short = ClusteringError::MappingLength {
        clustering: 0,
        mapped: 2,
        count: 7,
    };
    assert_eq!(refusal(step(&[[0.0, 0.0]], &[0, 0])), short);
    let out = ClusteringError::MappingRange {
        clustering: 0,
        vertex: 3,
    };
    assert_eq!(refusal(step(&[[0.0, 0.0]], &[0, 0, 0, 1, 0, 0, 0])), out);
    let empty = ClusteringError::Empty {
        clustering: 0,
        vertex: 1,
    };
    assert_eq!(refusal(step(&[[0.0, 0.0]; 2], &[0; 7])), empty);
}

#[test]
fn a_mesh_with_a_corner_out_of_range_is_refused() {
    let refusal = clustered_mesh(&POSITIONS, &[[0, 1, 7]], &[]);
    assert!(matches!(refusal, Err(ClusteringError::Mesh(_))), "{refusal:?}");
}
