#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::super::clustered_mesh;
use super::*;
use crate::streaming::multilevel::LevelView;

#[test]
fn cells_start_at_the_smallest_coordinates_and_double() {
    let positions = [[10.0], [10.9], [11.0], [13.0], [14.5]];
    let clusterings = grid_clusterings(&positions, 1.0, 3).unwrap();
    let mappings: Vec<_> = clusterings
        .iter()
        .map(|clustering| clustering.mapping.as_slice())
        .collect();
    assert_eq!(mappings, [&[0, 0, 1, 2, 3][..], &[0, 0, 1, 2], &[0, 0, 1]]);
}

#[test]
fn a_cells_vertex_is_the_mean_of_all_that_it_has_taken_in() {
    let positions = [[0.0, 0.0], [0.0, 1.5], [3.0, 3.0], [100.0, 0.0]];
    // The first two are one from the beginning and count twice afterwards.
    let clusterings = grid_clusterings(&positions, 2.0, 2).unwrap();
    assert_eq!(clusterings[1].positions, [[1.0, 1.5], [100.0, 0.0]]);
}

#[test]
fn any_mesh_becomes_multilevel_and_coarser_level_by_level() {
    let size = 9_u32;
    let positions: Vec<_> = (0..size * size)
        .map(|i| [f64::from(i % size), f64::from(i / size), f64::from(i * i % 7)])
        .collect();
    let cells = (0..size * size - size).filter(|i| i % size < size - 1);
    let triangles: Vec<_> = cells
        .flat_map(|i| [[i, i + 1, i + size], [i + 1, i + size + 1, i + size]])
        .collect();
    let clusterings = grid_clusterings(&positions, 2.0, 3).unwrap();
    let mesh = clustered_mesh(&positions, &triangles, &clusterings).unwrap().mesh;
    let counts: Vec<_> = (0..4).map(|level| mesh.end(level).unwrap().vertices).collect();
    assert_eq!(counts[0], 81);
    assert!(counts.windows(2).all(|pair| pair[1] < pair[0]), "{counts:?}");
    let mut view = LevelView::default();
    for level in 0..4 {
        view.set_level(&mesh, level).unwrap();
        let degenerate = view.triangles().iter().filter(|[a, b, c]| a == b || b == c || c == a);
        assert_eq!(degenerate.count(), 0, "level {level}");
    }
}

#[test]
fn cells_without_size_and_vertices_out_of_reach_are_refused() {
    assert_eq!(grid_clusterings(&[[0.0]], 0.0, 1), Err(GridError::BadCell(0.0)));
    assert!(grid_clusterings(&[[0.0]], f64::NAN, 1).is_err());
    assert_eq!(
        grid_clusterings(&[[0.0], [1e30]], 1.0, 1),
        Err(GridError::OutOfReach(1))
    );
    assert_eq!(
        grid_clusterings(&[[0.0], [f64::NAN]], 1.0, 1),
        Err(GridError::OutOfReach(1))
    );
}
