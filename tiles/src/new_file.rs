//! Files that appear at their path when they are whole, or not at all.
//!
//! What is written waits beside the output as `.NAME.part`. A program that is killed leaves that one file, and the next one that
//! writes the same output takes it over, so that no litter piles up.

use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

/// A file on its way to its path. Dropped before it is finished, it leaves what was there as it was.
pub struct NewFile {
    part: NamedTempFile,
    output: PathBuf,
}

impl NewFile {
    /// An empty file that is to be `output`, or what `output` links to.
    ///
    /// # Errors
    /// Where the folder cannot be written, another program is writing the same output, or something is there that is no file: root
    /// may move a file over `/dev/null`, which other programs then read and write.
    pub fn create(output: &Path) -> io::Result<Self> {
        let output = match fs::canonicalize(output) {
            Ok(there) if there.is_file() => there,
            Ok(_) => return Err(io::Error::new(io::ErrorKind::InvalidInput, "is not a file")),
            Err(error) if error.kind() == io::ErrorKind::NotFound => output.to_owned(),
            Err(error) => return Err(error),
        };
        Ok(Self {
            part: part_of(&output)?,
            output,
        })
    }

    /// What to write to.
    pub fn file(&mut self) -> &mut File {
        self.part.as_file_mut()
    }

    /// Puts the file at its path, over any that is there, when all of it is on the disk.
    ///
    /// # Errors
    /// Where the disk is full or the folder cannot be written any more.
    pub fn finish(self) -> io::Result<()> {
        self.part.as_file().sync_all()?;
        self.part.persist(self.output)?;
        Ok(())
    }
}

/// The empty file beside `output`, locked as long as it is open, and removed if it does not become the output.
fn part_of(output: &Path) -> io::Result<NamedTempFile> {
    let path = part_path(output);
    loop {
        let mut options = File::options();
        let file = options.write(true).create(true).truncate(false).open(&path)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(io::Error::new(
                    io::ErrorKind::ResourceBusy,
                    "another program is writing it",
                ));
            }
            // A file system without locks leaves it to its users not to write one file twice at once.
            Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => return Err(error),
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        if is_at(&file, &path)? {
            file.set_len(0)?;
            return Ok(NamedTempFile::from_parts(file, TempPath::try_from_path(path)?));
        }
        // It became another program's output before it was locked here.
    }
}

fn part_path(output: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(output.file_name().unwrap_or_default());
    name.push(".part");
    output.with_file_name(name)
}

fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    let opened = file.metadata()?;
    match fs::metadata(path) {
        Ok(there) => Ok((opened.dev(), opened.ino()) == (there.dev(), there.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
#[path = "new_file_tests.rs"]
mod tests;
