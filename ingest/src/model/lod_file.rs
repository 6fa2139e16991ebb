//! The ASCII file of a progressive multilevel mesh, `.lod`.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use anyhow::{Result, ensure};
use terrain_core::streaming::multilevel::{AsciiReader, Limits, MultilevelMesh, to_ascii};

use super::ModelError;
use super::levels::LeveledModel;
use crate::new_file::new_file_for;

/// Bytes read at once.
const PIECE: usize = 1 << 16;

/// Reads the levels of a file of dimension 3. Their errors are not known.
pub(super) fn read(path: &Path, limits: Limits) -> Result<LeveledModel, ModelError> {
    let mut file = File::open(path)?;
    let mut reader = AsciiReader::<3>::new(limits);
    let mut piece = vec![0; PIECE];
    loop {
        let length = file.read(&mut piece)?;
        if length == 0 {
            break;
        }
        reader.push(&piece[..length])?;
    }
    let partition = reader.finish()?.to_partition().map_err(|_| ModelError::EmptyLevel)?;
    Ok(LeveledModel {
        partition,
        columns: Vec::new(),
        lattice: None,
    })
}

/// Writes all levels, all at once or not at all, after comments with their errors.
pub(super) fn write(output: &Path, leveled: &LeveledModel) -> Result<()> {
    let text = errors(leveled) + &to_ascii(&multilevel(leveled)?);
    let mut file = new_file_for(output)?;
    file.write_all(text.as_bytes())?;
    file.persist(output).map_err(io::Error::from)?;
    Ok(())
}

/// The levels as the file has them.
pub(super) fn multilevel(leveled: &LeveledModel) -> Result<MultilevelMesh> {
    ensure!(leveled.keeps_vertices(), ModelError::MovesVertices);
    Ok(MultilevelMesh::from_partition(&leveled.partition)?)
}

fn errors(leveled: &LeveledModel) -> String {
    let mut comments = String::new();
    for (level, extent) in leveled.partition.levels.iter().rev().enumerate() {
        if extent.error.is_finite() {
            // Writing to a string cannot fail.
            let _ = writeln!(
                comments,
                "#level {level}: distance from the model at most {}",
                extent.error
            );
        }
    }
    comments
}
