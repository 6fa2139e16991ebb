#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use crate::mesh::Mesh;

/// A flat grid of 5 × 5 vertices, its squares cut from the lower left to the upper right.
fn grid() -> CurvedModel {
    let positions = (0..25)
        .map(|index| DVec3::new(f64::from(index % 5), f64::from(index / 5), 0.0))
        .collect();
    let square = |corner: u32| [[corner, corner + 1, corner + 6], [corner, corner + 6, corner + 5]];
    let triangles: Vec<_> = (0..20).filter(|corner| corner % 5 < 4).flat_map(square).collect();
    let normals = vec![[DVec3::Z; 3]; triangles.len()];
    CurvedModel::from_mesh(&Mesh { positions, triangles }, &normals).unwrap()
}

#[test]
fn opposite_edges_are_pairs_and_neighbours_are_not() {
    let model = grid();
    let mut ends: Vec<[u32; 2]> = model.mergeable_pairs(12, 1e-6).iter().map(|pair| pair.ends).collect();
    ends.iter_mut().for_each(|pair| pair.sort_unstable());
    ends.sort_unstable();
    assert_eq!(ends, [[6, 18], [7, 17], [11, 13]]);
    // On the boundary, straight on: three faces. At corners there are one or two, but the boundary turns.
    assert_eq!(model.mergeable_pairs(2, 1e-6).len(), 1);
    assert!(model.mergeable_pairs(0, 1e-6).is_empty());
    assert!(model.mergeable_pairs(4, 3.0).is_empty(), "one face is not enough");
}

#[test]
fn a_crease_is_kept_straight_on() {
    let mut model = grid();
    for edge in 0..model.is_crease.len() as u32 {
        let [from, to] = [model.topology.origin(edge), model.topology.end(edge)];
        model.is_crease[edge as usize] = from / 5 == 2 && to / 5 == 2;
    }
    let pairs = model.mergeable_pairs(12, 1e-6);
    assert_eq!(pairs.len(), 1);
    assert_eq!(
        (
            pairs[0].ends[0] + pairs[0].ends[1],
            pairs[0].ends[0].abs_diff(pairs[0].ends[1])
        ),
        (24, 2)
    );
}

#[test]
fn sides_of_three_faces_match_two_patterns_and_more() {
    let model = grid();
    let patterns = model.patterns(12, 1e-6);
    let along: Vec<&Pattern> = patterns.iter().filter(|pattern| pattern.side == [13, 11]).collect();
    // Above 11–13 are 18 and 17: either is between two in line, and beyond both there is 23.
    let kinds: Vec<_> = along.iter().map(|pattern| (pattern.kind, pattern.corners[2])).collect();
    assert_eq!(kinds, [(PatternKind::TriangleInTriangle, 23)], "{patterns:?}");
}
