use super::*;

fn voids(values: &[f64], scale: f64) -> Vec<(f64, u64)> {
    let mut ends = Ends::default();
    values.iter().for_each(|&value| ends.add(value));
    ends.voids(scale).iter().map(|void| (void.value, void.count)).collect()
}

#[test]
fn a_usual_sign_far_from_all_heights_is_a_void() {
    assert_eq!(voids(&[100.0, -9999.0, 900.0, -9999.0], 1.0), [(-9999.0, 2)]);
    assert_eq!(voids(&[100.0, 65_535.0, 900.0, f64::NAN], 1.0), [(65_535.0, 1)]);
    assert_eq!(
        voids(&[100.0, 900.0, f64::from(f32::MIN), f64::from(f32::MAX)], 1.0).len(),
        2
    );
    // Two kinds, with heights between; and a plain.
    assert_eq!(
        voids(&[-32_768.0, -9999.0, 5.0, 5.0, 5.0], 1.0),
        [(-32_768.0, 1), (-9999.0, 1)]
    );
}

#[test]
fn heights_are_no_voids_however_they_are_written() {
    // The Mariana Trench and Mount Everest; decimetres up to what 16 bits hold; a number that nobody writes for a void.
    assert_eq!(voids(&[-10_935.0, -9999.0, 0.0, 8848.0], 1.0), []);
    assert_eq!(voids(&[20_000.0, 32_766.0, 32_767.0], 0.1), []);
    assert_eq!(voids(&[100.0, -12_345.0, 900.0], 1.0), []);
    // 999 stands for voids far away only, in metres.
    assert_eq!(voids(&[-999.0, -600.0, -550.0], 1.0), []);
    assert_eq!(voids(&[-999.0, 100.0, 140.0], 1.0), [(-999.0, 1)]);
    assert_eq!(voids(&[-999.0, 100.0, 140.0], 0.1), []);
    assert_eq!(voids(&[-9999.0; 4], 1.0), []);
}

#[test]
fn more_different_values_than_are_kept_leave_the_outermost_with_their_counts() {
    let many = (0..1000).map(|index| f64::from(index * 37 % 100));
    let values: Vec<f64> = many.chain([-32_768.0, -32_768.0]).collect();
    assert_eq!(voids(&values, 1.0), [(-32_768.0, 2)]);
    let mut ends = Ends::default();
    values.iter().for_each(|&value| ends.add(value));
    assert_eq!(ends.highest[0], (99.0, 10));
    assert_eq!((ends.lowest.len(), ends.lowest[1]), (ENDS, (0.0, 10)));
}
