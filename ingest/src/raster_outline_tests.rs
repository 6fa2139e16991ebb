use super::*;

#[test]
fn a_crossing_is_the_same_from_both_ends_and_from_every_origin() {
    for (from, to) in [([-3, 10], [4, 271]), ([-7, -5], [1, -6]), ([2, 0], [-2, 1])] {
        let found = crossing([from, to], 0, 0);
        assert!(found.is_some());
        assert_eq!(found, crossing([to, from], 0, 0));
        let moved = |p: [i64; 2]| [p[0] + 1000, p[1] - 77_777];
        let elsewhere = crossing([moved(from), moved(to)], 0, 1000);
        assert_eq!(elsewhere.map(|along| along + 77_777), found);
    }
    assert_eq!(crossing([[-3, 0], [4, 7]], 0, 0), Some(3));
    assert_eq!(crossing([[0, 0], [4, 7]], 0, 0), None);
}

#[test]
fn no_node_of_the_outline_stays_in_a_strip() {
    let kept: Vec<i64> = (-6..=6).map(|coordinate| out_of_strip(coordinate, 64)).collect();
    assert_eq!(kept, [-6, -5, -4, 0, 0, 0, 0, 0, 0, 0, 4, 5, 6]);
}

#[test]
fn the_nearest_step_across_tells_on_which_side_of_it_a_point_is() {
    // The surface is the square (10, 0) … (20, 10), counter-clockwise.
    let square = [
        [[10, 0], [20, 0]],
        [[20, 0], [20, 10]],
        [[20, 10], [10, 10]],
        [[10, 10], [10, 0]],
    ];
    assert_eq!(is_bounded(&square, 5.5, true, 100.0), Some(false));
    assert_eq!(is_bounded(&square, 11.5, true, 100.0), None);
    assert_eq!(is_bounded(&square, 5.5, false, 100.0), None);
    assert_eq!(is_bounded(&square, 5.5, true, 9.0), None);
    let around = square.map(|ends| ends.map(|[across, along]| [across - 15, along]));
    assert_eq!(
        [true, false].map(|positive| is_bounded(&around, 5.5, positive, 100.0)),
        [Some(true); 2]
    );
}
