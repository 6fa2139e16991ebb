//! Where the ground of a tile was not measured: its source has voids there that were filled from their rims.
//!
//! A tile's square is cut into 256 × 256 cells, rows from the south, cells from the west. A cell is filled if some ground in it is.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use glam::DVec2;

/// Cells along a side.
pub const CELLS: usize = 256;
/// Cells whose bits are in one number.
const IN_WORD: usize = u64::BITS as usize;
const WORDS: usize = CELLS * CELLS / IN_WORD;

/// The cells of a tile that have filled ground.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filled {
    /// One bit a cell, the lowest first; no numbers at all where no cell is filled.
    words: Vec<u64>,
}

impl Filled {
    /// Whether all ground was measured.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Whether there is filled ground in the cell of a place, in parts of the tile's side from its south-west corner.
    #[must_use]
    pub fn has(&self, at: DVec2) -> bool {
        let [column, row] = at.to_array().map(cell);
        !self.is_empty() && self.bit(column, row)
    }

    /// Filled cells, by column and row.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 2]> {
        let numbers = 0..self.words.len() * IN_WORD;
        numbers
            .map(|number| [number % CELLS, number / CELLS])
            .filter(|&[column, row]| self.bit(column, row))
    }

    /// Takes all cells as filled that a rectangle has a part in; its corners are in parts of the tile's side, and may be beside it.
    pub fn fill(&mut self, low: DVec2, high: DVec2) {
        let is_beside = high.cmplt(DVec2::ZERO).any() || low.cmpgt(DVec2::ONE).any();
        if is_beside || low.is_nan() || high.is_nan() {
            return;
        }
        let ([west, south], [east, north]) = (low.to_array().map(cell), high.to_array().map(cell));
        for row in south..=north {
            (west..=east).for_each(|column| self.set(column, row));
        }
    }

    /// Takes over what a child has, which is the quarter of the tile at `quarter`: 0 or 1 from the west, 0 or 1 from the south.
    pub fn take_over(&mut self, child: &Self, quarter: [usize; 2]) {
        for cell in child.cells() {
            let [column, row] = [0, 1].map(|axis| (quarter[axis] * CELLS + cell[axis]) / 2);
            self.set(column, row);
        }
    }

    fn bit(&self, column: usize, row: usize) -> bool {
        let number = row * CELLS + column;
        self.words[number / IN_WORD] >> (number % IN_WORD) & 1 == 1
    }

    fn set(&mut self, column: usize, row: usize) {
        self.words.resize(WORDS, 0);
        let number = row * CELLS + column;
        self.words[number / IN_WORD] |= 1 << (number % IN_WORD);
    }

    /// A bit a cell, rows from the south and columns from the west, the lowest bit of a byte first; nothing where no cell is filled.
    #[must_use]
    pub fn bits(&self) -> Vec<u8> {
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// All bits, compressed by DEFLATE (RFC 1951); at least one cell is filled.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        let written = encoder.write_all(&self.bits()).and_then(|()| encoder.finish());
        written.expect("memory can be written to")
    }

    /// The other way round; none where these are not the bits of all cells, one of them filled.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        const BYTES: usize = CELLS * CELLS / 8;
        let mut bits = Vec::with_capacity(BYTES + 1);
        let mut decoder = DeflateDecoder::new(bytes).take(BYTES as u64 + 1);
        decoder.read_to_end(&mut bits).ok()?;
        let (words, _) = bits.as_chunks();
        let words: Vec<u64> = words.iter().map(|bytes| u64::from_le_bytes(*bytes)).collect();
        (bits.len() == BYTES && words.iter().any(|&word| word != 0)).then_some(Self { words })
    }
}

/// The column, or row, that a part of a side is in; the nearest for one beside it.
fn cell(part: f64) -> usize {
    // Out of range, floats become the nearest integer that there is.
    ((part * CELLS as f64).floor() as usize).min(CELLS - 1)
}

#[cfg(test)]
#[path = "filled_tests.rs"]
mod tests;
