//! The progressive mesh file, `.spm`: a Surface Partition of any manifold mesh on an integer lattice.
//! `docs/formats/spm.md` is its specification.
//!
//! ```text
//! ┌────────┬───────────┬─────────┬─────────┬─ … ─┐
//! │ header │ directory │ level 0 │ level 1 │     │
//! └────────┴───────────┴─────────┴─────────┴─ … ─┘
//! ```

use glam::DVec3;
use integer_encoding::VarInt;
use terrain_core::SurfacePartition;
use terrain_core::levels::partition;
use thiserror::Error;

use super::fields::{Directory, Entry, Fields, Format};
use super::spt::rounded_up;
use super::{DecodeError, LevelLimits};
use crate::level_stream::LevelStream;
use crate::progressive::{self, Frame, LevelsDecoder, Sampling, Start};

const FORMAT: Format = Format {
    name: "progressive mesh file",
    magic: *b"SPMF",
    versions: [VERSION, VERSION_WITH_HOLES],
};
/// Of a mesh in which no split opens a hole.
const VERSION: u8 = 1;
/// Of one in which some may: readers of version 1 know nothing of such splits.
const VERSION_WITH_HOLES: u8 = 2;
const HEIGHT_FIELD: u8 = 1;
const SAMPLED: u8 = 2;
/// Lattice units along each axis of a mesh are at most this.
const MAX_EXTENT: f64 = 2_147_483_648.0;

/// A mesh with its levels of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgressiveMesh {
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

/// Why a mesh cannot be written.
#[derive(Debug, Error, PartialEq)]
pub enum ProgressiveMeshError {
    /// It is no partition that the codec can hold.
    #[error(transparent)]
    Partition(#[from] progressive::Uncodable),
    /// The origin, a step, the sampling or the extent is not finite, not positive or too large.
    #[error("the lattice must be finite, with steps above 0 and at most 2^31 of them a side")]
    Lattice,
    /// A level of more bytes than its field tells.
    #[error("a level is larger than 4 GiB")]
    TooLarge,
}

impl ProgressiveMesh {
    /// Lays `partition`, in the units of a mesh, on a cubic lattice that divides its longest side by 2^`bits`, and rounds every
    /// position to it.
    ///
    /// # Errors
    /// When a position is not finite, or `bits` is more than 31.
    pub fn quantised(partition: &SurfacePartition, bits: u32) -> Result<Self, ProgressiveMeshError> {
        let positions = || partition.positions.iter().chain(&partition.blue_positions);
        let low = positions().copied().reduce(DVec3::min).unwrap_or_default();
        let high = positions().copied().reduce(DVec3::max).unwrap_or_default();
        let longest = (high - low).max_element();
        if !longest.is_finite() || bits > 31 {
            return Err(ProgressiveMeshError::Lattice);
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

/// Writes a mesh.
///
/// # Errors
/// When the mesh is not what [`ProgressiveMesh`] says it is, or its surface is no manifold where vertices collapse.
pub fn encode(mesh: &ProgressiveMesh) -> Result<Vec<u8>, ProgressiveMeshError> {
    let partition = &mesh.partition;
    let positions = partition.positions.iter().chain(&partition.blue_positions);
    let extent = positions.fold(DVec3::ZERO, |extent, &position| extent.max(position));
    let frame = frame(mesh.is_height_field, mesh.sampling, extent);
    let is_positive = |step: f64| step.is_finite() && step > 0.0;
    let is_lattice = mesh.origin.is_finite() && mesh.step.to_array().into_iter().all(is_positive);
    if !is_lattice || !frame.is_valid() || extent.max_element() > MAX_EXTENT {
        return Err(ProgressiveMeshError::Lattice);
    }
    let coded = progressive::encode(partition, partition.levels.len(), &frame)?;
    let mut bytes = Vec::new();
    write_header(&mut bytes, mesh, extent, coded.start);
    let mut directory = Directory::new(false);
    for (&level, coded) in partition.levels.iter().zip(&coded.levels) {
        let mut entry = Entry {
            length: coded.len(),
            level,
            outline_error: 0.0,
        };
        entry.level.error = f64::from(rounded_up(level.error));
        directory
            .write(&mut bytes, &entry)
            .map_err(|_| ProgressiveMeshError::TooLarge)?;
    }
    coded.levels.iter().for_each(|level| bytes.extend(level));
    Ok(bytes)
}

fn write_header(bytes: &mut Vec<u8>, mesh: &ProgressiveMesh, extent: DVec3, start: Start) {
    bytes.extend(FORMAT.magic);
    let flags = u8::from(mesh.is_height_field) * HEIGHT_FIELD + u8::from(mesh.sampling.is_some()) * SAMPLED;
    let version = if start.opens_holes { VERSION_WITH_HOLES } else { VERSION };
    bytes.extend([version, flags]);
    let lattice = [mesh.origin.to_array(), mesh.step.to_array()];
    bytes.extend(lattice.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
    let extent = extent.to_array().map(|extent| extent as u32);
    let numbers = [mesh.partition.levels.len() as u32, start.vertices, start.triangles];
    for number in numbers.into_iter().chain(extent) {
        bytes.extend(number.encode_var_vec());
    }
    mesh.sampling.iter().for_each(|sampling| sampling.write(bytes));
}

/// Reads a whole mesh.
///
/// # Errors
/// When the bytes are not a mesh of this version, or exceed `limits`.
pub fn decode(bytes: &[u8], limits: &LevelLimits) -> Result<ProgressiveMesh, DecodeError> {
    let (head, stream) = Head::read(bytes, limits)?;
    stream.check_whole()?;
    head.mesh(stream)
}

/// Reads as much of a mesh as its first bytes tell, at least its base: whole levels, and of the one that is cut the splits that
/// are whole. Corners are those of the finest surface so far. A level that is cut has the error of the one before, for which alone
/// it is certified; infinity if it is the first.
///
/// # Errors
/// When the bytes are not the beginning of a mesh of this version, or exceed `limits`.
pub fn decode_prefix(bytes: &[u8], limits: &LevelLimits) -> Result<ProgressiveMesh, DecodeError> {
    let (head, mut stream) = Head::read(bytes, limits)?;
    stream.cut()?;
    head.mesh(stream)
}

/// What stands before the levels.
struct Head {
    origin: DVec3,
    step: DVec3,
    frame: Frame,
}

impl Head {
    /// And the levels that follow, as far as they are there.
    fn read(bytes: &[u8], limits: &LevelLimits) -> Result<(Self, LevelStream), DecodeError> {
        let (mut fields, version) = Fields::open(bytes, &FORMAT)?;
        let [flags] = fields.bytes()?;
        let [origin, step] = [fields.doubles()?, fields.doubles()?].map(DVec3::from_array);
        let count = fields.number()? as usize;
        limits.check_levels(count)?;
        let start = Start {
            vertices: fields.number()?,
            triangles: fields.number()?,
            opens_holes: version == VERSION_WITH_HOLES,
        };
        let extent = [fields.number()?, fields.number()?, fields.number()?];
        let sampling = Sampling::read(&mut fields, flags & SAMPLED != 0)?;
        let extent = DVec3::from_array(extent.map(f64::from));
        let frame = frame(flags & HEIGHT_FIELD != 0, sampling, extent);
        if !frame.is_valid() || !origin.is_finite() || !step.is_finite() || step.min_element() <= 0.0 {
            return Err(DecodeError::OutOfRange("the lattice"));
        }
        let entries = Directory::new(false).read_all(&mut fields, count, limits)?;
        let levels = LevelsDecoder::new(start, count, frame.clone());
        let stream = LevelStream::new(entries, levels, bytes, &fields)?;
        Ok((Self { origin, step, frame }, stream))
    }

    fn mesh(&self, stream: LevelStream) -> Result<ProgressiveMesh, DecodeError> {
        let partition = stream.into_partition()?;
        partition::validate(&partition)?;
        Ok(ProgressiveMesh {
            origin: self.origin,
            step: self.step,
            is_height_field: self.frame.is_height_field,
            sampling: self.frame.sampling,
            partition,
        })
    }
}

fn frame(is_height_field: bool, sampling: Option<Sampling>, extent: DVec3) -> Frame {
    Frame {
        bounds: [DVec3::ZERO, extent],
        is_height_field,
        sampling,
    }
}

#[cfg(test)]
#[path = "spm_tests.rs"]
mod tests;
