#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

#[test]
fn extremes_are_those_of_all_parts_however_they_are_cut() {
    let heights = [5.0, f32::NAN, -9999.0, 3.0, -9999.0, 3.0, 8.0, f32::NAN, -9999.0];
    let all = Extremes {
        lowest: -9999.0,
        lowest_count: 3,
        second_lowest: Some(3.0),
        highest: 8.0,
    };
    assert_eq!(Extremes::of(&heights), Some(all));
    for cut in 1..heights.len() {
        let (first, last) = heights.split_at(cut);
        let parts = [first, last].into_iter().filter_map(Extremes::of);
        assert_eq!(parts.reduce(Extremes::with).unwrap(), all, "cut at {cut}");
    }
    assert_eq!(Extremes::of(&[f32::NAN]), None);
    assert_eq!(Extremes::of(&[2.0, 2.0]).unwrap().second_lowest, None);
}
