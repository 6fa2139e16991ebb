//! Curved levels of detail, `.clod`: every patch of every level, on an integer lattice. `docs/formats/clod.md` is its
//! specification.
//!
//! ```text
//! ┌────────┬─────────┬─────────┬─ … ─┐
//! │ header │ patch 0 │ patch 1 │     │    those that are drawn longest, the coarsest level's, come first
//! └────────┴─────────┴─────────┴─ … ─┘
//! ```
//! A vertex and a curve stand where they are used first. Patches that meet use the same curve, so they have the same control
//! points on it whatever is rounded.

mod lattice;
mod patches;

use glam::DVec3;
use integer_encoding::VarInt;
use terrain_core::curved::level_record::LevelsError;
use terrain_core::curved::levels::CurvedLevels;
use thiserror::Error;

use self::lattice::Lattice;
pub use self::lattice::MOST_BITS;
use self::patches::{PatchReader, PatchWriter};
use super::DecodeError;
use super::fields::{Fields, Format};

const FORMAT: Format = Format {
    name: "file of curved levels",
    magic: *b"CLOD",
    versions: [VERSION; 2],
};
const VERSION: u8 = 1;
/// The least bytes of a patch.
const LEAST_PATCH: usize = 15;

/// What a reader accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurvedLimits {
    /// Levels.
    pub levels: u32,
    /// Patches that all levels have between them.
    pub patches: u32,
}

impl Default for CurvedLimits {
    /// 65,536 levels and 2²⁶ patches.
    fn default() -> Self {
        Self {
            levels: 1 << 16,
            patches: 1 << 26,
        }
    }
}

/// Why levels cannot be written.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum EncodeError {
    /// Positions from infinity to NaN.
    #[error("a control point is not finite")]
    NotFinite,
    /// A lattice that is too fine.
    #[error("a lattice of 2^{0} steps is too fine")]
    TooFine(u32),
}

/// Why bytes are no curved levels.
#[derive(Debug, Error, PartialEq)]
pub enum CurvedError {
    /// The bytes are cut, of another format, or too many.
    #[error(transparent)]
    Bytes(#[from] DecodeError),
    /// The patches make no levels.
    #[error(transparent)]
    Levels(#[from] LevelsError),
}

/// All levels as bytes. Control points are rounded to a lattice of `2^bits` steps along the model's longest side; errors grow by
/// what that moves them.
///
/// # Errors
/// Where there is no such lattice.
pub fn encode(levels: &CurvedLevels, bits: u32) -> Result<Vec<u8>, EncodeError> {
    if bits > MOST_BITS {
        return Err(EncodeError::TooFine(bits));
    }
    let points = || levels.patches().iter().flat_map(|patch| patch.patch.points);
    if !points().all(DVec3::is_finite) {
        return Err(EncodeError::NotFinite);
    }
    let lattice = Lattice::over(points(), bits);
    let mut bytes = FORMAT.magic.to_vec();
    bytes.push(VERSION);
    lattice.write(&mut bytes);
    bytes.extend((levels.len() as u32).encode_var_vec());
    bytes.extend((levels.patches().len() as u32).encode_var_vec());
    let mut writer = PatchWriter::new(lattice);
    levels
        .patches()
        .iter()
        .for_each(|patch| writer.write(&mut bytes, patch));
    Ok(bytes)
}

/// All levels of a file.
///
/// # Errors
/// Where the bytes make none, or more than `limits` allow.
pub fn decode(bytes: &[u8], limits: &CurvedLimits) -> Result<CurvedLevels, CurvedError> {
    let (mut fields, _) = Fields::open(bytes, &FORMAT)?;
    let lattice = Lattice::read(&mut fields)?;
    let [levels, patches] = [fields.number()?, fields.number()?];
    if levels > limits.levels {
        return Err(DecodeError::Limit("the number of levels").into());
    }
    if patches > limits.patches {
        return Err(DecodeError::Limit("the number of patches").into());
    }
    if patches as usize > fields.remaining() / LEAST_PATCH {
        return Err(DecodeError::Truncated(bytes.len()).into());
    }
    let mut reader = PatchReader::new(lattice, levels);
    let read: Result<Vec<_>, DecodeError> = (0..patches).map(|_| reader.read(&mut fields)).collect();
    let read = read?;
    if fields.remaining() > 0 {
        return Err(DecodeError::OutOfRange("the number of bytes after the last patch").into());
    }
    Ok(CurvedLevels::from_patches(read, levels)?)
}

#[cfg(test)]
#[path = "clod_tests.rs"]
mod tests;
