//! The progressive mesh file, `.spm`: a Surface Partition of any manifold mesh on an integer lattice.
//! `docs/formats/spm.md` is its specification.
//!
//! ```text
//! ┌────────┬───────────┬─────────┬─────────┬─ … ─┐
//! │ header │ directory │ level 0 │ level 1 │     │
//! └────────┴───────────┴─────────┴─────────┴─ … ─┘
//! ```

use glam::DVec3;
use terrain_core::SurfacePartition;
use terrain_core::partition::{self, Level, PartitionError};
use thiserror::Error;

use crate::codec::{Limits, double, rounded_up, word};
use crate::progressive::{self, BaseSize, Damaged, Frame, Sampling};

const MAGIC: &[u8; 4] = b"SPMF";
const VERSION: u8 = 1;
const HEADER_LENGTH: usize = 112;
const ENTRY_LENGTH: usize = 16;
const HEIGHT_FIELD: u8 = 1;
const SAMPLED: u8 = 2;
/// Lattice units along each axis of a model are at most this.
const MAX_EXTENT: f64 = 2_147_483_648.0;

/// A mesh with its levels of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Where the lattice's origin is, in the units of the mesh.
    pub origin: DVec3,
    /// The mesh's units in one of the lattice, for each axis.
    pub step: DVec3,
    /// Whether the third axis is a height over the plane of the others.
    pub is_height_field: bool,
    /// Where the samples are that a height field was made of, on the lattice, if its vertices are such.
    pub sampling: Option<Sampling>,
    /// Positions are whole numbers from 0 to 2^31: lattice units. Errors are in the units of the mesh.
    pub partition: SurfacePartition,
}

/// Why a model cannot be written.
#[derive(Debug, Error, PartialEq)]
pub enum EncodeError {
    /// It is no partition that the codec can hold.
    #[error(transparent)]
    Partition(#[from] progressive::EncodeError),
    /// The origin, a step, the sampling or the extent is not finite, not positive or too large.
    #[error("the lattice must be finite, with steps above 0 and at most 2^31 of them a side")]
    Lattice,
    /// More levels than their field holds.
    #[error("at most 65,535 levels, and at least one")]
    Levels,
    /// More bytes than the 32-bit offsets reach.
    #[error("the file is larger than 4 GiB")]
    TooLarge,
}

/// Why bytes are no model.
#[derive(Debug, Error, PartialEq)]
pub enum DecodeError {
    /// The magic is another's.
    #[error("not a progressive mesh file")]
    NotAModel,
    /// Made by a newer program.
    #[error("mesh file version {0}; this program reads version {VERSION}")]
    Version(u8),
    /// Bytes are missing.
    #[error("truncated at byte {0}")]
    Truncated(usize),
    /// A field holds what it cannot.
    #[error("{0} is out of range")]
    OutOfRange(&'static str),
    /// A number exceeds the reader's [`Limits`].
    #[error("{0} exceeds this reader's limit")]
    Limit(&'static str),
    /// A level's bytes make no surface.
    #[error(transparent)]
    Damaged(#[from] Damaged),
    /// The arrays do not make a Surface Partition.
    #[error(transparent)]
    Partition(#[from] PartitionError),
}

impl Model {
    /// Lays `partition`, in the units of a mesh, on a cubic lattice that divides its longest side by 2^`bits`, and rounds every
    /// position to it.
    ///
    /// # Errors
    /// When a position is not finite, or `bits` is more than 31.
    pub fn quantised(partition: &SurfacePartition, bits: u32) -> Result<Self, EncodeError> {
        let positions = || partition.positions.iter().chain(&partition.blue_positions);
        let low = positions().copied().reduce(DVec3::min).unwrap_or_default();
        let high = positions().copied().reduce(DVec3::max).unwrap_or_default();
        let longest = (high - low).max_element();
        if !longest.is_finite() || bits > 31 {
            return Err(EncodeError::Lattice);
        }
        let step = if longest > 0.0 {
            longest / f64::from(bits).exp2()
        } else {
            1.0
        };
        Ok(Self::on_lattice(partition, low, DVec3::splat(step)))
    }

    /// Rounds every position of `partition`, in the units of a mesh, to a lattice. [`encode`] says whether it is one.
    #[must_use]
    pub fn on_lattice(partition: &SurfacePartition, origin: DVec3, step: DVec3) -> Self {
        let rounded = |positions: &[DVec3]| positions.iter().map(|&at| ((at - origin) / step).round()).collect();
        Self {
            origin,
            step,
            is_height_field: false,
            sampling: None,
            partition: SurfacePartition {
                positions: rounded(&partition.positions),
                blue_positions: rounded(&partition.blue_positions),
                ..partition.clone()
            },
        }
    }

    /// The partition in the units of the mesh.
    #[must_use]
    pub fn in_units(&self) -> SurfacePartition {
        let in_units = |positions: &[DVec3]| positions.iter().map(|&at| self.origin + at * self.step).collect();
        SurfacePartition {
            positions: in_units(&self.partition.positions),
            blue_positions: in_units(&self.partition.blue_positions),
            ..self.partition.clone()
        }
    }
}

/// Writes a model.
///
/// # Errors
/// When the model is not what [`Model`] says it is, or its surface is no manifold where vertices collapse.
pub fn encode(model: &Model) -> Result<Vec<u8>, EncodeError> {
    let partition = &model.partition;
    let levels = u16::try_from(partition.levels.len()).map_err(|_| EncodeError::Levels)?;
    let positions = partition.positions.iter().chain(&partition.blue_positions);
    let extent = positions.fold(DVec3::ZERO, |extent, &position| extent.max(position));
    let frame = frame(model.is_height_field, model.sampling, extent);
    let is_positive = |step: f64| step.is_finite() && step > 0.0;
    let is_lattice = model.origin.is_finite() && model.step.to_array().into_iter().all(is_positive);
    if !is_lattice || !frame.is_valid() || extent.max_element() > MAX_EXTENT {
        return Err(EncodeError::Lattice);
    }
    let coded = progressive::encode(partition, &frame)?;
    let mut bytes = Vec::new();
    bytes.extend(MAGIC);
    let flags = u8::from(model.is_height_field) * HEIGHT_FIELD + u8::from(model.sampling.is_some()) * SAMPLED;
    bytes.extend([VERSION, flags]);
    bytes.extend(levels.to_le_bytes());
    bytes.extend(coded.base.vertices.to_le_bytes());
    bytes.extend(coded.base.triangles.to_le_bytes());
    let sampling = model.sampling.unwrap_or(Sampling {
        origin: [0.0; 2],
        step: [0.0; 2],
    });
    for number in [model.origin.to_array(), model.step.to_array()].as_flattened() {
        bytes.extend(number.to_le_bytes());
    }
    for number in [sampling.origin, sampling.step].as_flattened() {
        bytes.extend(number.to_le_bytes());
    }
    for extent in extent.to_array() {
        bytes.extend((extent as u32).to_le_bytes());
    }
    bytes.extend([0; 4]);
    let mut end = HEADER_LENGTH + ENTRY_LENGTH * coded.levels.len();
    for (level, coded) in partition.levels.iter().zip(&coded.levels) {
        end += coded.len();
        bytes.extend(u32::try_from(end).map_err(|_| EncodeError::TooLarge)?.to_le_bytes());
        bytes.extend(level.vertex_end.to_le_bytes());
        bytes.extend(level.triangle_end.to_le_bytes());
        bytes.extend(rounded_up(level.error).to_le_bytes());
    }
    coded.levels.iter().for_each(|level| bytes.extend(level));
    Ok(bytes)
}

/// Reads a model, or as many of its levels as `bytes` hold: any prefix that ends with a level is one, of which corners are those
/// of the finest surface in it.
///
/// # Errors
/// When the bytes are not a model of this version, hold no whole level, or exceed `limits`.
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Model, DecodeError> {
    let header: &[u8; HEADER_LENGTH] = bytes.first_chunk().ok_or(DecodeError::Truncated(bytes.len()))?;
    if &header[..4] != MAGIC {
        return Err(DecodeError::NotAModel);
    }
    if header[4] != VERSION {
        return Err(DecodeError::Version(header[4]));
    }
    let count = usize::from(u16::from_le_bytes([header[6], header[7]]));
    if count > limits.levels {
        return Err(DecodeError::Limit("the number of levels"));
    }
    let [base_vertices, base_triangles] = [8, 12].map(|at| word(header, at));
    let numbers: [f64; 10] = std::array::from_fn(|index| double(header, 16 + 8 * index));
    let [ox, oy, oz, sx, sy, sz, column, row, across, down] = numbers;
    let sampling = (header[5] & SAMPLED != 0).then_some(Sampling {
        origin: [column, row],
        step: [across, down],
    });
    let extent = DVec3::from_array([96, 100, 104].map(|at| f64::from(word(header, at))));
    let frame = frame(header[5] & HEIGHT_FIELD != 0, sampling, extent);
    let (origin, step) = (DVec3::new(ox, oy, oz), DVec3::new(sx, sy, sz));
    if !frame.is_valid() || !origin.is_finite() || !step.is_finite() || step.min_element() <= 0.0 {
        return Err(DecodeError::OutOfRange("the lattice"));
    }
    let (levels, runs) = directory(bytes, count, limits)?;
    let base = BaseSize {
        vertices: base_vertices,
        triangles: base_triangles,
    };
    let partition = progressive::decode(base, &levels, &runs, &frame)?;
    partition::validate(&partition)?;
    Ok(Model {
        origin,
        step,
        is_height_field: frame.is_height_field,
        sampling,
        partition,
    })
}

fn frame(is_height_field: bool, sampling: Option<Sampling>, extent: DVec3) -> Frame {
    Frame {
        bounds: [DVec3::ZERO, extent],
        is_height_field,
        sampling,
        boundary_levels: 0,
    }
}

/// The levels, and the bytes of those that are there.
fn directory<'a>(bytes: &'a [u8], count: usize, limits: &Limits) -> Result<(Vec<Level>, Vec<&'a [u8]>), DecodeError> {
    let mut start = HEADER_LENGTH + ENTRY_LENGTH * count;
    let entries = bytes
        .get(HEADER_LENGTH..start)
        .ok_or(DecodeError::Truncated(bytes.len()))?;
    let (mut levels, mut runs) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for entry in entries.chunks_exact(ENTRY_LENGTH) {
        let end = word(entry, 0) as usize;
        let level = Level {
            vertex_end: word(entry, 4),
            triangle_end: word(entry, 8),
            error: f64::from(f32::from_bits(word(entry, 12))),
        };
        if end < start {
            return Err(DecodeError::OutOfRange("the end of a level"));
        }
        if level.vertex_end as usize > limits.vertices {
            return Err(DecodeError::Limit("the number of vertices"));
        }
        if level.triangle_end as usize > limits.triangles {
            return Err(DecodeError::Limit("the number of triangles"));
        }
        let Some(run) = bytes.get(start..end) else { break };
        levels.push(level);
        runs.push(run);
        start = end;
    }
    if runs.is_empty() {
        return Err(DecodeError::Truncated(bytes.len()));
    }
    Ok((levels, runs))
}

#[cfg(test)]
#[path = "model_tests.rs"]
mod tests;
