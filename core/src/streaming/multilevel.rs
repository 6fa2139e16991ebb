//! The progressive multilevel mesh: levels of detail that arrive one after the other, any of which can be drawn at once.
//!
//! After A. Guéziec, G. Taubin, B. Horn, F. Lazarus, *A Framework for Streaming Geometry in VRML*, IEEE Computer Graphics
//! and Applications 19(2), 1999, "Progressive multilevel mesh". Vertices and triangles stand in order of decreasing
//! level, so a level of detail is a prefix of both. A corner whose vertex is not there yet is drawn at the vertex's
//! *representative*, one of a smaller index, or at the representative's own, and so on.
//!
//! ```text
//! add_level:  append vertices, representatives and triangles; every corner must reach a vertex that is there
//! set_level:  n ← vertices of the level
//!             for each vertex v, in order: root[v] ← v < n ? v : root[representative[v]]
//!             draw the level's triangles, each corner at its root
//! ```
//!
//! Levels are numbered as in the paper: 0 is the finest one there is, the coarsest is the number of levels less one. While
//! a mesh loads, every arriving level becomes level 0. A vertex is `DIMENSION` numbers; those past the third may be any
//! properties that it makes sense to interpolate.

mod ascii;
mod build;
mod needed;
mod tokens;
mod view;

use std::collections::BTreeMap;
use std::ops::Range;

use thiserror::Error;

pub use ascii::{AsciiReader, ReadError, ReadFault, to_ascii};
pub use build::FromPartitionError;
pub use tokens::Place;
pub use view::{LevelRangeError, LevelView};

/// How much a mesh from outside may hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultilevelLimits {
    /// Vertices, and so the largest index less one; levels may name vertices that have yet to come.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
    /// Levels.
    pub levels: u32,
}

impl MultilevelLimits {
    /// Only what indices can count; for meshes of our own making.
    pub const NONE: Self = Self {
        vertices: u32::MAX,
        triangles: u32::MAX,
        levels: u32::MAX,
    };
}

impl Default for MultilevelLimits {
    /// 2²⁷ vertices, twice as many triangles, 65,536 levels: 6 GB for a full mesh of dimension 3.
    fn default() -> Self {
        Self {
            vertices: 1 << 27,
            triangles: 1 << 28,
            levels: 1 << 16,
        }
    }
}

/// One level on its way into a [`MultilevelMesh`]: what the next finer surface adds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelBatch<const DIMENSION: usize = 3> {
    /// The level's vertices; they are numbered on from those that are there.
    pub positions: Vec<[f64; DIMENSION]>,
    /// The level's triangles; a corner may be a vertex of a finer level if it has a representative.
    pub triangles: Vec<[u32; 3]>,
    /// Pairs of a vertex and its representative, each vertex once in a mesh.
    pub representatives: Vec<(u32, u32)>,
}

/// Which part of a batch is at fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelPart {
    /// The batch as a whole.
    Batch,
    /// One of the batch's vertices.
    Position(usize),
    /// One of the batch's triangles.
    Triangle(usize),
    /// One of the batch's pairs of vertex and representative.
    Representative(usize),
}

/// What is wrong with it.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum LevelFault {
    /// The mesh would outgrow the limit on levels.
    #[error("more than {0} levels; raise the limit to read it")]
    TooManyLevels(u32),
    /// The mesh would outgrow the limit on vertices.
    #[error("more than {0} vertices, or the index of one; raise the limit to read it")]
    TooManyVertices(u32),
    /// The mesh would outgrow the limit on triangles.
    #[error("more than {0} triangles; raise the limit to read it")]
    TooManyTriangles(u32),
    /// A coordinate is NaN or infinite.
    #[error("a coordinate is not finite")]
    NotFinite,
    /// Two corners are one vertex.
    #[error("vertex {0} is used twice by one triangle")]
    Degenerate(u32),
    /// A representative must have a smaller index than its vertex.
    #[error("vertex {vertex} cannot be represented by {representative}: a representative comes before its vertex")]
    NotBefore {
        /// The vertex.
        vertex: u32,
        /// What was to represent it.
        representative: u32,
    },
    /// A vertex has one representative for the whole mesh.
    #[error("vertex {0} has a representative already")]
    Repeated(u32),
    /// A corner, or the representative of a corner, is missing and has no representative.
    #[error("vertex {0} is not there yet and has no representative")]
    Unrepresented(u32),
    /// The finest level uses a vertex that never came.
    #[error("vertex {vertex} is used, but there are only {count} vertices")]
    NeverGiven {
        /// The vertex.
        vertex: u32,
        /// How many there are.
        count: u32,
    },
}

/// Why a level is refused. The mesh is as it was before.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("{part:?}: {fault}")]
pub struct LevelError {
    /// Where the fault is.
    pub part: LevelPart,
    /// What it is.
    pub fault: LevelFault,
}

/// How far the arrays reach for one level of detail: a prefix of each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelEnd {
    /// Its vertices.
    pub vertices: u32,
    /// Its triangles.
    pub triangles: u32,
}

/// A mesh and its levels of detail, as many as have arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct MultilevelMesh<const DIMENSION: usize = 3> {
    limits: MultilevelLimits,
    positions: Vec<[f64; DIMENSION]>,
    triangles: Vec<[u32; 3]>,
    /// One entry a vertex; its own index where it has no representative.
    representatives: Vec<u32>,
    /// Representatives of vertices that have yet to come.
    awaited: BTreeMap<u32, u32>,
    /// Coarsest first.
    ends: Vec<LevelEnd>,
    /// One past the largest vertex that a triangle uses.
    used_end: u32,
}

impl<const DIMENSION: usize> Default for MultilevelMesh<DIMENSION> {
    fn default() -> Self {
        Self::new(MultilevelLimits::default())
    }
}

impl<const DIMENSION: usize> MultilevelMesh<DIMENSION> {
    /// A mesh without a level.
    #[must_use]
    pub fn new(limits: MultilevelLimits) -> Self {
        Self {
            limits,
            positions: Vec::new(),
            triangles: Vec::new(),
            representatives: Vec::new(),
            awaited: BTreeMap::new(),
            ends: Vec::new(),
            used_end: 0,
        }
    }

    /// Appends the next finer level, which becomes level 0 (the paper's `addLevel`). Costs no more than the level is
    /// large, whatever is there already.
    ///
    /// # Errors
    /// The first fault of the batch; the mesh is then as it was.
    pub fn add_level(&mut self, batch: LevelBatch<DIMENSION>) -> Result<(), LevelError> {
        self.check_size(&batch)?;
        check_positions(&batch.positions)?;
        self.take_representatives(&batch)?;
        if let Err(error) = self.check_triangles(&batch) {
            batch
                .representatives
                .iter()
                .for_each(|(vertex, _)| self.forget_representative(*vertex));
            return Err(error);
        }
        let corners = batch.triangles.as_flattened().iter();
        self.used_end = corners.fold(self.used_end, |end, &corner| end.max(corner + 1));
        self.positions.extend(batch.positions);
        self.triangles.extend(batch.triangles);
        self.settle_awaited();
        self.ends.push(LevelEnd {
            vertices: self.positions.len() as u32,
            triangles: self.triangles.len() as u32,
        });
        Ok(())
    }

    /// Checks that no vertex is awaited any more: what a mesh without further levels must pass.
    ///
    /// # Errors
    /// With the largest vertex that is used and missing.
    pub fn check_complete(&self) -> Result<(), LevelFault> {
        let count = self.positions.len() as u32;
        match self.used_end {
            end if end > count => Err(LevelFault::NeverGiven { vertex: end - 1, count }),
            _ => Ok(()),
        }
    }

    /// Levels that have arrived.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.ends.len()
    }

    /// How much of [`positions`](Self::positions) and [`triangles`](Self::triangles) level of detail `level` has. None where
    /// there is no such level.
    #[must_use]
    pub fn end(&self, level: usize) -> Option<LevelEnd> {
        let place = self.ends.len().checked_sub(level + 1)?;
        Some(self.ends[place])
    }

    /// All vertices that have arrived, coarsest first.
    #[must_use]
    pub fn positions(&self) -> &[[f64; DIMENSION]] {
        &self.positions
    }

    /// All triangles that have arrived, coarsest first, with the corners of the finest surface.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// What stands for `vertex` where it is missing, if it has anything to stand for it.
    #[must_use]
    pub fn representative(&self, vertex: u32) -> Option<u32> {
        match self.representatives.get(vertex as usize) {
            Some(&own) => (own != vertex).then_some(own),
            None => self.awaited.get(&vertex).copied(),
        }
    }

    /// All vertices that have a representative, with it, in order.
    pub fn representatives(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let arrived = (0_u32..).zip(self.representatives.iter().copied());
        let arrived = arrived.filter(|(vertex, own)| vertex != own);
        arrived.chain(self.awaited.iter().map(|(&vertex, &own)| (vertex, own)))
    }

    /// Where vertices and triangles of level `level` alone stand in the arrays.
    fn level_range(&self, level: usize) -> (Range<usize>, Range<usize>) {
        let start = self.end(level + 1).unwrap_or_default();
        let end = self.end(level).unwrap_or(start);
        (
            start.vertices as usize..end.vertices as usize,
            start.triangles as usize..end.triangles as usize,
        )
    }

    fn check_size(&self, batch: &LevelBatch<DIMENSION>) -> Result<(), LevelError> {
        let levels = self.limits.levels;
        let room = match self.ends.len() < levels as usize {
            true => Ok(()),
            false => Err(LevelFault::TooManyLevels(levels)),
        };
        room.and_then(|()| self.check_room(batch.positions.len(), batch.triangles.len()))
            .map_err(|fault| LevelError {
                part: LevelPart::Batch,
                fault,
            })
    }

    /// Whether so many vertices and triangles more are within the limits.
    fn check_room(&self, vertices: usize, triangles: usize) -> Result<(), LevelFault> {
        let MultilevelLimits {
            vertices: vertex_limit,
            triangles: triangle_limit,
            ..
        } = self.limits;
        if self.positions.len() + vertices > vertex_limit as usize {
            return Err(LevelFault::TooManyVertices(vertex_limit));
        }
        if self.triangles.len() + triangles > triangle_limit as usize {
            return Err(LevelFault::TooManyTriangles(triangle_limit));
        }
        Ok(())
    }

    /// Remembers the batch's representatives, all of them or, when one is refused, none.
    fn take_representatives(&mut self, batch: &LevelBatch<DIMENSION>) -> Result<(), LevelError> {
        for (index, &(vertex, own)) in batch.representatives.iter().enumerate() {
            if let Err(fault) = self.take_representative(vertex, own) {
                let taken = &batch.representatives[..index];
                taken.iter().for_each(|(vertex, _)| self.forget_representative(*vertex));
                let part = LevelPart::Representative(index);
                return Err(LevelError { part, fault });
            }
        }
        Ok(())
    }

    fn take_representative(&mut self, vertex: u32, representative: u32) -> Result<(), LevelFault> {
        self.check_index(vertex)?;
        check_before(representative, vertex)?;
        if self.representative(vertex).is_some() {
            return Err(LevelFault::Repeated(vertex));
        }
        self.set_representative(vertex, representative);
        Ok(())
    }

    fn set_representative(&mut self, vertex: u32, representative: u32) {
        match self.representatives.get_mut(vertex as usize) {
            Some(own) => *own = representative,
            None => _ = self.awaited.insert(vertex, representative),
        }
    }

    fn forget_representative(&mut self, vertex: u32) {
        match self.representatives.get_mut(vertex as usize) {
            Some(own) => *own = vertex,
            None => _ = self.awaited.remove(&vertex),
        }
    }

    fn check_triangles(&self, batch: &LevelBatch<DIMENSION>) -> Result<(), LevelError> {
        let present = (self.positions.len() + batch.positions.len()) as u32;
        for (index, corners) in batch.triangles.iter().enumerate() {
            let part = LevelPart::Triangle(index);
            self.check_corners(*corners, present)
                .map_err(|fault| LevelError { part, fault })?;
        }
        Ok(())
    }

    fn check_corners(&self, corners: [u32; 3], present: u32) -> Result<(), LevelFault> {
        check_distinct(corners)?;
        for mut vertex in corners {
            self.check_index(vertex)?;
            while vertex >= present {
                vertex = self.representative(vertex).ok_or(LevelFault::Unrepresented(vertex))?;
            }
        }
        Ok(())
    }

    fn check_index(&self, vertex: u32) -> Result<(), LevelFault> {
        match vertex < self.limits.vertices {
            true => Ok(()),
            false => Err(LevelFault::TooManyVertices(self.limits.vertices)),
        }
    }

    /// Gives the vertices that have just come the representatives that came before them.
    fn settle_awaited(&mut self) {
        for vertex in self.representatives.len() as u32..self.positions.len() as u32 {
            let own = self.awaited.remove(&vertex).unwrap_or(vertex);
            self.representatives.push(own);
        }
    }
}

fn check_positions<const DIMENSION: usize>(positions: &[[f64; DIMENSION]]) -> Result<(), LevelError> {
    let is_bad = |position: &[f64; DIMENSION]| position.iter().any(|coordinate| !coordinate.is_finite());
    match positions.iter().position(is_bad) {
        None => Ok(()),
        Some(index) => Err(LevelError {
            part: LevelPart::Position(index),
            fault: LevelFault::NotFinite,
        }),
    }
}

fn check_before(representative: u32, vertex: u32) -> Result<(), LevelFault> {
    match representative < vertex {
        true => Ok(()),
        false => Err(LevelFault::NotBefore { vertex, representative }),
    }
}

fn check_distinct([a, b, c]: [u32; 3]) -> Result<(), LevelFault> {
    match () {
        () if a == b || a == c => Err(LevelFault::Degenerate(a)),
        () if b == c => Err(LevelFault::Degenerate(b)),
        () => Ok(()),
    }
}

#[cfg(test)]
#[path = "multilevel_tests.rs"]
mod tests;
