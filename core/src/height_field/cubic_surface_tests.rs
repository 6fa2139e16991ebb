#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::collections::HashMap;

use glam::DVec3;

use super::*;
use crate::height_field::ground::Ground;
use crate::height_field::plan::PlanMap;
use crate::height_field::reference::Bound;
use crate::height_field::rules::{Allowance, Quality, Shape};
use crate::height_field::simplify::Simplifier;
use crate::height_field::triangulate::{Outline, triangulate};
use crate::mesh;

const SIZE: usize = 65;
/// Plan units in a cell.
const SCALE: f64 = 256.0;
const LEAST_ALTITUDE: f64 = 4.0;

fn reference<'a>(samples: &'a [f32], curvature: &'a [DVec2]) -> Reference<'a> {
    let high = DVec2::splat((SIZE - 1) as f64 * SCALE);
    Reference {
        heights: Heights {
            columns: SIZE,
            rows: SIZE,
            samples,
        },
        plan: PlanMap::fit(DVec2::ZERO, high, |p| p / SCALE, |p| p * SCALE),
        curvature,
        ground: Ground::Plane(DVec2::splat(1.0 / SCALE)),
        bound: Bound::Samples,
        finer: None,
    }
}

fn smooth(random: &mut fastrand::Rng) -> Vec<f32> {
    let waves = [(); 3].map(|()| {
        [
            random.f32() * 0.12,
            random.f32() * 0.12,
            random.f32() * 6.0,
            10.0 + random.f32() * 30.0,
        ]
    });
    let height = |index: usize| {
        let (x, y) = ((index % SIZE) as f32, (index / SIZE) as f32);
        waves
            .iter()
            .map(|[a, b, c, high]| high * (a * x + b * y + c).sin())
            .sum()
    };
    (0..SIZE * SIZE).map(height).collect()
}

/// The square from (0, 0) to the last sample, with a square hole where `hole` says so.
fn surface<'a>(reference: &'a Reference<'a>, hole: Option<[usize; 2]>) -> Surface<'a> {
    let mut outline = Outline {
        has_outside: hole.is_some(),
        ..Outline::default()
    };
    for [first, last] in [Some([0, SIZE - 1]), hole].into_iter().flatten() {
        let number = outline.vertices.len() as u32;
        for (column, row) in [(first, first), (last, first), (last, last), (first, last)] {
            let plan = DVec2::new(column as f64, row as f64) * SCALE;
            let height = reference.heights.sample(column, row);
            outline.vertices.push(DVec3::new(plan.x, plan.y, height));
        }
        outline
            .segments
            .extend([0, 1, 2, 3].map(|side| [number + side, number + (side + 1) % 4]));
    }
    let is_inside = |plan: DVec2| {
        let cell = (plan / SCALE).floor();
        reference.heights.cell_is_valid(cell.x as i64, cell.y as i64)
    };
    let mut mesh = triangulate(&outline, is_inside).unwrap().mesh;
    mesh::separate_fans(&mut mesh, |_| false);
    Surface::new(&mesh, reference)
}

fn patches_of_flat(reference: &Reference, tolerance: f64) -> usize {
    let mut surface = surface(reference, None);
    let refinement = Refinement {
        tolerance,
        height_step: 0.0,
        frame: None,
        most_vertices: None,
    };
    crate::height_field::refine::refine(&mut surface, refinement);
    let shape = Shape {
        height_step: 0.0,
        least_altitude: LEAST_ALTITUDE,
    };
    let kinds = vec![VertexKind::Free; surface.vertex_count()];
    let mut simplifier = Simplifier::new(surface, kinds, shape, Quality::Default);
    simplifier.thin(Allowance {
        vertical: tolerance,
        outline: 0.0,
        breaklines: 0.0,
    });
    simplifier.surface().triangle_count()
}

/// Largest difference at the samples that some triangle covers, found by trying all triangles for each; and how many samples none
/// covers.
fn brute_force(curved: &CubicSurface, samples: &[f32]) -> (f64, usize) {
    let triangles: Vec<_> = curved.triangles().collect();
    let (mut worst, mut missed) = (0.0_f64, 0);
    for (index, &sample) in samples.iter().enumerate().filter(|(_, sample)| !sample.is_nan()) {
        let at = DVec2::new((index % SIZE) as f64, (index / SIZE) as f64);
        let covers = |corners: &&[SlopedPoint; 3]| {
            let [a, b, c] = corners.map(|corner| corner.point.grid);
            [(a, b), (b, c), (c, a)]
                .into_iter()
                .all(|(p, q)| (q - p).perp_dot(at - p) >= -1e-9)
        };
        match triangles.iter().find(covers) {
            None => missed += 1,
            Some(&corners) => {
                let height = Cubic::through(corners).unwrap().height(at);
                worst = worst.max((height - f64::from(sample)).abs());
            }
        }
    }
    (worst, missed)
}

#[test]
fn every_sample_is_within_the_tolerance() {
    let curvature = vec![DVec2::ZERO; SIZE];
    for seed in 0..12 {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut samples = smooth(&mut random);
        let rough = random.f32() * 20.0;
        samples.iter_mut().for_each(|sample| *sample += rough * random.f32());
        let hole = seed % 3 == 0;
        if hole {
            for row in 21..40 {
                samples[row * SIZE + 21..row * SIZE + 40].fill(f32::NAN);
            }
        }
        let reference = reference(&samples, &curvature);
        let tolerance = 0.5 + random.f64() * 10.0;
        let surface = surface(&reference, hole.then_some([20, 40]));
        let mut curved = CubicSurface::refined(surface, tolerance, LEAST_ALTITUDE);
        assert!(curved.deviation().size <= tolerance, "seed {seed}: refined");
        let before = curved.triangles().count();
        curved.thin(tolerance);
        let (worst, missed) = brute_force(&curved, &samples);
        assert_eq!(missed, 0, "seed {seed}");
        assert!(
            worst <= tolerance + 1e-9,
            "seed {seed}: {worst} m instead of {tolerance} m"
        );
        assert!((worst - curved.deviation().size).abs() < 1e-9, "seed {seed}");
        assert!(curved.triangles().count() <= before, "seed {seed}");
    }
}

#[test]
fn triangles_meet_edge_to_edge() {
    let curvature = vec![DVec2::ZERO; SIZE];
    let samples = smooth(&mut fastrand::Rng::with_seed(5));
    let reference = reference(&samples, &curvature);
    let mut curved = CubicSurface::refined(surface(&reference, None), 0.5, LEAST_ALTITUDE);
    curved.thin(0.5);
    let key = |point: SlopedPoint| {
        let SlopedPoint { point, slope } = point;
        [point.grid.x, point.grid.y, point.height, slope.x, slope.y].map(f64::to_bits)
    };
    let mut edges: HashMap<_, usize> = HashMap::new();
    for corners in curved.triangles() {
        for side in 0..3 {
            let ends = [key(corners[side]), key(corners[(side + 1) % 3])];
            *edges.entry(ends).or_default() += 1;
        }
    }
    let last = (SIZE - 1) as f64;
    for (&[from, to], &count) in &edges {
        let on_outline = |axis: usize| {
            let [a, b] = [from, to].map(|end| f64::from_bits(end[axis]));
            a == b && (a == 0.0 || a == last)
        };
        let has_twin = edges.contains_key(&[to, from]);
        assert_eq!(count, 1);
        assert_eq!(has_twin, !on_outline(0) && !on_outline(1));
    }
}

#[test]
fn smooth_ground_takes_fewer_patches_than_flat_triangles() {
    let curvature = vec![DVec2::ZERO; SIZE];
    let samples = smooth(&mut fastrand::Rng::with_seed(7));
    let reference = reference(&samples, &curvature);
    let mut curved = CubicSurface::refined(surface(&reference, None), 0.1, LEAST_ALTITUDE);
    curved.thin(0.1);
    let (patches, triangles) = (curved.triangles().count(), patches_of_flat(&reference, 0.1));
    assert!(4 * patches < triangles, "{patches} patches, {triangles} flat triangles");
}

#[test]
fn a_plane_is_two_patches() {
    let curvature = vec![DVec2::ZERO; SIZE];
    let samples: Vec<f32> = (0..SIZE * SIZE)
        .map(|index| (index % SIZE + index / SIZE) as f32)
        .collect();
    let reference = reference(&samples, &curvature);
    let mut curved = CubicSurface::refined(surface(&reference, None), 0.1, LEAST_ALTITUDE);
    curved.thin(0.1);
    assert_eq!(curved.triangles().count(), 2);
}
