use super::*;

fn curve(heights: &[f64]) -> Vec<DVec2> {
    heights
        .iter()
        .enumerate()
        .map(|(i, &h)| DVec2::new(i as f64, h))
        .collect()
}

/// Largest distance along y between the points and the polyline of the kept ones.
fn measured(points: &[DVec2], kept: &[usize]) -> f64 {
    let segments = kept.windows(2).flat_map(|pair| {
        let (a, b) = (points[pair[0]], points[pair[1]]);
        points[pair[0]..=pair[1]]
            .iter()
            .map(move |p| (a.y + (p.x - a.x) / (b.x - a.x) * (b.y - a.y) - p.y).abs())
    });
    segments.fold(0.0, f64::max)
}

#[test]
fn a_straight_line_keeps_its_ends() {
    let points = curve(&[0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(fewest_vertices(&points, &[0, 1, 2, 3, 4], 0.0), [0, 4]);
}

#[test]
fn a_tent_keeps_its_ridge_until_the_tolerance_reaches_it() {
    let points = curve(&[0.0, 1.0, 2.0, 1.0, 0.0]);
    assert_eq!(fewest_vertices(&points, &[0, 1, 2, 3, 4], 1.9).len(), 3);
    assert_eq!(fewest_vertices(&points, &[0, 1, 2, 3, 4], 0.9), [0, 2, 4]);
    assert_eq!(fewest_vertices(&points, &[0, 1, 2, 3, 4], 2.0), [0, 4]);
}

#[test]
fn points_that_are_no_candidates_still_bind() {
    let points = curve(&[0.0, 0.0, 5.0, 0.0, 0.0]);
    assert_eq!(fewest_vertices(&points, &[0, 1, 3, 4], 1.0), [0, 1, 3, 4]);
}

#[test]
fn a_rough_curve_stays_within_every_tolerance_and_nests() {
    let points: Vec<DVec2> = (0..200)
        .map(|i| DVec2::new(f64::from(i), f64::from((i * 7919 + i * i * 31) % 101) * 0.1))
        .collect();
    let mut candidates: Vec<usize> = (0..points.len()).collect();
    for tolerance in [2.0, 3.0, 4.0] {
        let kept = fewest_vertices(&points, &candidates, tolerance);
        assert!(
            measured(&points, &kept) <= tolerance + 1e-12 || kept.len() == candidates.len(),
            "{tolerance}"
        );
        assert!(
            kept.len() < candidates.len(),
            "{tolerance}: {} of {}",
            kept.len(),
            candidates.len()
        );
        assert!(kept.iter().all(|index| candidates.contains(index)));
        candidates = kept;
    }
}
