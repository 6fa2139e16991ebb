#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::levels::collapse_list::{ListedCollapse, to_log};
use crate::mesh::tests::three_by_three;

/// Nine vertices in three rows; the middle of the lower row, then the centre fall into the corner, which moves.
fn surface() -> AdaptiveSurface {
    let mesh = three_by_three();
    let collapse = |blue, height| ListedCollapse {
        blue,
        red: 0,
        moved_to: Some(DVec3::Z * height),
    };
    let log = to_log(&[collapse(1, 1.0), collapse(4, 2.0)], &mesh.positions, 1.0).unwrap();
    AdaptiveSurface::new(&mesh, &log).unwrap()
}

fn state(surface: &AdaptiveSurface) -> (Vec<u32>, Vec<u32>, f64) {
    let mut triangles = surface.triangles().to_vec();
    triangles.sort_unstable();
    (surface.splittable().to_vec(), triangles, surface.position(0).z)
}

#[test]
fn only_what_nothing_rests_on_is_split_and_the_red_vertex_goes_back() {
    let mut surface = surface();
    assert_eq!(state(&surface), (vec![1], vec![2, 4, 5, 6, 7], 2.0));
    assert!(!surface.split(0));
    assert!(surface.split(1));
    assert_eq!((surface.splittable(), surface.collapsible()), (&[0][..], &[1][..]));
    assert_eq!(surface.position(0).z, 1.0);
    assert!(surface.split(0));
    assert!(!surface.collapse(1));
    assert_eq!(state(&surface), (vec![], (0..8).collect(), 0.0));
    assert!(surface.collapse(0) && surface.collapse(1));
    assert_eq!(surface.position(0).z, 2.0);
}

#[test]
fn a_forced_split_begins_with_what_rests_on_it() {
    let mut surface = surface();
    assert_eq!(surface.force_split(0), [1, 0]);
    assert_eq!(surface.triangles().len(), 8);
    assert_eq!(surface.force_split(0), [0_u32; 0]);
}
