//! Curved models under their names: `.clod` files, as they are.

use std::fs;
use std::path::Path;

use anyhow::Context;
use axum::body::Bytes;
use terrain_tiles::formats::clod::{self, CurvedLimits};
use twox_hash::XxHash3_128;

/// A file of curved levels and what it is called.
pub struct CurvedFile {
    /// The file's name without its ending.
    pub name: String,
    /// Of its bytes.
    pub(crate) tag: String,
    pub(crate) bytes: Bytes,
}

impl CurvedFile {
    /// Whether a file is one, by its name.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        path.extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("clod"))
    }

    /// Reads the file at `path` and looks it through.
    ///
    /// # Errors
    /// What is wrong with the file, and which.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let bytes = fs::read(path).with_context(|| path.display().to_string())?;
        clod::decode(&bytes, &CurvedLimits::default()).with_context(|| path.display().to_string())?;
        Ok(Self {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            tag: format!("{:032x}", XxHash3_128::oneshot(&bytes)),
            bytes: bytes.into(),
        })
    }
}
