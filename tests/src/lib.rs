//! What the end-to-end tests share: oracles, and where test data are.

pub mod geographiclib;
pub mod random_lines;
pub mod random_raster;
pub mod selection;
pub mod source;
pub mod vectors;

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::{env, thread};

/// The top folder of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// A file of the sample data that come with the project.
#[must_use]
pub fn sample(name: &str) -> PathBuf {
    workspace().join("data-samples").join(name)
}

/// A file or folder of the larger data set that not everybody has: below `TERRAIN_SHARED_DATA`, or `../shared/data`
/// beside the workspace. None, and a line that says so, where it is missing; the test is then to return.
#[must_use]
pub fn shared_data(name: &str) -> Option<PathBuf> {
    let root = env::var_os("TERRAIN_SHARED_DATA").map_or_else(|| workspace().join("../shared/data"), PathBuf::from);
    there_or_skipped(root.join(name))
}

/// A file or folder of answers by an independent reference that not everybody has, in `../shared/vectors` beside the
/// workspace. None, and a line that says so, where it is missing; the test is then to return.
#[must_use]
pub fn shared_vectors(name: &str) -> Option<PathBuf> {
    there_or_skipped(workspace().join("../shared/vectors").join(name))
}

/// The program `terrain-ingest`: the one that `TERRAIN_INGEST` names, or one that is built now.
///
/// # Panics
/// Where it cannot be built.
#[must_use]
pub fn program() -> &'static Path {
    static PROGRAM: LazyLock<PathBuf> = LazyLock::new(|| match env::var_os("TERRAIN_INGEST") {
        Some(program) => program.into(),
        None => built_program(),
    });
    &PROGRAM
}

fn built_program() -> PathBuf {
    let (profile, folder) = if cfg!(debug_assertions) {
        ("dev", "debug")
    } else {
        ("release", "release")
    };
    let arguments = [
        "build",
        "--locked",
        "--quiet",
        "-p",
        "terrain-ingest",
        "--profile",
        profile,
    ];
    let built = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(workspace())
        .status();
    assert!(
        built.is_ok_and(|status| status.success()),
        "terrain-ingest cannot be built"
    );
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from);
    target.join(folder).join("terrain-ingest")
}

/// The path, if there is something. If not, the test that asks is noted in `target/skipped-tests`, which `./task test`
/// prints at its end.
fn there_or_skipped(path: PathBuf) -> Option<PathBuf> {
    if path.exists() {
        return Some(path);
    }
    let line = format!("{}: {} is not there\n", running_test(), path.display());
    print!("skipped: {line}");
    let note = OpenOptions::new()
        .create(true)
        .append(true)
        .open(workspace().join("target/skipped-tests"));
    // One call a line: tests of other processes write there, too.
    if let Err(error) = note.and_then(|mut file| file.write_all(line.as_bytes())) {
        println!("target/skipped-tests: {error}");
    }
    None
}

/// Its name: that of its thread, or, where a test has a process of its own, the first argument.
fn running_test() -> String {
    match thread::current().name() {
        Some(name) if name != "main" => name.to_owned(),
        _ => env::args().nth(1).unwrap_or_else(|| "a test".to_owned()),
    }
}

/// The files below a folder, in order.
///
/// # Panics
/// Where the folder cannot be listed.
#[must_use]
pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries
        .map(|entry| {
            entry
                .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
                .path()
        })
        .flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] })
        .collect();
    files.sort();
    files
}

/// Numbers from 0 to 1 that look random and are the same every time (SplitMix64; Steele, Lea and Flood, 2014).
pub fn random_numbers(seed: u64) -> impl Iterator<Item = f64> {
    let mut state = seed;
    std::iter::repeat_with(move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    })
}
