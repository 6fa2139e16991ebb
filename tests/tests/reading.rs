//! Real rasters of many kinds, read.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::{Path, PathBuf};

use glam::DVec2;
use terrain_ingest::raster::Rasters;
use terrain_ingest::samples::{Overrides, Raster};
use terrain_ingest::{HeightGrid, ReadError, ReadOptions, raster};
use terrain_tests::{files_below, sample, shared_data};
use terrain_tiles::metadata::{HeightsAbove, Vertical};

fn read(paths: &[PathBuf]) -> Result<HeightGrid, ReadError> {
    raster::read(paths, &ReadOptions::default())
}

fn read_one(path: &Path) -> HeightGrid {
    read(&[path.to_owned()]).unwrap()
}

fn voids(grid: &HeightGrid) -> usize {
    grid.heights.iter().filter(|height| height.is_nan()).count()
}

/// Height of the surface at a longitude and a latitude, where there is one.
fn surface(grid: &HeightGrid, place: DVec2) -> Option<f64> {
    let at = grid.georeference.grid(place);
    let cell = at.floor();
    let is_there = grid.whole().cell_is_valid(cell.x as i64, cell.y as i64);
    is_there.then(|| grid.whole().height_near(at))?
}

fn range(grid: &HeightGrid) -> (f32, f32) {
    let heights = grid.heights.iter().copied();
    heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| {
        (low.min(height), high.max(height))
    })
}

#[test]
fn the_sample_lies_at_the_jacksboro_fault() {
    let grid = read_one(&sample("jacksboro_fault.tif"));
    assert_eq!((grid.columns, grid.rows, voids(&grid)), (403, 344, 0));
    assert_eq!(range(&grid), (236.0, 1076.0));
    let half = 0.5 / 1200.0;
    let first = grid.georeference.geographic(DVec2::ZERO);
    assert!(
        (first - DVec2::new(-84.413_75 + half, 36.446_25 - half)).length() < 1e-12,
        "{first}"
    );
    let [west, south, east, north] = grid.georeference.geographic_bounds();
    assert!((east - west - 402.0 / 1200.0).abs() < 1e-12 && (north - south - 343.0 / 1200.0).abs() < 1e-12);
    assert!(grid.georeference.is_geographic());
}

#[test]
fn a_zipped_tile_is_read_as_it_is() {
    let Some(path) = shared_data("srtm/1arcsec/N48W125.hgt.zip") else {
        return;
    };
    let grid = read_one(&path);
    assert_eq!((grid.columns, grid.rows, voids(&grid)), (3601, 3601, 6_483_876));
    assert_eq!(range(&grid), (-13.0, 1095.0));
    assert_eq!(grid.georeference.geographic_bounds(), [-125.0, 48.0, -124.0, 49.0]);
}

#[test]
fn pixel_is_point_and_pixel_is_area_put_samples_at_the_same_places() {
    let Some(folder) = shared_data("encodings") else { return };
    let area = read_one(&folder.join("jacksboro_none_strip_int16.tif"));
    let point = read_one(&folder.join("jacksboro_pixelispoint_int16.tif"));
    assert_eq!(area.heights, point.heights);
    let apart = area.georeference.geographic(DVec2::ZERO) - point.georeference.geographic(DVec2::ZERO);
    assert!(apart.length() < 1e-9, "{apart}");
    // A whole SRTM tile has samples on full degrees, whichever way it is written.
    for name in ["srtm/N49W124.tif", "srtm/N44E005.hgt", "srtm/mt_rainier_90m.tif"] {
        let Some(path) = shared_data(name) else { return };
        let bounds = read_one(&path).georeference.geographic_bounds();
        assert!(
            bounds.iter().all(|bound| (bound - bound.round()).abs() < 1e-9),
            "{name}: {bounds:?}"
        );
    }
}

#[test]
fn one_terrain_in_two_reference_systems_has_the_same_heights() {
    let (Some(degrees), Some(metres)) = (
        shared_data("srtm/N44E005.hgt"),
        shared_data("projected/N44E005_UTM31_90m.tif"),
    ) else {
        return;
    };
    let (degrees, metres) = (read_one(&degrees), read_one(&metres));
    let mut differences = Vec::new();
    for row in (0..metres.rows).step_by(7) {
        for column in (0..metres.columns).step_by(7) {
            let place = metres.georeference.geographic(DVec2::new(column as f64, row as f64));
            let expected = surface(&degrees, place);
            let height = metres.height(column, row);
            if let (Some(expected), false) = (expected, height.is_nan()) {
                differences.push(f64::from(height) - expected);
            }
        }
    }
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let spread = (differences
        .iter()
        .map(|difference| difference * difference)
        .sum::<f64>()
        / count)
        .sqrt();
    assert!(
        count > 20_000.0 && mean.abs() < 0.2 && spread < 3.0,
        "{count} places, {mean} ± {spread} m"
    );
    // Half a cell off would show: the slopes of the Ventoux make it a multiple.
    let shifted = shifted_spread(&degrees, &metres);
    assert!(shifted > 3.0 * spread, "{shifted} m against {spread} m");
}

/// Root mean square of the difference when one raster is moved by half a cell.
fn shifted_spread(degrees: &HeightGrid, metres: &HeightGrid) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for row in (0..metres.rows).step_by(11) {
        for column in (0..metres.columns).step_by(11) {
            let place = metres
                .georeference
                .geographic(DVec2::new(column as f64 + 0.5, row as f64 + 0.5));
            let height = f64::from(metres.height(column, row));
            if let (Some(expected), false) = (surface(degrees, place), height.is_nan()) {
                sum += (height - expected).powi(2);
                count += 1.0;
            }
        }
    }
    f64::sqrt(sum / count)
}

#[test]
fn feet_decimetres_scales_and_offsets_come_out_as_the_same_metres() {
    let Some(folder) = shared_data("vertical") else { return };
    let expected = read_one(&sample("jacksboro_fault.tif"));
    for (name, tolerance, datum) in [
        ("jacksboro_feet_unit_ft.tif", 1e-3, "unspecified"),
        ("jacksboro_decimetres_int16_scale0.1.tif", 1e-4, "unspecified"),
        ("jacksboro_uint16_scale0.1_offset-500.tif", 1e-4, "unspecified"),
        ("jacksboro_egm96_compound_crs.tif", 0.0, "EGM96"),
    ] {
        let path = folder.join(name);
        let grid = read_one(&path);
        let rasters = Rasters::open(&[path], &ReadOptions::default()).unwrap();
        let apart = grid
            .heights
            .iter()
            .zip(&expected.heights)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        assert!(apart <= tolerance, "{name}: {apart} m");
        assert_eq!(rasters.provenance().vertical_datum, datum, "{name}");
    }
}

/// Heights of the same cells above the geoid and above the ellipsoid, by another program.
#[test]
fn heights_above_the_geoid_become_those_above_the_ellipsoid() {
    let Some(folder) = shared_data("vertical") else { return };
    let expected = read_one(&folder.join("los_angeles_dem_ellipsoid.tif"));
    let vertical = Vertical {
        heights: HeightsAbove::Ellipsoid,
        datum: Some("egm2008".to_owned()),
        geoid: Some(folder.join("egm08_los_angeles.tif").display().to_string()),
    };
    let options = ReadOptions {
        overrides: Overrides {
            vertical,
            ..Overrides::default()
        },
        ..ReadOptions::default()
    };
    let found = raster::read(&[folder.join("los_angeles_dem_geoid.tif")], &options).unwrap();
    let apart = found.heights.iter().zip(&expected.heights).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f32::max);
    println!("largest difference: {apart} m");
    assert!(apart < 0.02, "{apart} m");
}

#[test]
fn adjacent_tiles_become_one_grid() {
    let Some(folder) = shared_data("srtm") else { return };
    let paths = ["N49W124.tif", "N49W123.tif"].map(|name| folder.join(name));
    let grid = read(&paths).unwrap();
    assert_eq!((grid.columns, grid.rows), (2401, 1201));
    // The shared column has four voids, in both files.
    assert_eq!(voids(&grid), 25_620 + 34_926 - 4);
    let bounds = grid.georeference.geographic_bounds();
    let expected = [-124.0, 49.0, -122.0, 50.0];
    assert!(
        bounds
            .iter()
            .zip(expected)
            .all(|(bound, expected)| (bound - expected).abs() < 1e-9),
        "{bounds:?}"
    );
}

#[test]
fn halves_across_the_antimeridian_are_the_whole() {
    let Some(folder) = shared_data("antimeridian") else {
        return;
    };
    let whole = read_one(&folder.join("etopo5_fiji_170E_190E.tif"));
    let halves = ["etopo5_fiji_west_170E_180.tif", "etopo5_fiji_east_180_170W.tif"].map(|name| folder.join(name));
    let joined = read(&halves).unwrap();
    assert_eq!((joined.columns, joined.rows), (whole.columns, whole.rows));
    assert_eq!(joined.heights, whole.heights);
    assert_eq!(joined.georeference.geographic_bounds(), [170.0, -25.0, 190.0, -10.0]);
}

#[test]
fn rotated_and_upside_down_rasters_are_where_they_are() {
    let Some(folder) = shared_data("encodings") else { return };
    let upright = read_one(&folder.join("jacksboro_none_strip_int16.tif"));
    let flipped = read_one(&folder.join("jacksboro_southup_int16.tif"));
    for (column, row) in [(0, 0), (17, 91), (199, 159)] {
        let place = upright.georeference.geographic(DVec2::new(column as f64, row as f64));
        let grid = flipped.georeference.grid(place);
        assert!(
            (grid - DVec2::new(column as f64, (159 - row) as f64)).length() < 1e-6,
            "{grid}"
        );
        assert_eq!(
            flipped.height(grid.x.round() as usize, grid.y.round() as usize),
            upright.height(column, row)
        );
    }
    let rotated = read_one(&folder.join("jacksboro_rotated20deg_int16.tif"));
    let apart = rotated.georeference.geographic(DVec2::X) - rotated.georeference.geographic(DVec2::ZERO);
    let angle = apart.y.atan2(apart.x).to_degrees().abs();
    assert!((angle - 20.0).abs() < 0.1, "{angle}°");
}

#[test]
fn every_projection_is_invertible_all_over_its_raster() {
    let Some(folder) = shared_data("projected") else { return };
    for path in files_below(&folder) {
        let grid = read_one(&path);
        assert!(!grid.georeference.is_geographic(), "{}", path.display());
        for corner in [
            (0, 0),
            (grid.columns - 1, 0),
            (0, grid.rows - 1),
            (grid.columns / 2, grid.rows - 1),
        ] {
            let corner = DVec2::new(corner.0 as f64, corner.1 as f64);
            let again = grid.georeference.grid(grid.georeference.geographic(corner));
            assert!(
                (again - corner).length() < 1e-7,
                "{}: {corner} → {again}",
                path.display()
            );
        }
    }
}

#[test]
fn odd_and_damaged_files_give_a_grid_or_one_line() {
    for folder in [
        "corrupt",
        "odd_tiff",
        "nodata",
        "formats",
        "encodings",
        "polar",
        "global",
    ] {
        let Some(folder) = shared_data(folder) else { return };
        for path in files_below(&folder) {
            match read(std::slice::from_ref(&path)) {
                Ok(grid) => assert!(voids(&grid) < grid.heights.len(), "{}", path.display()),
                Err(error) => {
                    let message = error.to_string();
                    assert!(message.lines().count() == 1 && message.len() < 400, "{message}");
                }
            }
        }
    }
}

#[test]
fn an_exr_height_map_is_the_window_that_it_was_cut_from() {
    let (Some(window), Some(whole)) = (
        shared_data("heightmaps/aconcagua_257_metres_f32_Y.exr"),
        shared_data("srtm/S33W071.tif"),
    ) else {
        return;
    };
    let options = ReadOptions {
        overrides: Overrides {
            crs: Some("EPSG:4326".to_owned()),
            bounds: Some([-70.213_75, -32.760_416_666_666_664, -69.999_583_333_333_33, -32.546_25]),
            ..Overrides::default()
        },
        ..ReadOptions::default()
    };
    let (window, whole) = (raster::read(&[window], &options).unwrap(), read_one(&whole));
    assert_eq!(
        (window.columns, window.rows, range(&window)),
        (257, 257, (2627.0, 6929.0))
    );
    for (column, row) in [(0, 0), (256, 0), (100, 201), (256, 256)] {
        let place = window.georeference.geographic(DVec2::new(column as f64, row as f64));
        let grid = whole.georeference.grid(place);
        assert!((grid - grid.round()).length() < 1e-6, "{grid}");
        assert_eq!(
            whole.height(grid.x.round() as usize, grid.y.round() as usize),
            window.height(column, row),
            "{grid}"
        );
    }
}

#[test]
fn exr_files_of_other_programs_are_read() {
    let Some(folder) = shared_data("heightmaps") else {
        return;
    };
    let options = ReadOptions {
        overrides: Overrides {
            crs: Some("EPSG:32631".to_owned()),
            bounds: Some([500_000.0, 4_000_000.0, 500_100.0, 4_000_100.0]),
            ..Overrides::default()
        },
        ..ReadOptions::default()
    };
    for name in [
        "aconcagua_257_normalised_f16_R_piz.exr",
        "mountain1.exr",
        "peak2.exr",
        "terrain1.exr",
    ] {
        let (low, high) = range(&raster::read(&[folder.join(name)], &options).unwrap());
        assert!(low.is_finite() && high > low, "{name}: {low} … {high}");
    }
}
