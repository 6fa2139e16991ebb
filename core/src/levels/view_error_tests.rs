#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::adaptive_surface::AdaptiveSurface;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::mesh::tests::three_by_three;

const VIEW: View = View {
    eye: DVec3::new(0.0, 0.0, 100.0),
    viewport_height: 1080.0,
    field_of_view: std::f64::consts::FRAC_PI_2,
};

#[test]
fn a_metre_at_the_distance_of_half_the_viewport_in_pixels_is_a_pixel() {
    assert!((VIEW.screen_error(1.0, 540.0) - 1.0).abs() < 1e-12);
    assert!((VIEW.screen_error(3.0, 270.0) - 6.0).abs() < 1e-12);
    assert_eq!(VIEW.screen_error(1.0, 0.0), f64::INFINITY);
    assert_eq!(VIEW.screen_error(0.0, 0.0), 0.0);
}

#[test]
fn whatever_the_view_a_collapse_is_never_seen_smaller_than_what_it_needs() {
    let mesh = three_by_three();
    let pairs = [[1, 0], [5, 2], [3, 0], [4, 0], [2, 8]];
    let listed = pairs.map(|[blue, red]| ListedCollapse {
        blue,
        red,
        moved_to: Some(mesh.positions[red as usize] + DVec3::Z * f64::from(blue)),
    });
    let log = to_log(&listed, &mesh.positions, 1.0).unwrap();
    let surface = AdaptiveSurface::new(&mesh, &log).unwrap();
    let errors = ViewErrors::new(&mesh, &log, surface.dag(), &[5.0, 1.0, 2.0, 0.5, 0.1]).unwrap();
    let mut compared = 0;
    for eye in (0..64).map(|i| {
        DVec3::new(
            f64::from(i % 4) * 9.0,
            f64::from(i / 4 % 4) * 9.0,
            f64::from(i / 16) * 9.0,
        )
    }) {
        let view = View { eye, ..VIEW };
        for collapse in 0..5 {
            for &needed in surface.dag().constraints(collapse) {
                let (own, below) = (errors.screen_error(&view, collapse), errors.screen_error(&view, needed));
                assert!(
                    own >= below * (1.0 - 1e-12),
                    "{eye}: {collapse} {own}, {needed} {below}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared >= 64 * 4, "{compared}");
}

#[test]
fn the_ball_of_a_collapse_holds_its_star() {
    let mesh = Mesh {
        positions: vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(0.0, 3.0, 4.0),
            DVec3::new(-1.0, 1.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let listed = [ListedCollapse {
        blue: 1,
        red: 0,
        moved_to: None,
    }];
    let log = to_log(&listed, &mesh.positions, 1.0).unwrap();
    let surface = AdaptiveSurface::new(&mesh, &log).unwrap();
    let errors = ViewErrors::new(&mesh, &log, surface.dag(), &[2.0]).unwrap();
    let from = |distance: f64| View {
        eye: DVec3::NEG_Z * distance,
        ..VIEW
    };
    assert_eq!(
        errors.screen_error(&from(4.0), 0),
        f64::INFINITY,
        "inside the ball of radius 5"
    );
    assert!((errors.screen_error(&from(15.0), 0) - 108.0).abs() < 1e-9);
}
