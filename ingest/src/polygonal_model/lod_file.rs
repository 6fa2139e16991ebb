//! The ASCII file of a progressive multilevel mesh, `.lod`.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Result, ensure};
use terrain_core::streaming::multilevel::{MultilevelLimits, MultilevelMesh};
use terrain_tiles::formats::lod;

use super::ModelError;
use super::levels::LeveledModel;
use crate::new_file::new_file_for;

/// Reads the levels of a file of dimension 3. Their errors are not known.
pub(super) fn read(path: &Path, limits: MultilevelLimits) -> Result<LeveledModel, ModelError> {
    let mesh = lod::read(File::open(path)?, limits)?;
    let partition = mesh.to_partition().map_err(|_| ModelError::EmptyLevel)?;
    Ok(LeveledModel {
        partition,
        columns: Vec::new(),
        lattice: None,
    })
}

/// Writes all levels, all at once or not at all, after comments with their errors.
pub(super) fn write(output: &Path, leveled: &LeveledModel) -> Result<()> {
    let text = lod::write(&multilevel(leveled)?, &errors(leveled));
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

/// What each level claims, the finest first, where it is known.
fn errors(leveled: &LeveledModel) -> Vec<String> {
    let errors = leveled
        .partition
        .levels
        .iter()
        .rev()
        .map(|level| level.error)
        .enumerate();
    let known = errors.filter(|(_, error)| error.is_finite());
    known
        .map(|(level, error)| format!("level {level}: distance from the model at most {error}"))
        .collect()
}
