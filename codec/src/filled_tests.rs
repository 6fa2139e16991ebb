use glam::DVec2;

use super::{CELLS, Filled};

fn with(rectangles: &[[f64; 4]]) -> Filled {
    let mut filled = Filled::default();
    for &[west, south, east, north] in rectangles {
        filled.fill(DVec2::new(west, south), DVec2::new(east, north));
    }
    filled
}

#[test]
fn every_cell_that_a_rectangle_touches_is_filled_and_no_other() {
    let part = 1.0 / CELLS as f64;
    let filled = with(&[[10.5 * part, 20.5 * part, 11.5 * part, 20.6 * part]]);
    assert_eq!(filled.cells().collect::<Vec<_>>(), [[10, 20], [11, 20]]);
    assert!(filled.has(DVec2::new(11.9 * part, 20.0 * part)));
    assert!(!filled.has(DVec2::new(12.1 * part, 20.0 * part)));
    assert!(!filled.has(DVec2::new(11.9 * part, 21.1 * part)));
}

#[test]
fn what_is_beside_the_tile_fills_nothing_and_what_reaches_in_is_cut() {
    assert!(with(&[[-0.5, 0.1, -0.1, 0.2], [0.1, 1.2, 0.2, 1.3]]).is_empty());
    assert!(with(&[[f64::NAN, 0.0, 1.0, 1.0]]).is_empty());
    assert_eq!(with(&[[-1.0, -1.0, 2.0, 2.0]]).cells().count(), CELLS * CELLS);
}

#[test]
fn a_parent_has_the_cells_of_its_children_half_as_large() {
    let child = with(&[[0.0, 0.0, 0.001, 0.001], [0.999, 0.999, 1.0, 1.0]]);
    let mut parent = Filled::default();
    parent.take_over(&child, [1, 0]);
    let half = CELLS / 2;
    assert_eq!(parent.cells().collect::<Vec<_>>(), [[half, 0], [CELLS - 1, half - 1]]);
}

#[test]
fn bytes_are_read_back_and_damaged_ones_are_not() {
    let filled = with(&[[0.1, 0.2, 0.3, 0.4], [0.5, 0.5, 0.5, 0.5]]);
    let bytes = filled.to_bytes();
    assert!(bytes.len() < 200, "{} bytes", bytes.len());
    assert_eq!(Filled::from_bytes(&bytes), Some(filled));
    assert_eq!(Filled::from_bytes(&bytes[..bytes.len() / 2]), None);
    assert_eq!(Filled::from_bytes(&[]), None);
    let empty = Filled {
        words: vec![0; CELLS * CELLS / 64],
    };
    assert_eq!(Filled::from_bytes(&empty.to_bytes()), None);
}
