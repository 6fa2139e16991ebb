//! A world for X3D browsers, `.x3d` or `.wrl`, and beside it the `.lod` file that it streams.

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use terrain_tiles::formats::x3d::{Encoding, to_world};
use terrain_tiles::new_file::NewFile;

use super::levels::LeveledModel;
use super::{ModelError, lod_file};

/// Writes the world `output`, after the levels beside it; these are left alone where they are `input`, the file that they
/// were read from.
pub(super) fn write(output: &Path, encoding: Encoding, leveled: &LeveledModel, input: &Path) -> Result<()> {
    let data = output.with_extension("lod");
    let name = data.file_name().unwrap_or_default().to_string_lossy();
    let world = to_world(&lod_file::multilevel(leveled)?, &name, encoding).map_err(ModelError::from)?;
    let mut file = NewFile::create(output)?;
    file.file().write_all(world.as_bytes())?;
    if !is_same_file(input, &data) {
        lod_file::write(&data, leveled)?;
    }
    Ok(file.finish()?)
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}
