//! Runs the program as a person runs it.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in `folder`.
pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_terrain-ingest"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}
