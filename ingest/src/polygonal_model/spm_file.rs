//! The progressive mesh file, `.spm`: all levels, compressed, of positions on a lattice.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::Result;
use terrain_codec::LevelLimits;
use terrain_codec::spm::{self, ProgressiveMesh};
use terrain_tiles::new_file::NewFile;

use super::ModelError;
use super::levels::{Lattice, LeveledModel};

/// The longest side of a model is divided by two to this, or more where an error asks for it.
const FEWEST_BITS: u32 = 16;
/// Bits of the finest lattice that a file can have.
const MOST_BITS: u32 = 31;
/// Share of an error that rounding to the lattice may take.
const SHARE: f64 = 1.0 / 64.0;

/// Reads the levels of a file and their errors.
pub(super) fn read(path: &Path) -> Result<LeveledModel, ModelError> {
    Ok(in_units(&spm::decode(&fs::read(path)?, &LevelLimits::default())?))
}

/// Rounds positions to a lattice that is fine enough for `error`, if one is to be kept, and drops the columns, which a file
/// has no place for.
///
/// # Errors
/// Where the positions reach too far for any lattice.
pub(super) fn rounded(leveled: &LeveledModel, error: Option<f64>) -> Result<LeveledModel, ModelError> {
    let (low, high) = leveled.bounds();
    let mesh = ProgressiveMesh::quantised(&leveled.partition, bits_for((high - low).max_element(), error))?;
    Ok(in_units(&mesh))
}

/// A model in its own units, which knows its lattice.
fn in_units(mesh: &ProgressiveMesh) -> LeveledModel {
    LeveledModel {
        partition: mesh.in_units(),
        columns: Vec::new(),
        lattice: Some(Lattice {
            origin: mesh.origin,
            step: mesh.step,
        }),
    }
}

/// The fewest bits with which no position is moved by more than its share of `error`.
fn bits_for(longest_side: f64, error: Option<f64>) -> u32 {
    let half_diagonal = |bits: u32| longest_side / f64::from(bits).exp2() * 3.0_f64.sqrt() / 2.0;
    let is_enough = |bits: &u32| error.is_none_or(|error| half_diagonal(*bits) <= error * SHARE);
    (FEWEST_BITS..MOST_BITS).find(is_enough).unwrap_or(MOST_BITS)
}

/// Writes all levels, all at once or not at all. They are rounded where they are on no lattice yet.
pub(super) fn write(output: &Path, leveled: &LeveledModel) -> Result<()> {
    let bytes = match leveled.lattice {
        Some(Lattice { origin, step }) => {
            spm::encode(&ProgressiveMesh::on_lattice(&leveled.partition, origin, step)).map_err(ModelError::from)?
        }
        None => return write(output, &rounded(leveled, None)?),
    };
    let mut file = NewFile::create(output)?;
    file.file().write_all(&bytes)?;
    Ok(file.finish()?)
}
