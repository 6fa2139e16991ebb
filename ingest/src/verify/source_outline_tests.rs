#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;

#[test]
fn the_nearest_side_is_that_of_brute_force_over_all_of_them() {
    let (columns, rows) = (200, 150);
    // Two large holes, and voids here and there in one corner.
    let is_void = |x: usize, y: usize| {
        (30..90).contains(&x) && (20..70).contains(&y) || x > 160 && y > 100 && (x * 7 + y * 5).is_multiple_of(13)
    };
    let grid = HeightGrid {
        columns,
        rows,
        heights: (0..columns * rows)
            .map(|index| {
                if is_void(index % columns, index / columns) {
                    f32::NAN
                } else {
                    1.0
                }
            })
            .collect(),
        georeference: GeoReference::wgs84(columns, rows, DVec2::new(7.0, 60.0), DVec2::new(0.01, -0.02)),
    };
    let source = Source::from(&grid);
    let patch = source.patch(&source.whole()).unwrap();
    let all = RTree::bulk_load(segments(&source, &patch, &source.whole()));
    let outline = SourceOutline::new(source, 100).unwrap();
    let mut near = outline.near();
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..500 {
        let place = DVec2::new(random.f64() * 300.0 - 50.0, random.f64() * 250.0 - 50.0);
        let point = source.on_ellipsoid(place);
        let (found, expected) = (near.distance(point).unwrap(), distance(&all, point));
        assert!(
            (found - expected).abs() < 1e-6,
            "{place}: {found} instead of {expected}"
        );
    }
    assert!(near.known.len() > 6, "{} squares were looked into", near.known.len());
}

#[test]
fn a_source_without_surface_is_infinitely_far() {
    let grid = HeightGrid {
        columns: 3,
        rows: 2,
        heights: vec![1.0, f32::NAN, 1.0, 1.0, f32::NAN, 1.0],
        georeference: GeoReference::wgs84(3, 2, DVec2::ZERO, DVec2::ONE),
    };
    let outline = SourceOutline::new(Source::from(&grid), 64).unwrap();
    let distance = outline.near().distance(DVec3::X).unwrap();
    assert_eq!(distance, f64::INFINITY);
}
