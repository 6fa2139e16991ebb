use super::*;

#[test]
fn ground_is_never_the_number_of_no_ground_and_is_within_half_a_quantum() {
    for [low, high] in [[-430.5_f32, 8848.86], [100.0, 100.25], [7.5, 7.5]] {
        let scale = Scale::new(low.into(), high.into());
        assert_eq!(scale.number(f32::NAN), 0);
        assert_eq!(scale.number(low), 1);
        for part in 0..=1000 {
            let height = low + (high - low) * part as f32 / 1000.0;
            let number = scale.number(height);
            let metres = scale.zero + scale.quantum * f64::from(number);
            assert!(
                number > 0 && (metres - f64::from(height)).abs() <= scale.quantum * 0.500_001,
                "{height} {metres}"
            );
        }
    }
    assert_eq!(Scale::new(0.0, 1000.0).number(1000.0), u16::MAX);
}

#[test]
fn images_have_the_north_row_first() {
    assert_eq!(from_north(&[1.0, 2.0, 3.0, 4.0], 2), [3.0, 4.0, 1.0, 2.0]);
}
