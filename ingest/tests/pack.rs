//! Packs of the sample, read back.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use terrain_codec::address::TileAddress;
use terrain_tiles::archive::Reader;
use terrain_tiles::formats::quantized_mesh::{QuantizedMeshLimits, decode, validate};

const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../data-samples/jacksboro_fault.tif");

fn ingest(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_terrain-ingest"))
        .args(arguments)
        .output()
        .unwrap()
}

fn succeed(arguments: &[&str]) -> Value {
    let output = ingest(&[arguments, &["--quiet", "--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// An archive of the sample in a folder.
fn archive(folder: &Path) -> PathBuf {
    let path = folder.join("sample.pmtiles");
    succeed(&[
        SAMPLE,
        "-o",
        path.to_str().unwrap(),
        "--max-error",
        "20",
        "--quality",
        "fast",
    ]);
    path
}

fn pack(archive: &Path, format: &str, output: &Path, more: &[&str]) -> Value {
    let [archive, output] = [archive, output].map(|path| path.to_str().unwrap());
    succeed(&[&["pack", archive, "--format", format, "-o", output], more].concat())
}

/// Files below a folder, by their paths from there.
fn files(folder: &Path) -> BTreeSet<String> {
    let mut files = BTreeSet::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else {
            files.insert(path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned());
        }
    }
    files
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_folder_has_every_tile_that_its_layer_json_names_and_no_other() {
    let home = tempfile::tempdir().unwrap();
    let archive = archive(home.path());
    let output = home.path().join("pack");
    let report = pack(&archive, "folder", &output, &[]);
    let mut named = BTreeSet::from(["layer.json".to_owned()]);
    for (zoom, ranges) in json(&output.join("layer.json"))["available"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
    {
        for range in ranges.as_array().unwrap() {
            let number = |key: &str| range[key].as_u64().unwrap() as u32;
            for x in number("startX")..=number("endX") {
                for y in number("startY")..=number("endY") {
                    let path = format!("{zoom}/{x}/{y}.terrain");
                    let bytes = std::fs::read(output.join(&path)).unwrap();
                    let mesh = decode(&bytes, &QuantizedMeshLimits::default()).unwrap();
                    assert_eq!(validate(&mesh, TileAddress::new(zoom as u8, x, y).unwrap()), Ok(()));
                    assert!(mesh.normals.is_some(), "{path}");
                    named.insert(path);
                }
            }
        }
    }
    assert_eq!(files(&output), named);
    assert_eq!(report["files"], named.len());
    let tiles = Reader::open(&archive).unwrap().addresses().len();
    assert_eq!(report["tiles"], tiles);
    assert!(named.len() > tiles, "the other root is there, too");
}

/// Files that a document and those below it name.
fn named_by(folder: &Path, path: &str) -> BTreeSet<String> {
    let mut named = BTreeSet::from([path.to_owned()]);
    let mut open = vec![json(&folder.join(path))["root"].clone()];
    while let Some(tile) = open.pop() {
        open.extend(tile["children"].as_array().into_iter().flatten().cloned());
        match tile["content"]["uri"].as_str().map(|uri| uri.trim_start_matches("../")) {
            Some(uri) if uri.ends_with(".json") => named.extend(named_by(folder, uri)),
            Some(uri) => drop(named.insert(uri.to_owned())),
            None => (),
        }
    }
    named
}

#[test]
fn a_tileset_names_every_file_of_its_folder() {
    let home = tempfile::tempdir().unwrap();
    let output = home.path().join("pack");
    pack(&archive(home.path()), "3d-tiles", &output, &[]);
    let named = named_by(&output, "tileset.json");
    assert_eq!(files(&output), named);
    assert!(named.iter().filter(|name| name.ends_with(".json")).count() > 2);
}

#[test]
fn packed_tilesets_have_the_same_files_in_half_the_bytes_at_most_and_larger_errors() {
    let home = tempfile::tempdir().unwrap();
    let archive = archive(home.path());
    let [plain, packed] = ["plain", "meshopt"].map(|packing| {
        let output = home.path().join(packing);
        let report = pack(&archive, "3d-tiles", &output, &["--packing", packing]);
        let root = json(&output.join("tileset.json"))["root"].clone();
        (
            files(&output),
            report["bytes"].as_u64(),
            root["geometricError"].as_f64(),
        )
    });
    assert_eq!(packed.0, plain.0);
    assert!(packed.1.map(|bytes| 2 * bytes) < plain.1 && packed.2 > plain.2);
}

#[test]
fn a_part_has_the_same_files_as_the_whole_and_only_those_that_meet_its_box() {
    let home = tempfile::tempdir().unwrap();
    let archive = archive(home.path());
    let [whole, part] = ["whole", "part"].map(|name| home.path().join(name));
    pack(&archive, "3d-tiles", &whole, &[]);
    let box_and_zoom = ["--bbox", "-84.4,36.2,-84.3,36.3", "--max-zoom", "9"];
    pack(&archive, "3d-tiles", &part, &box_and_zoom);
    let glbs = |folder: &Path| {
        files(folder)
            .into_iter()
            .filter(|name| name.ends_with(".glb"))
            .collect::<BTreeSet<_>>()
    };
    let (all, some) = (glbs(&whole), glbs(&part));
    assert!(some.len() >= 10 && some.len() < all.len() && some.is_subset(&all));
    for name in some {
        let numbers: Vec<u32> = name
            .trim_end_matches(".glb")
            .split('/')
            .map(|number| number.parse().unwrap())
            .collect();
        let address = TileAddress::new(numbers[0] as u8, numbers[1], numbers[2]).unwrap();
        let (west, south, side) = (address.west(), address.south(), address.degrees());
        assert!(address.zoom <= 9 && west < -84.3 && west + side > -84.4 && south < 36.3 && south + side > 36.2);
        assert_eq!(
            std::fs::read(whole.join(&name)).unwrap(),
            std::fs::read(part.join(&name)).unwrap()
        );
    }
    assert_eq!(files(&part), named_by(&part, "tileset.json"));
}

#[test]
fn what_cannot_be_packed_is_refused_and_leaves_nothing() {
    let home = tempfile::tempdir().unwrap();
    let archive = archive(home.path());
    let output = home.path().join("pack");
    let [source, target] = [&archive, &output].map(|path| path.to_str().unwrap());
    let elsewhere = ingest(&["pack", source, "--format", "folder", "--bbox", "0,0,1,1", "-o", target]);
    assert_eq!(elsewhere.status.code(), Some(2));
    std::fs::create_dir(&output).unwrap();
    let again = ingest(&["pack", source, "--format", "folder", "-o", target]);
    assert_eq!(again.status.code(), Some(2));
    assert_eq!(files(home.path()), BTreeSet::from(["sample.pmtiles".to_owned()]));
}

#[test]
fn local_ground_is_flat_for_simulators() {
    const CELL: f64 = 500.0;
    let [columns, rows] = [61, 41];
    let height = |column: usize, row: usize| 100.0 + ((column * 7 + row * 3) % 11) as f64 + column as f64;
    let folder = tempfile::tempdir().unwrap();
    let mut text = format!("ncols {columns}\nnrows {rows}\nxllcorner 9000\nyllcorner -20000\ncellsize {CELL}\n");
    for row in 0..rows {
        let numbers: Vec<String> = (0..columns).map(|column| height(column, row).to_string()).collect();
        text.push_str(&(numbers.join(" ") + "\n"));
    }
    let raster = folder.path().join("moon.asc");
    std::fs::write(&raster, text).unwrap();
    let archive = folder.path().join("moon.pmtiles");
    let [raster, path] = [&raster, &archive].map(|path| path.to_str().unwrap());
    succeed(&[raster, "--local", "-o", path, "--max-error", "2"]);
    let out = folder.path().join("sim");
    pack(&archive, "sim", &out, &[]);
    let manifest = json(&out.join("manifest.json"));
    let origin = ["x", "y"].map(|axis| manifest["frame"]["origin"][axis].as_f64().unwrap());
    assert!(
        !std::fs::read_to_string(out.join("meshes.sdf"))
            .unwrap()
            .contains("spherical")
    );
    let error = manifest["meshes"]["error"].as_f64().unwrap();
    assert!(error < 4.0, "{error}");
    let mut vertices = 0;
    for mesh in manifest["meshes"]["tiles"].as_array().unwrap() {
        let offset: Vec<f64> = serde_json::from_value(mesh["offset"].clone()).unwrap();
        let object = out.join(format!("{}.obj", mesh["path"].as_str().unwrap()));
        for line in std::fs::read_to_string(object).unwrap().lines() {
            let Some(numbers) = line.strip_prefix("v ") else {
                continue;
            };
            let local: Vec<f64> = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
            let at = [0, 1].map(|axis| local[axis] + offset[axis] + origin[axis]);
            // The first sample is in the middle of the north-west cell.
            let column = (at[0] - 9000.0) / CELL - 0.5;
            let row = rows as f64 - 0.5 - (at[1] + 20_000.0) / CELL;
            let cell = [column, row].map(|place| place.max(0.0) as usize);
            let (west, north) = (cell[0].min(columns - 2), cell[1].min(rows - 2));
            let (across, down) = (column - west as f64, row - north as f64);
            let along = |row: usize| height(west, row) * (1.0 - across) + height(west + 1, row) * across;
            let expected = along(north) * (1.0 - down) + along(north + 1) * down;
            let found = local[2] + offset[2];
            assert!((found - expected).abs() <= error, "{found} {expected} at {at:?}");
            vertices += 1;
        }
    }
    // On the Earth the farthest corner would lie 25 m below.
    assert!(vertices > 500, "{vertices}");
}
