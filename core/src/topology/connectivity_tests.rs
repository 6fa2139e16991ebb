use glam::DVec3;

use super::*;
use crate::mesh::tests::three_by_three;

fn star_of(mesh: &Mesh, blue: u32, red: u32) -> EdgeStar {
    let mut star = EdgeStar::default();
    star.gather(&Connectivity::new(mesh), blue, red);
    star
}

fn link_condition(triangles: &[[u32; 3]], blue: u32, red: u32) -> Result<(), LinkFault> {
    let mesh = Mesh {
        positions: vec![DVec3::ZERO; 9],
        triangles: triangles.to_vec(),
    };
    star_of(&mesh, blue, red).link_condition()
}

fn sorted(indices: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut sorted: Vec<u32> = indices.into_iter().collect();
    sorted.sort_unstable();
    sorted
}

#[test]
fn the_star_of_an_edge_has_all_neighbours_of_both_ends_once() {
    let star = star_of(&three_by_three(), 1, 4);
    assert_eq!(sorted(star.vertices().iter().copied()), [0, 1, 2, 3, 4, 5, 7, 8]);
    assert_eq!(sorted(star.removed().iter().copied()), [0, 3]);
    let at_the_boundary = star_of(&three_by_three(), 2, 5);
    assert_eq!(sorted(at_the_boundary.vertices().iter().copied()), [1, 2, 4, 5, 8]);
    assert_eq!(at_the_boundary.removed(), [2]);
}

#[test]
fn a_collapse_hands_the_blue_corners_to_the_red_vertex() {
    let mesh = three_by_three();
    let mut connectivity = Connectivity::new(&mesh);
    let mut moved = Vec::new();
    connectivity.collapse(&star_of(&mesh, 4, 0), &mut moved);
    assert_eq!(sorted(moved.iter().map(|corner| corner / 3)), [3, 4, 6, 7]);
    assert_eq!(connectivity.star(4).count(), 0);
    assert_eq!(sorted(connectivity.star(0)), [3, 4, 6, 7]);
    assert_eq!(connectivity.corners(6), [0, 5, 8]);
    assert_eq!(sorted(connectivity.star(1)), [2, 3]);
    assert_eq!(connectivity.across(6, 0, 8), Some(7));
    assert_eq!(connectivity.across(6, 5, 8), None);
}

#[test]
fn gathering_again_forgets_the_edge_before() {
    let mesh = three_by_three();
    let connectivity = Connectivity::new(&mesh);
    let mut star = star_of(&mesh, 1, 4);
    star.gather(&connectivity, 2, 5);
    assert_eq!(sorted(star.vertices().iter().copied()), [1, 2, 4, 5, 8]);
    assert_eq!(star.link_condition(), Ok(()));
}

#[test]
fn the_link_condition_names_what_stands_against_a_collapse() {
    let grid = three_by_three().triangles;
    assert_eq!(link_condition(&grid, 4, 0), Ok(()));
    assert_eq!(link_condition(&grid, 0, 1), Ok(()));
    assert_eq!(link_condition(&grid, 0, 8), Err(LinkFault::NoEdge));
    assert_eq!(link_condition(&grid, 1, 5), Err(LinkFault::JoinsBoundary));
    assert_eq!(link_condition(&[[0, 1, 2]], 0, 1), Err(LinkFault::Last));
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    assert_eq!(link_condition(&tetrahedron, 0, 1), Err(LinkFault::Last));
    let book = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    assert_eq!(link_condition(&book, 0, 1), Err(LinkFault::TooManyTriangles));
    let around_a_hole = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    assert_eq!(link_condition(&around_a_hole, 0, 1), Err(LinkFault::CommonNeighbour));
}

#[test]
fn a_collapse_may_close_a_hole_of_three_vertices_and_no_other() {
    let closing = |triangles: &[[u32; 3]], blue, red| {
        let mesh = Mesh {
            positions: vec![DVec3::ZERO; 9],
            triangles: triangles.to_vec(),
        };
        star_of(&mesh, blue, red).closing_condition(&Connectivity::new(&mesh))
    };
    let around_a_hole = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    assert_eq!(closing(&around_a_hole, 0, 1), Ok(()));
    assert_eq!(
        closing(&around_a_hole, 0, 4),
        Err(LinkFault::NotAHole),
        "across to the other outline"
    );
    let grid = three_by_three().triangles;
    assert_eq!(
        closing(&grid, 0, 1),
        Err(LinkFault::NotAHole),
        "eight vertices are around it"
    );
    assert_eq!(
        closing(&[[0, 1, 2]], 0, 1),
        Err(LinkFault::CommonNeighbour),
        "beside a lone triangle"
    );
    let fan = [[0, 1, 3], [1, 2, 3], [2, 0, 3]];
    assert_eq!(
        closing(&fan, 0, 1),
        Err(LinkFault::Last),
        "nothing but a flat remainder"
    );
}
