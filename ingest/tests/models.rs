//! `terrain-ingest mesh` on models that are made here, its claims measured again from the files alone.

#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod run;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use run::run;
use serde_json::Value;
use tempfile::TempDir;

type Point = [f64; 3];

/// Positions and triangles.
#[derive(Clone, Default)]
struct Surface {
    positions: Vec<Point>,
    triangles: Vec<[usize; 3]>,
}

/// A torus of 320 triangles with bumps.
fn torus() -> Surface {
    let (columns, rows) = (20, 8);
    let at = |vertex: usize| {
        let [u, v] = [
            (vertex % columns) as f64 / columns as f64,
            (vertex / columns) as f64 / rows as f64,
        ]
        .map(|share| share * TAU);
        let thickness = 0.4 + 0.03 * (5.0 * u + 3.0 * v).sin();
        let out = 1.0 + thickness * v.cos();
        [out * u.cos(), out * u.sin(), thickness * v.sin()]
    };
    let vertex = |column: usize, row: usize| row % rows * columns + column % columns;
    let cell = |place: usize| {
        let (c, r) = (place % columns, place / columns);
        let corners = [vertex(c, r), vertex(c + 1, r), vertex(c + 1, r + 1), vertex(c, r + 1)];
        [
            [corners[0], corners[1], corners[2]],
            [corners[0], corners[2], corners[3]],
        ]
    };
    Surface {
        positions: (0..columns * rows).map(at).collect(),
        triangles: (0..columns * rows).flat_map(cell).collect(),
    }
}

/// A strip of so many cells that is joined to itself after half a turn.
fn moebius_strip(cells: usize) -> Surface {
    let at = |vertex: usize| {
        let turn = (vertex / 2) as f64 / cells as f64 * TAU;
        let across = if vertex.is_multiple_of(2) { 0.3 } else { -0.3 };
        let out = 1.0 + across * (turn / 2.0).cos();
        [out * turn.cos(), out * turn.sin(), across * (turn / 2.0).sin()]
    };
    let vertex = |cell: usize, side: usize| if cell < cells { 2 * cell + side } else { 1 - side };
    let cell = |cell: usize| {
        let [a, b, c, d] = [
            vertex(cell, 0),
            vertex(cell, 1),
            vertex(cell + 1, 0),
            vertex(cell + 1, 1),
        ];
        [[a, b, c], [c, b, d]]
    };
    Surface {
        positions: (0..2 * cells).map(at).collect(),
        triangles: (0..cells).flat_map(cell).collect(),
    }
}

/// The torus twice, the second one beside the first, or so near that one vertex of it `touches` one of the first.
fn two_tori(touches: bool) -> Surface {
    let (mut both, mut second) = (torus(), torus());
    let (rightmost, leftmost) = (both.positions[0], second.positions[10]);
    let gap = if touches { 0.0 } else { 1.0 };
    let moved = plus(minus(rightmost, leftmost), [gap, 0.0, 0.0]);
    second
        .positions
        .iter_mut()
        .for_each(|place| *place = plus(*place, moved));
    if touches {
        second.positions[10] = rightmost;
    }
    join(&mut both, &second);
    both
}

/// A tetrahedron over an edge that runs up from the origin, to the one or the other `side`. Its fronts look outwards.
fn tetrahedron(side: f64) -> Surface {
    Surface {
        positions: vec![[0.0; 3], [0.0, 0.0, 1.0], [side, side, 0.0], [side, -side, 0.0]],
        triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [3, 1, 2]],
    }
}

fn join(surface: &mut Surface, other: &Surface) {
    let first = surface.positions.len();
    surface.positions.extend(&other.positions);
    let moved = other
        .triangles
        .iter()
        .map(|corners| corners.map(|corner| corner + first));
    surface.triangles.extend(moved);
}

fn write_obj(path: &Path, surface: &Surface) {
    let mut text = String::new();
    for [x, y, z] in &surface.positions {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for corners in &surface.triangles {
        let [a, b, c] = corners.map(|corner| corner + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    fs::write(path, text).unwrap();
}

/// Reads what the program writes: double coordinates alone, triangles.
fn read_ply(path: &Path) -> Surface {
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let header = String::from_utf8(bytes[..start].to_vec()).unwrap();
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element));
        line.unwrap().trim().parse().unwrap()
    };
    let (vertices, faces) = bytes[start..].split_at(24 * count("element vertex"));
    assert_eq!(faces.len(), 13 * count("element face"));
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
    let corner = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap()) as usize;
    Surface {
        positions: vertices
            .chunks(24)
            .map(|place| [number(&place[..8]), number(&place[8..16]), number(&place[16..])])
            .collect(),
        triangles: faces
            .chunks(13)
            .map(|face| [corner(&face[1..5]), corner(&face[5..9]), corner(&face[9..])])
            .collect(),
    }
}

/// Distance along the sides of triangles between points that are looked at, in units of the models here.
const SPACING: f64 = 0.05;

/// The largest distance found, both ways: never more than the true one, and hardly less.
fn sampled_distance(one: &Surface, other: &Surface) -> f64 {
    one_sided(one, other).max(one_sided(other, one))
}

/// The largest distance found from points of one surface to the other.
fn one_sided(from: &Surface, to: &Surface) -> f64 {
    let targets: Vec<Target> = to.triangles.iter().map(|corners| Target::new(to, corners)).collect();
    let points = from.triangles.iter().flat_map(|corners| points(from, corners));
    points.fold(0.0, |worst, point| worst.max(distance(point, &targets)))
}

/// Rows of points of a triangle, its corners among them.
fn points(surface: &Surface, corners: &[usize; 3]) -> Vec<Point> {
    let [a, b, c] = corners.map(|corner| surface.positions[corner]);
    let sides = [minus(b, a), minus(c, b), minus(a, c)].map(length);
    let steps = (sides.into_iter().fold(0.0, f64::max) / SPACING).ceil() as usize;
    let share = |step: usize| step as f64 / steps as f64;
    let rows = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j)));
    rows.map(|(i, j)| plus(a, plus(scaled(minus(b, a), share(i)), scaled(minus(c, a), share(j)))))
        .collect()
}

/// A triangle and a ball that holds it.
struct Target {
    corners: [Point; 3],
    middle: Point,
    radius: f64,
}

impl Target {
    fn new(surface: &Surface, corners: &[usize; 3]) -> Self {
        let corners = corners.map(|corner| surface.positions[corner]);
        let middle = scaled(corners.into_iter().fold([0.0; 3], plus), 1.0 / 3.0);
        let radii = corners.map(|corner| length(minus(corner, middle)));
        Self {
            corners,
            middle,
            radius: radii.into_iter().fold(0.0, f64::max),
        }
    }
}

/// From a point to the nearest of some triangles; those whose balls are further away are not looked at.
fn distance(point: Point, targets: &[Target]) -> f64 {
    targets.iter().fold(f64::INFINITY, |nearest, target| {
        match length(minus(point, target.middle)) - target.radius {
            least if least >= nearest => nearest,
            _ => nearest.min(squared_distance(point, &target.corners).sqrt()),
        }
    })
}

/// By Gram's matrix inside of the triangle, otherwise from the nearest side.
fn squared_distance(point: Point, &[a, b, c]: &[Point; 3]) -> f64 {
    let (e, f, d) = (minus(b, a), minus(c, a), minus(point, a));
    let (ee, ef, ff, de, df) = (dot(e, e), dot(e, f), dot(f, f), dot(d, e), dot(d, f));
    let gram = ee * ff - ef * ef;
    let (u, v) = ((de * ff - df * ef) / gram, (df * ee - de * ef) / gram);
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        let off = minus(d, plus(scaled(e, u), scaled(f, v)));
        return dot(off, off);
    }
    let side = |from: Point, to: Point| {
        let along = minus(to, from);
        let share = (dot(minus(point, from), along) / dot(along, along)).clamp(0.0, 1.0);
        let off = minus(point, plus(from, scaled(along, share)));
        dot(off, off)
    };
    side(a, b).min(side(b, c)).min(side(c, a))
}

fn plus(a: Point, b: Point) -> Point {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn scaled(a: Point, by: f64) -> Point {
    a.map(|coordinate| coordinate * by)
}

fn dot(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// The report of a run that succeeds.
fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The one line of a run that is refused.
fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, &[arguments, &["--quiet"]].concat());
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), error.lines().count()), (Some(2), 1), "{error}");
    error
}

fn levels(report: &Value) -> Vec<(u64, f64)> {
    let level = |level: &Value| {
        (
            level["triangles"].as_u64().unwrap(),
            level["certified_error"].as_f64().unwrap(),
        )
    };
    report["levels"].as_array().unwrap().iter().map(level).collect()
}

/// Extracts each level of `file` from the first one on and holds it to its claim.
fn hold_to_claims(folder: &Path, model: &Surface, file: &str, levels: &[(u64, f64)], first: usize) {
    for (level, &(triangles, claim)) in levels.iter().enumerate().skip(first) {
        report(folder, &["mesh", file, "--lod", &level.to_string(), "-o", "level.ply"]);
        let surface = read_ply(&folder.join("level.ply"));
        assert_eq!(surface.triangles.len() as u64, triangles);
        let bytes = fs::read(folder.join("level.ply")).unwrap();
        let told = format!("distance from the model at most {claim}\n");
        assert!(
            String::from_utf8_lossy(&bytes).contains(&told),
            "level {level} is to say: {told}"
        );
        let found = sampled_distance(model, &surface);
        assert!(found <= claim, "level {level}: {found} of {claim}");
        assert!(
            claim <= found * 1.1 || level == 0,
            "level {level}: {claim}, but {found}"
        );
    }
}

#[test]
fn a_compressed_file_holds_every_level_within_what_it_claims() {
    let folder = TempDir::new().unwrap();
    write_obj(&folder.path().join("torus.obj"), &torus());
    let made = levels(&report(folder.path(), &["mesh", "torus.obj", "-o", "torus.spm"]));
    let step = 2.0 * 1.43 / 65_536.0;
    assert!(
        (step / 8.0..step).contains(&made[0].1),
        "the finest is rounded: {}",
        made[0].1
    );
    assert!(made.len() > 3 && made.last().unwrap().0 < 40, "{made:?}");
    let told = levels(&report(folder.path(), &["info", "torus.spm"]));
    let is_rounded_up =
        |(made, told): (&(u64, f64), &(u64, f64))| made.0 == told.0 && (made.1..=made.1 * 1.000_001).contains(&told.1);
    assert!(made.iter().zip(&told).all(is_rounded_up), "{made:?} {told:?}");
    hold_to_claims(folder.path(), &torus(), "torus.spm", &told, 0);
    let [text, compressed] = ["torus.obj", "torus.spm"].map(|name| fs::read(folder.path().join(name)).unwrap().len());
    assert!(compressed * 6 < text, "{compressed} bytes of {text}");
}

#[test]
fn an_error_asked_for_is_kept_by_the_positions_that_are_stored() {
    let folder = TempDir::new().unwrap();
    write_obj(&folder.path().join("torus.obj"), &torus());
    for (error, file) in [("0.02", "coarse.spm"), ("0.0003", "fine.spm")] {
        let made = levels(&report(
            folder.path(),
            &["mesh", "torus.obj", "--max-error", error, "-o", file],
        ));
        let last = made.len() - 1;
        let error: f64 = error.parse().unwrap();
        assert!(made[last].1 <= error && made[0].1 <= error / 60.0, "{made:?}");
        let told = levels(&report(folder.path(), &["info", file]));
        hold_to_claims(folder.path(), &torus(), file, &told, last);
    }
}

#[test]
fn an_error_that_nothing_simpler_keeps_leaves_the_model_as_it_is() {
    let folder = TempDir::new().unwrap();
    write_obj(&folder.path().join("torus.obj"), &torus());
    let tiny = ["mesh", "torus.obj", "--max-error", "1e-30", "-o"];
    let made = report(folder.path(), &[&tiny[..], &["all.ply"]].concat());
    assert_eq!(levels(&made), [(320, 0.0)]);
    let refused = refusal(folder.path(), &[&tiny[..], &["all.spm"]].concat());
    assert!(
        refused.contains("no lattice of a .spm file is fine enough"),
        "{refused}"
    );
    assert!(!folder.path().join("all.spm").exists());
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    write_obj(&folder.path().join("torus.obj"), &torus());
    write_obj(&folder.path().join("strip.obj"), &moebius_strip(150));
    for (model, file) in [
        ("torus.obj", "torus.spm"),
        ("torus.obj", "torus.lod"),
        ("torus.obj", "torus.ply"),
        ("strip.obj", "strip.lod"),
    ] {
        let bytes = ["1", "2"].map(|jobs| {
            report(
                folder.path(),
                &["mesh", model, "--jobs", jobs, "--max-error", "0.05", "-o", file],
            );
            fs::read(folder.path().join(file)).unwrap()
        });
        assert!(bytes[0] == bytes[1], "{file}");
    }
}

#[test]
fn a_moebius_strip_is_clustered_or_refused_by_name() {
    let folder = TempDir::new().unwrap();
    let strip = moebius_strip(150);
    write_obj(&folder.path().join("strip.obj"), &strip);
    let made = report(
        folder.path(),
        &["mesh", "strip.obj", "--target-triangles", "80", "-o", "strip.lod"],
    );
    assert_eq!(made["method"], "clustering");
    assert!(
        made["reason"]
            .as_str()
            .unwrap()
            .contains("used twice in the same direction")
    );
    let claims = levels(&made);
    assert!((30..=80).contains(&claims.last().unwrap().0), "{claims:?}");
    for (level, (_, claim)) in claims.iter().enumerate().skip(1) {
        report(
            folder.path(),
            &["mesh", "strip.lod", "--lod", &level.to_string(), "-o", "level.ply"],
        );
        let surface = read_ply(&folder.path().join("level.ply"));
        let found = sampled_distance(&strip, &surface);
        assert!(
            found <= *claim && *claim <= found * 1.2,
            "level {level}: {found} of {claim}"
        );
    }
    let refused = refusal(folder.path(), &["mesh", "strip.obj", "-o", "strip.spm"]);
    assert!(
        refused.contains("strip.obj: a .spm file holds manifolds only"),
        "{refused}"
    );
}

#[test]
fn parts_may_touch_in_a_vertex() {
    let folder = TempDir::new().unwrap();
    for touches in [false, true] {
        let model = two_tori(touches);
        write_obj(&folder.path().join("two.obj"), &model);
        let made = report(
            folder.path(),
            &["mesh", "two.obj", "--target-triangles", "120", "-o", "two.spm"],
        );
        assert_eq!(
            (&made["method"], levels(&made).last().unwrap().0),
            (&"collapses".into(), 120)
        );
        let finest = made["levels"][0]["vertices"].as_u64();
        assert_eq!(finest, Some(2 * 20 * 8), "the vertex where they touch is there twice");
        let coarsest = levels(&made).len() - 1;
        report(folder.path(), &["mesh", "two.spm", "-o", "level.ply"]);
        let surface = read_ply(&folder.path().join("level.ply"));
        let found = sampled_distance(&model, &surface);
        let claim = levels(&made)[coarsest].1;
        assert!(found <= claim && claim <= found * 1.1, "{found} of {claim}");
    }
}

#[test]
fn parts_that_touch_are_clustered_where_that_leaves_fewer_triangles() {
    let folder = TempDir::new().unwrap();
    write_obj(&folder.path().join("two.obj"), &two_tori(true));
    let made = |goal: &str, limit: &str, file: &str| {
        let made = report(folder.path(), &["mesh", "two.obj", goal, limit, "-o", file]);
        (made["method"].clone(), levels(&made).pop().unwrap())
    };
    let (method, (triangles, error)) = made("--target-triangles", "10", "few.lod");
    assert!(method == "clustering" && triangles <= 10, "{triangles}");
    let (method, (apart, _)) = made("--target-triangles", "10", "few.spm");
    // The least torus has 14.
    assert!(method == "collapses" && apart >= 28, "{apart}");
    let (method, (triangles, _)) = made("--max-error", &error.to_string(), "far.lod");
    assert!(method == "clustering" && triangles <= 10, "{triangles}");
}

#[test]
fn parts_that_touch_along_an_edge_are_parted_but_not_a_fin() {
    let folder = TempDir::new().unwrap();
    let mut pair = tetrahedron(1.0);
    join(&mut pair, &tetrahedron(-1.0));
    write_obj(&folder.path().join("pair.obj"), &pair);
    let made = report(folder.path(), &["mesh", "pair.obj", "-o", "pair.ply"]);
    assert_eq!((&made["method"], levels(&made)), (&"collapses".into(), vec![(8, 0.0)]));
    assert_eq!(read_ply(&folder.path().join("pair.ply")).positions.len(), 8);
    let mut fin = tetrahedron(1.0);
    let out = fin.positions.len();
    fin.positions.push([-1.0, 0.0, 0.0]);
    fin.triangles.push([0, 1, out]);
    write_obj(&folder.path().join("fin.obj"), &fin);
    let made = report(
        folder.path(),
        &["mesh", "fin.obj", "--max-error", "0.001", "-o", "fin.ply"],
    );
    assert_eq!((&made["method"], levels(&made)), (&"clustering".into(), vec![(5, 0.0)]));
}

#[test]
fn files_that_are_no_models_are_refused_by_name() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("cube.stl"), "solid\nendsolid\n").unwrap();
    fs::write(folder.path().join("cube.step"), "ISO-10303-21;").unwrap();
    fs::write(folder.path().join("junk.spm"), "SPMX").unwrap();
    write_obj(&folder.path().join("torus.obj"), &torus());
    for (input, output, message) in [
        ("cube.stl", "out.ply", "cube.stl: has no triangles\n"),
        ("cube.step", "out.ply", "cube.step: models are read from "),
        (
            "junk.spm",
            "out.ply",
            "junk.spm: not a readable .spm file: not a progressive mesh file\n",
        ),
        (
            "torus.obj",
            "out.stl",
            "out.stl: levels are written as .spm, .lod, .x3d or .wrl",
        ),
    ] {
        let refused = refusal(folder.path(), &["mesh", input, "-o", output]);
        assert!(refused.contains(message), "{refused}");
        assert!(!folder.path().join(output).exists());
    }
}
