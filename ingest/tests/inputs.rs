//! What can be given to the program as a raster, and what it says of rasters that are not what they seem.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod program;
mod run;

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use program::{failure, hills, report, same, write};
use run::run;

/// The lines that the program writes on standard error.
fn told(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {error}");
    error
}

/// What an archive says of itself.
fn info_of(folder: &Path, archive: &str) -> Value {
    let output = run(folder, &["info", archive, "--json"]);
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_folder_is_the_rasters_in_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::create_dir(path.join("dems")).unwrap();
    write(&path.join("dems/b.asc"), [30, 0], [31, 40], hills);
    write(&path.join("dems/a.asc"), [0, 0], [31, 40], hills);
    fs::write(path.join("dems/README.txt"), "no raster").unwrap();
    report(path, &["dems", "-o", "folder.pmtiles"]);
    report(path, &["dems/a.asc", "dems/b.asc", "-o", "files.pmtiles"]);
    assert!(same(path, "folder.pmtiles", "files.pmtiles"));
    fs::create_dir(path.join("empty")).unwrap();
    let line = failure(path, &["empty", "-o", "empty.pmtiles"], 2);
    assert_eq!(line, "error: empty: no file in this folder is a raster by its name");
}

#[test]
fn a_height_map_of_a_game_becomes_a_mesh_in_metres_of_its_own() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let side = 33;
    let heights = (0..side * side).map(|index| hills(index % side, index / side) as u16 * 50);
    fs::write(
        path.join("map.r16"),
        heights.flat_map(u16::to_be_bytes).collect::<Vec<u8>>(),
    )
    .unwrap();
    let how = [
        "--pixel-size",
        "2",
        "--height-range",
        "-10",
        "1300.7",
        "--byte-order",
        "big",
    ];
    let tin = ["tin", "map.r16", "-o", "map.obj", "--max-error", "1"];
    let made = report(path, &[&tin[..], &how].concat());
    assert!(made["triangles"].as_u64().unwrap() > 10, "{made}");
    let mesh = fs::read_to_string(path.join("map.obj")).unwrap();
    let numbers = |line: &str| {
        line.split(' ')
            .skip(1)
            .map(|number| number.parse().unwrap())
            .collect::<Vec<f64>>()
    };
    let vertices: Vec<Vec<f64>> = mesh
        .lines()
        .filter(|line| line.starts_with("v "))
        .map(numbers)
        .collect();
    let most = |axis: usize| vertices.iter().map(|vertex| vertex[axis]).fold(f64::MIN, f64::max);
    let least = |axis: usize| vertices.iter().map(|vertex| vertex[axis]).fold(f64::MAX, f64::min);
    assert_eq!([least(0), most(0), least(1), most(1)], [0.0, 64.0, 0.0, 64.0]);
    // Hills are from 240 to 560 m, stored in fiftieths of a metre of which 65,535 make 1,310.7 m.
    assert!(least(2) > 200.0 && most(2) < 570.0, "{} … {}", least(2), most(2));
    report(path, &[&["verify", "map.obj", "map.r16"][..], &how].concat());
    let without = [&tin[..], &how[2..]].concat();
    assert!(failure(path, &without, 2).contains("has no coordinate reference system"));
    let odd = [
        "tin",
        "map.r16",
        "-o",
        "odd.obj",
        "--max-error",
        "1",
        "--pixel-size",
        "2",
        "--crs",
        "EPSG:4326",
    ];
    assert_eq!(run(path, &odd).status.code(), Some(2));
}

#[test]
fn undeclared_voids_are_said_and_can_be_declared_and_the_archive_keeps_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let hole = |column, row| column < 12 && row < 15;
    let height = move |column, row| {
        if hole(column, row) {
            -32_768.0
        } else {
            hills(column, row)
        }
    };
    write(&path.join("dem.asc"), [0, 0], [40, 40], height);
    let said = told(path, &["dem.asc", "-o", "found.pmtiles"]);
    assert!(
        said.contains("-32768 is stored in 180 samples") && said.contains("taken for a void"),
        "{said}"
    );
    report(path, &["verify", "found.pmtiles", "dem.asc"]);
    let silent = told(path, &["dem.asc", "-o", "said.pmtiles", "--nodata", "-32768"]);
    assert!(!silent.contains("-32768"), "{silent}");
    report(path, &["verify", "said.pmtiles", "dem.asc"]);
    let info = info_of(path, "said.pmtiles");
    assert_eq!(info["asked"]["reading"]["nodata"][0].as_f64(), Some(-32_768.0));
    assert_eq!(info["heights"], info_of(path, "found.pmtiles")["heights"]);
}

#[test]
fn heights_in_another_unit_are_noticed_and_the_archive_keeps_the_unit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    write(&path.join("dm.asc"), [0, 0], [20, 20], |column, row| {
        100.0 * hills(column, row)
    });
    let said = told(path, &["dm.asc", "-o", "high.pmtiles", "--max-error", "1000"]);
    assert!(
        said.contains("above every mountain") && said.contains("--unit"),
        "{said}"
    );
    let said = told(path, &["dm.asc", "-o", "right.pmtiles", "--unit", "centimetre"]);
    assert!(!said.contains("mountain"), "{said}");
    report(path, &["verify", "right.pmtiles", "dm.asc"]);
    let info = info_of(path, "right.pmtiles");
    assert!(info["heights"][1].as_f64().unwrap() < 600.0, "{info}");
    assert_eq!(run(path, &["dm.asc", "--unit", "cubit"]).status.code(), Some(2));
}

#[test]
fn files_that_disagree_where_they_overlap_are_named() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    write(&path.join("a.asc"), [0, 0], [30, 20], |_, _| 100.0);
    write(&path.join("b.asc"), [20, 0], [30, 20], |_, _| 107.0);
    let said = told(path, &["a.asc", "b.asc", "-o", "out.pmtiles"]);
    let expected = "b.asc: 200 samples differ from those of files that count before it, by up to 7 m; beside these it is bent to meet them";
    assert!(said.contains(expected), "{said}");
}
