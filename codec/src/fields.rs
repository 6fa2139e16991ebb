//! Numbers in front of coded levels, in as few bytes as each takes: seven bits a byte, the lowest first; and the directory of
//! levels made of them. `docs/formats/spm.md` is the specification.

use std::num::TryFromIntError;

use integer_encoding::VarInt;
use terrain_core::levels::partition::{Level, PartitionError};
use thiserror::Error;

use crate::progressive::{Damaged, Sampling};

/// Bytes of the longest number.
const LONGEST: usize = 6;

/// What a decoder accepts from bytes that it did not make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelLimits {
    /// Levels of a tile or a mesh file.
    pub levels: usize,
    /// Vertices of its finest level.
    pub vertices: usize,
    /// Triangles of its finest level.
    pub triangles: usize,
}

impl Default for LevelLimits {
    fn default() -> Self {
        Self {
            levels: 1024,
            vertices: 1 << 24,
            triangles: 1 << 25,
        }
    }
}

impl LevelLimits {
    pub(crate) fn check_levels(&self, levels: usize) -> Result<(), DecodeError> {
        if levels > self.levels {
            return Err(DecodeError::Limit("the number of levels"));
        }
        Ok(())
    }
}

/// Why bytes are no tile and no mesh file.
#[derive(Debug, Error, PartialEq)]
pub enum DecodeError {
    /// The magic is another's: what it was taken for.
    #[error("not a {0}")]
    Magic(&'static str),
    /// Made by a newer program.
    #[error("{name} of version {found}; this program reads version {read}")]
    Version {
        /// What was read.
        name: &'static str,
        /// Its version.
        found: u8,
        /// The one that can be read.
        read: u8,
    },
    /// Bytes are missing: there are so many.
    #[error("truncated at byte {0}")]
    Truncated(usize),
    /// A field holds what it cannot.
    #[error("{0} is out of range")]
    OutOfRange(&'static str),
    /// A number exceeds the reader's [`LevelLimits`].
    #[error("{0} exceeds this reader's limit")]
    Limit(&'static str),
    /// A level's bytes make no surface.
    #[error(transparent)]
    Damaged(#[from] Damaged),
    /// The arrays do not make a Surface Partition.
    #[error(transparent)]
    Partition(#[from] PartitionError),
}

/// How the bytes of a format begin.
pub(crate) struct Format {
    pub(crate) name: &'static str,
    pub(crate) magic: [u8; 4],
    /// The first and the last version that can be read.
    pub(crate) versions: [u8; 2],
}

/// Reads one field after the other.
pub(crate) struct Fields<'a> {
    /// What was not read yet.
    rest: &'a [u8],
    /// How many bytes there were.
    length: usize,
}

impl<'a> Fields<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            length: bytes.len(),
        }
    }

    /// The fields after magic and version, and the version.
    pub(crate) fn open(bytes: &'a [u8], format: &Format) -> Result<(Self, u8), DecodeError> {
        let mut fields = Self::new(bytes);
        if fields.bytes()? != format.magic {
            return Err(DecodeError::Magic(format.name));
        }
        let [version] = fields.bytes()?;
        let [first, last] = format.versions;
        if !(first..=last).contains(&version) {
            return Err(DecodeError::Version {
                name: format.name,
                found: version,
                read: last,
            });
        }
        Ok((fields, version))
    }

    pub(crate) fn truncated(&self) -> DecodeError {
        DecodeError::Truncated(self.length)
    }

    /// Bytes that were not read yet.
    pub(crate) fn remaining(&self) -> usize {
        self.rest.len()
    }

    pub(crate) fn bytes<const COUNT: usize>(&mut self) -> Result<[u8; COUNT], DecodeError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or_else(|| self.truncated())?;
        self.rest = rest;
        Ok(*bytes)
    }

    /// So many bytes.
    pub(crate) fn run(&mut self, length: usize) -> Result<&'a [u8], DecodeError> {
        let (run, rest) = self.rest.split_at_checked(length).ok_or_else(|| self.truncated())?;
        self.rest = rest;
        Ok(run)
    }

    pub(crate) fn doubles<const COUNT: usize>(&mut self) -> Result<[f64; COUNT], DecodeError> {
        let mut doubles = [0.0; COUNT];
        for double in &mut doubles {
            *double = f64::from_le_bytes(self.bytes()?);
        }
        Ok(doubles)
    }

    /// A number below 2^32.
    pub(crate) fn number(&mut self) -> Result<u32, DecodeError> {
        let number: u64 = self.variable()?;
        u32::try_from(number).map_err(|_| DecodeError::OutOfRange("a number"))
    }

    /// A number between −2^41 and 2^41.
    pub(crate) fn signed_number(&mut self) -> Result<i64, DecodeError> {
        self.variable()
    }

    fn variable<N: VarInt>(&mut self) -> Result<N, DecodeError> {
        let (number, length) = N::decode_var(self.rest).ok_or_else(|| self.truncated())?;
        self.rest = &self.rest[length..];
        if length > LONGEST {
            return Err(DecodeError::OutOfRange("a number"));
        }
        Ok(number)
    }
}

impl Sampling {
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        let numbers = [self.origin, self.step];
        bytes.extend(numbers.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
    }

    /// Reads where samples lie, if it is told.
    pub(crate) fn read(fields: &mut Fields, is_told: bool) -> Result<Option<Self>, DecodeError> {
        if !is_told {
            return Ok(None);
        }
        let [column, row, across, down] = fields.doubles()?;
        Ok(Some(Self {
            origin: [column, row],
            step: [across, down],
        }))
    }
}

/// What the directory tells of a level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    /// Bytes of its splits.
    pub(crate) length: usize,
    pub(crate) level: Level,
    /// How far its outline may be off, where that is told.
    pub(crate) outline_error: f32,
}

/// Writes or reads the entries of a directory in order; each is told by what is new since the one before.
pub(crate) struct Directory {
    has_outline_errors: bool,
    vertices: i64,
    triangles: i64,
    error: u32,
    outline_error: u32,
}

impl Directory {
    /// Before the first entry.
    pub(crate) fn new(has_outline_errors: bool) -> Self {
        Self {
            has_outline_errors,
            vertices: 0,
            triangles: 0,
            error: 0,
            outline_error: 0,
        }
    }

    /// Writes an entry whose error is one of single precision; none if it has 2^32 bytes or more.
    pub(crate) fn write(&mut self, bytes: &mut Vec<u8>, entry: &Entry) -> Result<(), TryFromIntError> {
        let Level {
            vertex_end,
            triangle_end,
            error,
        } = entry.level;
        let vertices = i64::from(vertex_end) - self.vertices;
        let triangles = i64::from(triangle_end) - self.triangles;
        let errors = [(error as f32).to_bits(), entry.outline_error.to_bits()];
        bytes.extend(u32::try_from(entry.length)?.encode_var_vec());
        bytes.extend(vertices.unsigned_abs().encode_var_vec());
        bytes.extend((2 * vertices - triangles).encode_var_vec());
        bytes.extend((i64::from(errors[0]) - i64::from(self.error)).encode_var_vec());
        if self.has_outline_errors {
            bytes.extend((i64::from(errors[1]) - i64::from(self.outline_error)).encode_var_vec());
        }
        (self.vertices, self.triangles) = (i64::from(vertex_end), i64::from(triangle_end));
        [self.error, self.outline_error] = errors;
        Ok(())
    }

    /// Reads all entries.
    pub(crate) fn read_all(
        mut self,
        fields: &mut Fields,
        count: usize,
        limits: &LevelLimits,
    ) -> Result<Vec<Entry>, DecodeError> {
        (0..count).map(|_| self.read(fields, limits)).collect()
    }

    fn read(&mut self, fields: &mut Fields, limits: &LevelLimits) -> Result<Entry, DecodeError> {
        let length = fields.number()? as usize;
        let vertices = i64::from(fields.number()?);
        self.vertices += vertices;
        self.triangles += 2 * vertices - fields.signed_number()?;
        let end = |count: i64| {
            u32::try_from(count).map_err(|_| DecodeError::OutOfRange("the number of vertices or triangles"))
        };
        let [vertex_end, triangle_end] = [end(self.vertices)?, end(self.triangles)?];
        if vertex_end as usize > limits.vertices {
            return Err(DecodeError::Limit("the number of vertices"));
        }
        if triangle_end as usize > limits.triangles {
            return Err(DecodeError::Limit("the number of triangles"));
        }
        self.error = changed(self.error, fields.signed_number()?)?;
        if self.has_outline_errors {
            self.outline_error = changed(self.outline_error, fields.signed_number()?)?;
        }
        Ok(Entry {
            length,
            level: Level {
                vertex_end,
                triangle_end,
                error: f64::from(f32::from_bits(self.error)),
            },
            outline_error: f32::from_bits(self.outline_error),
        })
    }
}

/// The bits of an error that differ by `change` from those of the one before.
fn changed(bits: u32, change: i64) -> Result<u32, DecodeError> {
    let bits = u32::try_from(i64::from(bits) + change).ok();
    bits.filter(|&bits| f32::from_bits(bits) >= 0.0)
        .ok_or(DecodeError::OutOfRange("an error"))
}

#[cfg(test)]
#[path = "fields_tests.rs"]
mod tests;
