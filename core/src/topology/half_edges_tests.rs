#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

/// 3 × 3 vertices, numbered row by row, each cell cut from its first to its last corner.
fn grid() -> HalfEdges {
    let cell = |a: u32| [[a, a + 1, a + 4], [a, a + 4, a + 3]];
    let triangles: Vec<[u32; 3]> = [0, 1, 3, 4].into_iter().flat_map(cell).collect();
    HalfEdges::new(9, triangles)
}

fn around(connectivity: &HalfEdges, vertex: u32) -> Vec<u32> {
    let mut ring = Vec::new();
    connectivity.ring(vertex, &mut ring);
    ring
}

/// Every invariant: twins are mutual and run against each other, and a walk around a vertex sees all its triangles.
fn check(connectivity: &HalfEdges) {
    let mut stars = vec![0; connectivity.leaving.len()];
    for triangle in 0..connectivity.triangle_slots() {
        let Some(corners) = connectivity.corners(triangle) else {
            continue;
        };
        corners.iter().for_each(|&corner| stars[corner as usize] += 1);
        for edge in 3 * triangle..3 * triangle + 3 {
            let twin = connectivity.twin(edge);
            if twin != NONE {
                assert_eq!(connectivity.twin(twin), edge);
                assert_eq!(connectivity.origin(twin), connectivity.end(edge));
                assert_eq!(connectivity.end(twin), connectivity.origin(edge));
            }
        }
    }
    for vertex in 0..connectivity.leaving.len() as u32 {
        let walked = if connectivity.is_live(vertex) {
            connectivity.leaving(vertex).count()
        } else {
            0
        };
        assert_eq!(walked, stars[vertex as usize], "vertex {vertex}");
        assert!(
            connectivity
                .leaving(vertex)
                .take(walked)
                .all(|edge| connectivity.origin(edge) == vertex)
        );
    }
}

#[test]
fn walks_go_counter_clockwise_and_along_the_boundary_from_end_to_end() {
    let connectivity = grid();
    check(&connectivity);
    assert_eq!(around(&connectivity, 0), [1, 4, 3]);
    assert_eq!(around(&connectivity, 8), [7, 4, 5]);
    let inner = around(&connectivity, 4);
    let first = inner.iter().position(|&vertex| vertex == 0).unwrap();
    let turned: Vec<u32> = (0..6).map(|index| inner[(first + index) % 6]).collect();
    assert_eq!(turned, [0, 1, 5, 8, 7, 3]);
    assert!(connectivity.is_boundary(3) && !connectivity.is_boundary(4));
    assert_eq!(connectivity.boundary().count(), 8);
}

#[test]
fn edits_keep_every_invariant() {
    let mut connectivity = grid();
    let inside = connectivity.split_triangle(0);
    check(&connectivity);
    assert_eq!(around(&connectivity, inside).len(), 3);
    let edge = connectivity.edge_between(4, 8).unwrap();
    let between = connectivity.split_edge(edge);
    check(&connectivity);
    assert_eq!(around(&connectivity, between).len(), 4);
    let (from, to) = connectivity.boundary().next().unwrap();
    let outer = connectivity.split_edge(connectivity.edge_between(from, to).unwrap());
    check(&connectivity);
    assert!(connectivity.is_boundary(outer) && around(&connectivity, outer).len() == 3);
    let edge = connectivity.edge_between(4, between).unwrap();
    let (a, b) = (connectivity.apex(edge), connectivity.apex(connectivity.twin(edge)));
    connectivity.flip(edge);
    check(&connectivity);
    assert!(connectivity.edge_between(a, b).is_some() && connectivity.edge_between(4, between).is_none());
}

#[test]
fn collapses_keep_every_invariant_inside_and_along_the_boundary_in_both_directions() {
    for (blue, red, left) in [
        (4, 1, 6),
        (4, 8, 6),
        (1, 0, 7),
        (1, 2, 7),
        (5, 2, 7),
        (7, 8, 7),
        (3, 0, 7),
    ] {
        let mut connectivity = grid();
        connectivity.collapse(blue, red);
        check(&connectivity);
        assert!(!connectivity.is_live(blue));
        let triangles = (0..connectivity.triangle_slots()).filter_map(|triangle| connectivity.corners(triangle));
        assert_eq!(triangles.clone().count(), left, "{blue} into {red}");
        assert!(triangles.flatten().all(|corner| corner != blue));
    }
}

/// A triangle around a triangle: 0, 1 and 2 are around the hole.
fn around_a_hole() -> HalfEdges {
    let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    HalfEdges::new(6, triangles)
}

#[test]
fn a_hole_of_three_vertices_is_closed_along_any_edge_in_both_directions() {
    for [blue, red, third] in [[0, 1, 2], [1, 0, 2], [1, 2, 0], [2, 1, 0], [2, 0, 1], [0, 2, 1]] {
        let mut connectivity = around_a_hole();
        assert_eq!(connectivity.third_of_hole(blue, red), Some(third));
        connectivity.close_hole(blue, red, third);
        check(&connectivity);
        assert!(!connectivity.is_live(blue));
        assert!(!connectivity.is_boundary(red) && !connectivity.is_boundary(third));
        assert_eq!(around(&connectivity, red).len(), 4);
        assert_eq!(around(&connectivity, third).len(), 3);
        assert_eq!(connectivity.boundary().count(), 3, "the outer outline");
    }
}

#[test]
fn only_a_hole_of_three_vertices_has_a_third() {
    let grid = grid();
    assert_eq!(grid.third_of_hole(0, 1), None);
    assert_eq!(grid.third_of_hole(4, 0), None);
}
