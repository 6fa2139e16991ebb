use super::*;

#[test]
fn heights_are_bilinear_and_go_on_for_half_a_cell() {
    let stored = [0.0, 10.0, 20.0, 30.0];
    let place = |x: f64, y: f64| DVec2::new(x, y);
    let places = [
        place(0.5, 0.5),
        place(1.0, 0.25),
        place(-0.5, 0.0),
        place(1.4, 1.4),
        place(-0.6, 0.0),
        place(0.0, 1.51),
    ];
    let heights = bilinear(&places, [2, 2], [&(0..2), &(0..2)], &stored);
    assert_eq!(heights[..4], [15.0, 15.0, 0.0, 30.0]);
    assert!(heights[4..].iter().all(|height| height.is_nan()));
}

#[test]
fn a_void_counts_where_it_has_a_share_only() {
    let stored = [1.0, f64::NAN, 2.0, f64::NAN];
    let places = [DVec2::new(0.0, 0.5), DVec2::new(1e-9, 0.0), DVec2::new(0.1, 0.0)];
    let heights = bilinear(&places, [2, 2], [&(0..2), &(0..2)], &stored);
    assert!(
        heights[0] == 1.5 && heights[1] == 1.0 && heights[2].is_nan(),
        "{heights:?}"
    );
}

#[test]
fn what_is_needed_is_what_heights_are_made_from() {
    let places = [DVec2::new(2.5, 3.0), DVec2::new(4.0, 3.5), DVec2::new(90.0, 90.0)];
    assert_eq!(needed(&places, [10, 10]), Some([2..6, 3..5]));
    assert_eq!(needed(&places[2..], [10, 10]), None);
}
