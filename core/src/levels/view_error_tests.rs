#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::adaptive_surface::AdaptiveSurface;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::mesh::tests::three_by_three;

const VIEW: View = View {
    eye: DVec3::new(0.0, 0.0, 100.0),
    focal_length: 540.0,
    frustum: Vec::new(),
};

#[test]
fn a_metre_at_the_distance_of_the_focal_length_in_pixels_is_a_pixel() {
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
        let beside = HalfSpace {
            normal: (DVec3::new(4.0, 4.0, 0.0) - eye).normalize_or_zero(),
            offset: 3.0 - eye.length() / 2.0,
        };
        let all_around = View { eye, ..VIEW };
        let narrow = View {
            frustum: vec![beside],
            ..all_around.clone()
        };
        for (view, collapse) in [all_around, narrow]
            .iter()
            .flat_map(|view| (0..5).map(move |c| (view, c)))
        {
            for &needed in surface.dag().constraints(collapse) {
                let (own, below) = (
                    errors.largest_screen_error(view, collapse),
                    errors
                        .largest_screen_error(view, needed)
                        .max(errors.screen_error(view, collapse)),
                );
                assert!(own >= below, "{eye}: {collapse} {own}, {needed} {below}");
                compared += 1;
            }
        }
    }
    assert!(compared >= 2 * 64 * 4, "{compared}");
}

#[test]
fn the_box_of_a_collapse_holds_its_star() {
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
    assert_eq!(errors.screen_error(&from(0.0), 0), f64::INFINITY, "in the box");
    assert!((errors.screen_error(&from(10.0), 0) - 108.0).abs() < 1e-9);
    let aside = View {
        eye: DVec3::new(3.0, 3.0, 0.0),
        ..VIEW
    };
    assert!((errors.screen_error(&aside, 0) - 540.0).abs() < 1e-9, "2 from x = 1");
}

#[test]
fn what_is_beside_the_picture_has_no_error() {
    let seen = SeenError {
        error: 2.0,
        bounds: Bounds {
            low: DVec3::new(7.0, -3.0, -3.0),
            high: DVec3::new(13.0, 3.0, 3.0),
        },
    };
    let left_of = |x: f64| View {
        frustum: vec![HalfSpace {
            normal: DVec3::NEG_X,
            offset: x,
        }],
        ..VIEW
    };
    assert_eq!(seen.on_screen(&left_of(6.9)), 0.0);
    assert!(seen.on_screen(&left_of(7.1)) > 10.0);
}
