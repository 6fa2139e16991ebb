#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

#[test]
fn tiles_around_are_those_of_the_scheme() {
    let numbers = |zoom, x, y| TileAddress::new(zoom, x, y).unwrap().around().len();
    assert_eq!(
        [numbers(0, 0, 0), numbers(1, 0, 0), numbers(2, 0, 0), numbers(2, 3, 1)],
        [1, 5, 5, 8]
    );
}
