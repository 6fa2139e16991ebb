use super::*;

fn edge(ends: [u32; 2], [from, to]: [[f64; 2]; 2]) -> PlanEdge {
    let [from, to] = [from, to].map(|[x, y]| [x, y, 0.0]);
    PlanEdge {
        ends,
        parts: vec![Line::new(from, to)],
    }
}

#[test]
fn a_chain_counts_if_it_is_near_and_hangs_together() {
    let points: Vec<DVec3> = (0..=20).map(|x| DVec3::new(f64::from(x), 0.0, 0.0)).collect();
    let piece = &points[..11];
    let lines = Near::to(&[Stretch {
        points: points.clone(),
        pieces: Vec::new(),
    }]);
    let first = || edge([0, 1], [[0.0, 0.5], [5.0, 0.0]]);
    let second = || edge([1, 2], [[5.0, 0.0], [10.0, 0.25]]);
    let beside = || edge([1, 3], [[5.0, 0.0], [5.0, 9.0]]);
    let apart = || edge([7, 2], [[6.0, 0.0], [10.0, 0.25]]);
    let farthest = |edges: &[PlanEdge], within: f64| Chains::near(&lines, edges, within).farthest(piece);
    let both = farthest(&[first(), second(), beside()], 1.0);
    assert!(
        (both.0 - 0.5 * 5.0 / 5.0_f64.hypot(0.5)).abs() < 1e-12 && both.1 == 0,
        "{both:?}"
    );
    assert_eq!(farthest(&[first(), beside()], 1.0).1, 10);
    assert_eq!(farthest(&[first(), beside()], 1.0).0, 5.0);
    assert_eq!(farthest(&[first(), apart()], 1.0).0, 5.0);
    assert_eq!(farthest(&[beside()], 1.0).0, f64::INFINITY);
    assert_eq!(farthest(&[first(), second()], 0.3).0, 5.0);
    // An edge that goes on along the line beyond the piece.
    let long = edge([0, 1], [[0.0, 0.5], [18.0, 0.5]]);
    assert_eq!(farthest(&[long], 1.0).0, 0.5);
}
