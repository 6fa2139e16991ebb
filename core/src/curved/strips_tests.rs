use glam::DVec3;

use super::*;

/// A patch of a surface over the square (x, y) to (x + 1, y + 1), flat where `bend` is 0.
fn square(x: f64, y: f64, bend: f64) -> Bicubic {
    [0, 1, 2, 3].map(|i| {
        [0, 1, 2, 3].map(|j| {
            let (right, up) = (x + f64::from(i) / 3.0, y + f64::from(j) / 3.0);
            DVec3::new(right, up, 0.0) + bend * DVec3::new(0.0, 0.0, f64::from(i * i * j * j))
        })
    })
}

fn halvings_of(bicubics: &[Bicubic], tolerance: f64) -> Vec<[u32; 2]> {
    let tensors: Vec<TensorPatch> = bicubics.iter().map(TensorPatch::of_bicubic).collect();
    halvings(&tensors, bicubics, tolerance)
}

#[test]
fn strips_go_on_across_sides_and_no_others_are_halved() {
    // Four in a row along x, the last of them bent, and one above the first.
    let mut row: Vec<Bicubic> = (0..4).map(|x| square(f64::from(x), 0.0, 0.0)).collect();
    row[3] = square(3.0, 0.0, 0.2);
    row.push(square(0.0, 1.0, 0.0));
    let found = halvings_of(&row, 0.01);
    let [along, across] = found[3];
    assert!(along > 0 && across > 0, "{found:?}");
    assert_eq!(found[..3], [[0, across]; 3]);
    assert_eq!(found[4], [0, 0]);
    assert_eq!(halvings_of(&row, f64::INFINITY), [[0, 0]; 5]);
}

#[test]
fn pieces_are_as_near_as_asked() {
    let bent = [square(0.0, 0.0, 0.3)];
    let tensor = TensorPatch::of_bicubic(&bent[0]);
    for tolerance in [0.1, 0.01, 0.001] {
        let found = halvings_of(&bent, tolerance)[0];
        assert!(deviation(&tensor, found) <= tolerance);
        let one_less = found.map(|count: u32| count.saturating_sub(1));
        assert!(
            deviation(&tensor, one_less) > tolerance,
            "more than is asked for: {found:?}"
        );
    }
}

#[test]
fn opposite_sides_that_are_points_are_parted() {
    let mut spindle = square(0.0, 0.0, 0.0);
    spindle[0] = [DVec3::ZERO; 4];
    spindle[3] = [DVec3::X; 4];
    let [along, _] = halvings_of(&[spindle], 1e9)[0];
    assert_eq!(along, 1);
}
