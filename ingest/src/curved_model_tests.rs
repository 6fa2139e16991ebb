#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;

use tempfile::TempDir;
use terrain_tiles::formats::polygons::PolygonLimits;

use super::*;
use crate::polygonal_model;

/// A torus of 2 · 24 · 12 triangles as OBJ.
fn torus() -> String {
    let (around, across) = (24, 12);
    let mut text = String::new();
    for vertex in 0..around * across {
        let [u, v] = [(vertex / across, around), (vertex % across, across)]
            .map(|(step, steps)| TAU * f64::from(step) / f64::from(steps));
        let out = 3.0 + v.cos();
        writeln!(text, "v {} {} {}", out * u.cos(), out * u.sin(), v.sin()).unwrap();
    }
    let vertex = |u: i32, v: i32| u % around * across + v % across + 1;
    for (u, v) in (0..around * across).map(|cell| (cell / across, cell % across)) {
        let [a, b, c, d] = [vertex(u, v), vertex(u + 1, v), vertex(u + 1, v + 1), vertex(u, v + 1)];
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    text
}

fn made(folder: &TempDir, input: &str, options: &Options, output: &str) -> Result<Report> {
    let [input, output] = [input, output].map(|name| folder.path().join(name));
    run(&input, options, &output, &Progress::silent())
}

fn in_folder(text: &str, name: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join(name), text).unwrap();
    folder
}

fn read(path: PathBuf) -> polygonal_model::Model {
    polygonal_model::read(&path, PolygonLimits::default()).unwrap()
}

/// How far a point is from the torus.
fn off_torus(at: glam::DVec3) -> f64 {
    ((at.truncate().length() - 3.0).hypot(at.z) - 1.0).abs()
}

#[test]
fn levels_made_once_are_drawn_again_in_every_format_the_same() {
    let folder = in_folder(&torus(), "torus.obj");
    let report = made(&folder, "torus.obj", &Options::default(), "torus.clod").unwrap();
    assert!(report.levels.len() > 3 && report.levels[0].patches == 576);
    let told = info(&folder.path().join("torus.clod")).unwrap();
    for (told, made) in told.levels.iter().zip(&report.levels) {
        assert_eq!(told.patches, made.patches);
        assert!(told.certified_error >= made.certified_error && told.certified_error < made.certified_error + 1e-4);
    }
    let options = Options {
        patches: Some(200),
        ..Options::default()
    };
    let mut counts = Vec::new();
    for name in ["out.obj", "out.ply", "out.glb"] {
        let drawn = made(&folder, "torus.clod", &options, name)
            .unwrap()
            .tessellation
            .unwrap();
        assert!(report.levels[drawn.level].patches <= 200 && report.levels[drawn.level - 1].patches > 200);
        let model = read(folder.path().join(name));
        counts.push((model.mesh.positions.len(), model.mesh.triangles.len()));
        let (vertices, triangles) = counts[0];
        assert_eq!(triangles, 2 * vertices, "a closed surface with one hole through it");
        let farthest = model.mesh.positions.iter().map(|at| off_torus(*at)).fold(0.0, f64::max);
        let claimed = report.levels[drawn.level].certified_error + drawn.tolerance;
        assert!(farthest <= claimed + 0.02, "{farthest} {claimed}");
    }
    assert_eq!(counts, [counts[0]; 3]);
}

#[test]
fn an_error_is_kept_and_normals_look_outwards() {
    let folder = in_folder(&torus(), "torus.obj");
    let options = Options {
        max_error: Some(0.05),
        tolerance: Some(0.002),
        ..Options::default()
    };
    let report = made(&folder, "torus.obj", &options, "torus.ply").unwrap();
    let last = report.levels.last().unwrap();
    assert!(last.certified_error <= 0.05 && last.patches < 500, "{last:?}");
    let model = read(folder.path().join("torus.ply"));
    let normal = |vertex: usize| glam::DVec3::from_array([0, 1, 2].map(|axis| model.columns[axis].values[vertex]));
    for (vertex, at) in model.mesh.positions.iter().enumerate() {
        let ring = at.truncate().normalize() * 3.0;
        assert!(normal(vertex).dot(*at - ring.extend(0.0)) > 0.5);
        assert!(off_torus(*at) < 0.1);
    }
}

#[test]
fn patches_of_a_spline_surface_are_cut_until_two_triangles_each_are_near() {
    let row = |i: i32| {
        (0..4)
            .map(|j| format!("{i} {j} {}\n", (i * i - j) % 3))
            .collect::<String>()
    };
    let patch: String = (0..4).map(row).collect();
    let folder = in_folder(&format!("1\n{patch}"), "one.bez");
    let options = Options {
        max_error: Some(100.0),
        level: Some(0),
        tolerance: Some(0.01),
        ..Options::default()
    };
    let report = made(&folder, "one.bez", &options, "one.json").unwrap();
    assert_eq!(report.levels[0].patches, 2);
    let near = Options {
        max_error: Some(0.01),
        ..options
    };
    let cut = made(&folder, "one.bez", &near, "cut.json").unwrap();
    assert!(cut.levels[0].patches > 30 && cut.levels[0].certified_error <= 0.01 / 8.0);
    let text = fs::read_to_string(folder.path().join("one.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let patches = json["patches"].as_array().unwrap();
    assert_eq!(patches.iter().filter(|patch| patch["levels"][0] == 0).count(), 2);
    assert_eq!(json["patches"][0]["points"].as_array().unwrap().len(), 10);
    assert!(
        made(&folder, "one.bez", &options, "one.obj")
            .unwrap()
            .tessellation
            .unwrap()
            .triangles
            > 20
    );
}

#[test]
fn creases_are_where_triangles_meet_at_more_than_the_angle() {
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
        f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let folder = in_folder(cube, "cube.obj");
    let vertices = |crease_angle: Option<f64>| {
        let options = Options {
            crease_angle,
            level: Some(0),
            tolerance: Some(0.01),
            ..Options::default()
        };
        made(&folder, "cube.obj", &options, "out.obj")
            .unwrap()
            .tessellation
            .unwrap()
            .vertices
    };
    assert_eq!(vertices(None), 8, "flat sides");
    assert!(vertices(Some(2.0)) > 100, "round");
}

#[test]
fn faults_are_named() {
    let folder = in_folder(&torus(), "torus.obj");
    made(&folder, "torus.obj", &Options::default(), "torus.clod").unwrap();
    let fault = |input: &str, options: Options, output: &str| {
        let error = made(&folder, input, &options, output).unwrap_err();
        assert!(error.is::<CurvedModelError>(), "{error:?}");
        format!("{error:#}")
    };
    let none = Options::default;
    assert!(fault("torus.obj", none(), "out.txt").contains("are written as .clod or .json"));
    assert!(fault("torus.tif", none(), "out.clod").contains("models are read from"));
    let level = Options {
        level: Some(999),
        ..none()
    };
    assert!(fault("torus.clod", level, "out.obj").contains("there is no level 999"));
    let near = Options {
        patches: Some(100),
        max_error: Some(1e-9),
        ..none()
    };
    assert!(fault("torus.clod", near, "out.obj").contains("is within 0.000000001"));
    fs::write(folder.path().join("bad.clod"), b"CLOD\x02").unwrap();
    assert!(fault("bad.clod", none(), "out.obj").contains("version 2"));
    fs::write(folder.path().join("fin.obj"), torus() + "v 9 9 9\nf 1 2 289\n").unwrap();
    assert!(fault("fin.obj", none(), "out.obj").contains("only manifolds are fitted with patches"));
}
