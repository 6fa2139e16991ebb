#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

/// Samples of a paraboloid under four triangles around a vertex, as that would ask for them.
fn fit_of(samples: impl Fn(DVec2) -> f64) -> CornerFit {
    let mut fit = CornerFit::default();
    for index in 0..81 {
        let at = DVec2::new((index % 9) as f64 - 4.0, (index / 9) as f64 - 4.0);
        let near = 1.0 - at.abs().element_sum() / 8.0;
        fit.push(Asked {
            of_height: near,
            of_slope: at * near,
            target: samples(at) * near,
        });
    }
    fit
}

#[test]
fn a_plane_is_found_exactly() {
    let mut fit = fit_of(|at| 7.0 + 2.0 * at.x - 3.0 * at.y);
    let nowhere = Tangent {
        height: 0.0,
        slope: DVec2::ZERO,
    };
    let found = fit.solve(nowhere, 4.0, 1e-3).unwrap();
    assert!((found.height - 7.0).abs() < 1e-3);
    assert!(found.slope.distance(DVec2::new(2.0, -3.0)) < 1e-3);
}

#[test]
fn weights_find_a_tangent_where_least_squares_does_not() {
    // Many samples at 0 and a few at 2: the mean is far from the few, the middle is 1 from all.
    let mut fit = CornerFit::default();
    for index in 0..40 {
        fit.push(Asked {
            of_height: 1.0,
            of_slope: DVec2::ZERO,
            target: if index < 36 { 0.0 } else { 2.0 },
        });
    }
    let start = Tangent {
        height: 0.0,
        slope: DVec2::ZERO,
    };
    let found = fit.solve(start, 1.0, 1.2).unwrap();
    assert!((0.8..=1.2).contains(&found.height), "{found:?}");
    assert_eq!(fit.solve(start, 1.0, 0.9), None);
}

#[test]
fn what_nothing_asks_for_stays() {
    let present = Tangent {
        height: 5.0,
        slope: DVec2::new(1.0, 2.0),
    };
    assert_eq!(CornerFit::default().solve(present, 3.0, 0.1), Some(present));
}
