//! Numbers in front of coded levels, in as few bytes as each takes: seven bits a byte, the lowest first; and the directory of
//! levels made of them. `docs/formats/spm.md` is the specification.

use std::num::TryFromIntError;

use integer_encoding::VarInt;
use terrain_core::partition::Level;

use crate::codec::Limits;
use crate::progressive::{Run, Sampling};

/// Bytes of the longest number.
const LONGEST: usize = 6;

/// Why the fields of a header cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FieldError {
    /// The bytes end within them.
    Truncated,
    /// A field holds what it cannot.
    OutOfRange(&'static str),
    /// A number exceeds the reader's [`Limits`].
    Limit(&'static str),
}

/// Reads one field after the other.
pub(crate) struct Fields<'a> {
    /// What was not read yet.
    pub(crate) rest: &'a [u8],
}

impl Fields<'_> {
    pub(crate) fn bytes<const COUNT: usize>(&mut self) -> Result<[u8; COUNT], FieldError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(FieldError::Truncated)?;
        self.rest = rest;
        Ok(*bytes)
    }

    pub(crate) fn doubles<const COUNT: usize>(&mut self) -> Result<[f64; COUNT], FieldError> {
        let mut doubles = [0.0; COUNT];
        for double in &mut doubles {
            *double = f64::from_le_bytes(self.bytes()?);
        }
        Ok(doubles)
    }

    /// A number below 2^32.
    pub(crate) fn number(&mut self) -> Result<u32, FieldError> {
        let number: u64 = self.variable()?;
        u32::try_from(number).map_err(|_| FieldError::OutOfRange("a number"))
    }

    /// A number between −2^41 and 2^41.
    fn signed_number(&mut self) -> Result<i64, FieldError> {
        self.variable()
    }

    fn variable<N: VarInt>(&mut self) -> Result<N, FieldError> {
        let (number, length) = N::decode_var(self.rest).ok_or(FieldError::Truncated)?;
        self.rest = &self.rest[length..];
        if length > LONGEST {
            return Err(FieldError::OutOfRange("a number"));
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
    pub(crate) fn read(fields: &mut Fields, is_told: bool) -> Result<Option<Self>, FieldError> {
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

    pub(crate) fn read(&mut self, fields: &mut Fields, limits: &Limits) -> Result<Entry, FieldError> {
        let length = fields.number()? as usize;
        let vertices = i64::from(fields.number()?);
        self.vertices += vertices;
        self.triangles += 2 * vertices - fields.signed_number()?;
        let out_of_range = FieldError::OutOfRange("the number of vertices or triangles");
        let [vertex_end, triangle_end] = [self.vertices, self.triangles].map(u32::try_from);
        let [vertex_end, triangle_end] = [
            vertex_end.map_err(|_| out_of_range)?,
            triangle_end.map_err(|_| out_of_range)?,
        ];
        if vertex_end as usize > limits.vertices {
            return Err(FieldError::Limit("the number of vertices"));
        }
        if triangle_end as usize > limits.triangles {
            return Err(FieldError::Limit("the number of triangles"));
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

/// The bytes of each level, of which the last that there are any of may be cut. None where there are more bytes than levels take.
pub(crate) fn runs<'a>(entries: &[Entry], mut bytes: &'a [u8]) -> Option<Vec<Run<'a>>> {
    let mut runs: Vec<Run> = Vec::with_capacity(entries.len());
    for entry in entries {
        let (run, rest) = bytes.split_at_checked(entry.length).unwrap_or((bytes, &[]));
        let is_cut = run.len() < entry.length;
        if is_cut && run.is_empty() && !runs.is_empty() {
            break;
        }
        runs.push(Run {
            bytes: run,
            is_cut,
            level: entry.level,
        });
        bytes = rest;
        if is_cut {
            break;
        }
    }
    bytes.is_empty().then_some(runs)
}

/// The bits of an error that differ by `change` from those of the one before.
fn changed(bits: u32, change: i64) -> Result<u32, FieldError> {
    let out_of_range = FieldError::OutOfRange("an error");
    let bits = u32::try_from(i64::from(bits) + change).map_err(|_| out_of_range)?;
    if f32::from_bits(bits) >= 0.0 {
        Ok(bits)
    } else {
        Err(out_of_range)
    }
}

#[cfg(test)]
#[path = "fields_tests.rs"]
mod tests;
