//! What can be given to the program as a raster, and what it says of rasters that are not what they seem.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod program;
mod run;

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;
use terrain_tiles::formats::quantized_mesh::{QuantizedMeshLimits, decode};

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

/// How [`write_height_map`]'s is to be read.
const HOW: [&str; 7] = [
    "--pixel-size",
    "2",
    "--height-range",
    "-10",
    "1300.7",
    "--byte-order",
    "big",
];

/// 33 × 33 samples of hills from 240 to 560 m, in fiftieths of a metre.
fn write_height_map(path: &Path) {
    let side = 33;
    let heights = (0..side * side).map(|index| hills(index % side, index / side) as u16 * 50);
    fs::write(path, heights.flat_map(u16::to_be_bytes).collect::<Vec<u8>>()).unwrap();
}

#[test]
fn ground_that_is_nowhere_on_the_earth_is_shown_where_its_plane_touches_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    write_height_map(&path.join("map.r16"));
    report(path, &[&["map.r16", "-o", "map.pmtiles"][..], &HOW].concat());
    report(path, &["verify", "map.pmtiles", "map.r16"]);
    let metres_in_a_degree = 6_378_137.0_f64.to_radians();
    let holds_bounds = |info: &Value, metres: [f64; 4]| {
        // A degree of latitude is shorter by the ellipsoid's flattening.
        let shortening = [1.0, 0.993_305_6, 1.0, 0.993_305_6];
        for (side, (metres, shortening)) in metres.into_iter().zip(shortening).enumerate() {
            let at = info["bounds"][side].as_f64().unwrap() * metres_in_a_degree * shortening;
            assert!((at - metres).abs() < 1e-3, "side {side}: {at} m, not {metres} m");
        }
        assert_eq!(info["source"]["crs"].as_str(), Some("local metres"));
        assert_eq!(info["asked"]["reading"]["local"].as_bool(), Some(true));
    };
    holds_bounds(&info_of(path, "map.pmtiles"), [0.0, 0.0, 64.0, 64.0]);

    // A position in metres, of no reference system.
    let rows = "100 200 300\n110 190 310\n120 180 320\n";
    let header = "ncols 3\nnrows 3\nxllcorner -1500\nyllcorner 2500\ncellsize 1000\n";
    fs::write(path.join("moon.asc"), format!("{header}{rows}")).unwrap();
    let refusal = failure(path, &["moon.asc", "-o", "moon.pmtiles"], 2);
    assert!(refusal.contains("--local"), "{refusal}");
    report(path, &["moon.asc", "--local", "-o", "moon.pmtiles"]);
    report(path, &["verify", "moon.pmtiles", "moon.asc"]);
    holds_bounds(&info_of(path, "moon.pmtiles"), [-1000.0, 3000.0, 1000.0, 5000.0]);

    // A plane that is wider than the Earth cannot be laid on it.
    let wide = ["map.r16", "--pixel-size", "1000000", "-o", "wide.pmtiles"];
    let refusal = failure(path, &wide, 2);
    assert!(refusal.starts_with("error: map.r16: "), "{refusal}");
}

#[test]
fn a_height_map_of_a_game_becomes_a_mesh_in_metres_of_its_own() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let how = HOW;
    write_height_map(&path.join("map.r16"));
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

/// A picture of 40 × 40 pixels of red, green and blue.
fn write_picture(path: &Path, colour: impl Fn(usize, usize) -> [u8; 3]) {
    let pixels: Vec<u8> = (0..40 * 40).flat_map(|index| colour(index % 40, index / 40)).collect();
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), 40, 40);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

#[test]
fn colours_are_heights_where_the_person_says_how() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let is_void = |column: usize, row: usize| column < 3 && row < 3;
    let bytes = |number: f64| {
        let [_, red, green, blue] = (number.round() as u32).to_be_bytes();
        [red, green, blue]
    };
    let encodings: [(&str, f64, f64); 2] = [("mapbox", 10.0, 10_000.0), ("terrarium", 256.0, 32_768.0)];
    for (encoding, steps, lowest) in encodings {
        let name = format!("{encoding}.png");
        write_picture(&path.join(&name), |column, row| {
            if is_void(column, row) {
                [0; 3]
            } else {
                bytes((hills(column, row) + lowest) * steps)
            }
        });
        let place = ["--crs", "EPSG:4326", "--bounds", "10,50,10.1,50.1"];
        let unsaid = failure(path, &[&[&name, "-o", "a.pmtiles"][..], &place].concat(), 2);
        assert!(unsaid.contains("its pixels are coloured"), "{unsaid}");
        let how = [&[&name, "-o", "a.pmtiles", "--encoding", encoding][..], &place].concat();
        report(path, &how);
        report(path, &["verify", "a.pmtiles", &name]);
        let heights = info_of(path, "a.pmtiles")["heights"].clone();
        let [least, greatest] = [0, 1].map(|index| heights[index].as_f64().unwrap());
        assert!(least > 230.0 && greatest < 570.0, "{heights}");
    }
    write_picture(&path.join("grey.png"), |column, row| {
        [(hills(column, row) / 4.0) as u8; 3]
    });
    report(
        path,
        &[
            "tin",
            "grey.png",
            "--pixel-size",
            "3",
            "--max-error",
            "1",
            "-o",
            "grey.ply",
        ],
    );
    write(&path.join("plain.asc"), [0, 0], [20, 20], hills);
    let plain = failure(path, &["plain.asc", "--encoding", "mapbox", "-o", "b.pmtiles"], 2);
    assert!(plain.contains("no red, green and blue"), "{plain}");
}

/// A polygon as GeoJSON, of degrees east of 10° and south of 50°, in cells of the made-up lattice.
fn polygon(corners: &[[f64; 2]]) -> String {
    let place = |&[column, row]: &[f64; 2]| format!("[{:.9},{:.9}]", 10.0 + column / 1200.0, 50.0 - row / 1200.0);
    let closed: Vec<String> = corners.iter().chain(&corners[..1]).map(place).collect();
    let ring = closed.join(",");
    format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[[{ring}]]}}}}"#)
}

#[test]
fn water_is_level_and_clients_are_told_where_it_is_but_not_of_runways() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    write(&path.join("dem.asc"), [0, 0], [80, 80], hills);
    fs::write(
        path.join("lake.json"),
        polygon(&[[10.0, 10.0], [40.0, 12.0], [25.0, 45.0]]),
    )
    .unwrap();
    fs::write(
        path.join("runway.json"),
        polygon(&[[50.0, 50.0], [70.0, 50.0], [70.0, 60.0], [50.0, 60.0]]),
    )
    .unwrap();
    let how = ["--water", "lake.json", "--flatten", "runway.json"];
    report(path, &[&["dem.asc", "-o", "wet.pmtiles"][..], &how].concat());
    report(path, &["verify", "wet.pmtiles", "dem.asc"]);
    let info = info_of(path, "wet.pmtiles");
    let rings = info["water"][0].as_array().unwrap();
    assert_eq!((info["water"].as_array().unwrap().len(), rings.len()), (1, 1));
    assert_eq!(rings[0].as_array().unwrap().len(), 4);
    assert_eq!(rings[0][0][0].as_f64(), Some(10.008_333_3));
    report(path, &["pack", "wet.pmtiles", "--format", "folder", "-o", "pack"]);
    let layer: Value = serde_json::from_slice(&fs::read(path.join("pack/layer.json")).unwrap()).unwrap();
    assert_eq!(layer["extensions"][1].as_str(), Some("watermask"));
    let zoom = info["max_zoom"].as_u64().unwrap() as u8;
    let masks: Vec<Vec<u8>> = layer["available"][usize::from(zoom)]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|range| {
            let number = |name: &str| range[name].as_u64().unwrap();
            let columns = number("startX")..=number("endX");
            columns.flat_map(move |x| {
                (number("startY")..=number("endY")).map(move |y| format!("pack/{zoom}/{x}/{y}.terrain"))
            })
        })
        .map(|name| {
            let mesh = decode(&fs::read(path.join(name)).unwrap(), &QuantizedMeshLimits::default()).unwrap();
            mesh.water_mask.unwrap()
        })
        .collect();
    let pixels_in_a_cell = 256.0 * f64::from(1 << zoom) / 180.0 / 1200.0;
    let wet: usize = masks
        .iter()
        .map(|mask| {
            let count = mask.iter().filter(|&&pixel| pixel == 255).count();
            if mask.len() == 1 { count * 256 * 256 } else { count }
        })
        .sum();
    // The lake's area by its corners, in cells.
    let cells = wet as f64 / pixels_in_a_cell.powi(2);
    assert!((cells - 510.0).abs() < 5.0, "{cells} cells of water");

    report(path, &["dem.asc", "-o", "dry.pmtiles", "--flatten", "runway.json"]);
    assert!(info_of(path, "dry.pmtiles").get("water").is_none());
}
