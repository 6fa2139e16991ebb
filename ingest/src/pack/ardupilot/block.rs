//! A block of heights as the autopilot reads it from a card: 2048 bytes, the least significant first.
//!
//! ```text
//!    0 u64 bitmap  8 i32 latitude  12 i32 longitude  16 u16 checksum  18 u16 version  20 u16 spacing
//!   22 i16 × 28 × 32 heights, the south row first, each from west to east
//! 1814 u16 row of blocks  1816 u16 column  1818 i16 longitude  1820 i8 latitude, degrees  1821 u8 minor version
//! ```
//! A bit of the bitmap is one of 4 × 4 posts. The checksum is that of the bytes before the minor version, itself taken as 0.

use crc::{CRC_16_XMODEM, Crc};

use super::lattice::{Lattice, POSTS};

/// Bytes of a block.
pub(super) const BYTES: usize = 2048;
/// How far the checksum goes.
const CHECKED: usize = 1821;
const CHECKSUM_AT: usize = 16;
const VERSION: u16 = 1;
/// An autopilot does not arm with blocks of a lower one.
const MINOR_VERSION: u8 = 1;
/// Posts along a side of what a bit stands for.
const SQUARE: u32 = 4;
/// The height of a post without ground, in case that a reader does not look at the bitmap: below all ground.
const NO_GROUND: i16 = i16::MIN;

/// The block at a row and column of a file, of heights of its posts in whole metres, the south row first.
pub(super) fn encode(lattice: Lattice, index: [u32; 2], heights: &[Option<i16>]) -> Vec<u8> {
    let [latitude, longitude] = lattice.block(index);
    let mut bytes = Vec::with_capacity(BYTES);
    bytes.extend(bitmap(heights).to_le_bytes());
    bytes.extend(latitude.to_le_bytes());
    bytes.extend(longitude.to_le_bytes());
    bytes.extend(0_u16.to_le_bytes());
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(lattice.spacing.to_le_bytes());
    let metres = heights.iter().map(|height| height.unwrap_or(NO_GROUND));
    bytes.extend(metres.flat_map(i16::to_le_bytes));
    bytes.extend(index.map(|number| number as u16).into_iter().flat_map(u16::to_le_bytes));
    bytes.extend(lattice.longitude.to_le_bytes());
    bytes.extend(lattice.latitude.to_le_bytes());
    let checksum = Crc::<u16>::new(&CRC_16_XMODEM).checksum(&bytes[..CHECKED]);
    bytes[CHECKSUM_AT..CHECKSUM_AT + 2].copy_from_slice(&checksum.to_le_bytes());
    bytes.push(MINOR_VERSION);
    bytes.resize(BYTES, 0);
    bytes
}

/// Those squares of posts are there of which every post has ground.
fn bitmap(heights: &[Option<i16>]) -> u64 {
    let squares = POSTS.map(|posts| posts / SQUARE);
    let is_whole = |row: u32, column: u32| {
        let posts =
            (0..SQUARE).flat_map(|up| (0..SQUARE).map(move |across| (row * SQUARE + up, column * SQUARE + across)));
        posts
            .into_iter()
            .all(|(up, across)| heights[(up * POSTS[1] + across) as usize].is_some())
    };
    let all = (0..squares[0]).flat_map(|row| (0..squares[1]).map(move |column| (row, column)));
    let set = all.filter(|&(row, column)| is_whole(row, column));
    set.fold(0, |bits, (row, column)| bits | 1 << (row * squares[1] + column))
}

#[cfg(test)]
#[path = "block_tests.rs"]
mod tests;
