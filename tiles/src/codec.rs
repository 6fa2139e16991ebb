//! The progressive tile format, version 1: `docs/formats/spt.md` is its specification.
//!
//! ```text
//! ┌────────┬───────────┬─────────┬─────────┬─ … ─┬──────┬───────┬──────┬───────┐
//! │ header │ directory │ level 0 │ level 1 │     │ west │ south │ east │ north │
//! └────────┴───────────┴─────────┴─────────┴─ … ─┴──────┴───────┴──────┴───────┘
//! ```

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use glam::{DVec3, I64Vec3};
use terrain_core::SurfacePartition;
use terrain_core::partition::{self, Level, PartitionError};
use thiserror::Error;

use crate::address::{Side, TileAddress};
use crate::tile::Tile;

const MAGIC: &[u8; 4] = b"SPTL";
const VERSION: u8 = 1;
const HEADER_LENGTH: usize = 32;
const ENTRY_LENGTH: usize = 32;
/// Lattice coordinates must stay exact integers in an `f64`.
const MAX_EXTENT_BITS: u8 = 40;

/// What a decoder accepts from bytes that it did not make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Levels of a tile.
    pub levels: usize,
    /// Vertices of a tile.
    pub vertices: usize,
    /// Triangles of a tile.
    pub triangles: usize,
    /// Bytes of one level when inflated.
    pub level_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            levels: 1024,
            vertices: 1 << 24,
            triangles: 1 << 25,
            level_bytes: 1 << 30,
        }
    }
}

/// Why a tile cannot be written.
#[derive(Debug, Error, PartialEq)]
pub enum EncodeError {
    /// The tile's partition is none.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// Fewer levels than the four sides and one interior, or more than fit their field.
    #[error("a tile needs 5 to 65,535 levels, each with its outline error")]
    Levels,
    /// A coordinate is no multiple of its step, or beyond what the format holds.
    #[error("vertex {0} is not on the lattice")]
    OffLattice(usize),
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
    /// A level's bytes are no DEFLATE stream, end early or go on too long.
    #[error("level {0} is damaged")]
    Damaged(usize),
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
    let partition = &tile.partition;
    partition::validate(partition)?;
    let count = partition.levels.len();
    if !(5..=usize::from(u16::MAX)).contains(&count) || tile.outline_errors.len() != count {
        return Err(EncodeError::Levels);
    }
    let steps = Steps::of(tile)?;
    let bodies: Vec<Vec<u8>> = (0..count).map(|level| steps.level(partition, level)).collect();
    let packed: Vec<Vec<u8>> = bodies.iter().map(|body| deflate(body)).collect();
    let mut bytes = Vec::new();
    write_header(&mut bytes, tile, &steps, &packed)?;
    let mut offset = HEADER_LENGTH + ENTRY_LENGTH * count;
    for (index, level) in partition.levels.iter().enumerate() {
        let kind = (index + Side::ALL.len() + 1).saturating_sub(count) as u8;
        bytes.extend([kind, 0, 0, 0]);
        for number in [offset, packed[index].len()] {
            bytes.extend(u32::try_from(number).map_err(|_| EncodeError::TooLarge)?.to_le_bytes());
        }
        bytes.extend(level.vertex_end.to_le_bytes());
        bytes.extend(level.triangle_end.to_le_bytes());
        bytes.extend(rounded_up(level.error).to_le_bytes());
        bytes.extend(rounded_up(tile.outline_errors[index]).to_le_bytes());
        bytes.extend(
            u32::try_from(bodies[index].len())
                .map_err(|_| EncodeError::TooLarge)?
                .to_le_bytes(),
        );
        offset += packed[index].len();
    }
    packed.iter().for_each(|level| bytes.extend(level));
    Ok(bytes)
}

/// Reads a whole tile.
///
/// # Errors
/// When the bytes are not a tile of this version, or exceed `limits`.
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Tile, DecodeError> {
    let header = Header::read(bytes, limits)?;
    let mut tile = Tile {
        address: header.address,
        extent_bits: header.extent_bits,
        height_exponent: header.height_exponent,
        partition: SurfacePartition::default(),
        outline_errors: Vec::with_capacity(header.levels),
    };
    let mut current = Vec::new();
    let step = f64::from(header.height_exponent).exp2();
    for index in 0..header.levels {
        let entry = Entry::read(bytes, &header, index, limits)?;
        let packed = bytes
            .get(entry.start..entry.start + entry.length)
            .ok_or(DecodeError::Truncated(bytes.len()))?;
        let body = inflate(packed, entry.inflated).ok_or(DecodeError::Damaged(index))?;
        let damaged = DecodeError::Damaged(index);
        read_level(&body, &entry.level, index, step, &mut current, &mut tile.partition).ok_or(damaged)?;
        tile.partition.levels.push(entry.level);
        tile.outline_errors.push(entry.outline_error);
    }
    partition::validate(&tile.partition)?;
    Ok(tile)
}

struct Header {
    address: TileAddress,
    extent_bits: u8,
    height_exponent: i8,
    levels: usize,
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
        let address = TileAddress::new(fixed[5], word(fixed, 8), word(fixed, 12));
        Ok(Self {
            address: address.ok_or(DecodeError::OutOfRange("the tile address"))?,
            extent_bits: fixed[6],
            height_exponent: fixed[7].cast_signed(),
            levels,
        })
    }
}

struct Entry {
    start: usize,
    length: usize,
    inflated: usize,
    level: Level,
    outline_error: f64,
}

impl Entry {
    fn read(bytes: &[u8], header: &Header, index: usize, limits: &Limits) -> Result<Self, DecodeError> {
        let start = HEADER_LENGTH + ENTRY_LENGTH * index;
        let entry = bytes
            .get(start..start + ENTRY_LENGTH)
            .ok_or(DecodeError::Truncated(bytes.len()))?;
        let kind = (index + Side::ALL.len() + 1).saturating_sub(header.levels);
        if usize::from(entry[0]) != kind {
            return Err(DecodeError::OutOfRange("the kind of a level"));
        }
        let size = |at| word(entry, at) as usize;
        let level = Level {
            vertex_end: word(entry, 12),
            triangle_end: word(entry, 16),
            error: f64::from(f32::from_bits(word(entry, 20))),
        };
        for (number, limit, name) in [
            (size(12), limits.vertices, "the number of vertices"),
            (size(16), limits.triangles, "the number of triangles"),
            (size(28), limits.level_bytes, "the size of a level"),
        ] {
            if number > limit {
                return Err(DecodeError::Limit(name));
            }
        }
        let outline_error = f64::from(f32::from_bits(word(entry, 24)));
        if outline_error.is_nan() || outline_error < 0.0 || level.error < 0.0 {
            return Err(DecodeError::OutOfRange("an error"));
        }
        Ok(Self {
            start: size(4),
            length: size(8),
            inflated: size(28),
            level,
            outline_error,
        })
    }
}

fn read_level(
    body: &[u8],
    level: &Level,
    index: usize,
    step: f64,
    current: &mut Vec<I64Vec3>,
    partition: &mut SurfacePartition,
) -> Option<()> {
    let mut numbers = Numbers { bytes: body };
    let to_position = |p: I64Vec3| DVec3::new(p.x as f64, p.y as f64, p.z as f64 * step);
    let mut previous = I64Vec3::ZERO;
    for vertex in partition.positions.len()..level.vertex_end as usize {
        previous = numbers.position_after(previous)?;
        partition.positions.push(to_position(previous));
        current.push(previous);
        if index == 0 {
            partition.representatives.push(vertex as u32);
            partition.blue_positions.push(to_position(previous));
            continue;
        }
        let gap = usize::try_from(numbers.unsigned()?).ok()?;
        let representative = vertex.checked_sub(gap).filter(|_| gap > 0)?;
        let restored = numbers.position_after(current[representative])?;
        current[representative] = restored;
        partition.representatives.push(representative as u32);
        partition.blue_positions.push(to_position(restored));
    }
    let mut first = 0;
    for _ in partition.triangles.len()..level.triangle_end as usize {
        first = numbers.signed_after(first)?;
        let second = numbers.signed_after(first)?;
        let third = numbers.signed_after(second)?;
        partition.triangles.push([
            u32::try_from(first).ok()?,
            u32::try_from(second).ok()?,
            u32::try_from(third).ok()?,
        ]);
    }
    numbers.bytes.is_empty().then_some(())
}

/// The partition's positions as whole lattice units and height steps.
struct Steps {
    positions: Vec<I64Vec3>,
    blue_positions: Vec<I64Vec3>,
}

impl Steps {
    fn of(tile: &Tile) -> Result<Self, EncodeError> {
        let per_metre = (-f64::from(tile.height_exponent)).exp2();
        let limit = f64::from(1_u32 << 31);
        let convert = |positions: &[DVec3]| -> Result<Vec<I64Vec3>, EncodeError> {
            let steps = positions.iter().enumerate().map(|(vertex, position)| {
                let scaled = *position * DVec3::new(1.0, 1.0, per_metre);
                let on_lattice = scaled == scaled.round() && scaled.x.abs().max(scaled.y.abs()) < 2.0_f64.powi(41);
                let fits = on_lattice && scaled.z.abs() < limit;
                fits.then(|| scaled.as_i64vec3()).ok_or(EncodeError::OffLattice(vertex))
            });
            steps.collect()
        };
        Ok(Self {
            positions: convert(&tile.partition.positions)?,
            blue_positions: convert(&tile.partition.blue_positions)?,
        })
    }

    fn height_range(&self) -> [i32; 2] {
        let heights = || self.positions.iter().chain(&self.blue_positions).map(|p| p.z as i32);
        [heights().min().unwrap_or(0), heights().max().unwrap_or(0)]
    }

    fn level(&self, partition: &SurfacePartition, index: usize) -> Vec<u8> {
        let start = index.checked_sub(1).map(|coarser| partition.levels[coarser]);
        let vertex_start = start.map_or(0, |level| level.vertex_end as usize);
        let triangle_start = start.map_or(0, |level| level.triangle_end as usize);
        let level = partition.levels[index];
        let mut current = self.current_before(partition, vertex_start, level.vertex_end as usize, index);
        let mut bytes = Vec::new();
        let mut previous = I64Vec3::ZERO;
        for vertex in vertex_start..level.vertex_end as usize {
            write_difference(&mut bytes, self.positions[vertex], previous);
            previous = self.positions[vertex];
            if index > 0 {
                let representative = partition.representatives[vertex] as usize;
                write_unsigned(&mut bytes, (vertex - representative) as u64);
                write_difference(&mut bytes, self.blue_positions[vertex], current[representative]);
                current[representative] = self.blue_positions[vertex];
            }
        }
        let mut first = 0;
        for triangle in &partition.triangles[triangle_start..level.triangle_end as usize] {
            let [a, b, c] = triangle.map(i64::from);
            for difference in [a - first, b - a, c - b] {
                write_signed(&mut bytes, difference);
            }
            first = a;
        }
        bytes
    }

    /// Positions after the levels before `index`, and the level's own as stored.
    fn current_before(&self, partition: &SurfacePartition, start: usize, end: usize, index: usize) -> Vec<I64Vec3> {
        let mut current = self.positions[..end].to_vec();
        if index > 0 {
            let first = partition.levels[0].vertex_end as usize;
            for vertex in first..start {
                current[partition.representatives[vertex] as usize] = self.blue_positions[vertex];
            }
        }
        current
    }
}

fn write_header(bytes: &mut Vec<u8>, tile: &Tile, steps: &Steps, packed: &[Vec<u8>]) -> Result<(), EncodeError> {
    let length = HEADER_LENGTH + ENTRY_LENGTH * packed.len() + packed.iter().map(Vec::len).sum::<usize>();
    bytes.extend(MAGIC);
    bytes.extend([
        VERSION,
        tile.address.zoom,
        tile.extent_bits,
        tile.height_exponent.cast_unsigned(),
    ]);
    bytes.extend(tile.address.x.to_le_bytes());
    bytes.extend(tile.address.y.to_le_bytes());
    steps
        .height_range()
        .iter()
        .for_each(|height| bytes.extend(height.to_le_bytes()));
    bytes.extend((packed.len() as u16).to_le_bytes());
    bytes.extend([0, 0]);
    bytes.extend(u32::try_from(length).map_err(|_| EncodeError::TooLarge)?.to_le_bytes());
    Ok(())
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

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.expect("writing to memory cannot fail")
}

/// Exactly `length` bytes, or nothing.
fn inflate(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    DeflateDecoder::new(packed)
        .take(length as u64 + 1)
        .read_to_end(&mut bytes)
        .ok()?;
    (bytes.len() == length).then_some(bytes)
}

fn write_unsigned(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

fn write_signed(bytes: &mut Vec<u8>, value: i64) {
    write_unsigned(bytes, (value << 1 ^ value >> 63).cast_unsigned());
}

fn write_difference(bytes: &mut Vec<u8>, position: I64Vec3, from: I64Vec3) {
    (position - from)
        .to_array()
        .iter()
        .for_each(|&difference| write_signed(bytes, difference));
}

/// Reads variable-length integers; every method gives nothing where the bytes end early or a number is too long.
struct Numbers<'a> {
    bytes: &'a [u8],
}

impl Numbers<'_> {
    fn unsigned(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..63).step_by(7) {
            let (&byte, rest) = self.bytes.split_first()?;
            self.bytes = rest;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn signed_after(&mut self, previous: i64) -> Option<i64> {
        let coded = self.unsigned()?;
        previous.checked_add((coded >> 1).cast_signed() ^ -(coded & 1).cast_signed())
    }

    fn position_after(&mut self, previous: I64Vec3) -> Option<I64Vec3> {
        let position = I64Vec3::new(
            self.signed_after(previous.x)?,
            self.signed_after(previous.y)?,
            self.signed_after(previous.z)?,
        );
        (position.abs().max_element() < 1 << 41).then_some(position)
    }
}

#[cfg(test)]
#[path = "codec_tests.rs"]
mod tests;
