use super::*;

const EXTENT: i64 = 64;

#[test]
fn a_line_across_a_side_goes_straight_through_both_strips() {
    let edges = out_of_strips([[20, 10], [-20, 30]], EXTENT);
    assert_eq!(
        edges,
        [
            [[20, 10], [4, 18]],
            [[4, 18], [0, 18]],
            [[0, 18], [0, 22]],
            [[0, 22], [-4, 22]],
            [[-4, 22], [-20, 30]]
        ]
    );
    assert_eq!(stops(&edges, 0, 0), [18, 22]);
}

#[test]
fn a_line_along_a_side_is_on_it_and_stops_at_its_ends_only() {
    let steps = [[[1, 20], [-2, 30]], [[-2, 30], [2, 41]]];
    let edges: Vec<[Place; 2]> = steps.iter().flat_map(|&step| out_of_strips(step, EXTENT)).collect();
    assert_eq!(edges, [[[0, 20], [0, 30]], [[0, 30], [0, 41]]]);
    assert_eq!(stops(&edges, 0, 0), [20, 41]);
}

#[test]
fn a_line_over_a_corner_leaves_no_place_in_a_strip() {
    for (x, y) in (-9..=9).flat_map(|x| (-9..=9).map(move |y| (x, y))) {
        let edges = out_of_strips([[x, y], [17, 23]], EXTENT);
        for &[from, to] in &edges {
            for end in [from, to] {
                assert!(
                    end.iter().all(|c| c.rem_euclid(EXTENT) == 0 || c.abs() >= STRIP),
                    "{x}, {y}: {end:?}"
                );
            }
            let is_straight = from[0] == to[0] || from[1] == to[1];
            let is_inside = [from, to].iter().all(|end| end.iter().all(|&c| c >= STRIP))
                || [from, to].iter().all(|end| end[0] <= -STRIP && end[1] >= STRIP)
                || [from, to].iter().all(|end| end[1] <= -STRIP && end[0] >= STRIP)
                || [from, to].iter().all(|end| end.iter().all(|&c| c <= -STRIP));
            assert!(is_straight || is_inside, "{x}, {y}: {from:?} {to:?}");
        }
    }
}
