//! The progressive tile format, version 2: `docs/formats/spt.md` is its specification.
//!
//! ```text
//! ┌────────┬───────────┬─────────┬─────────┬─ … ─┬──────┬───────┬──────┬───────┐
//! │ header │ directory │ level 0 │ level 1 │     │ west │ south │ east │ north │
//! └────────┴───────────┴─────────┴─────────┴─ … ─┴──────┴───────┴──────┴───────┘
//! ```
//! What is in a level is [`crate::progressive`]'s.

use glam::DVec3;
use terrain_core::SurfacePartition;
use terrain_core::partition::{self, Level, PartitionError};
use thiserror::Error;

use crate::address::{Side, TileAddress};
use crate::progressive::{self, BaseSize, Damaged, Frame, Sampling};
use crate::tile::Tile;

const MAGIC: &[u8; 4] = b"SPTL";
const VERSION: u8 = 2;
const HEADER_LENGTH: usize = 72;
const ENTRY_LENGTH: usize = 20;
/// Lattice coordinates must stay exact integers in an `f64`.
const MAX_EXTENT_BITS: u8 = 40;
/// The flag of a tile whose samples are told.
const SAMPLED: u16 = 1;

/// What a decoder accepts from bytes that it did not make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Levels of a tile.
    pub levels: usize,
    /// Vertices of a tile.
    pub vertices: usize,
    /// Triangles of a tile.
    pub triangles: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            levels: 1024,
            vertices: 1 << 24,
            triangles: 1 << 25,
        }
    }
}

/// Why a tile cannot be written.
#[derive(Debug, Error, PartialEq)]
pub enum EncodeError {
    /// Fewer levels than the four sides and one interior, or more than fit their field.
    #[error("a tile needs 5 to 65,535 levels, each with its outline error")]
    Levels,
    /// A coordinate is no multiple of its step or outside the tile, or the surface is no manifold where vertices collapse.
    #[error(transparent)]
    Surface(#[from] progressive::EncodeError),
    /// The lattice is too fine, or the samples are not where any can be.
    #[error("the tile's lattice or its samples are out of range")]
    Lattice,
    /// More bytes than the 32-bit offsets reach.
    #[error("the tile is larger than 4 GiB")]
    TooLarge,
}

/// Why bytes are no tile.
#[derive(Debug, Error, PartialEq)]
pub enum DecodeError {
    /// The magic is another's.
    #[error("not a progressive terrain tile")]
    NotATile,
    /// Made by a newer program.
    #[error("tile format version {0}; this program reads version {VERSION}")]
    Version(u8),
    /// Bytes are missing.
    #[error("truncated at byte {0}")]
    Truncated(usize),
    /// A field holds what it cannot.
    #[error("{0} is out of range")]
    OutOfRange(&'static str),
    /// A level's bytes make no surface.
    #[error(transparent)]
    Damaged(#[from] Damaged),
    /// A number exceeds the reader's [`Limits`].
    #[error("{0} exceeds this reader's limit")]
    Limit(&'static str),
    /// The arrays do not make a Surface Partition.
    #[error(transparent)]
    Partition(#[from] PartitionError),
}

/// Writes a tile.
///
/// # Errors
/// When the tile is not what [`Tile`] says it is.
pub fn encode(tile: &Tile) -> Result<Vec<u8>, EncodeError> {
    let count = tile.partition.levels.len();
    if !(5..=usize::from(u16::MAX)).contains(&count) || tile.outline_errors.len() != count {
        return Err(EncodeError::Levels);
    }
    let partition = scaled(&tile.partition, (-f64::from(tile.height_exponent)).exp2());
    let heights = height_range(&partition);
    let frame = frame(tile.extent_bits, heights.map(f64::from), tile.sampling);
    if tile.extent_bits > MAX_EXTENT_BITS || !frame.is_valid() {
        return Err(EncodeError::Lattice);
    }
    let coded = progressive::encode(&partition, &frame)?;
    let length = HEADER_LENGTH + ENTRY_LENGTH * count + coded.levels.iter().map(Vec::len).sum::<usize>();
    let mut bytes = Vec::with_capacity(length);
    write_header(&mut bytes, tile, heights, coded.base);
    bytes[28..32].copy_from_slice(&u32::try_from(length).map_err(|_| EncodeError::TooLarge)?.to_le_bytes());
    let mut end = HEADER_LENGTH + ENTRY_LENGTH * count;
    for (index, level) in partition.levels.iter().enumerate() {
        end += coded.levels[index].len();
        bytes.extend((end as u32).to_le_bytes());
        bytes.extend(level.vertex_end.to_le_bytes());
        bytes.extend(level.triangle_end.to_le_bytes());
        bytes.extend(rounded_up(level.error).to_le_bytes());
        bytes.extend(rounded_up(tile.outline_errors[index]).to_le_bytes());
    }
    coded.levels.iter().for_each(|level| bytes.extend(level));
    Ok(bytes)
}

/// Reads a whole tile. Vertices and triangles of each level come in the order of their splits.
///
/// # Errors
/// When the bytes are not a tile of this version, or exceed `limits`.
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Tile, DecodeError> {
    let header = Header::read(bytes, limits)?;
    let mut start = HEADER_LENGTH + ENTRY_LENGTH * header.levels;
    let (mut levels, mut runs) = (Vec::with_capacity(header.levels), Vec::with_capacity(header.levels));
    let mut outline_errors = Vec::with_capacity(header.levels);
    for index in 0..header.levels {
        let entry = Entry::read(bytes, index, limits)?;
        if entry.end < start {
            return Err(DecodeError::OutOfRange("the end of a level"));
        }
        runs.push(bytes.get(start..entry.end).ok_or(DecodeError::Truncated(bytes.len()))?);
        start = entry.end;
        levels.push(entry.level);
        outline_errors.push(entry.outline_error);
    }
    if start != bytes.len() {
        return Err(DecodeError::OutOfRange("the length of the tile"));
    }
    let partition = progressive::decode(header.base, &levels, &runs, &header.frame)?;
    partition::validate(&partition)?;
    Ok(Tile {
        address: header.address,
        extent_bits: header.extent_bits,
        height_exponent: header.height_exponent,
        sampling: header.frame.sampling,
        partition: scaled(&partition, f64::from(header.height_exponent).exp2()),
        outline_errors,
    })
}

/// The same partition with heights in another unit.
fn scaled(partition: &SurfacePartition, scale: f64) -> SurfacePartition {
    let scaled = |positions: &[DVec3]| positions.iter().map(|&at| at * DVec3::new(1.0, 1.0, scale)).collect();
    SurfacePartition {
        positions: scaled(&partition.positions),
        blue_positions: scaled(&partition.blue_positions),
        ..partition.clone()
    }
}

/// The lowest and the highest, in steps; those beyond an `i32` are left to be found off the lattice.
fn height_range(partition: &SurfacePartition) -> [i32; 2] {
    let heights = || {
        let positions = partition.positions.iter().chain(&partition.blue_positions);
        positions.map(|position| position.z as i32)
    };
    [heights().min().unwrap_or(0), heights().max().unwrap_or(0)]
}

fn frame(extent_bits: u8, [lowest, highest]: [f64; 2], sampling: Option<Sampling>) -> Frame {
    let extent = f64::from(extent_bits).exp2();
    Frame {
        bounds: [DVec3::new(0.0, 0.0, lowest), DVec3::new(extent, extent, highest)],
        is_height_field: true,
        sampling,
        boundary_levels: Side::ALL.len(),
    }
}

struct Header {
    address: TileAddress,
    extent_bits: u8,
    height_exponent: i8,
    levels: usize,
    base: BaseSize,
    frame: Frame,
}

impl Header {
    fn read(bytes: &[u8], limits: &Limits) -> Result<Self, DecodeError> {
        let fixed: &[u8; HEADER_LENGTH] = bytes.first_chunk().ok_or(DecodeError::Truncated(bytes.len()))?;
        if &fixed[..4] != MAGIC {
            return Err(DecodeError::NotATile);
        }
        if fixed[4] != VERSION {
            return Err(DecodeError::Version(fixed[4]));
        }
        let levels = usize::from(u16::from_le_bytes([fixed[24], fixed[25]]));
        if levels > limits.levels {
            return Err(DecodeError::Limit("the number of levels"));
        }
        if levels <= Side::ALL.len() {
            return Err(DecodeError::OutOfRange("the number of levels"));
        }
        if fixed[6] > MAX_EXTENT_BITS {
            return Err(DecodeError::OutOfRange("the lattice extent"));
        }
        let heights = [16, 20].map(|at| f64::from(word(fixed, at).cast_signed()));
        let frame = frame(fixed[6], heights, sampling(fixed));
        if !frame.is_valid() {
            return Err(DecodeError::OutOfRange("the lattice"));
        }
        let address = TileAddress::new(fixed[5], word(fixed, 8), word(fixed, 12));
        Ok(Self {
            address: address.ok_or(DecodeError::OutOfRange("the tile address"))?,
            extent_bits: fixed[6],
            height_exponent: fixed[7].cast_signed(),
            levels,
            base: BaseSize {
                vertices: word(fixed, 32),
                triangles: word(fixed, 36),
            },
            frame,
        })
    }
}

fn sampling(header: &[u8; HEADER_LENGTH]) -> Option<Sampling> {
    let [column, row, across, down] = [40, 48, 56, 64].map(|at| double(header, at));
    let is_sampled = u16::from_le_bytes([header[26], header[27]]) & SAMPLED != 0;
    is_sampled.then_some(Sampling {
        origin: [column, row],
        step: [across, down],
    })
}

struct Entry {
    end: usize,
    level: Level,
    outline_error: f64,
}

impl Entry {
    fn read(bytes: &[u8], index: usize, limits: &Limits) -> Result<Self, DecodeError> {
        let start = HEADER_LENGTH + ENTRY_LENGTH * index;
        let entry = bytes
            .get(start..start + ENTRY_LENGTH)
            .ok_or(DecodeError::Truncated(bytes.len()))?;
        let level = Level {
            vertex_end: word(entry, 4),
            triangle_end: word(entry, 8),
            error: f64::from(f32::from_bits(word(entry, 12))),
        };
        if level.vertex_end as usize > limits.vertices {
            return Err(DecodeError::Limit("the number of vertices"));
        }
        if level.triangle_end as usize > limits.triangles {
            return Err(DecodeError::Limit("the number of triangles"));
        }
        let outline_error = f64::from(f32::from_bits(word(entry, 16)));
        if outline_error.is_nan() || outline_error < 0.0 || level.error < 0.0 {
            return Err(DecodeError::OutOfRange("an error"));
        }
        Ok(Self {
            end: word(entry, 0) as usize,
            level,
            outline_error,
        })
    }
}

/// All but the length of the tile.
fn write_header(bytes: &mut Vec<u8>, tile: &Tile, heights: [i32; 2], base: BaseSize) {
    bytes.extend(MAGIC);
    bytes.extend([
        VERSION,
        tile.address.zoom,
        tile.extent_bits,
        tile.height_exponent.cast_unsigned(),
    ]);
    bytes.extend(tile.address.x.to_le_bytes());
    bytes.extend(tile.address.y.to_le_bytes());
    heights.iter().for_each(|height| bytes.extend(height.to_le_bytes()));
    bytes.extend((tile.partition.levels.len() as u16).to_le_bytes());
    bytes.extend((u16::from(tile.sampling.is_some()) * SAMPLED).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(base.vertices.to_le_bytes());
    bytes.extend(base.triangles.to_le_bytes());
    let numbers = tile
        .sampling
        .map_or([[0.0; 2]; 2], |sampling| [sampling.origin, sampling.step]);
    for number in numbers.as_flattened() {
        bytes.extend(number.to_le_bytes());
    }
}

/// The smallest `f32` that is not below `value`.
#[must_use]
pub fn rounded_up(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) < value {
        nearest.next_up()
    } else {
        nearest
    }
}

pub(crate) fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

pub(crate) fn double(bytes: &[u8], at: usize) -> f64 {
    f64::from_bits(u64::from(word(bytes, at)) | u64::from(word(bytes, at + 4)) << 32)
}

#[cfg(test)]
#[path = "codec_tests.rs"]
mod tests;
