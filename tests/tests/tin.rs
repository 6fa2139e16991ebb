//! One mesh of grids whose answer is known: every bound is measured again by the verifier, and where the fewest
//! triangles are known, they are what comes out.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use glam::DVec2;
use tempfile::TempDir;
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::Quality;
use terrain_ingest::georeference::GeoReference;
use terrain_ingest::verify::MeshReport;
use terrain_ingest::{HeightGrid, Progress, tin, verify};

const QUALITIES: [Quality; 3] = [Quality::Fast, Quality::Default, Quality::Best];
const BOUNDS: [Bound; 2] = [Bound::Surface, Bound::Samples];

fn grid(columns: usize, rows: usize, height: impl Fn(usize, usize) -> f32) -> HeightGrid {
    let heights = (0..columns * rows).map(|index| height(index % columns, index / columns));
    HeightGrid {
        columns,
        rows,
        heights: heights.collect(),
        georeference: GeoReference::wgs84(columns, rows, DVec2::new(7.0, 46.0), DVec2::new(0.001, -0.001)),
    }
}

fn triangulated(grid: &HeightGrid, max_error: f64, bound: Bound, quality: Quality) -> (usize, MeshReport) {
    let folder = TempDir::new().unwrap();
    let output = folder.path().join("mesh.ply");
    let options = tin::Options {
        max_error,
        bound,
        quality,
        breaklines: Vec::new(),
    };
    let report = tin::run(grid, &options, &output, &Progress::silent()).unwrap();
    let measured = verify::mesh(&output, grid.into(), None, 64 << 20).unwrap();
    assert!(measured.holds(), "{bound:?} {quality:?}: {measured}");
    assert!(
        report.certified_error <= max_error,
        "{bound:?} {quality:?}: {}",
        report.certified_error
    );
    (report.triangles, measured)
}

fn in_all_ways(grid: &HeightGrid, max_error: f64, check: impl Fn(usize, Bound, Quality)) {
    for bound in BOUNDS {
        for quality in QUALITIES {
            check(triangulated(grid, max_error, bound, quality).0, bound, quality);
        }
    }
}

/// The same noise everywhere and always.
fn noise(column: usize, row: usize) -> f32 {
    let mixed = (column as u32).wrapping_mul(0x9e37_79b1) ^ (row as u32).wrapping_mul(0x85eb_ca77);
    let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x2c1b_3c6d);
    (mixed >> 8) as f32 / (1 << 24) as f32
}

#[test]
fn planes_of_any_slope_and_size_are_two_triangles() {
    for (columns, rows) in [(2, 2), (2, 40), (40, 2), (3, 3), (60, 45)] {
        for (across, down) in [(0.0, 0.0), (3.0, 0.0), (0.0, -7.0), (25.0, 11.0)] {
            let plane = grid(columns, rows, |column, row| {
                500.0 + across * column as f32 + down * row as f32
            });
            in_all_ways(&plane, 0.01, |triangles, bound, quality| {
                assert_eq!(
                    triangles, 2,
                    "{columns} × {rows}, {across}, {down}, {bound:?} {quality:?}"
                );
            });
        }
    }
}

#[test]
fn a_roof_is_four_triangles() {
    let roof = grid(41, 31, |column, _| 10.0 * (20.0 - (column as f32 - 20.0).abs()));
    for bound in BOUNDS {
        for quality in [Quality::Default, Quality::Best] {
            assert_eq!(triangulated(&roof, 0.01, bound, quality).0, 4, "{bound:?} {quality:?}");
        }
    }
}

#[test]
fn a_single_cell_that_is_bent_holds_its_bound_between_the_samples_or_only_at_them() {
    let saddle = grid(2, 2, |column, row| if column == row { 100.0 } else { 0.0 });
    let (triangles, measured) = triangulated(&saddle, 1.0, Bound::Samples, Quality::Default);
    assert_eq!(triangles, 2);
    assert!((measured.measured_between_samples - 50.0).abs() < 0.01, "{measured}");
    let (triangles, _) = triangulated(&saddle, 1.0, Bound::Surface, Quality::Default);
    assert!((50..400).contains(&triangles), "{triangles}");
}

#[test]
fn a_cliff_of_a_hundred_metres_keeps_its_height() {
    let cliff = grid(64, 48, |column, row| if 2 * column + row > 80 { 100.0 } else { 0.0 });
    in_all_ways(&cliff, 1.0, |triangles, bound, quality| {
        // Straight as it is, the cliff takes a handful of triangles between samples; the 48 cells that it crosses are each
        // as bent as the single one above.
        let expected = if bound == Bound::Surface { 60..48 * 60 } else { 6..20 };
        assert!(expected.contains(&triangles), "{triangles} {bound:?} {quality:?}");
    });
}

#[test]
fn noise_below_the_bound_is_two_triangles_and_above_it_no_more_than_all_samples() {
    let rough = grid(50, 50, |column, row| 10.0 * noise(column, row));
    assert_eq!(triangulated(&rough, 10.0, Bound::Samples, Quality::Default).0, 2);
    let (triangles, _) = triangulated(&rough, 1.0, Bound::Samples, Quality::Best);
    assert!((1000..2 * 49 * 49).contains(&triangles), "{triangles}");
}

#[test]
fn a_single_row_or_column_has_no_surface() {
    for (columns, rows) in [(1, 9), (9, 1), (1, 1)] {
        let folder = TempDir::new().unwrap();
        let options = tin::Options {
            max_error: 1.0,
            bound: Bound::Surface,
            quality: Quality::Default,
            breaklines: Vec::new(),
        };
        let line = grid(columns, rows, |_, _| 1.0);
        let refused = tin::run(&line, &options, &folder.path().join("mesh.ply"), &Progress::silent()).unwrap_err();
        assert!(
            refused.to_string().contains("no cell with four valid samples"),
            "{refused}"
        );
        assert_eq!(folder.path().read_dir().unwrap().count(), 0, "nothing is left behind");
    }
}

#[test]
fn holes_that_touch_in_a_point_keep_the_bound_on_both_sides_of_it() {
    let steep = |column: usize, row: usize| 40.0 * noise(column, row) + 3.0 * column as f32;
    // A chequered raster: each cell with a surface touches others in its corners alone.
    let is_void = |column: usize, row: usize| {
        [column, row].iter().all(|place| place % 4 == 2) || [column, row].iter().all(|place| place.is_multiple_of(4))
    };
    let holed = grid(33, 29, |column, row| {
        if is_void(column, row) {
            f32::NAN
        } else {
            steep(column, row)
        }
    });
    for max_error in [2.0, 10.0, 30.0] {
        in_all_ways(&holed, max_error, |_, _, _| ());
    }
}
