use glam::DVec2;

use super::*;
use crate::breaklines::Breaklines;
use crate::georeference::GeoReference;
use crate::lattice::Square;
use terrain_codec::address::Side;
use terrain_core::height_field::heights::Heights;

const LATTICE: Lattice = Lattice {
    leaf_zoom: 8,
    leaf_bits: 15,
    height_exponent: -4,
};
const SIZE: usize = 160;

/// Waves over 1.6° × 1.6° south-east of (10° E, 46° N), with a void where the meridian 10.546875° runs.
fn heights() -> Vec<f32> {
    let height = |index: usize| {
        let (column, row) = (index % SIZE, index / SIZE);
        let is_void = (50..60).contains(&column) && (60..70).contains(&row);
        let waves = 300.0 * (column as f32 * 0.3).sin() * (row as f32 * 0.2).cos() + ((index * 7919) % 17) as f32;
        if is_void { f32::NAN } else { waves }
    };
    (0..SIZE * SIZE).map(height).collect()
}

fn with_source(test: impl Fn(&BorderSource)) {
    let heights = heights();
    let georeference = GeoReference::wgs84(SIZE, SIZE, DVec2::new(10.0, 46.0), DVec2::new(0.01, -0.01));
    let heights = Heights {
        columns: SIZE,
        rows: SIZE,
        samples: &heights,
    };
    test(&BorderSource {
        lattice: LATTICE,
        georeference: &georeference,
        heights,
        breaklines: &Breaklines::new(&[], &georeference),
    });
}

/// The meridian 10.546875° E from 45.0° N on, at zoom 8.
fn meridian() -> Edge {
    Square {
        zoom: 8,
        x: 271,
        y: 192,
    }
    .edge(Side::West)
}

#[test]
fn both_neighbours_ask_for_the_same_side() {
    assert_eq!(
        meridian(),
        Square {
            zoom: 8,
            x: 270,
            y: 192
        }
        .edge(Side::East)
    );
    assert_eq!(meridian().line, 271);
}

#[test]
fn a_void_parts_a_side_and_the_ends_of_its_runs_stay() {
    with_source(|source| {
        let curve = BorderCurve::of_leaf(source, meridian(), 5.0);
        assert_eq!(curve.runs.len(), 2);
        let unit = LATTICE.degrees_per_unit();
        let gap = (curve.runs[1].ends()[0] - curve.runs[0].ends()[1]) as f64 * unit;
        assert!((gap - 0.11).abs() < 2.0 * unit, "{gap}");
        for run in &curve.runs {
            let kept: Vec<i64> = run
                .vertices()
                .filter(|vertex| vertex.2)
                .map(|vertex| vertex.0)
                .collect();
            assert_eq!([kept[0], kept[kept.len() - 1]], run.ends());
        }
    });
}

#[test]
fn each_zoom_keeps_its_tolerance_and_some_of_the_vertices_of_the_zoom_below() {
    with_source(|source| {
        let parent = Square { zoom: 7, x: 135, y: 96 }.edge(Side::East);
        let halves = parent.halves().map(|half| BorderCurve::of_leaf(source, half, 4.0));
        let curve = BorderCurve::of_halves(source.lattice, parent, [&halves[0], &halves[1]], 8.0);
        let coarse = |curve: &BorderCurve| -> Vec<i64> {
            curve
                .runs
                .iter()
                .flat_map(Run::vertices)
                .filter(|vertex| vertex.2)
                .map(|vertex| vertex.0)
                .collect()
        };
        let mut below: Vec<i64> = halves.iter().flat_map(coarse).collect();
        below.dedup();
        let fine: Vec<i64> = curve
            .runs
            .iter()
            .flat_map(Run::vertices)
            .map(|vertex| vertex.0)
            .collect();
        assert_eq!(fine, below);
        assert!(
            coarse(&curve).len() < fine.len() && fine.len() > 10,
            "{} of {}",
            coarse(&curve).len(),
            fine.len()
        );
        for run in &curve.runs {
            assert!(strays(run, |_| true) <= 8.001 && strays(run, |is_coarse| is_coarse) <= 16.001);
            assert!(strays(run, |is_coarse| is_coarse) > 8.0);
        }
    });
}

/// Largest vertical distance between a run's breakpoints and the chords of its chosen vertices, which hang below the
/// round Earth.
fn strays(run: &Run, chosen: impl Fn(bool) -> bool) -> f64 {
    let kept: Vec<(i64, f64)> = run.vertices().filter(|v| chosen(v.2)).map(|v| (v.0, v.1)).collect();
    let mut worst: f64 = 0.0;
    for pair in kept.windows(2) {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        for &(along, height) in run.points.iter().filter(|point| (from..=to).contains(&point.0)) {
            let share = (along - from) as f64 / (to - from) as f64;
            let metres = (to - from) as f64 * LATTICE.degrees_per_unit() * 111_195.0;
            let hang = metres * metres / (2.0 * 6_371_000.0) * share * (1.0 - share);
            worst = worst.max((low + share * (high - low) - hang - height).abs());
        }
    }
    worst
}
