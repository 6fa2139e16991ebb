use super::*;
use crate::curved::model::CurvedModel;

/// A bulged cube around the origin: six patches whose sides point outwards.
fn cube() -> Vec<Bicubic> {
    let face = |axis: usize, sign: f64| -> Bicubic {
        let along = |k: usize| 2.0 * k as f64 / 3.0 - 1.0;
        let outwards = [0, 1, 2, 3].map(|i| {
            [0, 1, 2, 3].map(|j| {
                let mut at = [0.0; 3];
                at[axis] = sign;
                at[(axis + 1) % 3] = along(i);
                at[(axis + 2) % 3] = along(j);
                let at = DVec3::from_array(at);
                at * (1.0 + 0.2 * (3.0 - at.length_squared()))
            })
        });
        if sign > 0.0 { outwards } else { transposed(&outwards) }
    };
    (0..3).flat_map(|axis| [face(axis, 1.0), face(axis, -1.0)]).collect()
}

fn assert_closed_and_outward(model: &CurvedModel) {
    for (index, patch) in (0..).zip(model.patches()) {
        assert!(
            !model.neighbours(index).contains(&None),
            "patch {index} has a free edge"
        );
        let at = DVec3::splat(1.0 / 3.0);
        assert!(
            patch.normal(at).dot(patch.point(at)) > 0.0,
            "patch {index} faces inwards"
        );
    }
}

#[test]
fn patches_that_are_turned_round_meet_their_neighbours_and_face_outwards() {
    assert_closed_and_outward(&CurvedModel::from_bicubics(&cube()));
    for which in [0b1, 0b100000, 0b101, 0b111110, 0b111111] {
        let mut mixed = cube();
        for (index, tensor) in mixed.iter_mut().enumerate() {
            if which >> index & 1 == 1 {
                *tensor = transposed(tensor);
            }
        }
        assert_closed_and_outward(&CurvedModel::from_bicubics(&mixed));
    }
}

/// What is open has no outside: it stays as it is, as most of its patches are.
#[test]
fn an_open_sheet_keeps_the_side_that_most_of_its_patches_have() {
    let patch = |shift: f64| -> Bicubic {
        [0, 1, 2, 3].map(|i| {
            [0, 1, 2, 3].map(|j| {
                let (x, y) = (i as f64 + shift, j as f64);
                DVec3::new(x, y, x * y / 9.0)
            })
        })
    };
    let up = [0.0, 3.0, 6.0].map(patch);
    let down = up.map(|tensor| transposed(&tensor));
    assert_eq!(to_turn(&up), [false; 3]);
    assert_eq!(to_turn(&down), [false; 3]);
    assert_eq!(to_turn(&[up[0], down[1], up[2]]), [false, true, false]);
    assert_eq!(to_turn(&[down[0], up[1], down[2]]), [false, true, false]);
}
