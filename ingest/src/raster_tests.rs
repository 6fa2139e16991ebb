#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::{fs, slice};

use exr::prelude::{AnyChannel, AnyChannels, Encoding, Layer, LayerAttributes};
use exr::prelude::{FlatSamples, Image, WritableImage};
use gdal::raster::{Buffer, GdalType};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DriverManager, Metadata};
use glam::DVec2;
use tempfile::TempDir;

use super::*;

/// A folder with rasters for one test.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        drivers::prepare_gdal(false);
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A GeoTIFF in EPSG:4326, `columns` wide, with half-degree pixels from 10° east, 50° north; `change` may alter it.
    pub(crate) fn tiff<T: GdalType + Copy>(
        &self,
        name: &str,
        columns: usize,
        values: &[T],
        change: impl FnOnce(&mut Dataset),
    ) -> PathBuf {
        let path = self.path(name);
        let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
        let rows = values.len() / columns;
        let mut dataset = driver.create_with_band_type::<T, _>(&path, columns, rows, 1).unwrap();
        dataset.set_geo_transform(&[10.0, 0.5, 0.0, 50.0, 0.0, -0.5]).unwrap();
        dataset.set_spatial_ref(&SpatialRef::from_epsg(4326).unwrap()).unwrap();
        change(&mut dataset);
        let mut buffer = Buffer::new((columns, rows), values.to_vec());
        dataset
            .rasterband(1)
            .unwrap()
            .write((0, 0), (columns, rows), &mut buffer)
            .unwrap();
        path
    }
}

fn read_one(path: PathBuf) -> Result<HeightGrid, ReadError> {
    read(&[path], &ReadOptions::default())
}

pub(crate) fn assert_heights(grid: &HeightGrid, expected: &[f32]) {
    assert_eq!(grid.heights.len(), expected.len());
    for (index, (height, expected)) in grid.heights.iter().zip(expected).enumerate() {
        assert!(
            height == expected || height.is_nan() && expected.is_nan(),
            "{index}: {height}, not {expected}"
        );
    }
}

#[test]
fn samples_are_at_pixel_centres() {
    let folder = Folder::new();
    let path = folder.tiff("a.tif", 3, &[1_i16, 2, 3, 4, 5, 6], |_| {});
    let provenance = Rasters::open(slice::from_ref(&path), &ReadOptions::default())
        .unwrap()
        .provenance();
    let grid = read_one(path).unwrap();
    assert_eq!((grid.columns, grid.rows), (3, 2));
    assert_eq!(grid.georeference.geographic(DVec2::ZERO), DVec2::new(10.25, 49.75));
    assert_eq!(
        grid.georeference.geographic(DVec2::new(2.0, 1.0)),
        DVec2::new(11.25, 49.25)
    );
    assert_eq!(grid.height(2, 1), 6.0);
    assert_eq!(
        (provenance.vertical_datum.as_str(), grid.georeference.crs_name()),
        ("unspecified", "EPSG:4326")
    );
    assert_eq!(provenance.files, ["a.tif"]);
}

#[test]
fn a_pixel_is_point_file_has_its_samples_at_the_same_places() {
    let folder = Folder::new();
    let as_point = |dataset: &mut Dataset| dataset.set_metadata_item("AREA_OR_POINT", "Point", "").unwrap();
    let grid = read_one(folder.tiff("a.tif", 2, &[1_i16, 2, 3, 4], as_point)).unwrap();
    // GDAL writes the tie point half a pixel off for such files, and takes the half back when it reads.
    assert_eq!(grid.georeference.geographic(DVec2::ZERO), DVec2::new(10.25, 49.75));
}

#[test]
fn nodata_is_void_however_it_is_said() {
    let folder = Folder::new();
    let nodata = |value: f64| {
        move |dataset: &mut Dataset| dataset.rasterband(1).unwrap().set_no_data_value(Some(value)).unwrap()
    };
    let void = f32::NAN;
    let tagged = folder.tiff("tag.tif", 2, &[1_i16, -32768, 3, 4], nodata(-32768.0));
    assert_heights(&read_one(tagged).unwrap(), &[1.0, void, 3.0, 4.0]);
    let float = folder.tiff(
        "float.tif",
        2,
        &[1.5_f32, f32::MIN, f32::NAN, 4.0],
        nodata(f64::from(f32::MIN)),
    );
    assert_heights(&read_one(float).unwrap(), &[1.5, void, void, 4.0]);
    let undeclared = folder.tiff("wild.tif", 2, &[1.5_f32, f32::INFINITY, 1e38, -1e5], |_| {});
    assert_heights(&read_one(undeclared).unwrap(), &[1.5, void, void, void]);
    let zero = folder.tiff("zero.tif", 2, &[0_u8, 7, 0, 9], nodata(0.0));
    assert_heights(&read_one(zero).unwrap(), &[void, 7.0, void, 9.0]);
}

#[test]
fn undeclared_voids_are_found_and_what_the_person_says_goes_before_that() {
    let folder = Folder::new();
    let void = f32::NAN;
    let path = folder.tiff("undeclared.tif", 3, &[120_i16, -9999, 340, 410, -9999, 99], |_| {});
    let read_with = |nodata: Option<Vec<f64>>| {
        let mut options = ReadOptions::default();
        options.overrides.reading.nodata = nodata;
        read(slice::from_ref(&path), &options).unwrap()
    };
    assert_heights(&read_with(None), &[120.0, void, 340.0, 410.0, void, 99.0]);
    assert_heights(&read_with(Some(vec![])), &[120.0, -9999.0, 340.0, 410.0, -9999.0, 99.0]);
    assert_heights(
        &read_with(Some(vec![99.0, 340.0])),
        &[120.0, -9999.0, void, 410.0, -9999.0, void],
    );
    // Besides those that a file declares.
    let declares = |dataset: &mut Dataset| dataset.rasterband(1).unwrap().set_no_data_value(Some(-1.0)).unwrap();
    let path = folder.tiff("declared.tif", 2, &[120_i16, -9999, -1, 410], declares);
    assert_heights(&read_one(path).unwrap(), &[120.0, void, void, 410.0]);
    // In single precision, said in decimals.
    let path = folder.tiff("float.tif", 2, &[1.5_f32, -0.1, 3.0, 4.0], |_| {});
    let mut options = ReadOptions::default();
    options.overrides.reading.nodata = Some(vec![-0.1]);
    assert_heights(&read(&[path], &options).unwrap(), &[1.5, void, 3.0, 4.0]);
}

#[test]
fn samples_that_are_transparent_are_voids() {
    let folder = Folder::new();
    let path = folder.path("alpha.tif");
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let options = gdal::raster::RasterCreationOptions::from_iter(["ALPHA=YES"]);
    let mut dataset = driver
        .create_with_band_type_with_options::<u16, _>(&path, 2, 2, 2, &options)
        .unwrap();
    dataset.set_geo_transform(&[10.0, 0.5, 0.0, 50.0, 0.0, -0.5]).unwrap();
    dataset.set_spatial_ref(&SpatialRef::from_epsg(4326).unwrap()).unwrap();
    for (band, values) in [(1, [1_u16, 2, 3, 4]), (2, [u16::MAX, 0, u16::MAX, u16::MAX])] {
        let mut buffer = Buffer::new((2, 2), values.to_vec());
        dataset
            .rasterband(band)
            .unwrap()
            .write((0, 0), (2, 2), &mut buffer)
            .unwrap();
    }
    drop(dataset);
    assert_heights(&read_one(path).unwrap(), &[1.0, f32::NAN, 3.0, 4.0]);
}

/// A height map of 3 × 3 samples of 16 bits.
fn raw(folder: &Folder, name: &str, bytes_of: impl Fn(u16) -> [u8; 2]) -> PathBuf {
    let path = folder.path(name);
    let bytes: Vec<u8> = (0..9_u16).flat_map(|index| bytes_of(index * 8000 + 1535)).collect();
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn raw_height_maps_are_local_ground_in_their_range_of_heights() {
    let folder = Folder::new();
    let mut options = ReadOptions::default();
    options.overrides.reading.height_range = Some([-100.0, 555.35]);
    options.overrides.reading.local = true;
    options.overrides.reading.pixel_size = Some([2.0, 3.0]);
    let little = read(&[raw(&folder, "a.r16", u16::to_le_bytes)], &options).unwrap();
    let big = raw(&folder, "b.raw", u16::to_be_bytes);
    options.overrides.reading.big_endian = true;
    let big = read(slice::from_ref(&big), &options).unwrap();
    let expected: Vec<f32> = (0..9).map(|index| 80.0 * index as f32 - 84.65).collect();
    for (grid, expected) in [&little, &big]
        .into_iter()
        .flat_map(|grid| grid.heights.iter().zip(&expected))
    {
        assert!((grid - expected).abs() < 1e-4, "{grid}, not {expected}");
    }
    assert_eq!(
        little.georeference.crs_coordinates(DVec2::new(2.0, 0.0)),
        DVec2::new(4.0, 6.0)
    );
    assert_eq!(little.georeference.crs_coordinates(DVec2::new(0.0, 2.0)), DVec2::ZERO);
    let odd = folder.path("odd.r16");
    fs::write(&odd, [0; 20]).unwrap();
    let refusal = read(&[odd], &options).unwrap_err().to_string();
    assert!(refusal.contains("20 bytes are no square"), "{refusal}");
}

#[test]
fn a_range_of_heights_is_that_of_what_can_be_stored() {
    let folder = Folder::new();
    let mut options = ReadOptions::default();
    options.overrides.reading.height_range = Some([1000.0, 2000.0]);
    let byte = folder.tiff("byte.tif", 2, &[0_u8, 51, 102, 255], |_| {});
    assert_heights(&read(&[byte], &options).unwrap(), &[1000.0, 1200.0, 1400.0, 2000.0]);
    let float = folder.tiff("float.tif", 2, &[0.0_f32, 0.25, 0.5, 1.0], |_| {});
    assert_heights(&read(&[float], &options).unwrap(), &[1000.0, 1250.0, 1500.0, 2000.0]);
}

#[test]
fn scale_offset_and_unit_make_metres() {
    let folder = Folder::new();
    let scaled = folder.tiff("scaled.tif", 2, &[10_i16, 20, -32768, 0], |dataset| {
        let mut band = dataset.rasterband(1).unwrap();
        band.set_scale(0.5).unwrap();
        band.set_offset(-100.0).unwrap();
        band.set_no_data_value(Some(-32768.0)).unwrap();
    });
    assert_heights(&read_one(scaled).unwrap(), &[-95.0, -90.0, f32::NAN, -100.0]);
    assert_eq!(units::metres_in("US survey foot"), Some(1200.0 / 3937.0));
    assert_eq!(units::metres_in(" FT "), Some(0.3048));
    assert_eq!(units::metres_in("metre"), Some(1.0));
    assert_eq!(units::metres_in("furlong"), None);
}

#[test]
fn the_unit_of_the_vertical_reference_system_is_applied_once_and_that_of_the_person_before_it() {
    let folder = Folder::new();
    let in_feet = |dataset: &mut Dataset| {
        let feet = SpatialRef::from_definition("EPSG:2232+8228").unwrap();
        dataset.set_spatial_ref(&feet).unwrap();
        dataset
            .set_geo_transform(&[3_100_000.0, 100.0, 0.0, 1_700_000.0, 0.0, -100.0])
            .unwrap();
    };
    let path = folder.tiff("feet.tif", 2, &[10_i16, 20, 30, 40], in_feet);
    let mut options = ReadOptions::default();
    let foot = 0.3048_f32;
    let grid = read(slice::from_ref(&path), &options).unwrap();
    assert_heights(&grid, &[10.0, 20.0, 30.0, 40.0].map(|feet: f32| feet * foot));
    options.overrides.reading.unit = Some(0.1);
    assert_heights(&read(&[path], &options).unwrap(), &[1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn every_kind_of_unusable_raster_has_its_message() {
    let folder = Folder::new();
    let junk = folder.path("junk.tif");
    fs::write(&junk, b"II*\0 this is no raster").unwrap();
    let values = [1_i16, 2, 3, 4];
    let nodata = |dataset: &mut Dataset| dataset.rasterband(1).unwrap().set_no_data_value(Some(7.0)).unwrap();
    let cases = [
        (junk, "cannot be read"),
        (folder.path("absent.tif"), "No such file"),
        (folder.0.path().to_owned(), "not a file"),
        (PathBuf::from("/vsizip/a.zip/b.tif"), "refused"),
        (PathBuf::from("<VRTDataset/>"), "refused"),
        (folder.tiff("thin.tif", 1, &values, |_| {}), "1 × 4 samples"),
        (folder.tiff("void.tif", 2, &[7_i16; 4], nodata), "every sample is void"),
        (bare(&folder, "bare.tif"), "no coordinate reference system; pass --crs"),
    ];
    for (path, message) in cases {
        let error = read_one(path).unwrap_err().to_string();
        assert!(error.contains(message) && error.lines().count() == 1, "{error}");
    }
    assert!(matches!(read(&[], &ReadOptions::default()), Err(ReadError::NoFile)));
}

/// A TIFF without a reference system and position.
fn bare(folder: &Folder, name: &str) -> PathBuf {
    let path = folder.path(name);
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let dataset = driver.create_with_band_type::<f32, _>(&path, 4, 2, 1).unwrap();
    let mut buffer = Buffer::new((4, 2), vec![1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    dataset
        .rasterband(1)
        .unwrap()
        .write((0, 0), (4, 2), &mut buffer)
        .unwrap();
    path
}

#[test]
fn the_caller_can_say_where_a_raster_is() {
    let folder = Folder::new();
    let path = bare(&folder, "bare.tif");
    let options = ReadOptions {
        overrides: Overrides {
            crs: Some("EPSG:4326".to_owned()),
            bounds: Some([-8.0, 1.0, -4.0, 2.0]),
            ..Overrides::default()
        },
        ..ReadOptions::default()
    };
    let grid = read(slice::from_ref(&path), &options).unwrap();
    assert_eq!(grid.georeference.geographic_bounds(), [-7.5, 1.25, -4.5, 1.75]);
    let mut without_bounds = options.clone();
    without_bounds.overrides.bounds = None;
    assert!(matches!(
        read(slice::from_ref(&path), &without_bounds),
        Err(ReadError::NoPosition(_))
    ));
    let mut unordered = options.clone();
    unordered.overrides.bounds = Some([8.0, 1.0, 4.0, 2.0]);
    assert!(matches!(
        read(slice::from_ref(&path), &unordered),
        Err(ReadError::BadBounds(_))
    ));
    let mut unknown = options;
    unknown.overrides.crs = Some("EPSG:999999".to_owned());
    assert!(matches!(read(&[path], &unknown), Err(ReadError::UnknownCrs(_))));
}

#[test]
fn limits_hold_before_memory_is_taken() {
    let folder = Folder::new();
    let path = folder.tiff("a.tif", 3, &[1_i16, 2, 3, 4, 5, 6], |_| {});
    let few_samples = RasterLimits {
        samples: 5,
        ..RasterLimits::default()
    };
    let small_blocks = RasterLimits {
        block_bytes: 11,
        ..RasterLimits::default()
    };
    for limits in [few_samples, small_blocks] {
        let options = ReadOptions {
            limits,
            ..ReadOptions::default()
        };
        assert!(
            matches!(read(slice::from_ref(&path), &options), Err(ReadError::TooLarge { .. })),
            "{limits:?}"
        );
    }
    // Two small files far apart: the grid over both is what is too large.
    let at = |dataset: &mut Dataset| dataset.set_geo_transform(&[110.0, 0.5, 0.0, 50.0, 0.0, -0.5]).unwrap();
    let far = folder.tiff("far.tif", 3, &[1_i16, 2, 3, 4, 5, 6], at);
    let limits = RasterLimits {
        samples: 300,
        ..RasterLimits::default()
    };
    let options = ReadOptions {
        limits,
        ..ReadOptions::default()
    };
    assert!(matches!(read(&[path, far], &options), Err(ReadError::TooLarge { .. })));
}

#[test]
fn a_virtual_raster_cannot_make_gdal_read_other_files() {
    let folder = Folder::new();
    let path = folder.tiff("a.tif", 2, &[1_i16, 2, 3, 4], |_| {});
    let source = path.display();
    let vrt = format!(
        r#"<VRTDataset rasterXSize="2" rasterYSize="2"><SRS>EPSG:4326</SRS><GeoTransform>0,1,0,0,0,-1</GeoTransform>
        <VRTRasterBand dataType="Int16" band="1"><SimpleSource><SourceFilename>{source}</SourceFilename>
        <SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"#
    );
    for name in ["sly.vrt", "sly.tif"] {
        fs::write(folder.path(name), &vrt).unwrap();
        let error = read_one(folder.path(name)).unwrap_err();
        assert!(matches!(error, ReadError::Unreadable { .. }), "{name}: {error}");
    }
    let refusal = read_one(folder.path("sly.vrt")).unwrap_err().to_string();
    assert!(refusal.contains("--allow-vrt"), "{refusal}");
    let mut options = ReadOptions::default();
    options.overrides.reading.allow_vrt = true;
    let asked = read(&[folder.path("sly.vrt")], &options).unwrap();
    assert_heights(&asked, &[1.0, 2.0, 3.0, 4.0]);
    // It stays with who asked.
    assert!(read_one(folder.path("sly.tif")).is_err());
}

/// CRC-32 as zip files have it (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    let divide = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes
        .iter()
        .fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), divide))
}

/// A zip file of files as they are (APPNOTE 4.3), by names and content.
fn zip(files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let size = (content.len() as u32).to_le_bytes();
        let place = (bytes.len() as u32).to_le_bytes();
        let name_length = [name.len() as u8, 0, 0, 0];
        let common = [
            &[20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0][..],
            &crc(content).to_le_bytes(),
            &size,
            &size,
            &name_length,
        ]
        .concat();
        bytes.extend([&b"PK\x03\x04"[..], &common, name.as_bytes(), content].concat());
        directory.extend([&b"PK\x01\x02\x14\0"[..], &common, &[0; 10], &place, name.as_bytes()].concat());
    }
    let [count, _] = (files.len() as u16).to_le_bytes();
    let counts = [0, 0, 0, 0, count, 0, count, 0];
    let (size, place) = (
        (directory.len() as u32).to_le_bytes(),
        (bytes.len() as u32).to_le_bytes(),
    );
    [&bytes[..], &directory, b"PK\x05\x06", &counts, &size, &place, &[0, 0]].concat()
}

#[test]
fn a_zip_file_with_one_raster_is_that_raster() {
    let folder = Folder::new();
    let tiff = fs::read(folder.tiff("a.tif", 2, &[1_i16, 2, 3, 4], |_| {})).unwrap();
    let named = |name, files: &[(&str, Vec<u8>)]| {
        let path = folder.path(name);
        fs::write(&path, zip(files)).unwrap();
        read_one(path)
    };
    let read_me = ("README.txt", b"Heights of a place.".to_vec());
    let one = named("one.zip", &[read_me.clone(), ("dem/a.tif", tiff.clone())]).unwrap();
    assert_heights(&one, &[1.0, 2.0, 3.0, 4.0]);
    for (name, files, reason) in [
        (
            "two.zip",
            vec![("a.tif", tiff.clone()), ("b.tif", tiff)],
            "it holds 2 rasters; unpack it",
        ),
        ("none.zip", vec![read_me], "it holds no raster"),
    ] {
        let refusal = named(name, &files).unwrap_err().to_string();
        assert!(refusal.contains(reason), "{refusal}");
    }
    fs::write(folder.path("junk.zip"), b"PK no archive").unwrap();
    assert!(matches!(
        read_one(folder.path("junk.zip")),
        Err(ReadError::Unreadable { .. })
    ));
}

#[test]
fn an_exr_height_map_is_read_where_the_caller_says_it_is() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let heights = FlatSamples::F32(vec![1.0, 2.0, 3.0, 4.0, f32::NAN, 6.25]);
    let channels = AnyChannels::sort([AnyChannel::new("Z", heights)].into_iter().collect());
    let layer = Layer::new(
        (3, 2),
        LayerAttributes::named("terrain"),
        Encoding::FAST_LOSSLESS,
        channels,
    );
    Image::from_layer(layer).write().to_file(&path).unwrap();
    let options = ReadOptions {
        overrides: Overrides {
            crs: Some("EPSG:32631".to_owned()),
            bounds: Some([500_000.0, 4_000_000.0, 500_030.0, 4_000_020.0]),
            ..Overrides::default()
        },
        ..ReadOptions::default()
    };
    let grid = read(slice::from_ref(&path), &options).unwrap();
    assert_heights(&grid, &[1.0, 2.0, 3.0, 4.0, f32::NAN, 6.25]);
    assert_eq!(
        grid.georeference.crs_coordinates(DVec2::ZERO),
        DVec2::new(500_005.0, 4_000_015.0)
    );
    assert!(matches!(read_one(path.clone()), Err(ReadError::NoCrs(_))));
    let limits = RasterLimits {
        samples: 5,
        ..RasterLimits::default()
    };
    assert!(matches!(
        read(
            slice::from_ref(&path),
            &ReadOptions {
                limits,
                ..options.clone()
            }
        ),
        Err(ReadError::TooLarge { .. })
    ));
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    assert!(matches!(read(&[path], &options), Err(ReadError::Unreadable { .. })));
}
