//! Samples that GDAL reads for us against those that the `tiff` crate, another decoder, reads from the same files.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fs::File;
use std::path::Path;

use terrain_ingest::{ReadOptions, raster};
use terrain_tests::{sample, shared_data};
use tiff::decoder::{Decoder, DecodingResult};

fn decode(path: &Path) -> (usize, Vec<f64>) {
    let mut decoder = Decoder::new(File::open(path).unwrap()).unwrap();
    let (width, _) = decoder.dimensions().unwrap();
    let values = match decoder.read_image().unwrap() {
        DecodingResult::U8(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::U16(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::I16(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::I32(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::F32(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::F64(values) => values,
        _ => panic!("{}: an unexpected sample type", path.display()),
    };
    (width as usize, values)
}

/// Compares every sample; returns how many of ours are void.
fn compare(path: &Path) -> usize {
    let grid = raster::read(&[path.to_owned()], &ReadOptions::default()).unwrap();
    let (width, values) = decode(path);
    assert_eq!(
        (width, values.len()),
        (grid.columns, grid.heights.len()),
        "{}",
        path.display()
    );
    let solid = grid.heights.iter().zip(&values).filter(|(height, _)| !height.is_nan());
    for (index, (height, value)) in solid.enumerate() {
        assert_eq!(f64::from(*height), *value, "{}: sample {index}", path.display());
    }
    grid.heights.iter().filter(|height| height.is_nan()).count()
}

#[test]
fn the_sample_is_what_the_file_says() {
    assert_eq!(compare(&sample("jacksboro_fault.tif")), 0);
}

#[test]
fn every_encoding_has_the_same_terrain() {
    let Some(folder) = shared_data("encodings") else { return };
    let names = [
        "bigendian_deflate_pred2_int16",
        "bigendian_none_float32",
        "bigtiff_lzw_int16",
        "deflate_pred3_float32",
        "deflate_pred3_float64_tiled",
        "lzw_pred2_tiled_int16",
        "none_strip_int16",
        "none_tiled64_int16",
        "packbits_int16",
        "zstd_pred2_int32",
        "zstd_pred3_float32",
    ];
    for name in names {
        assert_eq!(compare(&folder.join(format!("jacksboro_{name}.tif"))), 0, "{name}");
    }
}

#[test]
fn voids_are_voids_and_nothing_else_is() {
    let Some(folder) = shared_data("srtm") else { return };
    for (name, voids) in [
        ("N49W124.tif", 25_620),
        ("N49W123.tif", 34_926),
        ("S33W071.tif", 0),
        ("N46E008.tif", 103_743),
    ] {
        assert_eq!(compare(&folder.join(name)), voids, "{name}");
    }
}
