#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::PathBuf;

use gdal::raster::Buffer;
use gdal::spatial_ref::SpatialRef;
use gdal::{DriverManager, GeoTransform};
use tempfile::TempDir;

use super::*;
use crate::chunks::ChunkedRaster;
use crate::intake::Intake;
use crate::progress::Progress;
use crate::raster::{Rasters, ReadOptions};
use crate::samples::Samples;

fn tiff(
    folder: &TempDir,
    name: &str,
    [columns, rows]: [usize; 2],
    epsg: u32,
    to_crs: GeoTransform,
    height: impl Fn(usize, usize) -> f32,
) -> PathBuf {
    let path = folder.path().join(name);
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let mut dataset = driver.create_with_band_type::<f32, _>(&path, columns, rows, 1).unwrap();
    dataset.set_geo_transform(&to_crs).unwrap();
    dataset.set_spatial_ref(&SpatialRef::from_epsg(epsg).unwrap()).unwrap();
    let heights = (0..columns * rows).map(|index| height(index % columns, index / columns));
    let mut buffer = Buffer::new((columns, rows), heights.collect());
    let mut band = dataset.rasterband(1).unwrap();
    band.write((0, 0), (columns, rows), &mut buffer).unwrap();
    path
}

/// A site of 10 m in a rough country of 190 m by 250 m or so, with a void; the country is in degrees or in the site's metres.
fn site_in_country(folder: &TempDir, is_in_degrees: bool) -> [PathBuf; 2] {
    let country = |column: usize, row: usize| {
        let hash = (column * 7919 + row * 104_729 + column * row * 31) % 997;
        let is_void = (120..122).contains(&column) && (98..100).contains(&row);
        if is_void {
            f32::NAN
        } else {
            400.0 + hash as f32 / 10.0 + (column as f32 / 5.0).sin() * 300.0
        }
    };
    let site = tiff(
        folder,
        "site.tif",
        [300, 300],
        32632,
        [400_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0],
        |c, r| 500.0 + ((c * r) % 13) as f32,
    );
    let country = if is_in_degrees {
        let to_crs = [7.55, 0.0025, 0.0, 47.05, 0.0, -0.00225];
        tiff(folder, "country.tif", [130, 110], 4326, to_crs, country)
    } else {
        let to_crs = [389_003.0, 190.0, 0.0, 5_211_007.0, 0.0, -250.0];
        tiff(folder, "country.tif", [130, 110], 32632, to_crs, country)
    };
    [site, country]
}

fn taken(rasters: &Rasters, store: &Store) -> ChunkedRaster {
    let intake = Intake::new(rasters, store);
    let taken = intake.take(&intake.bands(), &Progress::silent()).unwrap();
    assert!(taken.interpolated.len() > 10, "{} chunks", taken.interpolated.len());
    assert!(taken.names.len() > 4, "{} stored chunks", taken.names.len());
    ChunkedRaster::new(rasters, store, taken, 1 << 24).unwrap()
}

#[test]
fn heights_and_bounds_of_a_country_around_a_site_are_those_of_all_its_samples_on_the_lattice() {
    for is_in_degrees in [true, false] {
        let folder = TempDir::new().unwrap();
        let store = Store::open(&folder.path().join("store").display().to_string()).unwrap();
        let rasters = Rasters::open(&site_in_country(&folder, is_in_degrees), &ReadOptions::default()).unwrap();
        let chunked = taken(&rasters, &store);
        chunked.make_relief(&Progress::silent()).unwrap();
        let [columns, rows] = Raster::size(&rasters);
        let whole = rasters.read(0..columns, 0..rows).unwrap().heights;
        let before = chunked.before();
        let window = chunked
            .window(before[0]..before[0] + columns, before[1]..before[1] + rows)
            .unwrap();
        for (index, (made, read)) in window.heights.iter().zip(&whole).enumerate() {
            let place = [index % columns, index / columns];
            let is_same = made.is_nan() && read.is_nan() || (made - read).abs() < 1e-3;
            assert!(is_same, "{place:?}: {made} instead of {read}");
        }
        check_relief(&chunked, rasters.origin(), &window.heights, [columns, rows]);
    }
}

/// Each block's bound holds all samples in it, and is not much wider than it must be.
fn check_relief(chunked: &ChunkedRaster, origin: [i64; 2], heights: &[f32], [columns, rows]: [usize; 2]) {
    let mut widths = [0.0, 0.0];
    let mut seen = 0;
    for level in 1..=4 {
        for id in chunked.chunks_of(level) {
            let chunk = chunked.chunk_at(id).unwrap().unwrap();
            if chunk.computed.is_none() {
                continue;
            }
            let (side, of_chunk) = (1 << level, first_of(origin, id));
            for block in (0..CHUNK * CHUNK).step_by(37) {
                let (across, down) = (block % CHUNK, block / CHUNK);
                let first = [of_chunk[0] + (across * side) as i64, of_chunk[1] + (down * side) as i64];
                let [a, b, c, d] = chunk.patch(across, down);
                let [least, greatest] = chunk.residual(across, down).map(f64::from);
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for index in 0..(side + 1) * (side + 1) {
                    let (s, t) = (index % (side + 1), index / (side + 1));
                    let (column, row) = (first[0] + s as i64, first[1] + t as i64);
                    assert!((0..columns as i64).contains(&column) && (0..rows as i64).contains(&row));
                    let [s, t] = [s, t].map(|step| step as f64 / side as f64);
                    let patch = (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t;
                    let above = f64::from(heights[row as usize * columns + column as usize]) - patch;
                    (low, high) = (low.min(above), high.max(above));
                }
                assert!(
                    least <= low && high <= greatest,
                    "{id:?} {block}: {low} … {high} beyond {least} … {greatest}"
                );
                widths = [widths[0] + high - low, widths[1] + greatest - least];
                seen += 1;
            }
        }
    }
    assert!(seen > 1000, "{seen} blocks");
    assert!(widths[1] < 6.0 * widths[0] + 0.01 * f64::from(seen), "{widths:?}");
}

#[test]
fn an_underlay_that_goes_on_beyond_the_rectangle_ends_with_it() {
    let folder = TempDir::new().unwrap();
    let store = Store::open(&folder.path().join("store").display().to_string()).unwrap();
    let [site, country] = site_in_country(&folder, true);
    let mut options = ReadOptions::default();
    options.overrides.reading.underlay = vec![country.display().to_string()];
    options.overrides.reading.around = Some(8000.0);
    let rasters = Rasters::open(&[site], &options).unwrap();
    let intake = Intake::new(&rasters, &store);
    let taken = intake.take(&intake.bands(), &Progress::silent()).unwrap();
    assert!(!taken.interpolated.is_empty());
    let size = Raster::size(&rasters).map(|samples| samples as i64);
    for &id in taken.interpolated.keys() {
        let first = first_of(rasters.origin(), id);
        let is_inside = |axis: usize| first[axis] >= 0 && first[axis] + CHUNK as i64 <= size[axis];
        assert!(is_inside(0) && is_inside(1), "{id:?} at {first:?} of {size:?}");
    }
}

/// Blocks no wider than a file's cells, wherever they are on it and however rough it is.
#[test]
fn a_bound_holds_all_of_the_ground_between_samples_as_rough_as_they_may_be() {
    const STEP: usize = 16;
    let mut random = fastrand::Rng::with_seed(5);
    let mut closest: f64 = f64::INFINITY;
    for _ in 0..20_000 {
        let heights = (0..16).map(|_| random.i32(-1000..1000) as f32).collect();
        let first = DVec2::new(random.f64(), random.f64());
        let across = DVec2::new(0.3 + 0.7 * random.f64(), random.f64() - 0.5);
        let down = DVec2::new(-across.y, across.x);
        let first = first + DVec2::new(0.5, 0.0);
        let nodes = vec![first, first + across, first + down, first + across + down];
        let blocks = FollowingBlocks {
            window: OwnWindow {
                columns: 0..4,
                rows: 0..4,
                heights,
            },
            places: Places {
                nodes,
                across: 2,
                apart: STEP,
            },
            step: STEP,
            bent: DVec2::ZERO,
            rounding: 1e-3,
        };
        let [a, b, c, d] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| f64::from(blocks.corner(x, y)));
        let [least, greatest] = blocks.residual(0, 0).map(f64::from);
        for (column, row) in (0..STEP).flat_map(|row| (0..STEP).map(move |column| (column, row))) {
            let [s, t] = [column, row].map(|step| step as f64 / STEP as f64);
            let patch = (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t;
            let above = blocks.window.height(blocks.places.at(column, row)) - patch;
            assert!(
                least <= above && above <= greatest,
                "{above} beyond {least} … {greatest}"
            );
            closest = closest.min((greatest - above).min(above - least));
        }
    }
    assert!(closest < 5.0, "the nearest comes as near as {closest}");
}
