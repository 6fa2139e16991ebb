//! A build by many processes that share a store: any order, twice, killed, and the archive is that of one process.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod program;
mod run;

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use program::{failure, hills, report, same, write};
use serde_json::Value;
use tempfile::TempDir;

const RASTERS: [&str; 2] = ["a.asc", "b.asc"];

/// Two rasters side by side, the build of them by one process, and a plan for many.
fn planned() -> (TempDir, Value) {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    write(&path.join("a.asc"), [0, 0], [700, 500], hills);
    write(&path.join("b.asc"), [700, 100], [300, 400], hills);
    let asked = ["--max-error", "8"];
    report(path, &[&RASTERS[..], &asked, &["-o", "one.pmtiles"]].concat());
    let plan = [&["plan"], &RASTERS[..], &asked, &["--work", "work", "--leaves", "4"]].concat();
    let first = report(path, &plan);
    assert_eq!(first, report(path, &plan), "a plan is the same each time");
    (folder, first["stages"].clone())
}

fn jobs(stage: &Value) -> Vec<String> {
    let name = stage["stage"].as_str().unwrap();
    let count = stage["jobs"].as_u64().unwrap();
    (0..count).map(|number| format!("{name}/{number}")).collect()
}

fn job(folder: &Path, name: &str) {
    report(folder, &["build", "--work", "work", "--job", name]);
}

#[test]
fn jobs_in_any_order_and_twice_make_the_archive_of_one_process() {
    let (folder, stages) = planned();
    let folder = folder.path();
    let merge = ["merge", "--work", "work", "-o", "many.pmtiles"];
    for stage in stages.as_array().unwrap() {
        let mut names = jobs(stage);
        fastrand::Rng::with_seed(3).shuffle(&mut names);
        let last = names.pop().unwrap();
        thread::scope(|scope| {
            for name in &names {
                scope.spawn(|| job(folder, name));
            }
        });
        let line = failure(folder, &merge, 1);
        assert!(line.contains("not been done"), "{line}");
        job(folder, &last);
        job(folder, names.first().unwrap_or(&last));
    }
    report(folder, &merge);
    assert!(same(folder, "one.pmtiles", "many.pmtiles"));
    report(folder, &["verify", "many.pmtiles", "a.asc", "b.asc"]);
}

#[test]
fn a_job_needs_those_before_it_and_rasters_only_for_their_samples() {
    let (folder, _) = planned();
    let folder = folder.path();
    let job_fails = |name: &str| failure(folder, &["build", "--work", "work", "--job", name], 1);
    assert!(job_fails("tiles/0").contains("samples"));
    assert!(job_fails("tiles/999").contains("no job tiles/999"));
    job(folder, "samples/0");
    let rest = report(
        folder,
        &[
            "plan",
            "a.asc",
            "b.asc",
            "--max-error",
            "8",
            "--work",
            "work",
            "--leaves",
            "4",
        ],
    );
    for stage in rest["stages"].as_array().unwrap() {
        if stage["stage"] == "relief" {
            for name in RASTERS {
                std::fs::rename(folder.join(name), folder.join(name).with_extension("gone")).unwrap();
            }
        }
        jobs(stage).iter().for_each(|name| job(folder, name));
    }
    report(folder, &["merge", "--work", "work", "-o", "many.pmtiles"]);
    assert!(same(folder, "one.pmtiles", "many.pmtiles"));
}

#[test]
fn a_raster_that_changed_since_the_plan_is_refused() {
    let (folder, _) = planned();
    let folder = folder.path();
    write(&folder.join("a.asc"), [0, 0], [700, 500], |column, row| {
        hills(column, row) + 1.0
    });
    let line = failure(folder, &["build", "--work", "work", "--job", "samples/0"], 1);
    assert!(line.contains("has changed since the build was planned"), "{line}");
    let nothing = failure(folder, &["build", "--work", "nowhere", "--job", "samples/0"], 2);
    assert!(nothing.contains("begin with `plan`"), "{nothing}");
    assert!(!folder.join("nowhere").exists());
}

#[test]
fn jobs_that_are_killed_are_run_again() {
    let (folder, stages) = planned();
    let folder = folder.path();
    let mut random = fastrand::Rng::with_seed(11);
    for stage in stages.as_array().unwrap() {
        for name in jobs(stage) {
            let mut killed = Command::new(env!("CARGO_BIN_EXE_terrain-ingest"))
                .args(["build", "--work", "work", "--job", &name, "--quiet"])
                .current_dir(folder)
                .stdout(Stdio::null())
                .spawn()
                .unwrap();
            thread::sleep(Duration::from_millis(random.u64(..250)));
            killed.kill().unwrap();
            killed.wait().unwrap();
            job(folder, &name);
        }
    }
    report(folder, &["merge", "--work", "work", "-o", "many.pmtiles"]);
    assert!(same(folder, "one.pmtiles", "many.pmtiles"));
}
