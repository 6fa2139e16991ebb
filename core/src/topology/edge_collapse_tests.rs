#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::{Edge, HalfEdges};

/// Whether the link condition lets `blue` collapse into `red`.
fn link_allows(triangles: Vec<[u32; 3]>, blue: u32, red: u32) -> bool {
    let connectivity = HalfEdges::new(6, triangles);
    let (mut around_blue, mut around_red) = (Vec::new(), Vec::new());
    connectivity.ring(blue, &mut around_blue);
    connectivity.ring(red, &mut around_red);
    let index = around_blue.iter().position(|&vertex| vertex == red).unwrap();
    let edge = Edge::new(&connectivity, blue, &around_blue, index);
    super::link_allows(&connectivity, edge, &around_blue, &around_red)
}

#[test]
fn collapses_that_would_tear_or_fold_the_surface_are_refused() {
    let strip = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
    assert!(link_allows(strip.clone(), 1, 0), "along the boundary");
    assert!(
        !link_allows(strip, 1, 4),
        "across the strip: both ends are on the boundary, the edge is not"
    );
    let fan = vec![[0, 1, 3], [1, 2, 3], [2, 0, 3]];
    assert!(
        !link_allows(fan.clone(), 0, 1),
        "vertex 2 is next to both without a triangle between the three"
    );
    assert!(link_allows(fan, 3, 0), "the middle may go");
    assert!(!link_allows(vec![[0, 1, 2]], 0, 1), "the last triangle stays");
}
