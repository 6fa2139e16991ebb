//! The Surface Partition: vertices and triangles sorted by level, coarsest first, with vertex representatives.
//!
//! After A. Guéziec, F. Lazarus, G. Taubin, *Surface Partitions for Progressive Transmission and Display, and Dynamic
//! Simplification of Polygonal Surfaces*, IBM RC 20890, 1997, §2. It differs in one thing: at the end of every band of
//! the log the floor of the levels is raised to the highest level so far, so that bands are runs of levels.
//!
//! ```text
//! for each collapse, in order:
//!     level ← 1 + max(floor, highest level in the star of the edge)
//!     blue and red vertex, and the triangles that vanish, get that level
//!     the blue vertex keeps where the red one was; the red one is its representative
//!     at the end of a band: floor ← highest level so far
//! what is left over gets one level more; sort by level, coarsest first
//! ```
//!
//! Level of detail `k` is then a prefix of the vertices and of the triangles, each corner replaced by the root of its
//! representatives, each moved red vertex put back in the order in which the prefix undoes the collapses.

use glam::DVec3;
use thiserror::Error;

use crate::collapse_log::{self, CollapseLog, LogError};
use crate::mesh::Mesh;

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

/// A surface and its levels of detail, one for each band of the log and one for the coarsest surface.
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
}

impl SurfacePartition {
    /// Replays `log` on `mesh` and sorts what it finds. `finest_error` is the certified error of `mesh` itself.
    ///
    /// # Errors
    /// When the log cannot be replayed on this mesh.
    pub fn from_log(mesh: &Mesh, log: &CollapseLog, finest_error: f64) -> Result<Self, LogError> {
        collapse_log::validate(log, &mesh.positions)?;
        let replay = Replay::run(mesh, log);
        let vertex_order = coarsest_first(&replay.vertex_levels);
        let triangle_order = coarsest_first(&replay.triangle_levels);
        let mut place = vec![0; vertex_order.len()];
        for (index, &vertex) in (0_u32..).zip(&vertex_order) {
            place[vertex as usize] = index;
        }
        let gather = |positions: &[DVec3]| vertex_order.iter().map(|&v| positions[v as usize]).collect();
        Ok(Self {
            positions: gather(&replay.positions),
            blue_positions: gather(&replay.blue_positions),
            representatives: vertex_order
                .iter()
                .map(|&v| place[replay.representatives[v as usize] as usize])
                .collect(),
            triangles: triangle_order
                .iter()
                .map(|&t| mesh.triangles[t as usize].map(|corner| place[corner as usize]))
                .collect(),
            levels: replay.levels(log, finest_error),
        })
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

/// What replaying a log tells of every vertex and triangle, in the numbering of the mesh.
struct Replay {
    positions: Vec<DVec3>,
    blue_positions: Vec<DVec3>,
    representatives: Vec<u32>,
    vertex_levels: Vec<u32>,
    triangle_levels: Vec<u32>,
    /// The highest level by the end of each band.
    floors: Vec<u32>,
}

impl Replay {
    fn run(mesh: &Mesh, log: &CollapseLog) -> Self {
        let mut replay = Self {
            positions: mesh.positions.clone(),
            blue_positions: mesh.positions.clone(),
            representatives: (0..).take(mesh.positions.len()).collect(),
            vertex_levels: vec![0; mesh.positions.len()],
            triangle_levels: vec![0; mesh.triangles.len()],
            floors: Vec::with_capacity(log.bands.len()),
        };
        let mut stars = Stars::new(mesh);
        let (mut start, mut floor, mut highest) = (0, 0, 0);
        for band in &log.bands {
            for collapse in &log.collapses[start..band.end] {
                let (blue, red) = (collapse.blue as usize, collapse.red as usize);
                let level = 1 + floor.max(stars.highest_level(collapse.blue, collapse.red, &replay.vertex_levels));
                highest = highest.max(level);
                for removed in stars.collapse(collapse.blue, collapse.red) {
                    replay.triangle_levels[removed as usize] = level;
                }
                replay.vertex_levels[blue] = level;
                replay.vertex_levels[red] = level;
                replay.representatives[blue] = collapse.red;
                replay.blue_positions[blue] = collapse.red_before;
                replay.positions[red] = collapse.red_after;
            }
            (start, floor) = (band.end, highest);
            replay.floors.push(floor);
        }
        replay.assign_coarsest(highest + 1);
        replay
    }

    fn assign_coarsest(&mut self, level: u32) {
        for (vertex, &representative) in self.representatives.iter().enumerate() {
            if representative as usize == vertex {
                self.vertex_levels[vertex] = level;
                self.blue_positions[vertex] = self.positions[vertex];
            }
        }
        self.triangle_levels
            .iter_mut()
            .filter(|found| **found == 0)
            .for_each(|found| *found = level);
    }

    /// Coarsest first: a band's raw levels are those above the floor that the band before it left.
    fn levels(&self, log: &CollapseLog, finest_error: f64) -> Vec<Level> {
        let above = |levels: &[u32], floor: u32| levels.iter().filter(|level| **level > floor).count() as u32;
        let floors = self.floors.iter().rev().copied().chain([0]);
        let errors = log.bands.iter().rev().map(|band| band.error).chain([finest_error]);
        floors
            .zip(errors)
            .map(|(floor, error)| Level {
                vertex_end: above(&self.vertex_levels, floor),
                triangle_end: above(&self.triangle_levels, floor),
                error,
            })
            .collect()
    }
}

/// The live triangles around each vertex while a log is replayed.
struct Stars {
    corners: Vec<[u32; 3]>,
    triangles_of: Vec<Vec<u32>>,
}

impl Stars {
    fn new(mesh: &Mesh) -> Self {
        let mut triangles_of = vec![Vec::new(); mesh.positions.len()];
        for (triangle, corners) in (0_u32..).zip(&mesh.triangles) {
            corners
                .iter()
                .for_each(|&corner| triangles_of[corner as usize].push(triangle));
        }
        Self {
            corners: mesh.triangles.clone(),
            triangles_of,
        }
    }

    /// Highest level of the endpoints and all their neighbours.
    fn highest_level(&self, blue: u32, red: u32, levels: &[u32]) -> u32 {
        let star = [blue, red].into_iter().flat_map(|end| &self.triangles_of[end as usize]);
        star.flat_map(|&triangle| self.corners[triangle as usize])
            .chain([blue, red])
            .map(|vertex| levels[vertex as usize])
            .fold(0, u32::max)
    }

    /// Moves the blue vertex's triangles to the red one; returns those that vanish.
    fn collapse(&mut self, blue: u32, red: u32) -> Vec<u32> {
        let moved = std::mem::take(&mut self.triangles_of[blue as usize]);
        let (removed, kept): (Vec<u32>, Vec<u32>) = moved
            .into_iter()
            .partition(|&triangle| self.corners[triangle as usize].contains(&red));
        for &triangle in &removed {
            for corner in self.corners[triangle as usize] {
                self.triangles_of[corner as usize].retain(|&other| other != triangle);
            }
        }
        for &triangle in &kept {
            let corners = &mut self.corners[triangle as usize];
            corners
                .iter_mut()
                .filter(|corner| **corner == blue)
                .for_each(|corner| *corner = red);
        }
        self.triangles_of[red as usize].extend(kept);
        removed
    }
}

fn coarsest_first(levels: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).take(levels.len()).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(levels[index as usize]));
    order
}

#[cfg(test)]
#[path = "partition_tests.rs"]
mod tests;
