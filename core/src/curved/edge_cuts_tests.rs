use super::*;
use crate::curved::patch::tests::random_patch;

#[test]
fn both_directions_of_a_curve_are_cut_in_the_same_points() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..200 {
        let curve = random_patch(&mut random).curve(0);
        let mut back = curve;
        back.reverse();
        for cuts in [
            EdgeCuts::even(random.u32(1..9)),
            EdgeCuts::gradual(1.0 + 8.0 * random.f64()),
        ] {
            let [one, other]: [Vec<DVec3>; 2] = [cuts.points(curve).collect(), cuts.points(back).collect()];
            assert_eq!(one, other);
        }
    }
}

#[test]
fn gradual_cuts_have_no_piece_longer_than_asked_and_slide_without_a_jump() {
    let mut before = EdgeCuts::gradual(1.0);
    assert_eq!(before.parameters, [0.0, 1.0]);
    for step in 1..7000 {
        let factor = 1.0 + f64::from(step) / 1000.0;
        let cuts = EdgeCuts::gradual(factor);
        let longest = cuts
            .parameters
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(0.0, f64::max);
        assert!((longest - 1.0 / factor).abs() < 1e-12, "{factor}: {longest}");
        // Every place of a lattice moves a little.
        for slot in 0..=64 {
            let at = |cuts: &EdgeCuts| cuts.parameters[cuts.nearest(slot, 64) as usize];
            assert!((at(&cuts) - at(&before)).abs() < 0.01, "{factor}, place {slot}");
        }
        before = cuts;
    }
    assert_eq!(EdgeCuts::gradual(8.0).parameters, EdgeCuts::even(8).parameters);
}

#[test]
fn every_cut_stands_for_a_place_and_ends_for_those_beside_them() {
    let mut checked = 0;
    for slots in 1..40_u32 {
        for pieces in 1..=slots {
            let power = pieces.is_power_of_two() && slots.is_power_of_two();
            let gradual = power.then(|| EdgeCuts::gradual(f64::from(pieces)));
            for cuts in [Some(EdgeCuts::even(pieces)), gradual].into_iter().flatten() {
                let nearest: Vec<u32> = (0..=slots).map(|slot| cuts.nearest(slot, slots)).collect();
                assert_eq!((nearest[0], nearest[slots as usize]), (0, pieces));
                assert!(nearest.windows(2).all(|pair| pair[1] - pair[0] <= 1), "{nearest:?}");
                if slots > 2 && 2 * pieces <= slots {
                    assert_eq!((nearest[1], nearest[slots as usize - 1]), (0, pieces));
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 700);
}
