//! The ASCII file of a progressive multilevel mesh, `.lod`, whose grammar is the papers' and stands in
//! [`terrain_core::streaming::multilevel`].

use std::io::{self, Read};

use terrain_core::streaming::multilevel::{self, AsciiReader, MultilevelLimits, MultilevelMesh};
use thiserror::Error;

/// Bytes read at once.
const PIECE: usize = 1 << 16;

/// Why a file is no multilevel mesh.
#[derive(Debug, Error)]
pub enum LodError {
    /// The system says no.
    #[error("cannot be read")]
    Unreadable(#[from] io::Error),
    /// The bytes are not of the format.
    #[error("not a readable multilevel file")]
    Malformed(#[from] multilevel::ReadError),
}

/// Reads a file of dimension 3, piece by piece.
///
/// # Errors
/// Where it cannot be read, is of another grammar, or exceeds `limits`.
pub fn read(mut file: impl Read, limits: MultilevelLimits) -> Result<MultilevelMesh, LodError> {
    let mut reader = AsciiReader::<3>::new(limits);
    let mut piece = vec![0; PIECE];
    loop {
        let length = file.read(&mut piece)?;
        if length == 0 {
            return Ok(reader.finish()?);
        }
        reader.push(&piece[..length])?;
    }
}

/// The whole file: `comments`, one a line, and then the mesh.
#[must_use]
pub fn write(mesh: &MultilevelMesh, comments: &[String]) -> String {
    let comments = comments.iter().map(|comment| format!("#{comment}\n"));
    comments.collect::<String>() + &multilevel::to_ascii(mesh)
}
