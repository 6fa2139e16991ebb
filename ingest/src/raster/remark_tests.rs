use super::*;

fn note(heights: &[f32]) -> Option<String> {
    Extremes::of(heights).as_ref().and_then(note_of_low)
}

#[test]
fn a_height_far_below_all_others_that_occurs_again_is_named_with_how_to_declare_it() {
    let told = note(&[320.0, -9999.0, 410.0, -9999.0, 1900.0]).unwrap_or_default();
    assert!(told.contains("-9999 m, far below all others: 2;"), "{told}");
    assert!(told.contains("-a_nodata -9999"), "{told}");
    let told = note(&[-32768.0, 5.0]).unwrap_or_default();
    assert!(told.contains("below every sea floor: 1;"), "{told}");
}

#[test]
fn a_single_pit_a_plain_and_a_deep_sea_are_no_remark() {
    assert_eq!(note(&[320.0, -9999.0, 410.0]), None);
    assert_eq!(note(&[7.0, 7.0, 7.0]), None);
    assert_eq!(note(&[-5000.0, -5000.0, -3000.0, 2000.0]), None);
}
