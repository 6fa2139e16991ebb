//! Readers against each other: what the one without GDAL reads is what GDAL reads, or is refused by name.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::{Path, PathBuf};

use glam::DVec2;
use terrain_ingest::{HeightGrid, ReadError, ReadOptions, raster};
use terrain_tests::{files_below, random_numbers, sample, shared_data};
use terrain_tiles::metadata::RasterReader;

/// Files that the reader of GeoTIFF reads, of those that GDAL reads too, at least.
const READ: usize = 85;

fn read(path: &Path, reader: RasterReader) -> Result<HeightGrid, ReadError> {
    let mut options = ReadOptions::default();
    options.overrides.reading.reader = Some(reader);
    raster::read(&[path.to_owned()], &options)
}

/// Whether both read the same samples at the same places; what the one without GDAL says where it refuses.
fn compare(path: &Path) -> Result<(), String> {
    let name = path.display();
    let by_tiff = read(path, RasterReader::Tiff).map_err(|error| error.to_string())?;
    let by_gdal = read(path, RasterReader::Gdal).unwrap_or_else(|error| panic!("GDAL refuses: {error}"));
    assert_eq!(
        (by_tiff.columns, by_tiff.rows),
        (by_gdal.columns, by_gdal.rows),
        "{name}"
    );
    for (index, (ours, theirs)) in by_tiff.heights.iter().zip(&by_gdal.heights).enumerate() {
        let is_same = ours == theirs || ours.is_nan() && theirs.is_nan();
        assert!(is_same, "{name}: sample {index} is {ours}, by GDAL {theirs}");
    }
    let corner = DVec2::new(by_gdal.columns as f64 - 1.0, by_gdal.rows as f64 - 1.0);
    for grid in [DVec2::ZERO, corner, corner / 3.0] {
        let [ours, theirs] = [&by_tiff, &by_gdal].map(|read| read.georeference.geographic(grid));
        assert!(
            (ours - theirs).length() < 1e-11,
            "{name}: {grid} is at {ours}, by GDAL {theirs}"
        );
    }
    Ok(())
}

#[test]
fn the_sample_is_the_same_by_both() {
    assert_eq!(compare(&sample("jacksboro_fault.tif")), Ok(()));
}

#[test]
fn geotiff_is_the_same_without_gdal_or_refused_by_name() {
    let mut paths: Vec<PathBuf> = Vec::new();
    for folder in ["encodings", "odd_tiff", "projected", "vertical", "cases"] {
        let Some(folder) = shared_data(folder) else { return };
        paths.extend(files_below(&folder));
    }
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "tif"));
    let mut same = 0;
    for path in &paths {
        match compare(path) {
            Ok(()) => same += 1,
            Err(refusal) => {
                let file = path.file_name().unwrap().to_string_lossy().into_owned();
                assert!(refusal.contains(&file) && refusal.lines().count() == 1, "{refusal}");
                println!("{refusal}");
            }
        }
    }
    println!("{same} of {} files are the same by both", paths.len());
    assert!(same >= READ, "{same}");
}

/// Bytes changed anywhere, or, every other time, near the ends, where headers and directories are.
fn damaged(whole: &[u8], random: &mut impl Iterator<Item = f64>) -> Vec<u8> {
    const NEAR: usize = 600;
    let mut below = |limit: usize| (random.next().unwrap() * limit as f64) as usize;
    let mut bytes = whole.to_vec();
    for _ in 0..1 + below(4) {
        let at = match below(4) {
            0 => below(NEAR),
            1 => whole.len() - 1 - below(NEAR),
            _ => below(whole.len()),
        };
        bytes[at] = below(256) as u8;
    }
    if below(8) == 0 {
        bytes.truncate(below(whole.len()));
    }
    bytes
}

/// Whether what a reader of ours reads of damaged copies is a grid or one line; how many were refused.
fn refused_of_damaged(whole: &[u8], name: &str, copies: usize, options: &ReadOptions) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let mut random = random_numbers(7);
    let refuses = |_: &usize| {
        std::fs::write(&path, damaged(whole, &mut random)).unwrap();
        let read = raster::read(std::slice::from_ref(&path), options);
        read.is_err_and(|error| {
            let line = error.to_string();
            assert!(line.lines().count() == 1, "{line}");
            true
        })
    };
    (0..copies).filter(refuses).count()
}

#[test]
fn damaged_geotiffs_are_read_or_refused_without_gdal() {
    let mut options = ReadOptions::default();
    options.overrides.reading.reader = Some(RasterReader::Tiff);
    let whole = std::fs::read(sample("jacksboro_fault.tif")).unwrap();
    let refused = refused_of_damaged(&whole, "a.tif", 100, &options);
    println!("{refused} of 100 are refused");
    assert!((10..95).contains(&refused), "{refused}");
    for name in [
        "jacksboro_lzw_pred2_tiled_int16",
        "jacksboro_bigtiff_lzw_int16",
        "jacksboro_sparse_missing_tile_int16",
    ] {
        let Some(path) = shared_data(&format!("encodings/{name}.tif")) else {
            return;
        };
        let refused = refused_of_damaged(&std::fs::read(path).unwrap(), "a.tif", 100, &options);
        println!("{refused} of 100 of {name} are refused");
    }
}

#[test]
fn damaged_exr_files_are_read_or_refused() {
    let mut options = ReadOptions::default();
    options.overrides.reading.pixel_size = Some([1.0, 1.0]);
    let Some(path) = shared_data("heightmaps/aconcagua_257_normalised_f16_R_piz.exr") else {
        return;
    };
    let refused = refused_of_damaged(&std::fs::read(path).unwrap(), "a.exr", 100, &options);
    println!("{refused} of 100 are refused");
}

#[test]
fn what_is_no_geotiff_is_refused() {
    let Some(path) = shared_data("formats/n43.dt0") else {
        return;
    };
    let refusal = read(&path, RasterReader::Tiff).unwrap_err().to_string();
    assert!(refusal.contains("n43.dt0: cannot be read"), "{refusal}");
    let refusal = read(&path, RasterReader::Exr).unwrap_err().to_string();
    assert!(refusal.contains("n43.dt0: cannot be read"), "{refusal}");
}
