#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_core::height_field::chunks::ChunksInMemory;

use super::*;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;

/// A raster at the equator: `columns` × `rows` samples a hundredth of a degree apart.
fn raster(columns: usize, heights: Vec<f32>) -> HeightGrid {
    let rows = heights.len() / columns;
    HeightGrid {
        columns,
        rows,
        heights,
        georeference: GeoReference::wgs84(columns, rows, DVec2::new(20.0, 0.0), DVec2::new(0.01, -0.01)),
    }
}

/// Two triangles over the whole raster; positions are longitude, latitude, height.
fn sheet(grid: &HeightGrid, heights: [f64; 4]) -> Mesh {
    let [west, south, east, north] = grid.georeference.geographic_bounds();
    let corners = [(west, south), (east, south), (east, north), (west, north)];
    let positions = corners
        .iter()
        .zip(heights)
        .map(|(&(x, y), z)| DVec3::new(x, y, z))
        .collect();
    Mesh {
        positions,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn error(grid: &HeightGrid, mesh: &Mesh, bound: Bound) -> f64 {
    error_beyond(grid, mesh, bound, 0.0).unwrap()
}

fn error_beyond(grid: &HeightGrid, mesh: &Mesh, bound: Bound, floor: f64) -> Option<f64> {
    let geodetic = |p: DVec3| Geodetic {
        longitude: p.x,
        latitude: p.y,
        height: p.z,
    };
    let chunks = ChunksInMemory::new(grid.whole());
    Certifier::new(&grid.georeference, &chunks, bound, &[0..grid.columns, 0..grid.rows])
        .vertical_error(mesh, geodetic, floor)
}

#[test]
fn a_flat_sea_is_as_wrong_as_the_earth_is_round() {
    let grid = raster(101, vec![0.0; 101 * 101]);
    let found = error(&grid, &sheet(&grid, [0.0; 4]), Bound::Surface);
    let diagonal = 2.0_f64.sqrt() * 111_000.0;
    let sagitta = diagonal * diagonal / (8.0 * 6_370_000.0);
    assert!((found / sagitta - 1.0).abs() < 0.02, "{found} m, expected {sagitta} m");
}

#[test]
fn an_edge_bends_inside_its_stretches_too() {
    let grid = raster(4, vec![0.0; 8]);
    let found = error(&grid, &sheet(&grid, [0.0; 4]), Bound::Surface);
    // The diagonal is cut into three stretches; its summit is in the middle of the second, and no sample is on it.
    let diagonal_squared = 3_339.6_f64.powi(2) + 1_106.6_f64.powi(2);
    let expected = diagonal_squared / (8.0 * 6_357_000.0)
        + Curvature::under(&grid.georeference, [4, 2], &[0..4, 0..2]).in_triangle(DVec2::ONE, 0.0, 0.0);
    assert!(
        (found / expected - 1.0).abs() < 0.02,
        "{found} m, expected {expected} m"
    );
}

#[test]
fn a_saddle_is_seen_between_its_samples() {
    let grid = raster(2, vec![0.0, 40.0, 40.0, 0.0]);
    let mesh = sheet(&grid, [40.0, 0.0, 40.0, 0.0]);
    assert!((error(&grid, &mesh, Bound::Surface) - 20.0).abs() < 0.2);
    assert!(error(&grid, &mesh, Bound::Samples) < 0.1);
}

#[test]
fn a_sample_above_the_sheet_is_measured_along_the_normal() {
    let mut heights = vec![0.0; 25];
    heights[12] = 33.0;
    let grid = raster(5, heights);
    let found = error(&grid, &sheet(&grid, [0.0; 4]), Bound::Samples);
    let sagitta = 2.0 * 2.0 * 2.0 * 1_110.0_f64.powi(2) / (2.0 * 6_370_000.0);
    assert!((found - 33.0 - sagitta).abs() < 0.05, "{found}");
}

#[test]
fn a_floor_changes_nothing_above_it_and_hides_what_is_below() {
    let heights = (0..101 * 101).map(|place| (place * 7919 % 1013) as f32).collect();
    let grid = raster(101, heights);
    let mesh = sheet(&grid, [500.0; 4]);
    for bound in [Bound::Surface, Bound::Samples] {
        let whole = error(&grid, &mesh, bound);
        for share in [0.5, 0.999_999] {
            assert_eq!(error_beyond(&grid, &mesh, bound, share * whole), Some(whole));
        }
        assert_eq!(error_beyond(&grid, &mesh, bound, whole), None);
    }
}

/// A flat raster with cells of a metre, and longitude, latitude and height of a place by its column and row.
fn cells_of_a_metre() -> (HeightGrid, impl Fn(f64, f64, f64) -> DVec3) {
    let (first, step) = (DVec2::new(20.0, 0.0), DVec2::new(1e-5, -1e-5));
    let grid = HeightGrid {
        georeference: GeoReference::wgs84(5, 5, first, step),
        ..raster(5, vec![0.0; 25])
    };
    (grid, move |column, row, height| {
        (first + step * DVec2::new(column, row)).extend(height)
    })
}

#[test]
fn what_is_beyond_the_tip_of_a_wall_is_not_under_it() {
    // A wall of 300 m that is seven millimetres wide and ends at a sample.
    let (grid, place) = cells_of_a_metre();
    let wall = |tip: f64| Mesh {
        positions: vec![place(2.0, tip, 0.0), place(1.997, 1.5, 300.0), place(2.004, 1.5, 300.0)],
        triangles: vec![[0, 1, 2]],
    };
    let found = error_beyond(&grid, &wall(1.0003), Bound::Samples, 0.0);
    assert!(found.is_none_or(|error| error < 0.2), "{found:?} m");
    // The same wall ten centimetres further covers the sample, 60 m above it.
    let covered = error(&grid, &wall(0.875), Bound::Samples);
    assert!((covered - 60.0).abs() < 1.0, "{covered} m");
}

#[test]
fn a_sample_at_the_tip_of_a_steep_triangle_is_compared_with_the_tip() {
    let (grid, place) = cells_of_a_metre();
    // A plane through the sample that rises 300 m in a cell; the triangle begins a third of a millimetre beside the sample, 9 cm higher.
    let on_plane = |column: f64, row: f64| place(column, row, 300.0 * (row - 1.0));
    let mesh = Mesh {
        positions: vec![on_plane(2.0, 1.0003), on_plane(1.9, 1.5), on_plane(2.1, 1.5)],
        triangles: vec![[0, 1, 2]],
    };
    let found = error_beyond(&grid, &mesh, Bound::Samples, 0.05).unwrap();
    assert!((found - 0.09).abs() < 1e-3, "{found} m");
}

#[test]
fn places_are_kept_of_the_samples_under_a_tile_alone_and_measure_the_same() {
    let heights = (0..900).map(|index| ((index % 30) as f32 * 0.7).sin() * 40.0 + (index / 30) as f32);
    let grid = raster(30, heights.collect());
    let mesh = sheet(&grid, [20.0; 4]);
    let geodetic = |p: DVec3| Geodetic {
        longitude: p.x,
        latitude: p.y,
        height: p.z,
    };
    let chunks = ChunksInMemory::new(grid.whole());
    let of_cells = |cells: [Range<usize>; 2]| {
        let certifier = Certifier::new(&grid.georeference, &chunks, Bound::Surface, &cells);
        let kept = certifier.separable.as_ref().unwrap();
        assert_eq!([kept.columns.len(), kept.rows.len()], cells.map(|range| range.len()));
        certifier.vertical_error(&mesh, geodetic, 0.0).unwrap()
    };
    let [all, few] = [of_cells([0..30, 0..30]), of_cells([12..20, 3..5])];
    assert!((all - few).abs() < 1e-6, "{all} {few}");
}

#[test]
fn samples_beyond_the_tip_of_a_thin_triangle_are_not_under_it() {
    let over = |beyond: f32| {
        let height = |index: usize| if index / 257 > 101 { beyond } else { 0.0 };
        let grid = raster(257, (0..257 * 257).map(height).collect());
        // A tenth of a millimetre wide, along a meridian.
        let places = [(128.0, 0.0), (128.0, 100.0), (128.0 + 1e-7, 50.0)];
        let corner = |(column, row): (f64, f64)| grid.georeference.geographic(DVec2::new(column, row)).extend(0.0);
        let mesh = Mesh {
            positions: places.map(corner).to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        error(&grid, &mesh, Bound::Samples)
    };
    assert_eq!(over(5000.0), over(0.0));
}
