//! The folder of a pack while it is written: what is in it, how large, and what it hashes to.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Written {
    pub(super) bytes: u64,
    /// In hexadecimal digits.
    pub(super) sha256: String,
}

/// A folder that threads write files into.
pub(super) struct Folder {
    path: PathBuf,
    /// By their paths from the folder.
    written: Mutex<BTreeMap<String, Written>>,
}

impl Folder {
    pub(super) fn new(path: PathBuf) -> Self {
        Self {
            path,
            written: Mutex::default(),
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a whole file.
    pub(super) fn write(&self, path: &str, bytes: &[u8]) -> anyhow::Result<()> {
        self.stream(path, |out| out.write_all(bytes).map_err(Into::into))
    }

    /// Writes a file piece by piece.
    pub(super) fn stream(
        &self,
        path: &str,
        write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let written = self.written_by(path, write).with_context(|| path.to_owned())?;
        self.locked().insert(path.to_owned(), written);
        Ok(())
    }

    fn written_by(
        &self,
        path: &str,
        write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
    ) -> anyhow::Result<Written> {
        let path = self.path.join(path);
        fs::create_dir_all(path.parent().unwrap_or(&self.path))?;
        let mut out = BufWriter::new(Hashed {
            file: File::create(&path)?,
            bytes: 0,
            hash: Sha256::new(),
        });
        write(&mut out)?;
        let Hashed { bytes, hash, .. } = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        let sha256 = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Written { bytes, sha256 })
    }

    /// All files so far.
    pub(super) fn written(&self) -> BTreeMap<String, Written> {
        self.locked().clone()
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, Written>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A file, counted and hashed as it is written.
struct Hashed {
    file: File,
    bytes: u64,
    hash: Sha256,
}

impl Write for Hashed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.hash.update(&bytes[..count]);
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
