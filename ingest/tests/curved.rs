//! `terrain-ingest clod` on models whose faces, edges or patches are degenerate (§9 of the paper): handled, or refused in a line.

#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod run;

use std::fs;

use run::run;
use serde_json::Value;
use tempfile::TempDir;

/// Exit code, standard error, and the levels that were made.
fn made(text: &str, name: &str) -> (Option<i32>, String, Vec<Value>) {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join(name), text).unwrap();
    let output = run(folder.path(), &["clod", name, "-o", "out.json", "--quiet"]);
    let error = String::from_utf8(output.stderr).unwrap();
    let levels = fs::read_to_string(folder.path().join("out.json")).map_or(Vec::new(), |text| {
        let made: Value = serde_json::from_str(&text).unwrap();
        made["levels"].as_array().unwrap().clone()
    });
    (output.status.code(), error, levels)
}

fn refusal(text: &str, name: &str) -> String {
    let (code, error, levels) = made(text, name);
    assert_eq!((code, error.lines().count(), levels.len()), (Some(2), 1, 0), "{error}");
    error
}

fn first_patches(text: &str, name: &str) -> u64 {
    let (code, error, levels) = made(text, name);
    assert_eq!((code, error.as_str()), (Some(0), ""));
    assert!(levels.iter().all(|level| level["certified_error"].is_number()));
    levels[0]["patches"].as_u64().unwrap()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn faces_that_are_no_manifold_are_refused() {
    let fin = format!("{SQUARE}v 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 3 5\n");
    assert!(refusal(&fin, "fin.obj").contains("manifold"));
}

#[test]
fn a_face_that_is_there_twice_is_one() {
    let twice = format!("{SQUARE}f 1 2 3\nf 1 2 3\n");
    assert_eq!(first_patches(&twice, "twice.obj"), 1);
}

#[test]
fn faces_without_area_are_refused_or_left_out() {
    let line = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    assert!(refusal(line, "line.obj").contains("without a position or a normal"));
    let repeated = format!("{SQUARE}f 1 2 2\n");
    assert!(refusal(&repeated, "repeated.obj").contains("no triangle"));
    let one_of_three = format!("{SQUARE}f 1 2 3\nf 1 3 4\nf 1 1 4\n");
    assert_eq!(first_patches(&one_of_three, "some.obj"), 2);
}

#[test]
fn an_edge_of_no_length_is_closed() {
    let doubled = format!("{SQUARE}v 1 1 0\nf 1 2 3\nf 1 5 4\nf 1 3 5\n");
    assert_eq!(first_patches(&doubled, "doubled.obj"), 2);
}

/// Two patches may have the same corners and curves and still not be one.
#[test]
fn a_closed_piece_of_two_patches_stays() {
    let pillow = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n";
    assert_eq!(first_patches(pillow, "pillow.obj"), 2);
    let side = |lift: f64| {
        patch(|i, j| {
            [
                f64::from(i),
                f64::from(j),
                if (1..3).contains(&i) && (1..3).contains(&j) {
                    lift
                } else {
                    0.0
                },
            ]
        })
    };
    let both = format!("2\n{}{}", side(1.0), side(-1.0));
    assert!(first_patches(&both, "pillow.bez") >= 4);
}

/// Control points row by row.
fn patch(point: impl Fn(i32, i32) -> [f64; 3]) -> String {
    let points = (0..16).map(|place| point(place / 4, place % 4));
    points.map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
}

#[test]
fn patches_whose_sides_are_points_are_handled_and_a_point_is_refused() {
    // Corners that coincide: one side, two opposite ones, two that meet.
    let fan = patch(|i, j| [f64::from(i), f64::from(i * j), 0.0]);
    assert_eq!(first_patches(&format!("1\n{fan}"), "fan.bez") % 2, 1);
    let spindle = patch(|i, j| [f64::from(i), f64::from(i * (3 - i) * j), 0.0]);
    assert!(first_patches(&format!("1\n{spindle}"), "spindle.bez") >= 2);
    let fold = patch(|i, j| [f64::from(i * j), f64::from(i * j * j), 0.0]);
    assert!(first_patches(&format!("1\n{fold}"), "fold.bez") >= 2);
    let point = patch(|_, _| [1.0, 2.0, 3.0]);
    let error = refusal(&format!("2\n{fan}{point}"), "point.bez");
    assert!(error.contains("patch 1 is a single point"), "{error}");
}
