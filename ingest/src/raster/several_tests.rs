//! Several rasters become one.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::PathBuf;
use std::slice;

use gdal::Dataset;
use glam::DVec2;
use terrain_tiles::metadata::Fill;

use super::tests::{Folder, assert_heights};
use super::*;

#[test]
fn files_side_by_side_become_one_grid_with_gaps_void() {
    let folder = Folder::new();
    let at =
        |x: f64, y: f64| move |dataset: &mut Dataset| dataset.set_geo_transform(&[x, 0.5, 0.0, y, 0.0, -0.5]).unwrap();
    let west = folder.tiff("west.tif", 2, &[1_i16, 2, 3, 4], at(10.0, 50.0));
    let east = folder.tiff("east.tif", 2, &[20_i16, 5, 40, 6], at(10.5, 49.5));
    let mut options = ReadOptions::default();
    options.overrides.reading.blend = Some(0.0);
    let grid = read(&[west, east], &options).unwrap();
    let void = f32::NAN;
    assert_eq!((grid.columns, grid.rows), (3, 3));
    assert_heights(&grid, &[1.0, 2.0, void, 3.0, 4.0, 5.0, void, 40.0, 6.0]);
    assert_eq!(grid.georeference.geographic(DVec2::ZERO), DVec2::new(10.25, 49.75));
}

#[test]
fn where_files_overlap_and_differ_the_first_counts_and_the_difference_is_kept() {
    let folder = Folder::new();
    let at = |x: f64| move |dataset: &mut Dataset| dataset.set_geo_transform(&[x, 0.5, 0.0, 50.0, 0.0, -0.5]).unwrap();
    let a = folder.tiff("a.tif", 3, &[1.0_f32, 2.0, 3.0, 4.0, f32::NAN, 6.0], at(10.0));
    let b = folder.tiff("b.tif", 3, &[2.005_f32, 10.0, 30.0, 5.0, 6.0, 60.0], at(10.5));
    let mut options = ReadOptions::default();
    options.overrides.reading.blend = Some(0.0);
    let rasters = Rasters::open(&[a, b], &options).unwrap();
    let read = rasters.read(0..4, 0..2).unwrap();
    assert_eq!(read.heights, [1.0, 2.0, 3.0, 30.0, 4.0, 5.0, 6.0, 60.0]);
    let of_b = Faults {
        disagreeing: 1,
        apart: 7.0,
        ..Faults::default()
    };
    assert_eq!(read.faults, [Faults::default(), of_b]);
}

#[test]
fn a_file_without_a_place_on_the_plane_of_the_first_is_refused_by_name() {
    let folder = Folder::new();
    let polar = folder.tiff("polar.tif", 3, &[1.0_f32; 9], |dataset| {
        dataset
            .set_geo_transform(&[-1500.0, 1000.0, 0.0, 1500.0, 0.0, -1000.0])
            .unwrap();
        dataset
            .set_spatial_ref(&gdal::spatial_ref::SpatialRef::from_epsg(3031).unwrap())
            .unwrap();
    });
    let far = folder.tiff("far.tif", 3, &[1.0_f32; 9], |dataset| {
        dataset
            .set_geo_transform(&[-180.0, 60.0, 0.0, 90.0, 0.0, -60.0])
            .unwrap();
    });
    let refused = Rasters::open(&[polar, far], &ReadOptions::default()).err().unwrap();
    assert!(refused.to_string().contains("no place for it"), "{refused}");
}

#[test]
fn files_across_the_antimeridian_are_neighbours() {
    let folder = Folder::new();
    let at = |x: f64| move |dataset: &mut Dataset| dataset.set_geo_transform(&[x, 0.5, 0.0, 5.0, 0.0, -0.5]).unwrap();
    let west = folder.tiff("west.tif", 2, &[1_i16, 2, 3, 4], at(179.0));
    let east = folder.tiff("east.tif", 2, &[5_i16, 6, 7, 8], at(-180.0));
    for (paths, heights) in [
        ([west.clone(), east.clone()], [1.0, 2.0, 5.0, 6.0, 3.0, 4.0, 7.0, 8.0]),
        ([east, west], [1.0, 2.0, 5.0, 6.0, 3.0, 4.0, 7.0, 8.0]),
    ] {
        let grid = read(&paths, &ReadOptions::default()).unwrap();
        assert_heights(&grid, &heights);
        assert_eq!(grid.georeference.geographic_bounds(), [179.25, 4.25, 180.75, 4.75]);
    }
}

/// A plane over degrees, so that heights between samples are known whatever the cells.
fn plane(
    folder: &Folder,
    name: &str,
    [west, north, step]: [f64; 3],
    size: usize,
    tilt: fn(f64, f64) -> f64,
) -> PathBuf {
    let at = |index: usize| {
        let (column, row) = ((index % size) as f64 + 0.5, (index / size) as f64 + 0.5);
        tilt(west + column * step, north - row * step) as f32
    };
    let heights: Vec<f32> = (0..size * size).map(at).collect();
    folder.tiff(name, size, &heights, |dataset| {
        dataset
            .set_geo_transform(&[west, step, 0.0, north, 0.0, -step])
            .unwrap();
    })
}

#[test]
fn the_finest_raster_has_the_lattice_and_counts_and_others_are_read_between_their_samples() {
    let folder = Folder::new();
    let tilt = |x: f64, y: f64| 100.0 * (x - 10.0) + 30.0 * (y - 50.0);
    let coarse = plane(&folder, "coarse.tif", [10.0, 50.0, 0.3], 10, tilt);
    let fine = plane(&folder, "fine.tif", [11.0, 49.0, 0.07], 9, |x, y| {
        100.0 * (x - 10.0) + 30.0 * (y - 50.0) + 500.0
    });
    let mut options = ReadOptions::default();
    options.overrides.reading.blend = Some(0.0);
    let grid = read(&[coarse, fine], &options).unwrap();
    let (mut of_fine, mut of_coarse) = (0, 0);
    for (index, &height) in grid.heights.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
        let place = DVec2::new((index % grid.columns) as f64, (index / grid.columns) as f64);
        let at = grid.georeference.geographic(place);
        let off = f64::from(height) - tilt(at.x, at.y);
        let is_fine = (11.0..11.63).contains(&at.x) && (48.37..49.0).contains(&at.y);
        // Half a cell beyond the outermost samples, heights are those of these.
        let is_inside = (10.15..12.85).contains(&at.x) && (47.15..49.85).contains(&at.y);
        if is_fine {
            of_fine += 1;
            assert!((off - 500.0).abs() < 1e-3, "{at}: {off}");
        } else if is_inside {
            of_coarse += 1;
            assert!(off.abs() < 1e-3, "{at}: {off}");
        }
    }
    assert_eq!(of_fine, 81);
    assert!(of_coarse > 1000, "{of_coarse}");
}

#[test]
fn heights_in_a_rectangle_do_not_depend_on_it() {
    let folder = Folder::new();
    let fine = plane(&folder, "fine.tif", [11.0, 49.0, 0.05], 24, |x, y| {
        40.0 * x * x - 70.0 * y
    });
    let coarse = plane(&folder, "coarse.tif", [10.5, 49.5, 0.21], 12, |x, y| {
        38.0 * x * x - 69.0 * y
    });
    let mut options = ReadOptions::default();
    options.overrides.reading.fill = Some(Fill { widest: Some(40_000.0) });
    let rasters = Rasters::open(&[fine, coarse], &options).unwrap();
    let [columns, rows] = rasters.size();
    let whole = rasters.read(0..columns, 0..rows).unwrap().heights;
    for [left, right, top, bottom] in [[0, 9, 0, 7], [5, 21, 8, 30], [15, columns, 11, rows], [20, 21, 20, 21]] {
        let part = rasters.read(left..right, top..bottom).unwrap().heights;
        for (row, heights) in (top..bottom).zip(part.chunks_exact(right - left)) {
            let there = &whole[row * columns + left..row * columns + right];
            let is_same = |(a, b): (&f32, &f32)| a == b || (a.is_nan() && b.is_nan());
            assert!(heights.iter().zip(there).all(is_same), "{left} {top}, row {row}");
        }
    }
}

#[test]
fn an_underlay_counts_last_and_reaches_as_far_as_asked() {
    let folder = Folder::new();
    let site = plane(&folder, "site.tif", [11.0, 49.0, 0.1], 10, |_, _| 10.0);
    let country = plane(&folder, "country.tif", [0.0, 60.0, 0.05], 500, |_, _| 10.0);
    let mut options = ReadOptions::default();
    options.overrides.reading.underlay = vec![country.display().to_string()];
    let grid = read(slice::from_ref(&site), &options).unwrap();
    assert_eq!([grid.columns, grid.rows], [20, 20]);
    assert!(grid.heights.iter().all(|&height| height == 10.0));
    options.overrides.reading.around = Some(7000.0);
    let rasters = Rasters::open(&[site], &options).unwrap();
    let cells = rasters.georeference().cell_metres(DVec2::ZERO);
    assert_eq!(rasters.size(), [12, 12], "{cells}");
    assert_eq!(rasters.provenance().files, ["site.tif"]);
}
