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

use crate::codec::rounded_up;
use crate::fields::{self, Directory, Entry, Fields, Format};
use crate::progressive::{self, BaseSize, Frame, Run, Sampling};

pub use crate::fields::{DecodeError, Limits};

const FORMAT: Format = Format {
    name: "progressive mesh file",
    magic: *b"SPMF",
    version: 1,
};
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
    /// A level of more bytes than its field tells.
    #[error("a level is larger than 4 GiB")]
    TooLarge,
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
    let positions = partition.positions.iter().chain(&partition.blue_positions);
    let extent = positions.fold(DVec3::ZERO, |extent, &position| extent.max(position));
    let frame = frame(model.is_height_field, model.sampling, extent);
    let is_positive = |step: f64| step.is_finite() && step > 0.0;
    let is_lattice = model.origin.is_finite() && model.step.to_array().into_iter().all(is_positive);
    if !is_lattice || !frame.is_valid() || extent.max_element() > MAX_EXTENT {
        return Err(EncodeError::Lattice);
    }
    let coded = progressive::encode(partition, partition.levels.len(), &frame)?;
    let mut bytes = Vec::new();
    write_header(&mut bytes, model, extent, coded.base);
    let mut directory = Directory::new(false);
    for (&level, coded) in partition.levels.iter().zip(&coded.levels) {
        let mut entry = Entry {
            length: coded.len(),
            level,
            outline_error: 0.0,
        };
        entry.level.error = f64::from(rounded_up(level.error));
        directory.write(&mut bytes, &entry).map_err(|_| EncodeError::TooLarge)?;
    }
    coded.levels.iter().for_each(|level| bytes.extend(level));
    Ok(bytes)
}

fn write_header(bytes: &mut Vec<u8>, model: &Model, extent: DVec3, base: BaseSize) {
    bytes.extend(FORMAT.magic);
    let flags = u8::from(model.is_height_field) * HEIGHT_FIELD + u8::from(model.sampling.is_some()) * SAMPLED;
    bytes.extend([FORMAT.version, flags]);
    let lattice = [model.origin.to_array(), model.step.to_array()];
    bytes.extend(lattice.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
    let extent = extent.to_array().map(|extent| extent as u32);
    let numbers = [model.partition.levels.len() as u32, base.vertices, base.triangles];
    for number in numbers.into_iter().chain(extent) {
        bytes.extend(number.encode_var_vec());
    }
    model.sampling.iter().for_each(|sampling| sampling.write(bytes));
}

/// Reads a whole model.
///
/// # Errors
/// When the bytes are not a model of this version, or exceed `limits`.
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Model, DecodeError> {
    let head = Head::read(bytes, limits)?;
    head.model(&fields::whole_runs(&head.entries, &head.rest)?)
}

/// Reads as much of a model as its first bytes tell, at least its base: whole levels, and of the one that is cut the splits that
/// are whole. Corners are those of the finest surface so far. A level that is cut has the error of the one before, for which alone
/// it is certified; infinity if it is the first.
///
/// # Errors
/// When the bytes are not the beginning of a model of this version, or exceed `limits`.
pub fn decode_prefix(bytes: &[u8], limits: &Limits) -> Result<Model, DecodeError> {
    let head = Head::read(bytes, limits)?;
    head.model(&fields::runs(&head.entries, &head.rest)?)
}

/// What stands before the levels, and what follows.
struct Head<'a> {
    origin: DVec3,
    step: DVec3,
    frame: Frame,
    base: BaseSize,
    entries: Vec<Entry>,
    rest: Fields<'a>,
}

impl<'a> Head<'a> {
    fn read(bytes: &'a [u8], limits: &Limits) -> Result<Self, DecodeError> {
        let mut fields = Fields::open(bytes, &FORMAT)?;
        let [flags] = fields.bytes()?;
        let [origin, step] = [fields.doubles()?, fields.doubles()?].map(DVec3::from_array);
        let count = fields.number()? as usize;
        limits.check_levels(count)?;
        let base = BaseSize {
            vertices: fields.number()?,
            triangles: fields.number()?,
        };
        let extent = [fields.number()?, fields.number()?, fields.number()?];
        let sampling = Sampling::read(&mut fields, flags & SAMPLED != 0)?;
        let extent = DVec3::from_array(extent.map(f64::from));
        let frame = frame(flags & HEIGHT_FIELD != 0, sampling, extent);
        if !frame.is_valid() || !origin.is_finite() || !step.is_finite() || step.min_element() <= 0.0 {
            return Err(DecodeError::OutOfRange("the lattice"));
        }
        Ok(Self {
            origin,
            step,
            frame,
            base,
            entries: Directory::new(false).read_all(&mut fields, count, limits)?,
            rest: fields,
        })
    }

    fn model(&self, runs: &[Run]) -> Result<Model, DecodeError> {
        let partition = progressive::decode(self.base, runs, self.entries.len(), &self.frame)?;
        partition::validate(&partition)?;
        Ok(Model {
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
#[path = "model_tests.rs"]
mod tests;
