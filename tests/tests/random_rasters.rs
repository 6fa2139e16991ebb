//! Small rasters of every kind become archives that `verify` passes, or are refused in one line: through files and the
//! command line, with a time limit.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::BTreeMap;
use std::env;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use terrain_tests::random_raster::{Place, RandomRaster};
use terrain_tests::{program, shared_data, workspace};

/// How many rasters every run of the tests makes.
const RASTERS: u64 = 200;
/// Another that was once refuted: `verify` saw an edge to a pole on another meridian.
const ONCE_REFUTED: [u64; 1] = [1537];

/// No raster of a few hundred samples takes so long, on a busy machine either: what goes on longer does not end.
const LIMIT: Duration = Duration::from_secs(60);

/// Exit code, none where the time limit ended it, and what it printed.
fn run(folder: &Path, arguments: &[String]) -> (Option<i32>, String) {
    let printed = folder.join("printed");
    let file = File::create(&printed).unwrap();
    let mut command = Command::new(program());
    command
        .args(arguments)
        .args(["--quiet", "--jobs", "1"])
        .current_dir(folder);
    let outputs = (Stdio::from(file.try_clone().unwrap()), Stdio::from(file));
    let mut child = command.stdout(outputs.0).stderr(outputs.1).spawn().unwrap();
    let started = Instant::now();
    let code = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break Some(status.code().unwrap_or(-1));
        }
        if started.elapsed() > LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            break None;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut text = String::new();
    File::open(printed).unwrap().read_to_string(&mut text).unwrap();
    (code, text)
}

/// Builds an archive and verifies it; what is wrong, if anything is.
fn fault(folder: &Path, files: &[String], options: &[String], has_surface: bool) -> Option<String> {
    let output = ["-o", "out.pmtiles"].map(str::to_owned);
    let (code, text) = run(folder, &[files, &output, options].concat());
    if !has_surface {
        let is_one_line = text.trim_end().lines().count() == 1;
        return (code != Some(2) || !is_one_line).then(|| format!("not refused: exit {code:?}: {text}"));
    }
    if code != Some(0) {
        return Some(format!("not built: exit {code:?}: {text}"));
    }
    let (code, text) = run(
        folder,
        &[&["verify".to_owned(), "out.pmtiles".to_owned()], files].concat(),
    );
    let violation = text.lines().find(|line| line.contains("violation: ")).unwrap_or(&text);
    (code != Some(0)).then(|| format!("refuted: exit {code:?}: {violation}"))
}

fn fault_of(seed: u64) -> Option<String> {
    let folder = tempfile::tempdir().unwrap();
    let raster = RandomRaster::new(seed);
    let files = raster.write(folder.path()).unwrap();
    fault(folder.path(), &files, &raster.options, raster.has_surface())
}

/// A seed, what it makes, what is wrong with it, and how to see it again.
fn told(seed: u64, fault: &str) -> String {
    let raster = RandomRaster::new(seed);
    let (place, relief, voids) = (raster.place, raster.relief, raster.voids);
    let size = [raster.columns, raster.rows];
    let release = if cfg!(debug_assertions) { "" } else { "--release " };
    format!(
        "{place:?} {relief:?} {voids:?} {size:?} {:?}\n  {}\n  TERRAIN_SEED={seed} cargo test {release}-p terrain-tests \
         --test random_rasters -- --ignored one_seed",
        raster.options,
        fault.trim_end()
    )
}

/// Fails with all faults of the rasters of these seeds whose place is among `places`.
fn check(seeds: impl IntoParallelIterator<Item = u64>, places: &[Place]) {
    let seeds = seeds.into_par_iter();
    let chosen = seeds.filter(|&seed| places.contains(&RandomRaster::new(seed).place));
    let all: Vec<(u64, Option<String>)> = chosen.map(|seed| (seed, fault_of(seed))).collect();
    let bad: Vec<String> = all
        .iter()
        .filter_map(|(seed, fault)| fault.as_ref().map(|fault| told(*seed, fault)))
        .collect();
    println!("{} rasters", all.len());
    assert!(
        bad.is_empty(),
        "{} of {} rasters:\n{}",
        bad.len(),
        all.len(),
        bad.join("\n")
    );
}

#[test]
fn rasters_of_every_kind_become_archives_that_hold() {
    let seeds: Vec<u64> = (0..RASTERS).chain(ONCE_REFUTED).collect();
    check(seeds, &Place::ALL);
}

/// `TERRAIN_RASTERS` says how many, after those of every run; `TERRAIN_PLACES` the kinds, all if not given.
#[test]
#[ignore = "takes as long as one likes"]
fn many_rasters() {
    let count = env::var("TERRAIN_RASTERS").map_or(2000, |count| count.parse().unwrap());
    let names = env::var("TERRAIN_PLACES").unwrap_or_default();
    let is_asked = |place: &Place| names.is_empty() || names.split(',').any(|name| name == format!("{place:?}"));
    let places: Vec<Place> = Place::ALL.into_iter().filter(is_asked).collect();
    check(RASTERS..RASTERS + count, &places);
}

/// Leaves the files of the seed `TERRAIN_SEED` in `target/random-raster`.
#[test]
#[ignore = "repeats what another test found"]
fn one_seed() {
    let seed: u64 = env::var("TERRAIN_SEED").unwrap().parse().unwrap();
    let folder = workspace().join("target/random-raster");
    fs::create_dir_all(&folder).unwrap();
    RandomRaster::new(seed).write(&folder).unwrap();
    if let Some(fault) = fault_of(seed) {
        panic!("{}", told(seed, &fault));
    }
}

/// The generator makes what it says: all kinds, and some that have no surface.
#[test]
fn seeds_make_rasters_of_every_kind() {
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    let rasters = (0..RASTERS).map(RandomRaster::new);
    for raster in rasters {
        let kind = [
            format!("{:?}", raster.place),
            format!("{:?}", raster.relief),
            format!("{:?}", raster.voids),
            format!("surface {}", raster.has_surface()),
        ];
        kind.into_iter().for_each(|kind| *kinds.entry(kind).or_default() += 1);
    }
    assert_eq!(kinds.len(), 12 + 6 + 6 + 2, "{kinds:?}");
    assert!(kinds.values().all(|&count| count >= 5), "{kinds:?}");
}

/// Small rasters that were once not built, or whose claims did not hold.
#[test]
fn rasters_that_once_failed_hold() {
    let Some(folder) = shared_data("cases") else { return };
    let together = [
        "abutting_nw.tif",
        "abutting_ne.tif",
        "abutting_sw.tif",
        "abutting_se.tif",
    ];
    let pairs = [
        ["far_a.tif", "far_b.tif"],
        ["pixel_width_a.tif", "pixel_width_b.tif"],
        ["resolution_30m.tif", "resolution_10m.tif"],
        ["resolution_30m.tif", "other_zone_30m.tif"],
        ["overlap_shift_a.tif", "overlap_shift_b.tif"],
        ["overlap_a.tif", "overlap_b.tif"],
    ];
    let alone = [
        "pole_row_2x2.tif",
        "global_gridline_10deg.tif",
        "near_pole_1deg.tif",
        "beside_pole_3413.tif",
        "pole_row_half_degree.tif",
        "flat_10deg.tif",
        "global_area_10deg.tif",
        "flat_corner_missing_vertex.tif",
        "void_corner_missing_vertex_south.tif",
        "void_corner_missing_vertex_west.tif",
        "flat_unshared_edge.tif",
        "flat_outline_claim.tif",
        "dateline_outline_claim.tif",
        "vertical_claim.tif",
        "void_collar_vertical_claim.tif",
        "step_30m_at_1m.tif",
        "box_30m_at_1m.tif",
        "blocks_at_1m.tif",
        "undeclared_minus9999.tif",
        "undeclared_minus32768.tif",
        "near_pole_3413.tif",
        "pole_inside_3031.tif",
    ];
    let path = |name: &&str| folder.join(name).to_str().unwrap().to_owned();
    let cases = alone.iter().map(|name| vec![path(name)]);
    let pairs = pairs.iter().map(|pair| pair.iter().map(path).collect());
    let together = together.iter().map(path).collect();
    let cases: Vec<Vec<String>> = cases.chain(pairs).chain([together]).collect();
    let faults = cases.par_iter().filter_map(|files| {
        let folder = tempfile::tempdir().unwrap();
        fault(folder.path(), files, &[], true).map(|fault| format!("{}: {}", files[0], fault.trim_end()))
    });
    let faults: Vec<String> = faults.collect();
    assert!(
        faults.is_empty(),
        "{} of {}:\n{}",
        faults.len(),
        cases.len(),
        faults.join("\n")
    );
}
