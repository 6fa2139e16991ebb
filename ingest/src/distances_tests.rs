use super::*;

#[test]
fn distances_are_those_of_brute_force() {
    let mut random = fastrand::Rng::with_seed(3);
    for [columns, rows] in [[1, 1], [7, 1], [1, 9], [23, 17], [40, 12]] {
        let marked: Vec<bool> = (0..columns * rows).map(|_| random.u8(0..20) == 0).collect();
        let cell = [0.5 + random.f64(), 0.5 + random.f64()];
        let found = distances(&marked, columns, cell);
        for (index, &found) in found.iter().enumerate() {
            let apart = |other: usize| {
                let across = (index % columns).abs_diff(other % columns) as f64 * cell[0];
                let down = (index / columns).abs_diff(other / columns) as f64 * cell[1];
                across.hypot(down)
            };
            let others = (0..marked.len()).filter(|&other| marked[other]);
            let nearest = others.map(apart).fold(f64::INFINITY, f64::min) as f32;
            assert!(found == nearest || (found - nearest).abs() < 1e-5, "{found} {nearest}");
        }
    }
}
