//! What becomes of each raster below a folder, as a table in Markdown: the errors that `verify` measures, or the words of the refusal.
//!
//! ```sh
//! cargo run --release -p terrain-tests --example raster_table -- ../shared/data > table.md
//! ```
//! A file that asks for `--crs` or `--bounds` gets them and is tried again. `MANIFEST.tsv` in the folder says what is right: its first
//! column names a file, its last has facts.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::Parser;
use serde_json::Value;
use terrain_tests::{files_below, program};

/// What goes on longer is ended.
const LIMIT: Duration = Duration::from_secs(120);
/// Kilobytes of address space that a run may take.
const MEMORY: u64 = 6 << 20;
/// What a file is given that does not say where it is.
const GIVEN: [(&str, &[&str]); 3] = [
    ("--crs", &["--crs", "EPSG:4326"]),
    ("--bounds", &["--bounds", "7,45,7.1,45.1"]),
    ("--allow-vrt", &["--allow-vrt"]),
];

#[derive(Parser)]
struct Arguments {
    /// Files below it are tried.
    folder: PathBuf,
    /// Only files whose path below the folder begins so; all if not given.
    #[arg(long, default_value = "")]
    only: String,
}

/// How a run ended.
struct Run {
    /// None where it was ended from outside.
    code: Option<i32>,
    printed: String,
    told: String,
    seconds: f64,
}

fn main() -> Result<()> {
    let Arguments { folder, only } = Arguments::parse();
    let facts = facts(&folder.join("MANIFEST.tsv")).unwrap_or_default();
    println!("| file | what is known of it | options | result | seconds |\n| --- | --- | --- | --- | ---: |");
    for file in files_below(&folder) {
        let name = file.strip_prefix(&folder)?.display().to_string();
        if name.starts_with(&only) {
            let known = facts.get(&name).map_or("", String::as_str);
            println!("{}", row(&file, &name, known)?);
        }
    }
    Ok(())
}

fn facts(manifest: &Path) -> Result<BTreeMap<String, String>> {
    let text = fs::read_to_string(manifest)?;
    let line = |line: &str| {
        let (name, _) = line.split_once('\t')?;
        let (_, facts) = line.rsplit_once('\t')?;
        Some((name.to_owned(), facts.to_owned()))
    };
    Ok(text.lines().filter_map(line).collect())
}

/// Tries a file, with what it asks for if it does.
fn row(file: &Path, name: &str, known: &str) -> Result<String> {
    let mut options: Vec<&str> = Vec::new();
    let (result, seconds) = loop {
        let (result, seconds) = tried(file, &options)?;
        let asked = GIVEN.iter().find(|(word, given)| {
            let is_new = !options.contains(&given[0]);
            is_new && result.starts_with("exit 2") && result.contains(word)
        });
        match asked {
            Some((_, given)) => options.extend(*given),
            None => break (result, seconds),
        }
    };
    let cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
    let options = options.join(" ");
    Ok(format!(
        "| {name} | {} | {options} | {} | {seconds:.1} |",
        cell(known),
        cell(&result)
    ))
}

/// Builds an archive of a file and verifies it.
fn tried(file: &Path, options: &[&str]) -> Result<(String, f64)> {
    let folder = tempfile::tempdir()?;
    let archive = folder.path().join("out.pmtiles");
    let (archive, file) = (archive.display().to_string(), file.display().to_string());
    let build = run(folder.path(), &[&[file.as_str(), "-o", &archive], options].concat())?;
    if build.code != Some(0) {
        return Ok((ended(&build), build.seconds));
    }
    let verify = run(
        folder.path(),
        &[&["verify", &archive, &file, "--json"], options].concat(),
    )?;
    let seconds = build.seconds + verify.seconds;
    if verify.code != Some(0) {
        return Ok((format!("REFUTED: {}", ended(&verify)), seconds));
    }
    let report: Value = serde_json::from_str(&verify.printed).context("the report of verify")?;
    let leaves = report["zooms"].as_array().and_then(|zooms| zooms.last());
    let leaves = leaves.context("an archive without zooms")?;
    let figure = |name: &str| leaves[name].as_f64().unwrap_or(f64::NAN);
    let remarks: Vec<&str> = build.told.lines().filter(|line| line.starts_with("note: ")).collect();
    let result = format!(
        "zoom {}, {} tiles, claimed {:.3} m, measured {:.3} m; {}",
        leaves["zoom"],
        leaves["tiles"],
        figure("claimed_finest"),
        figure("measured_finest"),
        remarks.join("; ").replace(&file, "it")
    );
    Ok((result, seconds))
}

fn ended(run: &Run) -> String {
    let code = run.code.map_or("NOT ENDED".to_owned(), |code| format!("exit {code}"));
    let last = run.told.trim().lines().last().unwrap_or("NOTHING SAID");
    format!("{code}: {last}")
}

fn run(folder: &Path, arguments: &[&str]) -> Result<Run> {
    let path = |name: &str| folder.join(name);
    let limited = format!("ulimit -v {MEMORY}; exec \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &limited, "sh"])
        .arg(program())
        .args(arguments)
        .stdout(Stdio::from(File::create(path("printed"))?))
        .stderr(Stdio::from(File::create(path("told"))?))
        .spawn()?;
    let started = Instant::now();
    let code = loop {
        if let Some(status) = child.try_wait()? {
            break Some(status.code().unwrap_or(-1));
        }
        if started.elapsed() > LIMIT {
            child.kill()?;
            child.wait()?;
            break None;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let text = |name: &str| -> Result<String> { Ok(String::from_utf8_lossy(&fs::read(path(name))?).into_owned()) };
    Ok(Run {
        code,
        printed: text("printed")?,
        told: text("told")?,
        seconds: started.elapsed().as_secs_f64(),
    })
}
