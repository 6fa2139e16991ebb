use super::*;

/// Ontario.
const AREA: [f64; 4] = [-80.0, 44.0, -79.0, 45.0];

fn of(code: &str) -> Option<MissingGrids> {
    let crs = Crs {
        name: code.to_owned(),
        definition: code.to_owned(),
    };
    missing_grids(&crs, AREA)
}

#[test]
fn systems_of_wgs84_miss_nothing() {
    for code in ["EPSG:4326", "EPSG:32617", "EPSG:3857"] {
        assert_eq!(of(code), None, "{code}");
    }
}

#[test]
fn a_datum_that_only_a_grid_shifts_names_it() {
    let missing = of("EPSG:4608").expect("no computer has Canada's grid of 1976 by itself");
    assert!(missing.grids[0].to_lowercase().contains("may76v20"), "{missing:?}");
    assert_eq!(missing.without, None);
}

#[test]
fn a_datum_with_a_worse_shift_tells_both() {
    let missing = of("EPSG:4267").expect("no computer has Canada's grid of 1927 by itself");
    assert!(!missing.grids.is_empty());
    let without = missing.without.flatten().expect("a shift by three numbers");
    assert!(
        missing.accuracy.is_some_and(|accuracy| accuracy < without),
        "{missing:?}"
    );
}
