//! What the program prints, and what it leaves in a folder.

use std::fs;
use std::path::Path;

pub(crate) const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../data-samples/jacksboro_fault.tif");

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Whether the last cause in a line of causes is told once only.
pub(crate) fn tells_its_cause_once(error: &str) -> bool {
    let cause = error.trim_end().rsplit(": ").next();
    cause.is_some_and(|cause| error.matches(cause).count() == 1)
}

/// What a folder holds, by name.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
