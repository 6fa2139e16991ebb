//! Outputs that are there when they are whole.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// Lets `write` make a folder or file in a folder of its own, and moves it to `output`.
pub(super) fn write_whole<T>(
    output: &Path,
    write: impl FnOnce(&Path) -> anyhow::Result<(PathBuf, T)>,
) -> anyhow::Result<T> {
    let parent = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let parent = parent.unwrap_or(Path::new("."));
    let part = tempfile::Builder::new().prefix(".pack-").tempdir_in(parent);
    let part = part.with_context(|| parent.display().to_string())?;
    let (whole, done) = write(part.path())?;
    fs::rename(whole, output).with_context(|| output.display().to_string())?;
    Ok(done)
}
