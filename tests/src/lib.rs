//! What the end-to-end tests share: oracles, and where test data are.

pub mod geographiclib;
pub mod source;
pub mod vectors;

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

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
    let root =
        std::env::var_os("TERRAIN_SHARED_DATA").map_or_else(|| workspace().join("../shared/data"), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    tell_skipped(&path);
    None
}

/// Tells that the running test leaves something out because `path` is not there: on standard output, and in a line of the file
/// that `TERRAIN_SKIPPED_TESTS` names, so that a run of all tests can end with a list of them.
///
/// # Panics
/// Where that file cannot be written.
pub fn tell_skipped(path: &Path) {
    let thread = std::thread::current();
    let line = format!("{}: {} is not there\n", thread.name().unwrap_or("?"), path.display());
    print!("skipped: {line}");
    if let Some(list) = std::env::var_os("TERRAIN_SKIPPED_TESTS") {
        let opened = OpenOptions::new().create(true).append(true).open(&list);
        let written = opened.and_then(|mut file| file.write_all(line.as_bytes()));
        written.unwrap_or_else(|error| panic!("{}: {error}", list.display()));
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
