#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn grid(heights: [f32; 6]) -> HeightGrid {
    HeightGrid {
        columns: 3,
        rows: 2,
        heights: heights.to_vec(),
        georeference: GeoReference::wgs84(3, 2, DVec2::new(10.0, 50.0), DVec2::new(0.5, -0.25)),
    }
}

#[test]
fn bilinear_meets_the_samples_and_the_middle_of_a_cell() {
    let grid = grid([1.0, 2.0, 4.0, 3.0, 6.0, 10.0]);
    assert_eq!(grid.bilinear(DVec2::new(2.0, 1.0)), Some(10.0));
    assert_eq!(grid.bilinear(DVec2::new(1.0, 0.0)), Some(2.0));
    assert_eq!(grid.bilinear(DVec2::new(0.5, 0.5)), Some(3.0));
    assert_eq!(grid.bilinear(DVec2::new(1.25, 0.75)), Some(0.25 * 2.5 + 0.75 * 7.0));
}

#[test]
fn there_is_nothing_outside() {
    let grid = grid([0.0; 6]);
    for outside in [
        [-1e-12, 0.0],
        [2.000_000_1, 0.0],
        [0.0, 1.000_1],
        [0.0, -0.1],
        [f64::NAN, 0.0],
    ] {
        assert_eq!(grid.bilinear(DVec2::from(outside)), None, "{outside:?}");
    }
}

#[test]
fn a_void_counts_only_where_it_has_a_weight() {
    let grid = grid([1.0, f32::NAN, 4.0, 3.0, 6.0, 10.0]);
    assert_eq!(grid.bilinear(DVec2::new(0.5, 1.0)).unwrap(), 4.5);
    assert_eq!(grid.bilinear(DVec2::new(0.0, 0.5)).unwrap(), 2.0);
    assert_eq!(grid.bilinear(DVec2::new(2.0, 0.5)).unwrap(), 7.0);
    assert_eq!(grid.bilinear(DVec2::new(0.5, 0.999)), None);
    assert_eq!(grid.bilinear(DVec2::new(1.0, 0.0)), None);
}
