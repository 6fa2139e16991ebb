//! The Surface Partition: vertices and triangles sorted by level, coarsest first, with vertex representatives.
//!
//! After A. Guéziec, F. Lazarus, G. Taubin, *Surface Partitions for Progressive Transmission and Display, and Dynamic
//! Simplification of Polygonal Surfaces*, IBM RC 20890, 1997, §2. It differs in one thing: at the end of every band of
//! the log the floor of the levels is raised to the highest level so far, so that bands are runs of levels. How levels
//! are found stands in [`crate::levels::replay`].
//!
//! Level of detail `k` is a prefix of the vertices and of the triangles, each corner replaced by the root of its
//! representatives, each moved red vertex put back in the order in which the prefix undoes the collapses.
//! [`crate::levels::level_view`] goes from one level to another.

use glam::DVec3;
use thiserror::Error;

use crate::levels::attribute::Attribute;
use crate::levels::collapse_log::{Band, Collapse, CollapseLog, LogError};
use crate::levels::replay::{Batch, Demand, Replay};
use crate::mesh::Mesh;
use crate::topology::connectivity::{Connectivity, EdgeStar};

/// How far the arrays reach for one level of detail, and what its surface is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Vertices of this level and all coarser ones.
    pub vertex_end: u32,
    /// Triangles of this level and all coarser ones.
    pub triangle_end: u32,
    /// Certified error of the surface that the prefix draws, in the units of the heights.
    pub error: f64,
}

/// A surface and its levels of detail. Raw levels may be merged; inside each, vertices keep the order of raw levels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfacePartition {
    /// Position of each vertex at the time it left the surface, or in the coarsest surface where it never did.
    pub positions: Vec<DVec3>,
    /// Where the representative was before the vertex collapsed into it; for vertices of the coarsest level, their
    /// own position.
    pub blue_positions: Vec<DVec3>,
    /// Vertex that each one collapses into, of a smaller index; itself in the coarsest level.
    pub representatives: Vec<u32>,
    /// Corners as of the finest surface, in this numbering.
    pub triangles: Vec<[u32; 3]>,
    /// Coarsest first.
    pub levels: Vec<Level>,
}

/// Why arrays are not a Surface Partition.
#[derive(Debug, Error, PartialEq)]
pub enum PartitionError {
    /// The arrays of the vertices differ in length.
    #[error("arrays of {0}, {1} and {2} vertices")]
    Lengths(usize, usize, usize),
    /// There is no level, or their ends do not grow up to the arrays' lengths.
    #[error("level {0} does not end where it should")]
    BadLevel(usize),
    /// The errors grow towards the finest level, or are no numbers.
    #[error("level {0} claims a larger error than the coarser one before it")]
    ErrorNotMonotone(usize),
    /// A representative comes after its vertex, or a vertex of the coarsest level has one.
    #[error("vertex {0} has a representative that comes after it")]
    BadRepresentative(usize),
    /// A triangle of a level uses a vertex of a finer one, or no vertex at all.
    #[error("triangle {0} has a corner out of range")]
    BadCorner(usize),
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} is not finite")]
    NotFinite(usize),
    /// Levels were to be merged into batches that do not begin with level 1, shrink or pass the highest level.
    #[error("batch {0} does not begin where it should")]
    BadBatch(usize),
}

/// Bytes of a coordinate and of an index in §2.3.
const INDEX_OR_COORDINATE: usize = 4;

/// Bytes that a partition takes. A closed surface of `n` vertices has some `2n` triangles: `mesh` is `36n`, and
/// `mesh + representatives` less than `40n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Storage {
    /// Positions and triangles, as without levels.
    pub mesh: usize,
    /// Representatives; those of red vertices go without saying.
    pub representatives: usize,
    /// Where red vertices were before each collapse, if they move: one entry for each blue vertex.
    pub blue_positions: usize,
    /// The same as the paper has it, a whole copy of the positions.
    pub blue_positions_whole: usize,
}

impl SurfacePartition {
    /// Replays `log` on `mesh` and sorts what it finds into one level for each band and one for the coarsest surface.
    /// `finest_error` is the certified error of `mesh` itself. The log is trusted to be valid ([`Demand::Drawable`]).
    ///
    /// # Errors
    /// When the log cannot be replayed on this mesh.
    pub fn from_log(mesh: &Mesh, log: &CollapseLog, finest_error: f64) -> Result<Self, LogError> {
        let replay = Replay::run(mesh, log, Demand::Drawable, |_| ())?;
        Ok(Self::assembled(mesh, &replay, &replay.band_batches(log, finest_error)))
    }

    /// Sorts what `replay` found out about `mesh`, with one level for each of `batches`, which are given finest first:
    /// [`Replay::level_batches`], [`Replay::band_batches`] or any others that begin with level 1 and grow.
    ///
    /// # Errors
    /// [`PartitionError::BadBatch`] where they do not.
    pub fn from_replay(mesh: &Mesh, replay: &Replay, batches: &[Batch]) -> Result<Self, PartitionError> {
        let mut previous = 1;
        for (index, batch) in batches.iter().enumerate() {
            let is_first = index == 0 && batch.first_level != 1;
            if is_first || batch.first_level < previous || batch.first_level > replay.top_level {
                return Err(PartitionError::BadBatch(index));
            }
            previous = batch.first_level;
        }
        if batches.is_empty() {
            return Err(PartitionError::BadBatch(0));
        }
        Ok(Self::assembled(mesh, replay, batches))
    }

    /// The finest surface and the collapses that make its levels, each a band: the opposite of [`Self::from_log`], but for the order of
    /// the vertices, which is that of the partition here. Where a collapse fails the link condition it is one that closes a hole, or
    /// the surface is none of which [`Demand::Consistent`] can be asked.
    #[must_use]
    pub fn to_log(&self) -> (Mesh, CollapseLog) {
        let count = self.positions.len();
        let mut positions = self.position_attribute();
        positions.undo(&self.representatives, self.coarsest_end()..count);
        let mesh = Mesh {
            positions: positions.red.clone(),
            triangles: self.triangles.clone(),
        };
        let (mut connectivity, mut star) = (Connectivity::new(&mesh), EdgeStar::default());
        let collapses = (self.coarsest_end()..count).rev().map(|vertex| {
            let (blue, red) = (vertex as u32, self.representatives[vertex]);
            star.gather(&connectivity, blue, red);
            let closes_hole = star.link_condition().is_err() && star.closing_condition(&connectivity).is_ok();
            connectivity.collapse(&star, &mut Vec::new());
            let red_before = positions.red[red as usize];
            positions.redo(&self.representatives, vertex..vertex + 1);
            Collapse {
                blue,
                red,
                red_before,
                red_after: positions.red[red as usize],
                closes_hole,
            }
        });
        let collapses = collapses.collect();
        let bands = self.levels.iter().rev().skip(1).map(|level| Band {
            end: count - level.vertex_end as usize,
            error: level.error,
        });
        let bands = bands.collect();
        (mesh, CollapseLog { collapses, bands })
    }

    /// One past the last vertex that never collapses.
    fn coarsest_end(&self) -> usize {
        self.levels.first().map_or(0, |level| level.vertex_end as usize)
    }

    fn assembled(mesh: &Mesh, replay: &Replay, batches: &[Batch]) -> Self {
        let vertex_order = replay.vertex_order();
        let mut place = vec![0; vertex_order.len()];
        for (index, &vertex) in (0_u32..).zip(&vertex_order) {
            place[vertex as usize] = index;
        }
        let placed = |vertex: u32| place[vertex as usize];
        let positions = replay.positions.sorted(&vertex_order);
        let triangles = replay.triangle_order().into_iter();
        Self {
            positions: positions.red,
            blue_positions: positions.blue,
            representatives: vertex_order
                .iter()
                .map(|&vertex| placed(replay.representatives[vertex as usize]))
                .collect(),
            triangles: triangles
                .map(|triangle| mesh.triangles[triangle as usize].map(placed))
                .collect(),
            levels: levels(replay, batches),
        }
    }

    /// The positions as the attribute that level switches work on.
    #[must_use]
    pub fn position_attribute(&self) -> Attribute<DVec3> {
        Attribute {
            red: self.positions.clone(),
            blue: self.blue_positions.clone(),
        }
    }

    /// What the arrays take by the reckoning of §2.3: 4 bytes a coordinate, 4 bytes an index.
    #[must_use]
    pub fn storage(&self) -> Storage {
        let vertices = self.positions.len();
        let red = self.coarsest_end();
        Storage {
            mesh: INDEX_OR_COORDINATE * 3 * (vertices + self.triangles.len()),
            representatives: INDEX_OR_COORDINATE * (vertices - red),
            blue_positions: INDEX_OR_COORDINATE * 3 * (vertices - red),
            blue_positions_whole: INDEX_OR_COORDINATE * 3 * vertices,
        }
    }

    /// The surface of level `level` and all coarser ones; vertices keep their order, so level `k` uses the first
    /// `levels[k].vertex_end`.
    #[must_use]
    pub fn lod(&self, level: usize) -> Mesh {
        self.lod_of(|candidate| candidate <= level)
    }

    /// The surface of all levels for which `selected` holds. The coarsest must be among them; which other sets are
    /// surfaces is for the maker of the log to know (every prefix is).
    #[must_use]
    pub fn lod_of(&self, selected: impl Fn(usize) -> bool) -> Mesh {
        let mut positions = self.positions.clone();
        let mut roots: Vec<u32> = (0..).take(positions.len()).collect();
        let mut kept = vec![false; positions.len()];
        let mut triangles = Vec::new();
        let (mut vertex_start, mut triangle_start) = (0, 0);
        for (index, level) in self.levels.iter().enumerate() {
            let (vertex_end, triangle_end) = (level.vertex_end as usize, level.triangle_end as usize);
            let is_selected = selected(index);
            for vertex in vertex_start..vertex_end {
                let representative = self.representatives[vertex] as usize;
                if !is_selected {
                    roots[vertex] = roots[representative];
                    continue;
                }
                kept[vertex] = true;
                if representative != vertex {
                    positions[representative] = self.blue_positions[vertex];
                }
            }
            if is_selected {
                triangles.extend_from_slice(&self.triangles[triangle_start..triangle_end]);
            }
            (vertex_start, triangle_start) = (vertex_end, triangle_end);
        }
        let mut numbers = vec![0_u32; positions.len()];
        for (count, vertex) in (0..positions.len()).filter(|&vertex| kept[vertex]).enumerate() {
            numbers[vertex] = count as u32;
        }
        for corner in triangles.as_flattened_mut() {
            *corner = numbers[roots[*corner as usize] as usize];
        }
        let mut keep = kept.iter();
        positions.retain(|_| *keep.next().unwrap_or(&false));
        Mesh { positions, triangles }
    }
}

/// Checks that the arrays are a Surface Partition: levels in order, errors monotone, every representative before its
/// vertex, every corner of a level drawn by it.
///
/// # Errors
/// The first fault.
pub fn validate(partition: &SurfacePartition) -> Result<(), PartitionError> {
    let count = partition.positions.len();
    if partition.blue_positions.len() != count || partition.representatives.len() != count {
        let lengths = (partition.blue_positions.len(), partition.representatives.len());
        return Err(PartitionError::Lengths(count, lengths.0, lengths.1));
    }
    let finite = |v: &usize| partition.positions[*v].is_finite() && partition.blue_positions[*v].is_finite();
    if let Some(vertex) = (0..count).find(|v| !finite(v)) {
        return Err(PartitionError::NotFinite(vertex));
    }
    validate_levels(partition)?;
    let coarsest_end = partition.levels[0].vertex_end as usize;
    for (vertex, &representative) in partition.representatives.iter().enumerate() {
        let representative = representative as usize;
        if if vertex < coarsest_end {
            representative != vertex
        } else {
            representative >= vertex
        } {
            return Err(PartitionError::BadRepresentative(vertex));
        }
    }
    let out_of_range = |triangle: &[u32; 3]| triangle.iter().any(|&corner| corner as usize >= count);
    match partition.triangles.iter().position(out_of_range) {
        Some(triangle) => Err(PartitionError::BadCorner(triangle)),
        None => Ok(()),
    }
}

fn validate_levels(partition: &SurfacePartition) -> Result<(), PartitionError> {
    let mut previous = Level {
        vertex_end: 0,
        triangle_end: 0,
        error: f64::INFINITY,
    };
    for (index, level) in partition.levels.iter().enumerate() {
        if level.vertex_end < previous.vertex_end || level.triangle_end < previous.triangle_end {
            return Err(PartitionError::BadLevel(index));
        }
        if level.error.is_nan() || level.error > previous.error {
            return Err(PartitionError::ErrorNotMonotone(index));
        }
        previous = *level;
    }
    let complete = (previous.vertex_end as usize, previous.triangle_end as usize)
        == (partition.positions.len(), partition.triangles.len());
    if partition.levels.is_empty() || !complete {
        return Err(PartitionError::BadLevel(partition.levels.len().saturating_sub(1)));
    }
    Ok(())
}

/// Coarsest first.
fn levels(replay: &Replay, batches: &[Batch]) -> Vec<Level> {
    let vertices = replay.counts_from(&replay.vertex_levels);
    let triangles = replay.counts_from(&replay.triangle_levels);
    let level = |batch: &Batch| Level {
        vertex_end: vertices[batch.first_level as usize],
        triangle_end: triangles[batch.first_level as usize],
        error: batch.error,
    };
    batches.iter().rev().map(level).collect()
}

#[cfg(test)]
#[path = "partition_tests.rs"]
mod tests;
