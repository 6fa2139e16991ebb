use super::*;

/// A graph with rows of constraints, and the chains of collapses into one red vertex.
fn dag(rows: &[&[u32]], earlier_into_red: &[Option<u32>]) -> CollapseDag {
    let mut constraints = CompressedRows::default();
    rows.iter().for_each(|row| constraints.push(row.iter().copied()));
    CollapseDag {
        split_constraints: constraints.transposed(),
        constraints,
        earlier_into_red: earlier_into_red.iter().map(|earlier| earlier.unwrap_or(NONE)).collect(),
    }
}

fn rows(rows: &CompressedRows) -> Vec<Vec<u32>> {
    rows.rows().map(<[u32]>::to_vec).collect()
}

#[test]
fn all_influences_follow_the_chains_into_a_red_vertex() {
    let dag = dag(&[&[], &[0], &[1], &[1, 2]], &[None, Some(0), None, Some(2)]);
    let all = dag.all_influences();
    assert_eq!(rows(&all), [vec![], vec![0], vec![0, 1], vec![0, 1, 2]]);
    assert_eq!(rows(&all.transposed()), [vec![1, 2, 3], vec![2, 3], vec![3], vec![]]);
}

#[test]
fn the_reduction_leaves_out_what_others_imply() {
    let dag = dag(&[&[], &[], &[0], &[0, 1, 2], &[0, 1, 3]], &[None; 5]);
    assert_eq!(
        rows(&dag.transitive_reduction()),
        [vec![], vec![], vec![0], vec![1, 2], vec![3]]
    );
}

#[test]
fn monotone_errors_are_the_largest_of_what_is_needed() {
    let dag = dag(&[&[], &[0], &[], &[1, 2]], &[None; 4]);
    assert_eq!(dag.monotone_errors(&[3.0, 1.0, 4.0, 2.0]), [3.0, 3.0, 4.0, 4.0]);
}

#[test]
fn a_closed_set_holds_what_its_members_need() {
    let dag = dag(&[&[], &[0], &[1]], &[None; 3]);
    assert!(dag.is_closed(|_| false));
    assert!(dag.is_closed(|collapse| collapse < 2));
    assert!(!dag.is_closed(|collapse| collapse != 0));
    assert!(!dag.is_closed(|collapse| collapse != 1));
}
