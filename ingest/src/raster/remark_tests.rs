use super::*;

/// The only one, empty where there is none.
fn note(heights: &[f32]) -> String {
    let notes = Extremes::of(heights)
        .iter()
        .flat_map(notes_of_heights)
        .collect::<Vec<_>>();
    assert!(notes.len() < 2, "{notes:?}");
    notes.concat()
}

fn has_no_note(heights: &[f32]) -> bool {
    note(heights).is_empty()
}

#[test]
fn heights_above_every_mountain_and_a_plain_of_one_height_are_named() {
    let told = note(&[60_120.0, 66_010.0]);
    assert!(
        told.contains("66010 m, above every mountain") && told.contains("--unit"),
        "{told}"
    );
    assert!(has_no_note(&[8848.0, 8600.0]));
    let told = note(&[7.0, 7.0, f32::NAN, 7.0]);
    assert!(told.contains("all 3 samples with a height are at 7 m"), "{told}");
}

#[test]
fn files_that_disagree_are_named_with_how_many_samples_and_by_how_much() {
    let faults = Faults {
        filled: 3,
        wild: 3,
        disagreeing: 1800,
        apart: 7.0,
    };
    let notes = notes_of_faults(Path::new("b.tif"), &faults);
    assert!(notes[0].starts_with("b.tif: 3 samples are infinite"), "{notes:?}");
    assert!(
        notes[1].starts_with("b.tif: 1800 samples differ from those of files that count before it, by up to 7 m"),
        "{notes:?}"
    );
    assert_eq!(notes[2], "3 void samples were filled from their rims");
    assert!(notes_of_faults(Path::new("b.tif"), &Faults::default()).is_empty());
}

#[test]
fn a_height_far_below_all_others_that_occurs_again_is_named_with_how_to_declare_it() {
    let told = note(&[320.0, -9999.0, 410.0, -9999.0, 1900.0]);
    assert!(told.contains("-9999 m, far below all others: 2;"), "{told}");
    assert!(told.contains("--nodata"), "{told}");
    let told = note(&[-32768.0, 5.0]);
    assert!(told.contains("below every sea floor: 1;"), "{told}");
}

#[test]
fn a_single_pit_and_a_deep_sea_are_no_remark() {
    assert!(has_no_note(&[320.0, -9999.0, 410.0]));
    assert!(has_no_note(&[-5000.0, -5000.0, -3000.0, 2000.0]));
    assert!(has_no_note(&[-10_935.0, 5.0]));
}
