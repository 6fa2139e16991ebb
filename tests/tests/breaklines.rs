//! Lines that surfaces keep as edges, through files and the command line: whatever they are, `verify` finds them in every tile.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;
use terrain_tests::random_lines::random_lines;
use terrain_tests::random_raster::RandomRaster;
use terrain_tests::{program, sample, workspace};

/// How many rasters with lines every run of the tests makes.
const RASTERS: u64 = 60;
/// Others that were once refuted: over a pole, beside the tip of a steep triangle, along a tile's side, of lines 7° long.
const ONCE_REFUTED: [u64; 6] = [119, 127, 203, 233, 282, 292];

/// Exit code and what the program printed.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = Command::new(program())
        .args(arguments)
        .args(["--quiet", "--jobs", "1"])
        .current_dir(folder)
        .output()
        .unwrap();
    let printed = [output.stdout, output.stderr].concat();
    (output.status.code().unwrap_or(-1), String::from_utf8(printed).unwrap())
}

/// What is wrong with an archive or a mesh of a random raster with random lines, if anything is.
fn fault_of(seed: u64, folder: &Path) -> Option<String> {
    let raster = RandomRaster::new(seed);
    if !raster.has_surface() {
        return None;
    }
    let files = raster.write(folder).unwrap();
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    let lines = random_lines(&raster, seed);
    fs::write(folder.join("lines.geojson"), lines.to_string()).unwrap();
    let options: Vec<&str> = raster.options.iter().map(String::as_str).collect();
    let with_lines = ["--breaklines", "lines.geojson"];
    let (code, text) = run(
        folder,
        &[&files[..], &["-o", "out.pmtiles"], &options[..], &with_lines].concat(),
    );
    if code != 0 {
        return Some(format!("not built: exit {code}: {text}"));
    }
    let (code, text) = run(folder, &[&["verify", "out.pmtiles"], &files[..], &with_lines].concat());
    let violation = text.lines().find(|line| line.contains("violation: ")).unwrap_or(&text);
    (code != 0).then(|| format!("refuted: exit {code}: {violation}"))
}

fn told(seed: u64, fault: &str) -> String {
    let raster = RandomRaster::new(seed);
    let (place, relief, voids, options) = (raster.place, raster.relief, raster.voids, &raster.options);
    format!(
        "{place:?} {relief:?} {voids:?} {options:?}\n  {}\n  TERRAIN_SEED={seed} cargo test -p terrain-tests --test breaklines -- \
         --ignored one_seed",
        fault.trim_end()
    )
}

fn check(seeds: impl Iterator<Item = u64>) {
    let seeds: Vec<u64> = seeds.collect();
    let faults: Vec<String> = seeds
        .par_iter()
        .filter_map(|&seed| {
            let folder = tempfile::tempdir().unwrap();
            fault_of(seed, folder.path()).map(|fault| told(seed, &fault))
        })
        .collect();
    let count = seeds.len();
    assert!(
        faults.is_empty(),
        "{} of {count} rasters:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

#[test]
fn lines_of_every_kind_are_kept_by_archives_that_hold() {
    check((0..RASTERS).chain(ONCE_REFUTED));
}

/// `TERRAIN_RASTERS` says how many, after those of every run.
#[test]
#[ignore = "takes as long as one likes"]
fn many_rasters_with_lines() {
    let count = env::var("TERRAIN_RASTERS").map_or(500, |count| count.parse().unwrap());
    check(RASTERS..RASTERS + count);
}

/// Leaves the files of the seed `TERRAIN_SEED` in `target/random-breaklines`.
#[test]
#[ignore = "repeats what another test found"]
fn one_seed() {
    let seed: u64 = env::var("TERRAIN_SEED").unwrap().parse().unwrap();
    let folder = workspace().join("target/random-breaklines");
    fs::create_dir_all(&folder).unwrap();
    if let Some(fault) = fault_of(seed, &folder) {
        panic!("{}", told(seed, &fault));
    }
}

/// A road across the sample data, and what is made of it by a change.
fn road(folder: &Path, name: &str, bend: f64) {
    let line = format!(
        r#"{{"type": "LineString", "coordinates": [[-84.4, 36.2], [-84.25, {}], [-84.1, 36.4]]}}"#,
        36.3 + bend
    );
    fs::write(folder.join(name), line).unwrap();
}

#[test]
fn a_mesh_has_the_line_that_a_mesh_without_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let dem = sample("jacksboro_fault.tif");
    let dem = dem.to_str().unwrap();
    road(folder.path(), "road.geojson", 0.0);
    let lines = ["--breaklines", "road.geojson"];
    for (name, quality, is_kept) in [("with.ply", "best", true), ("without.ply", "best", false)] {
        let tin = ["tin", dem, "--max-error", "50", "--quality", quality, "-o", name];
        let asked: &[&str] = if is_kept { &lines } else { &[] };
        let (code, text) = run(folder.path(), &[&tin, asked].concat());
        assert_eq!(code, 0, "{text}");
        let (code, text) = run(folder.path(), &[&["verify", name, dem], &lines[..]].concat());
        assert_eq!(code, i32::from(!is_kept), "{text}");
        assert_eq!(
            text.contains("breakline: no chain of edges is along it"),
            !is_kept,
            "{text}"
        );
    }
}

#[test]
fn a_line_that_changes_makes_the_tiles_under_it_anew_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let dem = sample("jacksboro_fault.tif");
    let dem = dem.to_str().unwrap();
    let build = |output: &str| {
        let (code, text) = run(folder.path(), &[dem, "-o", output, "--breaklines", "road.geojson"]);
        assert_eq!(code, 0, "{text}");
    };
    let from = Path::new(dem).parent().unwrap().to_str().unwrap();
    road(folder.path(), "road.geojson", 0.0);
    build("road.pmtiles");
    road(folder.path(), "road.geojson", 0.02);
    let (code, text) = run(folder.path(), &["update", "road.pmtiles", "--from", from]);
    assert_eq!(code, 0, "{text}");
    build("anew.pmtiles");
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("road.pmtiles") == bytes("anew.pmtiles"));
    let rebuilt = text.lines().find_map(|line| line.strip_prefix("rebuilt ")).unwrap();
    let numbers: Vec<u32> = rebuilt.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(0 < numbers[0] && numbers[0] < numbers[1], "{rebuilt}");
}

#[test]
fn files_without_lines_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let dem = sample("jacksboro_fault.tif");
    let dem = dem.to_str().unwrap();
    let point = r#"{"type": "Point", "coordinates": [-84.2, 36.3]}"#;
    fs::write(folder.path().join("point.geojson"), point).unwrap();
    fs::write(folder.path().join("cut.geojson"), r#"{"type": "LineString", "coordi"#).unwrap();
    let expected = [
        ("point.geojson", "it has no line"),
        ("cut.geojson", "cannot be read"),
        ("nowhere.geojson", "cannot be read"),
        (dem, "cannot be read"),
    ];
    for (lines, reason) in expected {
        for command in [
            &["-o", "out.pmtiles"][..],
            &["tin", "--max-error", "9", "-o", "out.ply"],
        ] {
            let (code, text) = run(folder.path(), &[command, &[dem, "--breaklines", lines]].concat());
            assert_eq!((code, text.trim_end().lines().count()), (2, 1), "{lines}: {text}");
            assert!(text.contains(reason) && text.contains(lines), "{text}");
            assert!(!folder.path().join("out.pmtiles").exists() && !folder.path().join("out.ply").exists());
        }
    }
}
