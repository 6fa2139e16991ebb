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
use terrain_codec::ellipsoid::to_geodetic;
use terrain_codec::{LevelLimits, spt};
use terrain_heights::{Frame, Heights, Place};
use terrain_ingest::{HeightGrid, ReadOptions, raster};
use terrain_tests::{program, random_numbers, sample, workspace};
use terrain_tiles::archive::Reader;

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

/// Frames: in the middle of the sample, at its side, and 400 km north-west of it, where the vertical leans by almost 4°.
const FRAMES: [[f64; 3]; 3] = [[-84.2, 36.3, 250.0], [-84.39, 36.11, -40.0], [-88.0, 38.5, 0.0]];

/// Places in plan that lines come down at, beside the sample, too.
fn plan(frame: &Frame, count: usize) -> Vec<[f64; 2]> {
    let place = |[longitude, latitude]: [f64; 2]| {
        let above = Frame::at(longitude, latitude, 500.0).unwrap().origin - frame.origin;
        let local = frame.axes.transpose() * above;
        [local.x, local.y]
    };
    places(count).into_iter().map(place).collect()
}

/// The triangles of the finest surfaces of a zoom, Earth-centred.
fn decoded(zoom: u8) -> Vec<[DVec3; 3]> {
    let archive = Reader::open(&ARCHIVE.1).unwrap();
    let of_zoom = archive.addresses().filter(|address| address.zoom == zoom);
    of_zoom
        .flat_map(|address| {
            let tile = spt::decode(&archive.tile(address).unwrap().unwrap(), &LevelLimits::default()).unwrap();
            let mesh = tile.surface(tile.finest());
            let positions: Vec<DVec3> = mesh.positions.iter().map(|&at| tile.earth_centred(at)).collect();
            let corners = mesh.triangles.into_iter();
            corners
                .map(move |triangle| triangle.map(|vertex| positions[vertex as usize]))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Metres up in the frame of the highest of the triangles over a place in plan, and its normal, in the frame's own coordinates.
fn highest(triangles: &[[DVec3; 3]], [east, north]: [f64; 2]) -> Option<(f64, DVec3)> {
    let at = DVec3::new(east, north, 0.0);
    let of_triangle = |&[a, b, c]: &[DVec3; 3]| {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        if at.x < low.x || at.x > high.x || at.y < low.y || at.y > high.y {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let area = |p: DVec3, q: DVec3| (p - at).cross(q - at).z;
        let is_inside = [area(a, b), area(b, c), area(c, a)]
            .iter()
            .all(|area| area * normal.z.signum() >= 0.0);
        let up = a.z - ((east - a.x) * normal.x + (north - a.y) * normal.y) / normal.z;
        is_inside.then(|| (up, normal.normalize()))
    };
    triangles
        .iter()
        .filter_map(of_triangle)
        .max_by(|one, other| one.0.total_cmp(&other.0))
}

#[test]
fn in_a_frame_heights_are_where_its_vertical_meets_the_decoded_triangles() {
    let heights = open(1 << 30);
    for zoom in [7, 11, heights.finest_zoom()] {
        let decoded = decoded(zoom);
        for [longitude, latitude, height] in FRAMES {
            let frame = Frame::at(longitude, latitude, height).unwrap();
            let into_frame = |at: DVec3| frame.axes.transpose() * (at - frame.origin);
            let triangles: Vec<[DVec3; 3]> = decoded.iter().map(|triangle| triangle.map(into_frame)).collect();
            let mut measured = 0;
            for place in plan(&frame, 1_000) {
                let found = heights.in_frame(&frame, place[0], place[1], zoom).unwrap();
                match (found, highest(&triangles, place)) {
                    (Place::Measured(point, _), Some((up, normal))) => {
                        assert!(
                            (point.height - up).abs() < 1e-5,
                            "zoom {zoom}, {place:?}: {point:?} {up}"
                        );
                        // On an edge it is that of the one or the other.
                        measured += usize::from(point.normal.distance(normal) < 1e-6);
                    }
                    (Place::Void | Place::Outside, None) => {}
                    other => panic!("zoom {zoom}, {place:?}: {other:?}"),
                }
            }
            assert!(measured > 900, "{measured}");
        }
    }
}

#[test]
fn in_a_frame_the_source_is_as_near_along_its_vertical_as_is_said() {
    let heights = open(1 << 30);
    let [west, south, east, north] = DEM.georeference.geographic_bounds();
    for [longitude, latitude, height] in FRAMES {
        let frame = Frame::at(longitude, latitude, height).unwrap();
        let mut worst = 0_f64;
        for place in plan(&frame, 5_000) {
            let Place::Measured(point, error) = heights.in_frame(&frame, place[0], place[1], u8::MAX).unwrap() else {
                continue;
            };
            let above = |up: f64| {
                let at = frame.origin + frame.axes * DVec3::new(place[0], place[1], up);
                let at = to_geodetic(at);
                let is_inside = (west..=east).contains(&at.longitude) && (south..=north).contains(&at.latitude);
                is_inside.then(|| at.height - dem(at.longitude, at.latitude))
            };
            // The source is met between two points of the line if one of them is above it and the other below.
            let (Some(below), Some(over)) = (above(point.height - error), above(point.height + error)) else {
                continue;
            };
            assert!(
                below <= 0.0 && over >= 0.0,
                "{place:?}: {point:?} {error} {below} {over}"
            );
            worst = worst.max(1.0 - over.min(-below) / error);
        }
        assert!(worst > 0.5, "the claim is far from what is: {worst}");
    }
}

#[test]
fn in_a_frame_at_a_place_heights_are_those_of_the_place() {
    let heights = open(1 << 30);
    for [longitude, latitude] in places(300) {
        let frame = Frame::at(longitude, latitude, 1_000.0).unwrap();
        let in_frame = heights.in_frame(&frame, 0.0, 0.0, u8::MAX).unwrap();
        let (Place::Measured(one, one_error), Place::Measured(other, other_error)) =
            (in_frame, heights.at(longitude, latitude, u8::MAX).unwrap())
        else {
            panic!("{in_frame:?}");
        };
        assert!((one.height + 1_000.0 - other.height).abs() < 1e-5, "{one:?} {other:?}");
        assert!(
            (one_error - other_error).abs() < 1e-6 * other_error,
            "{one_error} {other_error}"
        );
    }
    let frame = Frame::at(-84.2, 36.3, 0.0).unwrap();
    for [east, north] in [[0.0, 60e3], [8_000e3, 0.0], [f64::NAN, 0.0], [0.0, f64::INFINITY]] {
        assert_eq!(heights.in_frame(&frame, east, north, u8::MAX).unwrap(), Place::Outside);
    }
    assert!(Frame::at(0.0, 90.1, 0.0).is_none() && Frame::at(f64::NAN, 0.0, 0.0).is_none());
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
    let frame = Frame::at(-88.0, 38.5, 0.0).unwrap();
    let plan = plan(&frame, 1_000);
    let all = |heights: &Heights| -> Vec<Place> {
        let at = places
            .iter()
            .map(|&[longitude, latitude]| heights.at(longitude, latitude, u8::MAX));
        let in_frame = plan
            .iter()
            .map(|&[east, north]| heights.in_frame(&frame, east, north, u8::MAX));
        at.chain(in_frame).map(Result::unwrap).collect()
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
    for &[east, north] in &plan {
        heights.in_frame(&frame, east, north, u8::MAX).unwrap();
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
    let frame = Frame::at(-84.6, 36.15, 0.0).unwrap();
    let mut measured = 0;
    for line in text.lines().skip(1) {
        let words: Vec<&str> = line.split(' ').collect();
        let numbers: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        if let [longitude, latitude, height, error, _, _, _, east, north, up, up_error] = numbers[..] {
            assert!((height - dem(longitude, latitude)).abs() <= error + 1e-4, "{line}");
            let there = Frame::at(longitude, latitude, height).unwrap().origin - frame.origin;
            assert!(
                (frame.axes.transpose() * there).distance(DVec3::new(east, north, up)) < 1e-3,
                "{line}"
            );
            assert!((error..1.1 * error).contains(&(up_error + 1e-4)), "{line}");
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
