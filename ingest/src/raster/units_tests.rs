use super::*;

fn told(band: &str, of_crs: Option<f64>, said: Option<f64>, scale: f64) -> (f64, String) {
    let (metres, remarks) = of_heights(band, of_crs, said, scale);
    assert!(remarks.len() < 2, "{remarks:?}");
    (metres, remarks.concat())
}

#[test]
fn a_unit_is_what_the_person_says_or_the_band_or_the_reference_system() {
    const SURVEY_FOOT: f64 = 1200.0 / 3937.0;
    let nothing = String::new;
    assert_eq!(told("", None, None, 1.0), (1.0, nothing()));
    assert_eq!(told("ft", None, None, 1.0), (0.3048, nothing()));
    assert_eq!(told("", Some(0.3048), None, 1.0), (0.3048, nothing()));
    assert_eq!(
        told("US survey foot", Some(0.304_800_609_601_2), None, 1.0),
        (SURVEY_FOOT, nothing())
    );
    assert_eq!(told("", None, Some(0.1), 1.0), (0.1, nothing()));
}

#[test]
fn what_is_contradictory_is_said_with_what_was_taken() {
    let (metres, told_either) = told("m", Some(0.3048), None, 1.0);
    assert!(
        metres == 1.0 && told_either.contains("1 m by its band, which counts, and 0.3048 m by its coordinate"),
        "{told_either}"
    );
    let (metres, feet) = told("ft", Some(1200.0 / 3937.0), None, 1.0);
    assert!(metres == 0.3048 && feet.contains("0.3048 m by its band"), "{feet}");
    let (metres, against) = told("m", None, Some(0.1), 1.0);
    assert!(
        metres == 0.1 && against.contains("0.1 m by --unit, 1 m by what it says"),
        "{against}"
    );
    let (metres, twice) = told("dm", None, None, 0.1);
    assert!(
        metres == 0.1 && twice.contains("both its scale and its unit are 0.1"),
        "{twice}"
    );
    let (metres, unknown) = told("furlong", None, None, 1.0);
    assert!(
        metres == 1.0 && unknown.contains("unit `furlong` is not known, 1 m"),
        "{unknown}"
    );
}
