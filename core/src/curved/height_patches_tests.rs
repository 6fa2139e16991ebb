#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use glam::DVec3;

use super::*;
use crate::curved::model::CurvedModel;
use crate::curved::tensor::TensorPatch;

const COLUMNS: usize = 9;
const ROWS: usize = 7;

fn heights(of: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let samples = (0..COLUMNS * ROWS).map(|index| ((index % COLUMNS) as f64, (index / COLUMNS) as f64));
    samples.map(|(x, y)| of(x, y) as f32).collect()
}

fn samples(heights: &[f32], step: DVec2) -> HeightSamples<'_> {
    HeightSamples {
        columns: COLUMNS,
        heights,
        origin: DVec2::new(100.0, 50.0),
        step,
    }
}

fn hills(x: f64, y: f64) -> f64 {
    (x * 1.3).sin() * 10.0 + (x * y * 0.4).cos() * 4.0
}

fn point(patch: &Bicubic, u: f64, v: f64) -> DVec3 {
    TensorPatch::new(patch.as_flattened().to_vec(), 4).unwrap().point(u, v)
}

#[test]
fn the_surface_passes_through_every_sample() {
    let heights = heights(hills);
    let patches = samples(&heights, DVec2::new(30.0, -20.0)).bicubics();
    assert_eq!(patches.len(), (COLUMNS - 1) * (ROWS - 1));
    for (index, patch) in patches.iter().enumerate() {
        let (column, row) = (index % (COLUMNS - 1), index / (COLUMNS - 1));
        for (u, v) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            // Rows go down, so u runs along them.
            let (x, y) = (column + v, row + u);
            let height = f64::from(heights[y * COLUMNS + x]);
            let expected = DVec3::new(100.0 + 30.0 * x as f64, 50.0 - 20.0 * y as f64, height);
            assert!(point(patch, u as f64, v as f64).distance(expected) < 1e-12);
        }
    }
}

#[test]
fn patches_meet_without_creases_and_look_up() {
    let heights = heights(hills);
    for step in [DVec2::new(30.0, -20.0), DVec2::new(30.0, 20.0)] {
        let patches = samples(&heights, step).bicubics();
        let model = CurvedModel::from_bicubics(&patches);
        let inner = (0..model.patches().len() as u32)
            .flat_map(|patch| model.neighbours(patch))
            .flatten()
            .count();
        assert_eq!(
            inner,
            3 * model.patches().len() - 2 * (COLUMNS - 1 + ROWS - 1),
            "all but the outline"
        );
        for (patch, beyond) in patches.iter().zip(&patches[COLUMNS - 1..]) {
            for at in [0.0, 0.3, 0.8] {
                // The side along x is v = 1, or u = 1 where u and v are the other way round.
                let (own, other) = if step.y > 0.0 {
                    ((at, 1.0), (at, 0.0))
                } else {
                    ((1.0, at), (0.0, at))
                };
                let [own, other] = [(patch, own), (beyond, other)].map(|(patch, at)| normal(patch, at));
                assert!(own.z > 0.0 && own.distance(other) < 1e-5, "{own} {other}");
            }
        }
    }
}

fn normal(patch: &Bicubic, (u, v): (f64, f64)) -> DVec3 {
    let step = 1e-6;
    let inwards = |at: f64| if at > 0.5 { -step } else { step };
    let (du, dv) = (inwards(u), inwards(v));
    let at = point(patch, u, v);
    ((point(patch, u + du, v) - at) / du)
        .cross((point(patch, u, v + dv) - at) / dv)
        .normalize()
}

#[test]
fn planes_stay_planes_and_parabolas_inside_too() {
    let plane = heights(|x, y| 3.0 * x - 2.0 * y);
    let off = |patch: &Bicubic, height: &dyn Fn(DVec3) -> f64| {
        let at = point(patch, 0.4, 0.7);
        (at.z - height(at)).abs()
    };
    let on_plane = |at: DVec3| 3.0 * (at.x - 100.0) - 2.0 * (at.y - 50.0);
    let patches = samples(&plane, DVec2::ONE).bicubics();
    assert!(patches.iter().all(|patch| off(patch, &on_plane) < 1e-9));
    let bowl = heights(|x, y| x * x + x * y);
    let on_bowl = |at: DVec3| (at.x - 100.0).powi(2) + (at.x - 100.0) * (at.y - 50.0);
    let exact = samples(&bowl, DVec2::ONE)
        .bicubics()
        .iter()
        .filter(|patch| off(patch, &on_bowl) < 1e-9)
        .count();
    assert_eq!(
        exact,
        (COLUMNS - 3) * (ROWS - 1),
        "all but the first and the last column"
    );
}

#[test]
fn voids_have_no_patches_and_slopes_beside_them_are_one_sided() {
    let mut heights = heights(|x, y| 3.0 * x - 2.0 * y);
    heights[3 * COLUMNS + 4] = f32::NAN;
    let patches = samples(&heights, DVec2::ONE).bicubics();
    assert_eq!(patches.len(), (COLUMNS - 1) * (ROWS - 1) - 4);
    let on_plane = |at: &DVec3| (at.z - 3.0 * (at.x - 100.0) + 2.0 * (at.y - 50.0)).abs() < 1e-9;
    assert!(patches.iter().flatten().flatten().all(on_plane));
}
