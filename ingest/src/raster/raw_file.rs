//! Raw height maps (`.r16`, `.raw`), as game engines have them: 16 bits a sample, row by row, as many rows as columns, and nothing else.

use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::ReadError;
use super::reader::{Found, Reader};

const BYTES: usize = 2;

pub(super) struct RawFile {
    path: std::path::PathBuf,
    file: File,
    side: usize,
    is_big_endian: bool,
}

impl RawFile {
    pub(super) fn open(path: &Path, is_big_endian: bool) -> Result<Found, ReadError> {
        let unreadable = |error: std::io::Error| ReadError::unreadable(path, error);
        let file = File::open(path).map_err(unreadable)?;
        let bytes = file.metadata().map_err(unreadable)?.len();
        let side = (bytes / BYTES as u64).isqrt() as usize;
        if bytes != (side * side * BYTES) as u64 {
            let reason = format!("{bytes} bytes are no square of samples of 16 bits");
            return Err(ReadError::unreadable(path, reason));
        }
        let reader = Self {
            path: path.to_owned(),
            file,
            side,
            is_big_endian,
        };
        Ok(Found::bare(reader, [side, side], f64::from(u16::MAX)))
    }
}

impl Reader for RawFile {
    fn stored(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f64>, ReadError> {
        let value = |bytes: &[u8]| {
            let bytes = [bytes[0], bytes[1]];
            f64::from(if self.is_big_endian {
                u16::from_be_bytes(bytes)
            } else {
                u16::from_le_bytes(bytes)
            })
        };
        let mut values = Vec::with_capacity(columns.len() * rows.len());
        let mut row_bytes = vec![0; columns.len() * BYTES];
        for row in rows {
            let first = (row * self.side + columns.start) * BYTES;
            let read = self.file.read_exact_at(&mut row_bytes, first as u64);
            read.map_err(|error| ReadError::unreadable(&self.path, error))?;
            values.extend(row_bytes.chunks_exact(BYTES).map(value));
        }
        Ok(values)
    }
}
