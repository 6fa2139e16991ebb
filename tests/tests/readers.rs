//! Readers against each other: what the one without GDAL reads is what GDAL reads, or is refused by name.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::{Path, PathBuf};

use glam::DVec2;
use terrain_ingest::{HeightGrid, ReadError, ReadOptions, raster};
use terrain_tests::{files_below, sample, shared_data};
use terrain_tiles::metadata::RasterReader;

/// Files that the reader of GeoTIFF reads, of those that GDAL reads too, at least.
const READ: usize = 100;

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
    for folder in [
        "encodings",
        "odd_tiff",
        "srtm",
        "projected",
        "vertical",
        "cases",
        "nodata",
    ] {
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
