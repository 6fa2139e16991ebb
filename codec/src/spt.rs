//! The progressive tile format, versions 3 to 6: `docs/formats/spt.md` is its specification.
//!
//! ```text
//! ┌────────┬───────────┬─────────┬─────────┬─ … ─┬──────┬───────┬──────┬───────┐
//! │ header │ directory │ level 0 │ level 1 │     │ west │ south │ east │ north │
//! └────────┴───────────┴─────────┴─────────┴─ … ─┴──────┴───────┴──────┴───────┘
//! ```
//! What is in a level is [`crate::progressive`]'s.

use glam::DVec3;
use integer_encoding::VarInt;
use terrain_core::SurfacePartition;
use terrain_core::levels::partition::{self, Level};
use thiserror::Error;

use super::fields::{Directory, Entry, Fields, Format};
use crate::address::{Side, TileAddress};
use crate::filled::Filled;
use crate::level_stream::LevelStream;
use crate::progressive::{self, Frame, LevelsDecoder, Sampling, Start};
use crate::tile::{Lineage, Tile};

use super::{DecodeError, LevelLimits};

const FORMAT: Format = Format {
    name: "progressive terrain tile",
    magic: *b"SPTL",
    versions: [VERSION, VERSION_WITH_FILLED],
};
/// Of a tile in which no split opens a hole.
const VERSION: u8 = 3;
/// Of one in which some may: readers of version 3 know nothing of such splits.
const VERSION_WITH_HOLES: u8 = 4;
/// Of one with breaklines: its flags tell whether splits may open holes.
const VERSION_WITH_BREAKLINES: u8 = 5;
/// Of one with filled ground; it tells of breaklines, too.
const VERSION_WITH_FILLED: u8 = 6;
/// Lattice coordinates must stay exact integers in an `f64`.
const MAX_EXTENT_BITS: u8 = 40;
/// The flag of a tile whose samples are told.
const SAMPLED: u8 = 1;
/// The flag of a tile with breaklines or filled ground in which splits may open holes.
const OPENS_HOLES: u8 = 2;

/// Why a tile cannot be written.
#[derive(Debug, Error, PartialEq)]
pub enum TileError {
    /// Fewer levels than the four sides and one interior, or more than fit their field.
    #[error("a tile needs 5 to 65,535 levels, each with its outline error")]
    Levels,
    /// A coordinate is no multiple of its step or outside the tile, or the surface is no manifold where vertices collapse.
    #[error(transparent)]
    Surface(#[from] progressive::Uncodable),
    /// The lattice is too fine, or the samples are not where any can be.
    #[error("the tile's lattice or its samples are out of range")]
    Lattice,
    /// A level of more bytes than its field tells.
    #[error("a level is larger than 4 GiB")]
    TooLarge,
}

/// Writes a tile.
///
/// # Errors
/// When the tile is not what [`Tile`] says it is.
pub fn encode(tile: &Tile) -> Result<Vec<u8>, TileError> {
    let count = tile.partition.levels.len();
    if !(5..=usize::from(u16::MAX)).contains(&count) || tile.outline_errors.len() != count {
        return Err(TileError::Levels);
    }
    let mut partition = tile.partition.clone();
    scale(&mut partition, (-f64::from(tile.height_exponent)).exp2());
    for level in &mut partition.levels {
        level.error = f64::from(rounded_up(level.error));
    }
    let heights = height_range(&partition);
    let frame = frame(tile.extent_bits, heights.map(f64::from), tile.sampling);
    if tile.extent_bits > MAX_EXTENT_BITS || !frame.is_valid() {
        return Err(TileError::Lattice);
    }
    let coded = progressive::encode(&partition, count - Side::ALL.len(), &frame)?;
    let mut bytes = Vec::new();
    write_header(&mut bytes, tile, heights, coded.start);
    let mut directory = Directory::new(true);
    for (index, &level) in partition.levels.iter().enumerate() {
        let entry = Entry {
            length: coded.levels[index].len(),
            level,
            outline_error: rounded_up(tile.outline_errors[index]),
        };
        directory.write(&mut bytes, &entry).map_err(|_| TileError::TooLarge)?;
    }
    coded.levels.iter().for_each(|level| bytes.extend(level));
    Ok(bytes)
}

/// What a tile says of itself before its levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Which square of the Earth.
    pub address: TileAddress,
    /// What it was made from, and what its parent takes over.
    pub lineage: Lineage,
    /// Lowest and highest height of any vertex of any level, metres.
    pub heights: [f64; 2],
    /// Triangles of the finest surface.
    pub triangles: usize,
    /// Certified vertical error of the finest and of the coarsest surface, metres.
    pub errors: [f64; 2],
    /// How far the outline of the coarsest surface may be from that of the source in plan view, metres.
    pub outline_error: f64,
}

/// Reads what stands before the levels: the first bytes of a tile are enough.
///
/// # Errors
/// When the bytes are not the beginning of a tile of this version, or exceed `limits`.
pub fn decode_head(bytes: &[u8], limits: &LevelLimits) -> Result<Head, DecodeError> {
    let (header, entries, _) = read_head(bytes, limits)?;
    let (Some(coarsest), Some(finest)) = (entries.first(), entries.last()) else {
        return Err(DecodeError::OutOfRange("the number of levels"));
    };
    let step = f64::from(header.height_exponent).exp2();
    Ok(Head {
        address: header.address,
        lineage: header.lineage,
        heights: header.frame.bounds.map(|bound| bound.z * step),
        triangles: finest.level.triangle_end as usize,
        errors: [finest.level.error, coarsest.level.error],
        outline_error: f64::from(coarsest.outline_error),
    })
}

/// Reads a whole tile. Vertices and triangles of each level come in the order of their splits.
///
/// # Errors
/// When the bytes are not a tile of this version, or exceed `limits`.
pub fn decode(bytes: &[u8], limits: &LevelLimits) -> Result<Tile, DecodeError> {
    let decoder = TileDecoder::new(bytes, limits)?;
    decoder.stream.check_whole()?;
    decoder.into_tile()
}

/// Reads as much of a tile as its first bytes tell, at least its base: whole levels, and of the one that is cut the splits that
/// are whole. The surface so far is complete and has the tile's outline as far as it is split. A level that is cut has the
/// error of the one before (infinity before the end of the first level), and so have those that are missing and add nothing. That
/// error is certified for the level before only: between two levels nothing was measured, and surfaces may be a little worse.
///
/// # Errors
/// When the bytes are not the beginning of a tile of this version, or exceed `limits`.
pub fn decode_prefix(bytes: &[u8], limits: &LevelLimits) -> Result<Tile, DecodeError> {
    let mut decoder = TileDecoder::new(bytes, limits)?;
    decoder.cut()?;
    decoder.into_tile()
}

/// Decodes a tile while its bytes come in, each level as soon as it is whole.
#[derive(Debug)]
pub struct TileDecoder {
    header: Header,
    stream: LevelStream,
}

impl TileDecoder {
    /// Begins with a tile's first bytes.
    ///
    /// # Errors
    /// [`DecodeError::Truncated`] where they end before the levels begin; others where they are not the beginning of a tile of this
    /// version, or exceed `limits`.
    pub fn new(first: &[u8], limits: &LevelLimits) -> Result<Self, DecodeError> {
        let (header, entries, rest) = read_head(first, limits)?;
        let levels = LevelsDecoder::new(header.start, header.levels - Side::ALL.len(), header.frame.clone());
        let stream = LevelStream::new(entries, levels, first, &rest)?;
        Ok(Self { header, stream })
    }

    /// Goes on with the bytes that come next.
    ///
    /// # Errors
    /// When a level's bytes make no surface of its size, or there are bytes after the last level. Then the decoder is of no more use.
    pub fn add(&mut self, bytes: &[u8]) -> Result<(), DecodeError> {
        self.stream.add(bytes)
    }

    /// Decodes what is there of the level that is not whole: nothing more comes.
    ///
    /// # Errors
    /// When its bytes make no surface, or are cut before the base ends.
    pub fn cut(&mut self) -> Result<(), DecodeError> {
        self.stream.cut()
    }

    /// Which square of the Earth.
    #[must_use]
    pub fn address(&self) -> TileAddress {
        self.header.address
    }

    /// The tile's side is 2^`extent_bits` lattice units.
    #[must_use]
    pub fn extent_bits(&self) -> u8 {
        self.header.extent_bits
    }

    /// Which of the tile's ground was not measured.
    #[must_use]
    pub fn filled(&self) -> &Filled {
        &self.header.filled
    }

    /// The levels as the directory tells them, also those that are not there yet.
    pub fn levels(&self) -> impl Iterator<Item = Level> {
        self.stream.levels()
    }

    /// Bytes of the tile up to the end of each level.
    pub fn ends(&self) -> impl Iterator<Item = usize> {
        self.stream.ends()
    }

    /// How many levels are whole.
    #[must_use]
    pub fn levels_there(&self) -> usize {
        self.stream.whole().len()
    }

    /// How many bytes of the tile have come.
    #[must_use]
    pub fn bytes_there(&self) -> usize {
        self.stream.bytes_there()
    }

    /// Whether all levels are there.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.stream.is_whole()
    }

    /// What has been decoded so far. Levels that are missing add nothing and have the error of the last that is whole.
    ///
    /// # Errors
    /// Before the first level, and where what was decoded is no Surface Partition.
    pub fn tile(&self) -> Result<Tile, DecodeError> {
        tile(&self.header, self.stream.whole(), self.stream.partition()?)
    }

    fn into_tile(self) -> Result<Tile, DecodeError> {
        let whole = self.stream.whole().to_vec();
        tile(&self.header, &whole, self.stream.into_partition()?)
    }
}

/// All that stands before the levels, and what follows.
fn read_head<'a>(bytes: &'a [u8], limits: &LevelLimits) -> Result<(Header, Vec<Entry>, Fields<'a>), DecodeError> {
    let (mut fields, version) = Fields::open(bytes, &FORMAT)?;
    let header = Header::read(&mut fields, version, limits)?;
    let entries = Directory::new(true).read_all(&mut fields, header.levels, limits)?;
    Ok((header, entries, fields))
}

/// The tile of a header, whose levels are a partition so far; `whole` are those of its levels that are all there.
fn tile(header: &Header, whole: &[Entry], mut partition: SurfacePartition) -> Result<Tile, DecodeError> {
    if let Some(&last) = partition.levels.last() {
        partition.levels.resize(header.levels, last);
    }
    partition::validate(&partition)?;
    scale(&mut partition, f64::from(header.height_exponent).exp2());
    let mut outline_errors: Vec<f64> = whole.iter().map(|entry| f64::from(entry.outline_error)).collect();
    outline_errors.resize(header.levels, outline_errors.last().copied().unwrap_or(f64::INFINITY));
    Ok(Tile {
        address: header.address,
        extent_bits: header.extent_bits,
        height_exponent: header.height_exponent,
        sampling: header.frame.sampling,
        lineage: header.lineage,
        partition,
        outline_errors,
        breaklines: header.breaklines.clone(),
        filled: header.filled.clone(),
    })
}

/// Puts heights in another unit.
fn scale(partition: &mut SurfacePartition, scale: f64) {
    let positions = partition.positions.iter_mut().chain(&mut partition.blue_positions);
    positions.for_each(|position| position.z *= scale);
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
    }
}

#[derive(Debug)]
struct Header {
    address: TileAddress,
    extent_bits: u8,
    height_exponent: i8,
    levels: usize,
    lineage: Lineage,
    start: Start,
    frame: Frame,
    breaklines: Vec<[[i64; 2]; 2]>,
    filled: Filled,
}

impl Header {
    /// All but the magic and the version.
    fn read(fields: &mut Fields, version: u8, limits: &LevelLimits) -> Result<Self, DecodeError> {
        let [zoom, extent_bits, height_exponent] = fields.bytes()?;
        let [x, y, lowest, highest] = [(); 4].map(|()| fields.bytes());
        let [x, y] = [u32::from_le_bytes(x?), u32::from_le_bytes(y?)];
        let heights = [i32::from_le_bytes(lowest?), i32::from_le_bytes(highest?)];
        let [flags] = fields.bytes()?;
        let lineage = Lineage::read(fields)?;
        let levels = fields.number()? as usize;
        limits.check_levels(levels)?;
        if levels <= Side::ALL.len() {
            return Err(DecodeError::OutOfRange("the number of levels"));
        }
        if extent_bits > MAX_EXTENT_BITS {
            return Err(DecodeError::OutOfRange("the lattice extent"));
        }
        let start = Start {
            vertices: fields.number()?,
            triangles: fields.number()?,
            opens_holes: version == VERSION_WITH_HOLES
                || version >= VERSION_WITH_BREAKLINES && flags & OPENS_HOLES != 0,
        };
        let frame = frame(
            extent_bits,
            heights.map(f64::from),
            Sampling::read(fields, flags & SAMPLED != 0)?,
        );
        if !frame.is_valid() {
            return Err(DecodeError::OutOfRange("the lattice"));
        }
        let breaklines = if version >= VERSION_WITH_BREAKLINES {
            read_breaklines(fields, 1 << extent_bits)?
        } else {
            Vec::new()
        };
        let filled = if version == VERSION_WITH_FILLED {
            let length = fields.number()? as usize;
            Filled::from_bytes(fields.run(length)?).ok_or(DecodeError::OutOfRange("the filled ground"))?
        } else {
            Filled::default()
        };
        Ok(Self {
            breaklines,
            filled,
            address: TileAddress::new(zoom, x, y).ok_or(DecodeError::OutOfRange("the tile address"))?,
            extent_bits,
            height_exponent: height_exponent.cast_signed(),
            levels,
            lineage,
            start,
            frame,
        })
    }
}

fn write_header(bytes: &mut Vec<u8>, tile: &Tile, heights: [i32; 2], start: Start) {
    bytes.extend(FORMAT.magic);
    let has_breaklines = !tile.breaklines.is_empty();
    let version = match (has_breaklines, start.opens_holes) {
        _ if !tile.filled.is_empty() => VERSION_WITH_FILLED,
        (true, _) => VERSION_WITH_BREAKLINES,
        (false, true) => VERSION_WITH_HOLES,
        (false, false) => VERSION,
    };
    bytes.extend([
        version,
        tile.address.zoom,
        tile.extent_bits,
        tile.height_exponent.cast_unsigned(),
    ]);
    bytes.extend(tile.address.x.to_le_bytes());
    bytes.extend(tile.address.y.to_le_bytes());
    heights.iter().for_each(|height| bytes.extend(height.to_le_bytes()));
    let has_flag = version >= VERSION_WITH_BREAKLINES;
    let holes = u8::from(has_flag && start.opens_holes) * OPENS_HOLES;
    bytes.push((u8::from(tile.sampling.is_some()) * SAMPLED) | holes);
    tile.lineage.write(bytes);
    bytes.extend(tile.partition.levels.len().encode_var_vec());
    bytes.extend(start.vertices.encode_var_vec());
    bytes.extend(start.triangles.encode_var_vec());
    tile.sampling.iter().for_each(|sampling| sampling.write(bytes));
    if version >= VERSION_WITH_BREAKLINES {
        write_breaklines(bytes, &tile.breaklines);
    }
    if version == VERSION_WITH_FILLED {
        let filled = tile.filled.to_bytes();
        bytes.extend(filled.len().encode_var_vec());
        bytes.extend(filled);
    }
}

/// Each end as what it is from the one before.
fn write_breaklines(bytes: &mut Vec<u8>, breaklines: &[[[i64; 2]; 2]]) {
    bytes.extend((breaklines.len() as u64).encode_var_vec());
    let mut before = [0, 0];
    for &end in breaklines.as_flattened() {
        bytes.extend(
            [0, 1]
                .iter()
                .flat_map(|&axis: &usize| (end[axis] - before[axis]).encode_var_vec()),
        );
        before = end;
    }
}

/// Ends are on the lattice of a tile whose side has so many units.
fn read_breaklines(fields: &mut Fields, extent: i64) -> Result<Vec<[[i64; 2]; 2]>, DecodeError> {
    /// An edge takes four numbers of a byte or more.
    const LEAST_BYTES: usize = 4;
    let count = fields.number()? as usize;
    if count > fields.remaining() / LEAST_BYTES {
        return Err(fields.truncated());
    }
    let mut before = [0_i64, 0];
    let mut edges = vec![[[0; 2]; 2]; count];
    for end in edges.as_flattened_mut() {
        for axis in [0, 1] {
            let at = before[axis].checked_add(fields.signed_number()?);
            let on_lattice = at.filter(|at| (0..=extent).contains(at));
            end[axis] = on_lattice.ok_or(DecodeError::OutOfRange("an edge along a breakline"))?;
        }
        before = *end;
    }
    Ok(edges)
}

impl Lineage {
    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.name.to_be_bytes());
        let inherited = [self.coarsest_measured, self.outline_strayed];
        bytes.extend(inherited.iter().flat_map(|error| error.to_le_bytes()));
    }

    fn read(fields: &mut Fields) -> Result<Self, DecodeError> {
        let name = u128::from_be_bytes(fields.bytes()?);
        let [coarsest_measured, outline_strayed] =
            [f32::from_le_bytes(fields.bytes()?), f32::from_le_bytes(fields.bytes()?)];
        if !(coarsest_measured >= 0.0 && outline_strayed >= 0.0) {
            return Err(DecodeError::OutOfRange("what the parent takes over"));
        }
        Ok(Self {
            name,
            coarsest_measured,
            outline_strayed,
        })
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

#[cfg(test)]
#[path = "spt_tests.rs"]
mod tests;
