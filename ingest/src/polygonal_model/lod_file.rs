//! The ASCII file of a progressive multilevel mesh, `.lod`.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use anyhow::{Result, ensure};
use terrain_core::streaming::multilevel::{MultilevelLimits, MultilevelMesh};
use terrain_tiles::formats::lod;
use terrain_tiles::new_file::NewFile;

use super::ModelError;
use super::levels::LeveledModel;

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
    let mut file = NewFile::create(output)?;
    file.file().write_all(text.as_bytes())?;
    Ok(file.finish()?)
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
