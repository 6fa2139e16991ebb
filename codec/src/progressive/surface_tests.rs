use super::super::ring::are_possible;
use super::*;

/// A square of four triangles around vertex 4.
fn square() -> GrowingSurface {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0]];
    let vertex = |[x, y]: [f64; 2]| Vertex::new(DVec3::new(x, y, 0.0), Fit::Free);
    GrowingSurface::new(
        corners.map(vertex).to_vec(),
        &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    )
}

fn walk(surface: &GrowingSurface, vertex: u32) -> Ring {
    let mut ring = Ring::default();
    surface.walk(vertex, &mut ring);
    ring
}

fn split(surface: &mut GrowingSurface, red: u32, side: Side, [first, second]: [u32; 2]) {
    let ring = walk(surface, red);
    let place = |neighbour| {
        ring.spokes
            .iter()
            .position(|spoke| spoke.vertex == neighbour)
            .unwrap_or(0)
    };
    let cuts = Cuts {
        side,
        first: place(first),
        second: place(second),
    };
    assert!(are_possible(cuts, &ring), "{cuts:?} in {:?}", ring.spokes);
    surface.split(red, &ring, cuts, Vertex::new(DVec3::ZERO, Fit::Free));
    for vertex in 0..surface.vertices.len() as u32 {
        let ring = walk(surface, vertex);
        let known = surface.vertices[vertex as usize];
        assert_eq!(known.valence as usize, ring.spokes.len(), "neighbours of {vertex}");
        assert_eq!(known.is_closed, ring.is_closed(), "around {vertex}");
    }
}

/// Neighbours of a vertex, counter-clockwise, those of an inner vertex from the smallest on.
fn around(surface: &GrowingSurface, vertex: u32) -> Vec<u32> {
    let ring = walk(surface, vertex);
    let mut vertices: Vec<u32> = ring.spokes.iter().map(|spoke| spoke.vertex).collect();
    if ring.is_closed() {
        let smallest = vertices.iter().min().copied();
        let start = vertices.iter().position(|&v| Some(v) == smallest).unwrap_or(0);
        vertices.rotate_left(start);
    }
    vertices
}

#[test]
fn a_walk_on_the_boundary_begins_at_its_first_edge() {
    let surface = square();
    assert_eq!(around(&surface, 0), [1, 4, 3]);
    assert_eq!(around(&surface, 4), [0, 1, 2, 3]);
}

#[test]
fn an_inner_vertex_takes_what_is_between_the_cuts() {
    let mut surface = square();
    split(&mut surface, 4, Side::Inner, [3, 1]);
    assert_eq!(around(&surface, 5), [0, 1, 4, 3]);
    assert_eq!(around(&surface, 4), [1, 2, 3, 5]);
    assert_eq!(around(&surface, 3), [0, 5, 4, 2]);
    assert_eq!(surface.triangles().skip(4).collect::<Vec<_>>(), [[4, 3, 5], [4, 5, 1]]);
}

#[test]
fn the_boundary_gets_a_vertex_before_or_after() {
    let mut surface = square();
    split(&mut surface, 0, Side::Front, [0, 4]);
    assert_eq!(around(&surface, 5), [1, 4, 0]);
    assert_eq!(around(&surface, 0), [5, 4, 3]);
    split(&mut surface, 0, Side::Back, [3, 0]);
    assert_eq!(around(&surface, 6), [0, 3]);
    assert_eq!(around(&surface, 0), [5, 4, 3, 6]);
    assert_eq!(around(&surface, 3), [6, 0, 4, 2]);
}

#[test]
fn a_vertex_of_the_boundary_moves_inside() {
    let mut surface = square();
    split(&mut surface, 0, Side::Outer, [1, 3]);
    assert_eq!(around(&surface, 5), [1, 0, 3]);
    assert_eq!(around(&surface, 0), [1, 4, 3, 5].to_vec());
    assert!(walk(&surface, 0).is_closed());
}

#[test]
fn cuts_must_leave_each_its_triangles() {
    let surface = square();
    let [inner, open] = [4, 0].map(|vertex| walk(&surface, vertex));
    let cuts = |side, first, second| Cuts { side, first, second };
    assert!(!are_possible(cuts(Side::Inner, 1, 1), &inner), "nothing for blue");
    assert!(
        are_possible(cuts(Side::Inner, 2, 1), &inner),
        "around the start of the walk"
    );
    assert!(!are_possible(cuts(Side::Inner, 2, 1), &open));
    assert!(!are_possible(cuts(Side::Inner, 0, 4), &inner), "no such neighbour");
    assert!(!are_possible(cuts(Side::Front, 0, 1), &inner));
}

#[test]
fn an_edge_of_three_triangles_stays_open() {
    let vertices = vec![Vertex::new(DVec3::ZERO, Fit::Free); 5];
    let surface = GrowingSurface::new(vertices, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    assert_eq!(around(&surface, 2).len(), 2);
    assert!(!walk(&surface, 0).is_closed());
}

#[test]
fn a_star_opens_into_a_hole_at_either_cut() {
    for (side, cuts, triangle, of_red, of_blue) in [
        (Side::HoleFirst, [5, 2], [4, 6, 2], [6, 2, 3, 5], [5, 1, 2, 4]),
        (Side::HoleSecond, [2, 5], [4, 2, 6], [5, 1, 2, 6], [4, 2, 3, 5]),
    ] {
        let mut surface = square();
        split(&mut surface, 4, Side::Inner, [3, 1]);
        assert_eq!(around(&surface, 4), [1, 2, 3, 5]);
        split(&mut surface, 4, side, cuts);
        assert_eq!(surface.triangles().skip(6).collect::<Vec<_>>(), [triangle]);
        assert_eq!(around(&surface, 4), of_red);
        assert_eq!(around(&surface, 6), of_blue);
        assert!(walk(&surface, 5).is_open);
    }
}

#[test]
fn a_hole_does_not_touch_another_outline() {
    let surface = square();
    let ring = walk(&surface, 4);
    let cuts = |side| Cuts {
        side,
        first: 0,
        second: 2,
    };
    assert!(surface.can_split(&ring, cuts(Side::Inner)));
    assert!(!surface.can_split(&ring, cuts(Side::HoleFirst)));
    assert!(
        !surface.can_split(&walk(&surface, 0), cuts(Side::HoleSecond)),
        "red is on the boundary"
    );
}
