#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

/// A square whose centre 4 collapses into corner 0, and before that 5, beside the centre, into the centre:
///
/// ```text
///  3 ─────── 2
///  │ ╲     ╱ │
///  │   4─5   │      4 → 0 makes the square of two triangles
///  │ ╱     ╲ │
///  0 ─────── 1
/// ```
pub(super) fn batches() -> [LevelBatch<2>; 3] {
    [
        LevelBatch {
            positions: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
            triangles: vec![[1, 2, 5], [2, 3, 4]],
            representatives: vec![(5, 4), (4, 0)],
        },
        LevelBatch {
            positions: vec![[2.0, 2.0]],
            triangles: vec![[0, 1, 4], [3, 0, 4]],
            representatives: vec![],
        },
        LevelBatch {
            positions: vec![[3.0, 2.0]],
            triangles: vec![[4, 1, 5], [2, 4, 5]],
            representatives: vec![],
        },
    ]
}

pub(super) fn square() -> MultilevelMesh<2> {
    let mut mesh = MultilevelMesh::default();
    batches().into_iter().for_each(|batch| mesh.add_level(batch).unwrap());
    mesh
}

fn refused(batch: LevelBatch<2>) -> LevelError {
    let mut mesh = MultilevelMesh::default();
    let [first, ..] = batches();
    mesh.add_level(first).unwrap();
    let before = mesh.clone();
    let error = mesh.add_level(batch).unwrap_err();
    assert_eq!(mesh, before, "a refused level leaves nothing behind");
    error
}

#[test]
fn levels_are_numbered_from_the_finest_that_has_arrived() {
    let mut mesh = MultilevelMesh::default();
    let mut counts = Vec::new();
    for batch in batches() {
        mesh.add_level(batch).unwrap();
        let end = mesh.end(0).unwrap();
        counts.push((end.vertices, end.triangles));
    }
    assert_eq!(counts, [(4, 2), (5, 4), (6, 6)]);
    assert_eq!(mesh.end(2).unwrap().vertices, 4);
    assert_eq!(mesh.end(3), None);
}

#[test]
fn a_corner_that_nothing_represents_is_refused_with_its_triangle() {
    let batch = LevelBatch {
        triangles: vec![[0, 1, 2], [0, 1, 6]],
        ..LevelBatch::default()
    };
    let (part, fault) = (LevelPart::Triangle(1), LevelFault::Unrepresented(6));
    assert_eq!(refused(batch), LevelError { part, fault });
}

#[test]
fn a_chain_of_representatives_must_reach_a_vertex_that_is_there() {
    let batch = LevelBatch {
        triangles: vec![[0, 1, 8]],
        representatives: vec![(8, 7)],
        ..LevelBatch::default()
    };
    assert_eq!(refused(batch).fault, LevelFault::Unrepresented(7));
}

#[test]
fn a_second_or_later_representative_is_refused() {
    let with = |representatives| LevelBatch {
        representatives,
        ..LevelBatch::default()
    };
    assert_eq!(refused(with(vec![(7, 1), (4, 1)])).part, LevelPart::Representative(1));
    assert_eq!(refused(with(vec![(4, 1)])).fault, LevelFault::Repeated(4));
    let not_before = LevelFault::NotBefore {
        vertex: 6,
        representative: 6,
    };
    assert_eq!(refused(with(vec![(6, 6)])).fault, not_before);
}

#[test]
fn degenerate_triangles_and_numbers_that_are_none_are_refused() {
    let triangles = vec![[2, 1, 1]];
    let degenerate = LevelBatch {
        triangles,
        ..LevelBatch::default()
    };
    assert_eq!(refused(degenerate).fault, LevelFault::Degenerate(1));
    let positions = vec![[0.0, f64::NAN]];
    let nowhere = LevelBatch {
        positions,
        ..LevelBatch::default()
    };
    assert_eq!(refused(nowhere).part, LevelPart::Position(0));
}

#[test]
fn limits_hold_for_vertices_triangles_levels_and_vertices_yet_to_come() {
    let refusal = |limits: MultilevelLimits| {
        let mut mesh = MultilevelMesh::<2>::new(limits);
        batches()
            .into_iter()
            .find_map(|batch| mesh.add_level(batch).err())
            .map(|error| error.fault)
    };
    let all = MultilevelLimits {
        vertices: 6,
        triangles: 6,
        levels: 3,
    };
    assert_eq!(refusal(all), None);
    assert_eq!(
        refusal(MultilevelLimits { vertices: 5, ..all }),
        Some(LevelFault::TooManyVertices(5))
    );
    assert_eq!(
        refusal(MultilevelLimits { triangles: 5, ..all }),
        Some(LevelFault::TooManyTriangles(5))
    );
    assert_eq!(
        refusal(MultilevelLimits { levels: 2, ..all }),
        Some(LevelFault::TooManyLevels(2))
    );
}

#[test]
fn a_mesh_is_complete_when_every_vertex_in_use_has_come() {
    let mut mesh = MultilevelMesh::default();
    let completeness = batches().map(|batch| {
        mesh.add_level(batch).unwrap();
        mesh.check_complete()
    });
    let missing = |count| Err(LevelFault::NeverGiven { vertex: 5, count });
    assert_eq!(completeness, [missing(4), missing(5), Ok(())]);
}

#[test]
fn only_representatives_that_a_level_draws_with_are_needed() {
    let mut mesh = MultilevelMesh::default();
    let [mut coarse, mut middle, mut fine] = batches();
    coarse.triangles = vec![[1, 2, 4], [2, 3, 4]];
    coarse.representatives = vec![(4, 0)];
    middle.representatives = vec![(5, 4)];
    fine.triangles = vec![[4, 1, 5], [2, 4, 5]];
    for batch in [coarse, middle, fine] {
        mesh.add_level(batch).unwrap();
    }
    let before: Vec<_> = mesh.representatives().collect();
    mesh.keep_needed_representatives();
    let after: Vec<_> = mesh.representatives().collect();
    assert_eq!((before, after), (vec![(4, 0), (5, 4)], vec![(4, 0)]));
}
