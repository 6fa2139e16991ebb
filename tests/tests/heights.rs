//! The library of heights, from Rust and from C: as near to the raster as it says, the same for all threads, without allocating.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]
#![expect(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::thread;

use glam::DVec3;
use tempfile::TempDir;
use terrain_heights::{Heights, Place};
use terrain_ingest::{HeightGrid, ReadOptions, raster};
use terrain_tests::{program, random_numbers, sample, workspace};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: it does what the system's does.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The sample as an archive.
static ARCHIVE: LazyLock<(TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("sample.pmtiles");
    let mut command = Command::new(program());
    command.arg(sample("jacksboro_fault.tif")).arg("-o").arg(&path);
    assert!(
        command
            .args(["--max-error", "10", "--quiet"])
            .output()
            .unwrap()
            .status
            .success()
    );
    (folder, path)
});

static DEM: LazyLock<HeightGrid> =
    LazyLock::new(|| raster::read(&[sample("jacksboro_fault.tif")], &ReadOptions::default()).unwrap());

fn open(cache_bytes: u64) -> Heights {
    Heights::open(&ARCHIVE.1, cache_bytes).unwrap()
}

/// Bilinear between samples, whose rows and columns are those of longitudes and latitudes here.
fn dem(longitude: f64, latitude: f64) -> f64 {
    let [west, south, east, north] = DEM.georeference.geographic_bounds();
    let x = (longitude - west) / (east - west) * (DEM.columns - 1) as f64;
    let y = (north - latitude) / (north - south) * (DEM.rows - 1) as f64;
    let (column, row) = ((x as usize).min(DEM.columns - 2), (y as usize).min(DEM.rows - 2));
    let (u, v) = (x - column as f64, y - row as f64);
    let at = |right: usize, down: usize| f64::from(DEM.heights[(row + down) * DEM.columns + column + right]);
    (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(1, 0)) + v * ((1.0 - u) * at(0, 1) + u * at(1, 1))
}

fn places(count: usize) -> Vec<[f64; 2]> {
    let [west, south, east, north] = DEM.georeference.geographic_bounds();
    let mut numbers = random_numbers(3);
    let mut within = move |low: f64, high: f64| low + (high - low) * (0.001 + 0.998 * numbers.next().unwrap());
    (0..count).map(|_| [within(west, east), within(south, north)]).collect()
}

#[test]
fn heights_are_as_near_to_the_raster_as_is_said() {
    let heights = open(1 << 30);
    for zoom in [8, 10, u8::MAX] {
        let mut worst = 0_f64;
        for [longitude, latitude] in places(20_000) {
            let Place::Measured(point, error) = heights.at(longitude, latitude, zoom).unwrap() else {
                panic!("no ground at {longitude} {latitude}");
            };
            let off = (point.height - dem(longitude, latitude)).abs();
            assert!(off <= error, "zoom {zoom}: {off} {error}");
            assert!((point.normal.length() - 1.0).abs() < 1e-12 && point.normal.z > 0.0);
            worst = worst.max(off / error);
        }
        assert!(worst > 0.5, "zoom {zoom}: the claim is far from what is: {worst}");
    }
}

#[test]
fn the_normal_is_that_of_the_surface() {
    let heights = open(1 << 30);
    let height = |longitude: f64, latitude: f64| match heights.at(longitude, latitude, u8::MAX).unwrap() {
        Place::Measured(point, _) => point,
        other => panic!("{other:?}"),
    };
    let step = 1e-7;
    let mut steep = 0;
    let mut wrong = 0;
    for [longitude, latitude] in places(500) {
        let point = height(longitude, latitude);
        let metres = 111_320.0 * step;
        let across = height(longitude + step, latitude).height - point.height;
        let up = height(longitude, latitude + step).height - point.height;
        let east = DVec3::new(metres * latitude.to_radians().cos(), 0.0, across);
        let north = DVec3::new(0.0, metres, up);
        // Where an edge is between the places, they say nothing.
        wrong += usize::from(east.cross(north).normalize().angle_between(point.normal) > 0.01);
        steep += usize::from(point.normal.z < 0.95);
    }
    assert!(wrong < 5 && steep > 100, "{wrong} {steep}");
}

#[test]
fn outside_is_outside_whatever_number_says_it() {
    let heights = open(1 << 30);
    for [longitude, latitude] in [
        [0.0, 0.0],
        [f64::NAN, 36.0],
        [-84.2, 91.0],
        [-84.2, f64::INFINITY],
        [f64::INFINITY, 0.0],
    ] {
        assert_eq!(
            heights.at(longitude, latitude, 9).unwrap(),
            Place::Outside,
            "{longitude} {latitude}"
        );
    }
    // A turn further on, a longitude has fewer bits.
    let [here, around] = [-84.2, 275.8].map(|longitude| match heights.at(longitude, 36.3, 9).unwrap() {
        Place::Measured(point, _) => point.height,
        other => panic!("{other:?}"),
    });
    assert!((here - around).abs() < 1e-6, "{here} {around}");
    assert!(Heights::open(Path::new("/nowhere.pmtiles"), 1).is_err());
}

#[test]
fn many_threads_and_a_small_cache_give_the_same_and_a_warm_one_allocates_nothing() {
    let places = places(5_000);
    let all = |heights: &Heights| -> Vec<Place> {
        places
            .iter()
            .map(|&[longitude, latitude]| heights.at(longitude, latitude, u8::MAX).unwrap())
            .collect()
    };
    let heights = open(1 << 30);
    let expected = all(&heights);
    let small = open(1 << 20);
    thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| all(&small))).collect();
        threads
            .into_iter()
            .for_each(|thread| assert_eq!(thread.join().unwrap(), expected));
    });
    let before = ALLOCATIONS.with(Cell::get);
    for &[longitude, latitude] in &places {
        heights.at(longitude, latitude, u8::MAX).unwrap();
    }
    assert_eq!(ALLOCATIONS.with(Cell::get), before);
}

#[test]
fn the_header_is_that_of_the_library() {
    let of_crate = workspace().join("heights");
    let config = cbindgen::Config::from_file(of_crate.join("cbindgen.toml")).unwrap();
    let mut made = Vec::new();
    let source = of_crate.join("src/capi.rs");
    cbindgen::Builder::new()
        .with_config(config)
        .with_src(source)
        .generate()
        .unwrap()
        .write(&mut made);
    let header = of_crate.join("include/terrain_heights.h");
    if env::var_os("TERRAIN_WRITE_HEADER").is_some() {
        std::fs::write(&header, &made).unwrap();
    }
    let made = String::from_utf8(made).unwrap();
    assert_eq!(
        std::fs::read_to_string(header).unwrap(),
        made,
        "TERRAIN_WRITE_HEADER=1 writes it"
    );
}

#[test]
fn the_example_in_c_is_compiled_and_runs() {
    let (of_crate, folder) = (workspace().join("heights"), TempDir::new().unwrap());
    let example = folder.path().join("profile");
    let libraries = env::current_exe().unwrap().parent().unwrap().to_owned();
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic"]);
    compiler
        .arg("-I")
        .arg(of_crate.join("include"))
        .arg(of_crate.join("examples/profile.c"));
    compiler
        .arg("-L")
        .arg(&libraries)
        .args(["-lterrain_heights", "-o"])
        .arg(&example);
    assert!(compiler.status().unwrap().success());
    let run = |arguments: &[&str]| {
        let mut command = Command::new(&example);
        command
            .env("LD_LIBRARY_PATH", &libraries)
            .args(arguments)
            .output()
            .unwrap()
    };
    let done = run(&[ARCHIVE.1.to_str().unwrap(), "-84.6", "36.15", "-83.9", "36.45", "200"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = String::from_utf8(done.stdout).unwrap();
    let mut measured = 0;
    for line in text.lines().skip(1) {
        let words: Vec<&str> = line.split(' ').collect();
        let numbers: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        if let [longitude, latitude, height, error, ..] = numbers[..] {
            assert!((height - dem(longitude, latitude)).abs() <= error + 1e-4, "{line}");
            measured += 1;
        } else {
            assert_eq!(words[2], "outside", "{line}");
        }
    }
    assert!((80..120).contains(&measured), "{measured}");
    let failed = run(&["/nowhere.pmtiles", "0", "0", "1", "1", "2"]);
    assert_eq!(failed.status.code(), Some(1));
    assert!(String::from_utf8(failed.stderr).unwrap().contains("/nowhere.pmtiles"));
}
