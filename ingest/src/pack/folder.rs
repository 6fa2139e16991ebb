//! Folders of packs: files that are written into them, and what is in them.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A folder that threads write files into.
pub(super) struct Folder(PathBuf);

impl Folder {
    pub(super) fn new(path: PathBuf) -> Self {
        Self(path)
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
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
        self.create(path)
            .and_then(|mut out| {
                write(&mut out)?;
                Ok(out.flush()?)
            })
            .with_context(|| path.to_owned())
    }

    fn create(&self, path: &str) -> anyhow::Result<BufWriter<File>> {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().unwrap_or(&self.0))?;
        Ok(BufWriter::new(File::create(&path)?))
    }
}

/// Bytes of the files in a folder and in those below it, by their paths from there, with `/` between names.
pub(super) fn sizes(folder: &Path) -> anyhow::Result<BTreeMap<String, u64>> {
    let mut sizes = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(here) = open.pop() {
        let unreadable = || here.display().to_string();
        for entry in fs::read_dir(&here).with_context(unreadable)? {
            let entry = entry.with_context(unreadable)?;
            let metadata = fs::metadata(entry.path()).with_context(unreadable)?;
            if metadata.is_dir() {
                open.push(entry.path());
                continue;
            }
            let path = entry.path();
            let name = path.strip_prefix(folder)?.to_str();
            let name = name.ok_or_else(|| anyhow!("{}: its name is not UTF-8", path.display()))?;
            sizes.insert(name.to_owned(), metadata.len());
        }
    }
    Ok(sizes)
}

/// What tells a file from others.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct Sum {
    pub(super) bytes: u64,
    /// In hexadecimal digits.
    pub(super) sha256: String,
}

impl Sum {
    /// Of some bytes.
    pub(super) fn of(bytes: &[u8]) -> Self {
        Self::made(bytes.len() as u64, Sha256::new_with_prefix(bytes))
    }

    /// Of a whole file.
    pub(super) fn of_file(path: &Path) -> io::Result<Self> {
        let mut hash = Sha256::new();
        let mut file = BufReader::new(File::open(path)?);
        let mut bytes = 0;
        loop {
            let data = file.fill_buf()?;
            let length = data.len();
            if length == 0 {
                return Ok(Self::made(bytes, hash));
            }
            hash.update(data);
            bytes += length as u64;
            file.consume(length);
        }
    }

    fn made(bytes: u64, hash: Sha256) -> Self {
        let sha256 = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Self { bytes, sha256 }
    }
}

/// Of all files of a folder.
pub(super) fn sums(folder: &Path) -> anyhow::Result<BTreeMap<String, Sum>> {
    let sum = |path: String| {
        let sum = Sum::of_file(&folder.join(&path)).with_context(|| path.clone())?;
        anyhow::Ok((path, sum))
    };
    sizes(folder)?.into_par_iter().map(|(path, _)| sum(path)).collect()
}
