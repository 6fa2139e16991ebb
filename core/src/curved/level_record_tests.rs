#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use glam::DVec3;

use super::*;
use crate::curved::merging::with_average_centre;

fn flat(corners: [u32; 3]) -> LevelPatch {
    let at = corners.map(|corner| DVec3::new(f64::from(corner % 2), f64::from(corner / 2), 0.0));
    let inner = |a: usize, b: usize| [at[a].lerp(at[b], 1.0 / 3.0), at[b].lerp(at[a], 1.0 / 3.0)];
    let patch = with_average_centre(at, [inner(0, 1), inner(1, 2), inner(2, 0)]);
    LevelPatch::new(patch, corners, [false; 3], 0.0)
}

/// A square of two patches, cut one way at level 0 and the other at level 1.
fn square() -> Vec<LevelPatch> {
    let [first, second] = [0..1, 1..2];
    vec![
        flat([0, 1, 3]).shown_by(first.clone()),
        flat([0, 3, 2]).shown_by(first),
        flat([0, 1, 2]).shown_by(second.clone()),
        flat([1, 3, 2]).shown_by(second),
    ]
}

#[test]
fn levels_are_made_of_what_they_show_and_patches_meet_there() {
    let levels = CurvedLevels::from_patches(square(), 2).unwrap();
    for level in 0..2 {
        let model = levels.model(level);
        assert_eq!(model.patches().len(), 2);
        assert_eq!(model.neighbours(0).iter().flatten().collect::<Vec<_>>(), [&1]);
        assert_eq!(model.neighbours(1).iter().flatten().collect::<Vec<_>>(), [&0]);
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let refused = |change: &dyn Fn(&mut Vec<LevelPatch>), count: u32| {
        let mut patches = square();
        change(&mut patches);
        CurvedLevels::from_patches(patches, count).unwrap_err()
    };
    assert_eq!(refused(&|_| (), 1), LevelsError::Lifetime(2));
    assert_eq!(
        refused(&|patches| patches[1] = patches[1].shown_by(1..1), 2),
        LevelsError::Lifetime(1)
    );
    assert_eq!(refused(&|_| (), 3), LevelsError::Empty(2));
    assert_eq!(
        refused(&|patches| patches[3] = patches[3].shown_by(0..2), 2),
        LevelsError::SameSide(0, 3)
    );
    assert_eq!(
        refused(&|patches| patches[2].patch.points[4].x = f64::NAN, 2),
        LevelsError::NotFinite(2)
    );
    assert_eq!(
        refused(&|patches| patches[0].error = -1.0, 2),
        LevelsError::NotFinite(0)
    );
}
