use super::*;

#[test]
fn the_error_left_to_the_program_follows_the_cells_up_to_what_can_be_seen() {
    let errors = [1.0, 30.9, 92.7, 1000.0, 9276.0, 111_320.0].map(default_error);
    let wanted = [0.1, 5.0, 10.0, 100.0, 200.0, 1000.0];
    for (error, wanted) in errors.into_iter().zip(wanted) {
        assert!((error - wanted).abs() < 1e-9, "{errors:?}");
    }
    assert!(default_error(1_113_200.0) > 50_000.0, "what cells of 10° bend away");
}
