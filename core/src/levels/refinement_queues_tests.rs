#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::mesh::tests::three_by_three;

/// Two collapses, of which the second rests on the first.
fn two_collapses() -> AdaptiveSurface {
    let mesh = three_by_three();
    let collapse = |blue| ListedCollapse {
        blue,
        red: 0,
        moved_to: None,
    };
    let log = to_log(&[collapse(1), collapse(3)], &mesh.positions, 1.0).unwrap();
    AdaptiveSurface::new(&mesh, &log).unwrap()
}

fn update(surface: &mut AdaptiveSurface, errors: &[f64], maximum: f64) -> (usize, usize) {
    let error = |collapse: u32| errors[collapse as usize];
    let mut queues = RefinementQueues::new(surface, error);
    let changes = queues.update(surface, maximum, error);
    (changes.splits, changes.collapses)
}

#[test]
fn a_small_error_on_top_keeps_a_large_one_collapsed_unless_errors_are_monotone() {
    let mut surface = two_collapses();
    let errors = [10.0, 1.0];
    assert_eq!(update(&mut surface, &errors, 5.0), (0, 0));
    let monotone = surface.dag().monotone_errors(&errors);
    assert_eq!(update(&mut surface, &monotone, 5.0), (2, 0));
}

#[test]
fn an_error_of_just_the_maximum_changes_nothing() {
    let mut surface = two_collapses();
    assert_eq!(update(&mut surface, &[5.0, 5.0], 5.0), (0, 0));
    assert_eq!(update(&mut surface, &[4.0, 6.0], 5.0), (1, 0));
    assert_eq!(update(&mut surface, &[4.0, 5.0], 5.0), (0, 0));
    assert_eq!(update(&mut surface, &[4.0, 4.0], 5.0), (0, 1));
}

#[test]
fn an_error_that_is_no_number_splits() {
    let mut surface = two_collapses();
    assert_eq!(update(&mut surface, &[0.0, f64::NAN], 5.0), (1, 0));
}

#[test]
fn entries_keep_their_errors_until_the_refill() {
    let mut surface = two_collapses();
    let mut queues = RefinementQueues::new(&surface, |_| 1.0);
    assert_eq!(queues.update(&mut surface, 2.0, |_| 9.0).splits, 0);
    assert_eq!(queues.refill(&surface, |_| 9.0), 1);
    assert_eq!(queues.update(&mut surface, 2.0, |_| 9.0).splits, 2);
    assert_eq!(queues.update(&mut surface, 20.0, |_| 9.0).collapses, 2);
}

#[test]
fn an_entry_that_was_made_again_counts_by_its_latest_error() {
    let mut surface = two_collapses();
    let mut queues = RefinementQueues::new(&surface, |_| 9.0);
    let error_below = |below: f64| move |collapse: u32| [below, 9.0][collapse as usize];
    assert_eq!(queues.update(&mut surface, 5.0, error_below(1.0)).splits, 1);
    assert_eq!(queues.update(&mut surface, 20.0, error_below(1.0)).collapses, 1);
    assert_eq!(queues.update(&mut surface, 5.0, error_below(0.2)).splits, 1);
    assert_eq!(queues.update(&mut surface, 0.5, error_below(0.2)).splits, 0);
}
