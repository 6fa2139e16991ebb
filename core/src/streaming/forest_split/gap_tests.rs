#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

#[test]
fn a_polygon_is_the_walk_read_backwards_from_the_same_start() {
    assert_eq!(polygon(&[0, 1, 2, 3]), [0, 3, 2, 1]);
    assert!(polygon::<u32>(&[]).is_empty());
}

#[test]
fn a_fill_tells_its_triangles_root_first_left_before_right() {
    let both = [[true, true], [false, false], [false, true], [false, false]];
    assert_eq!(
        fill_triangles(6, &both).unwrap(),
        [[0, 2, 5], [0, 1, 2], [2, 3, 5], [3, 4, 5]]
    );
}

#[test]
fn a_fill_that_is_no_tree_or_of_another_size_is_refused() {
    assert_eq!(fill_triangles(4, &[[false, false], [false, false]]), None);
    assert_eq!(fill_triangles(4, &[[true, true], [false, false]]), None);
    assert_eq!(fill_triangles(5, &[[true, false], [false, false]]), None);
    assert_eq!(fill_triangles(1, &[]), None);
}

#[test]
fn a_fill_is_found_again_from_its_triangles() {
    for fill in [
        vec![[true, false], [false, true], [false, false]],
        vec![[true, true], [false, false], [false, false]],
        vec![[false, true], [true, false], [false, false]],
    ] {
        let triangles = fill_triangles(5, &fill).unwrap();
        let apex = |first, last| {
            let found = triangles
                .iter()
                .find(|corners| corners[0] == first && corners[2] == last);
            found.map(|corners| corners[1])
        };
        assert_eq!(find_fill(5, apex), Some(fill));
    }
    assert_eq!(find_fill(5, |_, _| None), None);
    assert_eq!(find_fill(5, |first, _| Some(first)), None);
}

#[test]
fn a_walk_has_a_corner_for_each_side_of_each_edge() {
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let surface = ClosedSurface::new(4, &tetrahedron).unwrap();
    let mut is_marked = vec![false; surface.half_edge_count()];
    for half_edge in 0..surface.half_edge_count() as u32 {
        let ends = [surface.origin(half_edge), surface.target(half_edge)];
        is_marked[half_edge as usize] = ends.contains(&1) && !ends.contains(&3);
    }
    let gaps = gaps(&surface, &is_marked);
    let visited: Vec<Vec<u32>> = gaps
        .iter()
        .map(|gap| gap.iter().map(|corner| corner.vertex).collect())
        .collect();
    assert_eq!(visited, [[0, 1, 2, 1]]);
    let sectors: Vec<usize> = gaps[0].iter().map(|corner| corner.sector.len()).collect();
    assert_eq!(sectors, [3, 2, 3, 1], "of all ten corners but the one at 3, none twice");
}
