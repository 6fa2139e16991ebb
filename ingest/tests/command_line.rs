//! The program as a person meets it: exit codes, one line an error, nothing left behind.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod in_folder;
mod run;

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use in_folder::{SAMPLE, names, tells_its_cause_once, text};
use run::run;

/// An Esri ASCII grid of 3 × 2 samples; `prj` is what its side file says, if there is one.
fn ascii_grid(folder: &Path, name: &str, heights: &str, prj: Option<&str>) {
    let header = "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 50\ncellsize 0.5\nNODATA_value -9999\n";
    fs::write(folder.join(name), format!("{header}{heights}\n")).unwrap();
    if let Some(prj) = prj {
        fs::write(folder.join(name).with_extension("prj"), prj).unwrap();
    }
}

const WGS84: &str = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]"#;

#[test]
fn unusable_input_is_one_line_and_exit_code_2_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("junk.tif"), "no raster at all").unwrap();
    fs::write(path.join("truncated.tif"), &fs::read(SAMPLE).unwrap()[..70_000]).unwrap();
    ascii_grid(path, "placeless.asc", "1 2 3\n4 5 6", None);
    ascii_grid(path, "void.asc", "-9999 -9999 -9999\n-9999 -9999 -9999", Some(WGS84));
    ascii_grid(path, "holes.asc", "1 -9999 3\n-9999 5 -9999", Some(WGS84));
    let before = names(path);
    let cases: [(&[&str], &str); 16] = [
        (&["holes.asc"], "holes.asc: no four neighbouring samples are all valid"),
        (&["absent.tif"], "absent.tif: cannot be read: No such file"),
        (&["junk.tif"], "junk.tif: cannot be read"),
        (&["truncated.tif"], "truncated.tif: cannot be read"),
        (&["."], "./junk.tif: cannot be read"),
        (&["/vsicurl/http://127.0.0.1:1/a.tif"], "refused"),
        (
            &["placeless.asc"],
            "placeless.asc: has no coordinate reference system; pass --crs",
        ),
        (&["void.asc"], "void.asc: every sample is void"),
        (
            &[SAMPLE, "--crs", "EPSG:999999"],
            "`EPSG:999999` is no coordinate reference system",
        ),
        (&[SAMPLE, "--bounds", "5,5,4,6"], "are not west < east"),
        (&[SAMPLE, "--bounds", "5,80,6,100"], "beyond the pole"),
        (
            &[SAMPLE, "-o", "absent/out.pmtiles"],
            "absent/out.pmtiles: its folder does not exist",
        ),
        (
            &["tin", SAMPLE, "--max-error", "5", "-o", "out.stl"],
            "out.stl: meshes are written as .ply or .obj",
        ),
        (
            &["tin", "junk.tif", "--max-error", "5", "-o", "out.ply"],
            "junk.tif: cannot be read",
        ),
        (&["info", "junk.tif"], "junk.tif"),
        (&["verify", "absent.pmtiles", SAMPLE], "absent.pmtiles"),
    ];
    for (arguments, message) in cases {
        let output = run(
            path,
            &[arguments, &["--quiet"][..usize::from(arguments[0] != "info")]].concat(),
        );
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.starts_with("error: ") && error.contains(message),
            "{arguments:?}: {error}"
        );
        assert_eq!(error.lines().count(), 1, "{arguments:?}: {error}");
        assert!(tells_its_cause_once(&error), "{error}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert_eq!(names(path), before, "{arguments:?}");
    }
}

#[test]
fn wrong_options_are_told_with_exit_code_2() {
    let folder = TempDir::new().unwrap();
    let cases: [(&[&str], &str); 8] = [
        (&[], "<DEM>"),
        (
            &["--quiet", "info", "a.pmtiles"],
            "“info” is a command: it comes before all options",
        ),
        (
            &["--quiet", "pack", "a.pmtiles", "--format", "sim"],
            "“pack” is a command",
        ),
        (&[SAMPLE, "--max-error", "-3"], "above 0"),
        (&[SAMPLE, "--max-error", "much"], "not a number"),
        (&[SAMPLE, "--bounds", "-3,2,1"], "WEST,SOUTH,EAST,NORTH"),
        (&[SAMPLE, "--jobs", "0"], "--jobs"),
        (&["tin", SAMPLE, "-o", "out.ply"], "--max-error"),
    ];
    for (arguments, message) in cases {
        let output = run(folder.path(), arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(message), "{arguments:?}: {error}");
        assert_eq!(names(folder.path()), [""; 0]);
    }
}

#[test]
fn help_teaches_by_examples() {
    let folder = TempDir::new().unwrap();
    let output = run(folder.path(), &["--help"]);
    // Where lines end depends on the terminal.
    let help = text(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(output.status.success());
    for part in [
        "Examples:",
        "terrain-ingest verify dem.pmtiles dem.tif",
        "Exit codes:",
        "certified error in metres",
    ] {
        assert!(help.contains(part), "{part} is missing in:\n{help}");
    }
}

#[test]
fn the_main_job_writes_an_archive_that_verifies() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let built = run(path, &[SAMPLE, "--max-error", "20", "--json"]);
    assert!(built.status.success(), "{}", text(&built.stderr));
    assert_eq!(names(path), ["jacksboro_fault.pmtiles"]);
    let report: Value = serde_json::from_slice(&built.stdout).unwrap();
    assert_eq!(report["output"], "jacksboro_fault.pmtiles");
    assert!(report["seconds"].as_f64().unwrap() > 0.0 && report["peak_memory_bytes"].as_u64().unwrap() > 1_000_000);

    let info = run(path, &["info", "jacksboro_fault.pmtiles", "--json"]);
    let metadata: Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!(metadata["source"]["crs"], "EPSG:4326");
    assert_eq!(metadata["source"]["files"][0], "jacksboro_fault.tif");
    assert_eq!(metadata["source"]["samples"], serde_json::json!([403, 344]));
    assert!(metadata["max_error"].as_f64().unwrap() <= 20.0);

    let verified = run(path, &["verify", "jacksboro_fault.pmtiles", SAMPLE, "--quiet"]);
    let report = text(&verified.stdout);
    assert!(
        verified.status.success() && report.contains("verified"),
        "{report}{}",
        text(&verified.stderr)
    );
}

#[test]
fn one_mesh_keeps_its_error() {
    let folder = TempDir::new().unwrap();
    for name in ["out.ply", "out.obj"] {
        let made = run(
            folder.path(),
            &["tin", SAMPLE, "--max-error", "15", "-o", name, "--json"],
        );
        assert!(made.status.success(), "{}", text(&made.stderr));
        let verified = run(folder.path(), &["verify", name, SAMPLE, "--json"]);
        assert!(
            verified.status.success(),
            "{}{}",
            text(&verified.stdout),
            text(&verified.stderr)
        );
        let report: Value = serde_json::from_slice(&verified.stdout).unwrap();
        let measured = report["measured_between_samples"].as_f64().unwrap();
        assert!(measured > 5.0 && measured <= 15.0, "{name}: {measured} m");
    }
    assert_eq!(names(folder.path()), ["out.obj", "out.ply"]);
}

/// Level 1 is one triangle, level 0 two.
const MODEL: &str = "#a comment\n{0 0 0 4 0 0 0 4 0}{0 3 2 1}{4 4 1}{0 1 3}";

#[test]
fn a_multilevel_mesh_becomes_a_world_with_its_data_beside_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("model.lod"), MODEL).unwrap();
    let made = run(path, &["mesh", "model.lod", "-o", "a world.x3d", "--json"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let report: Value = serde_json::from_slice(&made.stdout).unwrap();
    let triangles = [0, 1].map(|level: usize| &report["levels"][level]["triangles"]);
    assert_eq!(triangles, [2, 1]);
    assert_eq!(names(path), ["a world.lod", "a world.x3d", "model.lod"]);
    let world = fs::read_to_string(path.join("a world.x3d")).unwrap();
    assert!(world.contains("name=\"urlData\" value=\"a%20world.lod\""));
    let again = run(path, &["mesh", "a world.lod", "-o", "b.wrl"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
    let written = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    assert_eq!(written("a world.lod"), written("b.lod"));
}

#[test]
fn a_mesh_that_lies_beside_its_world_already_stays_as_it_is() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("model.lod"), MODEL).unwrap();
    let made = run(path, &["mesh", "model.lod", "-o", "model.wrl"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    assert_eq!(fs::read_to_string(path.join("model.lod")).unwrap(), MODEL);
    let world = fs::read_to_string(path.join("model.wrl")).unwrap();
    assert!(world.starts_with("#VRML V2.0 utf8\n") && world.contains("urlData \"model.lod\""));
}

#[test]
fn what_cannot_be_a_world_is_one_line_and_exit_code_2_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("model.lod"), MODEL).unwrap();
    fs::write(path.join("junk.lod"), "{0 0 0\n1 0 zero}").unwrap();
    fs::write(path.join("huge.lod"), "{0 0 1e300 1 0 0 0 1 0}{0 1 2}").unwrap();
    let before = names(path);
    let cases = [
        ("absent.lod", "out.x3d", "absent.lod: cannot be read: No such file"),
        (
            "junk.lod",
            "out.x3d",
            "junk.lod: not a readable multilevel file: line 2, column 5: expected",
        ),
        (
            "huge.lod",
            "out.x3d",
            "out.x3d: a coordinate of 1e300 is more than X3D can hold",
        ),
        (
            "model.lod",
            "out.html",
            "out.html: levels are written as .spm, .lod, .x3d or .wrl, one of them as .ply",
        ),
        (
            "model.lod",
            "absent/out.wrl",
            "absent/out.wrl: its folder does not exist",
        ),
    ];
    for (model, output, message) in cases {
        let refused = run(path, &["mesh", model, "-o", output, "--quiet"]);
        let error = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{error}");
        assert!(error.starts_with("error: ") && error.contains(message), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(tells_its_cause_once(&error), "{error}");
        assert_eq!(names(path), before);
    }
}

/// Starts a build of the sample in `folder`.
fn begin(folder: &Path) -> std::process::Child {
    Command::new(env!("CARGO_BIN_EXE_terrain-ingest"))
        .args([SAMPLE, "--max-error", "40", "-o", "out.pmtiles", "--quiet"])
        .current_dir(folder)
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn a_build_that_is_killed_again_and_again_goes_on_and_gives_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    let arguments = [SAMPLE, "--max-error", "40", "-o", "whole.pmtiles", "--quiet"];
    assert!(run(folder.path(), &arguments).status.success());
    assert_eq!(names(folder.path()), ["whole.pmtiles"], "the work is gone");
    let mut random = fastrand::Rng::with_seed(7);
    let mut kills = 0;
    // Ever longer, so that on a machine at its limit the slowest tile is made at last.
    let finished = (0..200).any(|attempt| {
        let mut build = begin(folder.path());
        std::thread::sleep(std::time::Duration::from_millis(random.u64(5..400 + 20 * attempt)));
        build.kill().unwrap();
        let status = build.wait().unwrap();
        kills += usize::from(!status.success());
        status.success()
    });
    assert!(finished && kills > 0, "{kills} kills");
    assert_eq!(names(folder.path()), ["out.pmtiles", "whole.pmtiles"]);
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("out.pmtiles") == read("whole.pmtiles"));
}

#[test]
fn a_second_build_at_the_same_work_is_refused_and_kept_work_is_taken_up() {
    let folder = TempDir::new().unwrap();
    let work = folder.path().join("work");
    let arguments = [
        SAMPLE,
        "--max-error",
        "40",
        "-o",
        "out.pmtiles",
        "--work",
        "work",
        "--keep-work",
        "--json",
        "--quiet",
    ];
    assert!(run(folder.path(), &arguments).status.success());
    let lock = fs::File::open(work.join("lock")).unwrap();
    lock.lock().unwrap();
    let refused = run(folder.path(), &arguments);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("work: another build is at work here"));
    lock.unlock().unwrap();
    let count = |folder: &str| fs::read_dir(work.join(folder)).unwrap().count();
    let before = ["samples", "relief", "tiles"].map(count);
    let first = fs::read(folder.path().join("out.pmtiles")).unwrap();
    assert!(run(folder.path(), &arguments).status.success());
    assert_eq!(["samples", "relief", "tiles"].map(count), before);
    assert!(fs::read(folder.path().join("out.pmtiles")).unwrap() == first);
}
