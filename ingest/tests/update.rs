//! Archives whose rasters change: what `update` writes is what a build of all the rasters writes.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod program;
mod run;

use std::fs;
use std::path::Path;

use program::{failure, hills, report, same, write};
use serde_json::Value;
use tempfile::TempDir;

/// Four rasters of 400 × 300 samples side by side, two and two.
const NAMES: [&str; 4] = ["a.asc", "b.asc", "c.asc", "d.asc"];
const SIZE: [usize; 2] = [400, 300];

fn first(name: &str) -> [usize; 2] {
    let number = NAMES.iter().position(|known| *known == name).unwrap();
    [number % 2 * SIZE[0], number / 2 * SIZE[1]]
}

fn write_all(folder: &Path, names: &[&str]) {
    for name in names {
        write(&folder.join(name), first(name), SIZE, hills);
    }
}

fn build(folder: &Path, names: &[&str], output: &str) -> Value {
    report(folder, &[names, &["--max-error", "8", "-o", output]].concat())
}

fn tiles(report: &Value) -> u64 {
    let zooms = report["metadata"]["zooms"].as_array().unwrap();
    zooms.iter().map(|zoom| zoom["tiles"].as_u64().unwrap()).sum()
}

fn count(report: &Value, what: &str) -> u64 {
    report["update"][what].as_u64().unwrap()
}

#[test]
fn a_changed_hill_makes_the_tiles_over_it_anew_and_no_others() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write_all(folder, &NAMES);
    build(folder, &NAMES, "was.pmtiles");
    fs::copy(folder.join("was.pmtiles"), folder.join("now.pmtiles")).unwrap();
    let hill = |column: usize, row: usize| {
        let far = (column as f64 - 650.0).hypot(row as f64 - 450.0);
        hills(column, row) + 10.0 * (-far * far / 50.0).exp()
    };
    write(&folder.join("d.asc"), first("d.asc"), SIZE, hill);

    let updated = report(folder, &["update", "now.pmtiles", "--changed", "d.asc"]);
    build(folder, &NAMES, "anew.pmtiles");
    assert!(same(folder, "now.pmtiles", "anew.pmtiles"));
    assert!(!same(folder, "now.pmtiles", "was.pmtiles"));
    assert!((1..=9).contains(&count(&updated, "changed_leaves")), "{updated}");
    assert!(count(&updated, "kept") > tiles(&updated) / 2, "{updated}");
    assert_eq!([count(&updated, "new_leaves"), count(&updated, "removed")], [0, 0]);
    assert!(!folder.join("now.pmtiles.work").exists());

    let again = report(folder, &["update", "now.pmtiles"]);
    assert_eq!(count(&again, "kept"), tiles(&again));
    assert!(same(folder, "now.pmtiles", "anew.pmtiles"));
}

#[test]
fn rasters_come_and_go() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write_all(folder, &NAMES);
    build(folder, &NAMES[..1], "now.pmtiles");
    for count_of_rasters in 2..=4 {
        let name = NAMES[count_of_rasters - 1];
        let added = report(folder, &["update", "now.pmtiles", "--added", name]);
        build(folder, &NAMES[..count_of_rasters], "all.pmtiles");
        assert!(same(folder, "now.pmtiles", "all.pmtiles"), "{name}");
        assert!(count(&added, "new_leaves") > 0 && count(&added, "kept") > 0, "{added}");
    }

    let removed = report(folder, &["update", "now.pmtiles", "--removed", "b.asc"]);
    build(folder, &["a.asc", "c.asc", "d.asc"], "three.pmtiles");
    assert!(same(folder, "now.pmtiles", "three.pmtiles"));
    assert!(
        count(&removed, "removed") > 0 && count(&removed, "kept") > 0,
        "{removed}"
    );
}

#[test]
fn kept_work_says_where_the_other_rasters_are() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for name in ["dems", "new", "out"] {
        fs::create_dir(folder.join(name)).unwrap();
    }
    write_all(&folder.join("dems"), &NAMES[..2]);
    write(&folder.join("new/b.asc"), first("b.asc"), SIZE, |column, row| {
        hills(column, row) - 1.0
    });
    let archive = "out/x.pmtiles";
    let made = ["dems/a.asc", "dems/b.asc", "--max-error", "8", "-o", archive];
    report(folder, &made);
    let update = ["update", archive, "--changed", "new/b.asc"];
    let lost = failure(folder, &update, 2);
    assert!(lost.contains("a.asc") && lost.contains("--from"), "{lost}");
    assert!(!folder.join("out/x.pmtiles.work").exists());
    fs::copy(folder.join(archive), folder.join("out/y.pmtiles")).unwrap();
    let from = ["update", "out/y.pmtiles", "--changed", "new/b.asc", "--from", "dems"];
    assert!(count(&report(folder, &from), "kept") > 0);

    report(folder, &[&made[..], &["--keep-work"]].concat());
    assert!(count(&report(folder, &update), "kept") > 0);
    assert!(same(folder, archive, "out/y.pmtiles"));
}

#[test]
fn what_cannot_be_updated_is_one_line_and_leaves_the_archive_as_it_was() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    write_all(folder, &NAMES[..2]);
    build(folder, &NAMES[..2], "now.pmtiles");
    let before = fs::read(folder.join("now.pmtiles")).unwrap();
    fs::write(folder.join("junk.pmtiles"), "no archive").unwrap();
    fs::write(folder.join("torn.asc"), "ncols 3\nnrows").unwrap();
    for (arguments, told) in [
        (&["junk.pmtiles"][..], "not a readable PMTiles archive"),
        (&["none.pmtiles"], "No such file"),
        (
            &["now.pmtiles", "--changed", "z.asc"],
            "made of no file of that name, but of a.asc, b.asc",
        ),
        (&["now.pmtiles", "--added", "b.asc"], "is it --changed?"),
        (&["now.pmtiles", "--added", "torn.asc"], "torn.asc"),
        (&["now.pmtiles", "--removed", "a.asc", "b.asc"], "no raster is left"),
    ] {
        let line = failure(folder, &[&["update"], arguments].concat(), 2);
        assert!(line.contains(told), "{line}");
    }
    assert_eq!(fs::read(folder.join("now.pmtiles")).unwrap(), before);
    assert!(!folder.join("now.pmtiles.work").exists());
}

/// Changes in a row, at random: each update gives what a build gives.
#[test]
fn any_changes_in_a_row_give_what_a_build_gives() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let mut random = fastrand::Rng::with_seed(7);
    let mut there: Vec<&str> = NAMES[..2].to_vec();
    write_all(folder, &NAMES);
    build(folder, &there, "now.pmtiles");
    for step in 0..4 {
        let other = NAMES.into_iter().find(|name| !there.contains(name));
        let (verb, name) = match (random.u8(..3), other) {
            (0, Some(name)) => ("--added", name),
            (1, _) if there.len() > 1 => ("--removed", there[random.usize(1..there.len())]),
            _ => ("--changed", there[random.usize(..there.len())]),
        };
        match verb {
            "--added" => there.push(name),
            "--removed" => there.retain(|known| *known != name),
            _ => {
                let [left, top] = first(name);
                let (column, row) = (left + random.usize(..SIZE[0]), top + random.usize(..SIZE[1]));
                let wide = random.usize(1..60);
                let is_there = move |x: usize, y: usize| x.abs_diff(column) < wide && y.abs_diff(row) < wide;
                let height = |x: usize, y: usize| if is_there(x, y) { -9999.0 } else { hills(x, y) };
                write(&folder.join(name), first(name), SIZE, height);
            }
        }
        report(folder, &["update", "now.pmtiles", verb, name]);
        build(folder, &there, "anew.pmtiles");
        assert!(
            same(folder, "now.pmtiles", "anew.pmtiles"),
            "step {step}: {verb} {name}"
        );
    }
}
