//! The progressive codec: a Surface Partition on an integer lattice as a stream of vertex splits, from a base of a few triangles
//! to the finest level. `docs/formats/spm.md` is its specification.
//!
//! ```text
//! base mesh ──splits──▶ level 0 ──splits──▶ level 1 ──▶ … ──▶ finest level        one run of bytes a level
//! ```
//! After H. Hoppe, *Progressive meshes*, 1996 (vertex splits); R. Pajarola, J. Rossignac, *Compressed progressive meshes*, 2000
//! (splits in batches, one bit a vertex to tell which, geometry that predicts them). It differs in what is told first: the new
//! vertex's position is, and then the neighbours at which the star is cut are found by how well they fit it.

mod base;
mod collapses;
mod flatness;
mod level;
mod number;
mod plan_model;
mod range_coder;
mod ring;
mod sampling;
mod schedule;
mod split;
mod star;
mod surface;

use glam::DVec3;
use terrain_core::SurfacePartition;
use terrain_core::levels::partition::{self, Level, PartitionError};
use thiserror::Error;

use base::Base;
use collapses::{Collapses, unravel};
use level::{Fault, LevelCoder, Stage, Unknown};
use range_coder::{Decoder, Encoder};
use schedule::Schedule;
use split::SplitModel;
use surface::GrowingSurface;

pub use sampling::Sampling;

/// Coordinates are at most this in size, so that sums and differences of a few stay exact in a double.
const MAX_COORDINATE: f64 = (1_u64 << 41) as f64;

/// Samples are at least this far from each other, in lattice units.
const LEAST_STEP: f64 = 1.0 / 65_536.0;

/// What a stream of levels is read by; it is stored beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The lowest and the highest coordinates: whole numbers below 2^41 in size.
    pub bounds: [DVec3; 2],
    /// Whether the third coordinate is a height over the plane of the other two and every triangle counter-clockwise in it.
    pub is_height_field: bool,
    /// Where the vertices of a height field like to lie.
    pub sampling: Option<Sampling>,
}

impl Frame {
    /// Whether its numbers are finite, in order and not too large.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let [low, high] = self.bounds;
        let are_bounds = low.cmple(high).all() && low.abs().max(high.abs()).max_element() <= MAX_COORDINATE;
        let is_sampling = |sampling: Sampling| {
            let is_small = |number: f64| number.abs() <= MAX_COORDINATE;
            sampling.origin.into_iter().all(is_small)
                && sampling
                    .step
                    .into_iter()
                    .all(|step| step >= LEAST_STEP && is_small(step))
        };
        are_bounds && self.sampling.is_none_or(is_sampling)
    }
}

/// From what the splits of level 0 begin, and what they may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Start {
    /// Vertices of the base mesh.
    pub vertices: u32,
    /// Its triangles.
    pub triangles: u32,
    /// Whether any split opens a hole.
    pub opens_holes: bool,
}

/// A coded partition.
#[derive(Clone, Debug, PartialEq)]
pub struct Coded {
    /// From what level 0 begins.
    pub start: Start,
    /// The bytes of each level.
    pub levels: Vec<Vec<u8>>,
}

/// Why a partition cannot be coded.
#[derive(Debug, Error, PartialEq)]
pub enum Uncodable {
    /// It is none.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// A coordinate is not whole, or out of bounds.
    #[error("vertex {0} is not on the lattice")]
    OffLattice(usize),
    /// The vertex cannot be split off its representative: the surface around them is no manifold, or has too many edges.
    #[error("vertex {0} is not split off a manifold surface")]
    NotASplit(usize),
    /// The splits do not lead to the partition's triangles.
    #[error("the surface is no manifold where vertices split")]
    NotASurface,
}

/// Why bytes are no levels.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("level {0} is damaged")]
pub struct Damaged(pub usize);

/// Codes a partition whose positions are whole numbers. `boundary_from` is the first of the levels that split vertices of the
/// boundary only, the number of levels if there is none.
///
/// # Errors
/// When it is not what [`Frame`] says, or no surface that vertex splits can make.
pub fn encode(partition: &SurfacePartition, boundary_from: usize, frame: &Frame) -> Result<Coded, Uncodable> {
    partition::validate(partition)?;
    check_lattice(partition, frame)?;
    let collapses = unravel(partition, frame.is_height_field).map_err(|fault| Uncodable::NotASplit(fault.0))?;
    let (base, originals) = numbered_base(partition, &collapses);
    let mut schedule = Schedule::new(partition, &collapses, originals);
    let start = Start {
        vertices: base.positions.len() as u32,
        triangles: base.triangles.len() as u32,
        opens_holes: collapses.undos.iter().any(|undo| undo.side.opens_hole()),
    };
    let mut encoder = Encoder::new();
    let count = [base.positions.len(), base.triangles.len()];
    Base::code(&mut encoder, count, frame.bounds, &base).ok_or(Uncodable::NotASurface)?;
    let mut coder = level_coder(base, frame, start.opens_holes);
    let mut levels = Vec::with_capacity(partition.levels.len());
    for (index, level) in partition.levels.iter().enumerate() {
        schedule.level = index as u32;
        let splits = level.vertex_end as usize - coder.surface.vertices.len();
        let stage = stage(index, boundary_from);
        let coded = coder.code(&mut encoder, stage, splits, &mut schedule);
        coded.map_err(|_| Uncodable::NotASurface)?;
        levels.push(std::mem::replace(&mut encoder, Encoder::new()).finish());
    }
    check_result(partition, &coder, &schedule)?;
    Ok(Coded { start, levels })
}

/// A level to decode.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Its bytes, as far as they are there.
    pub bytes: &'a [u8],
    /// Whether there are more, which are not there.
    pub is_cut: bool,
    /// What it makes once all are there.
    pub level: Level,
}

/// Decodes one level after the other.
#[derive(Debug)]
pub struct LevelsDecoder {
    start: Start,
    boundary_from: usize,
    frame: Frame,
    /// None before the first level.
    coder: Option<LevelCoder>,
    levels: Vec<Level>,
}

impl LevelsDecoder {
    /// Before the first level. `boundary_from` is the first of the levels that split vertices of the boundary only.
    #[must_use]
    pub fn new(start: Start, boundary_from: usize, frame: Frame) -> Self {
        Self {
            start,
            boundary_from,
            frame,
            coder: None,
            levels: Vec::new(),
        }
    }

    /// Decodes the next level. Of one that is cut there is what it has whole splits of, with the error of the one before, though that
    /// is certified for the one before only; a cut first level has an infinite one. Behind one that is cut there is none.
    ///
    /// # Errors
    /// Where its bytes make no surface of its size, or are cut before the base ends.
    pub fn add(&mut self, run: &Run) -> Result<(), Damaged> {
        let index = self.levels.len();
        let level = self.decode(run).ok_or(Damaged(index))?;
        self.levels.push(level);
        Ok(())
    }

    /// Decodes a level; tells what it makes as far as it is there. None if its bytes make no surface of its size.
    fn decode(&mut self, run: &Run) -> Option<Level> {
        let mut decoder = Decoder::new(run.bytes, run.is_cut);
        let coder = match &mut self.coder {
            Some(coder) => coder,
            None => self
                .coder
                .insert(first_coder(&mut decoder, self.start, run.level, &self.frame)?),
        };
        let splits = (run.level.vertex_end as usize).checked_sub(coder.surface.vertices.len())?;
        match coder.code(
            &mut decoder,
            stage(self.levels.len(), self.boundary_from),
            splits,
            &mut Unknown,
        ) {
            Err(Fault::Exhausted) if run.is_cut => Some(Level {
                vertex_end: coder.surface.vertices.len() as u32,
                triangle_end: coder.surface.triangle_count() as u32,
                error: self.levels.last().map_or(f64::INFINITY, |before| before.error),
            }),
            Ok(()) if coder.surface.triangle_count() == run.level.triangle_end as usize => Some(run.level),
            _ => None,
        }
    }

    /// What has been decoded so far. The vertices of each level come in the order of their splits, and so do the triangles; corners are
    /// those of the finest surface decoded.
    ///
    /// # Errors
    /// Before the first level.
    pub fn partition(&self) -> Result<SurfacePartition, Damaged> {
        let coder = self.coder.as_ref().ok_or(Damaged(0))?;
        Ok(SurfacePartition {
            positions: coder.made_at.clone(),
            blue_positions: coder.blue_positions.clone(),
            representatives: coder.representatives.clone(),
            triangles: coder.surface.triangles().collect(),
            levels: self.levels.clone(),
        })
    }

    /// The same, if nothing more comes.
    ///
    /// # Errors
    /// Before the first level.
    pub fn into_partition(self) -> Result<SurfacePartition, Damaged> {
        let coder = self.coder.ok_or(Damaged(0))?;
        Ok(SurfacePartition {
            positions: coder.made_at,
            blue_positions: coder.blue_positions,
            representatives: coder.representatives,
            triangles: coder.surface.triangles().collect(),
            levels: self.levels,
        })
    }
}

/// Reads the base, which stands before the splits of the first level.
fn first_coder(decoder: &mut Decoder, start: Start, level: Level, frame: &Frame) -> Option<LevelCoder> {
    if start.vertices > level.vertex_end || start.triangles > level.triangle_end {
        return None;
    }
    let size = [start.vertices as usize, start.triangles as usize];
    let base = Base::code(decoder, size, frame.bounds, &Base::default())?;
    Some(level_coder(base, frame, start.opens_holes))
}

fn stage(index: usize, boundary_from: usize) -> Stage {
    if index == 0 {
        Stage::Base
    } else if index >= boundary_from {
        Stage::Boundary
    } else {
        Stage::Level
    }
}

fn level_coder(base: Base, frame: &Frame, opens_holes: bool) -> LevelCoder {
    let splits = SplitModel::new(frame.is_height_field, frame.sampling, opens_holes);
    let vertices = base.positions.iter().map(|&position| splits.vertex(position)).collect();
    LevelCoder::new(GrowingSurface::new(vertices, &base.triangles), splits, frame.bounds)
}

fn check_lattice(partition: &SurfacePartition, frame: &Frame) -> Result<(), Uncodable> {
    let [low, high] = frame.bounds;
    let is_on_lattice =
        |position: &DVec3| *position == position.floor() && position.cmpge(low).all() && position.cmple(high).all();
    let vertices = partition.positions.iter().zip(&partition.blue_positions);
    let mut vertices = vertices.map(|(red, blue)| is_on_lattice(red) && is_on_lattice(blue));
    match vertices.position(|is_on_lattice| !is_on_lattice) {
        Some(vertex) => Err(Uncodable::OffLattice(vertex)),
        None => Ok(()),
    }
}

/// The base mesh, its vertices in the order in which its triangles name them, and their numbers in the partition.
fn numbered_base(partition: &SurfacePartition, collapses: &Collapses) -> (Base, Vec<u32>) {
    let mut base = Base::default();
    let mut originals = Vec::new();
    let mut numbers = vec![None; collapses.is_base.len()];
    for triangle in &collapses.base_triangles {
        base.triangles.push(triangle.map(|corner| {
            *numbers[corner as usize].get_or_insert_with(|| {
                originals.push(corner);
                originals.len() as u32 - 1
            })
        }));
    }
    let is_alone = |&vertex: &u32| collapses.is_base[vertex as usize] && numbers[vertex as usize].is_none();
    originals.extend((0..numbers.len() as u32).filter(is_alone));
    base.positions = originals
        .iter()
        .map(|&vertex| partition.positions[vertex as usize])
        .collect();
    (base, originals)
}

/// Compares what a decoder will have with what was asked for.
fn check_result(partition: &SurfacePartition, coder: &LevelCoder, schedule: &Schedule) -> Result<(), Uncodable> {
    let turned = |[a, b, c]: [u32; 3]| match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    };
    let original = |triangle: [u32; 3]| turned(triangle.map(|corner| schedule.originals[corner as usize]));
    let coded: Vec<[u32; 3]> = coder.surface.triangles().map(original).collect();
    let mut start = 0;
    for level in &partition.levels {
        let run = start..level.triangle_end as usize;
        let mut coded = coded.get(run.clone()).ok_or(Uncodable::NotASurface)?.to_vec();
        let mut told: Vec<[u32; 3]> = partition.triangles[run].iter().copied().map(turned).collect();
        coded.sort_unstable();
        told.sort_unstable();
        if coded != told {
            return Err(Uncodable::NotASurface);
        }
        start = level.triangle_end as usize;
    }
    Ok(())
}

#[cfg(test)]
#[path = "progressive_tests.rs"]
pub(crate) mod tests;
