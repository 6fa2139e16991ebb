use super::*;

const VIRTUAL: u32 = 20;

fn collapse(blue: u32, red: u32, x: u32, y: u32) -> Candidate {
    let wings = [x, y];
    Candidate { blue, red, wings }
}

/// A forest of the tree 1–2–3, after the collapse 0 → 2.
fn forest() -> Forest {
    let mut forest = Forest::new(VIRTUAL);
    forest.add(collapse(0, 2, 1, 3));
    forest
}

#[test]
fn a_collapse_far_from_all_trees_is_a_new_one() {
    let mut forest = forest();
    assert!(forest.admits(collapse(4, 5, 6, 7)));
    forest.add(collapse(4, 5, 6, 7));
    assert_eq!(forest.marks().0, [[1, 2], [2, 3], [5, 6], [5, 7]]);
}

#[test]
fn a_tree_grows_by_a_marked_edge_but_not_between_the_wings() {
    for admitted in [
        collapse(1, 2, 8, 9),
        collapse(8, 2, 1, 9),
        collapse(2, 8, 9, 3),
        collapse(3, 9, 8, 2),
    ] {
        assert!(forest().admits(admitted), "{admitted:?}");
    }
    for refused in [
        collapse(8, 9, 1, 2),
        collapse(1, 3, 8, 9),
        collapse(8, 1, 3, 9),
        collapse(8, 2, 9, 10),
    ] {
        assert!(!forest().admits(refused), "{refused:?}");
    }
}

#[test]
fn two_trees_become_one_across_the_collapsed_edge() {
    let mut forest = forest();
    forest.add(collapse(4, 5, 6, 7));
    assert!(forest.admits(collapse(1, 5, 6, 2)), "1–2 and 5–6");
    assert!(forest.admits(collapse(1, 5, 2, 7)), "the wings exchanged");
    assert!(!forest.admits(collapse(1, 2, 5, 6)), "the wings are joined");
    assert!(!forest.admits(collapse(1, 3, 2, 2)), "one tree alone");
    assert!(
        !forest.admits(collapse(1, 5, 3, 6)),
        "1 and 3 are in one tree, but not joined"
    );
    forest.add(collapse(1, 5, 6, 2));
    assert_eq!(forest.marks().0, [[2, 3], [2, 5], [5, 6], [5, 7]]);
}

#[test]
fn blue_hands_its_marks_to_red() {
    let mut forest = forest();
    forest.add(collapse(2, 8, 9, 3));
    assert_eq!(forest.marks().0, [[1, 8], [3, 8], [8, 9]]);
}

#[test]
fn the_virtual_vertex_is_a_leaf_of_any_number_of_trees() {
    let mut forest = Forest::new(VIRTUAL);
    forest.add(collapse(0, 1, 2, VIRTUAL));
    let beside = collapse(3, 4, 5, VIRTUAL);
    assert!(forest.admits(beside));
    forest.add(beside);
    assert_eq!(forest.marks(), (vec![[1, 2], [4, 5]], vec![1, 4]));
    assert!(!forest.admits(collapse(1, 4, 6, VIRTUAL)), "both ends are open");
    assert!(
        forest.admits(collapse(6, 1, 7, VIRTUAL)),
        "grows by the edge to the virtual vertex"
    );
    assert!(
        !forest.admits(collapse(6, 1, 2, VIRTUAL)),
        "1–2 and that edge are of one tree"
    );
}

#[test]
fn an_opened_vertex_that_collapses_opens_the_other() {
    let mut forest = Forest::new(VIRTUAL);
    forest.add(collapse(0, 1, 2, VIRTUAL));
    forest.add(collapse(1, 3, 2, 4));
    assert_eq!(forest.marks(), (vec![[2, 3], [3, 4]], vec![3]));
}
