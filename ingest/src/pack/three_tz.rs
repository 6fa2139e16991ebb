//! A folder of 3D Tiles as one file (Maxar, *3D Tiles Archive Format* 1.3): a ZIP of files as they are, the last of which tells where
//! each is by the hash of its path, so that whoever reads one file need not read the list of all.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use md5::{Digest, Md5};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// Path of the file with the index.
const INDEX: &str = "@3dtilesIndex1@";

/// Writes the files of `folder` that are at `paths`, in their order, as `output`.
pub(super) fn write<'a>(folder: &Path, paths: impl Iterator<Item = &'a str>, output: &Path) -> anyhow::Result<()> {
    // One time for all: the same files give the same bytes.
    let as_they_are = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::DEFAULT)
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(File::create_new(output)?);
    for path in paths {
        archive.start_file(path, as_they_are)?;
        io::copy(&mut File::open(folder.join(path))?, &mut archive)?;
    }
    archive.finish()?;
    let index = index(output)?;
    let file = fs::OpenOptions::new().read(true).write(true).open(output)?;
    let mut archive = ZipWriter::new_append(file)?;
    archive.start_file(INDEX, as_they_are)?;
    io::copy(&mut index.as_slice(), &mut archive)?;
    archive.finish()?;
    Ok(())
}

/// For each file the hash of its path and where its header is, sorted by the hash as two numbers with the least significant byte first.
fn index(archive: &Path) -> anyhow::Result<Vec<u8>> {
    let mut archive = ZipArchive::new(File::open(archive)?)?;
    let mut entries = Vec::with_capacity(archive.len());
    for number in 0..archive.len() {
        let file = archive.by_index_raw(number)?;
        let hash = u128::from_le_bytes(Md5::digest(file.name_raw()).into());
        entries.push((hash as u64, (hash >> 64) as u64, file.header_start()));
    }
    entries.sort_unstable();
    let numbers = entries
        .iter()
        .flat_map(|&(first, second, start)| [first, second, start]);
    Ok(numbers.flat_map(u64::to_le_bytes).collect())
}
