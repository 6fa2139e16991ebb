//! Performs the collapses of a log again, without their geometry, and notes what each did (Surface Partitions §2.1,
//! §2.2, §2.4).
//!
//! ```text
//! for each collapse, in order:
//!     gather the star of the edge; refuse what fails the link condition
//!     level ← 1 + max(floor, highest level of a vertex in the star)
//!     blue and red vertex, and the triangles that vanish, get that level
//!     a triangle that vanishes is represented by the one across (blue, third), or across (red, third) at the boundary
//!     the blue vertex keeps where the red one was; the red one is its representative
//!     at the end of a band: floor ← highest level so far
//! what is left over gets one level more
//! ```
//!
//! Why levels work: the star of a collapse is one of levels below its own, so undoing all collapses from some level on
//! leaves each remaining star as it was when its edge collapsed. This needs a 2-manifold and the link condition. A collapse that
//! closes a hole is no exception: it is one inside the surface with the hole as a triangle that is removed, too.
//!
//! The time is that of looking at every star once.

use glam::DVec3;

use crate::levels::attribute::Attribute;
use crate::levels::collapse_log::{self, Collapse, CollapseLog, LogError};
use crate::mesh::Mesh;
use crate::topology::compressed_rows::CompressedRows;
use crate::topology::connectivity::{Connectivity, EdgeStar};
use crate::topology::manifold;

/// What a replay insists on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// A 2-manifold and collapses that pass the link condition, boundary part included, or close a hole of three vertices if they
    /// say so. Every level of detail is then a consistent surface, and so is every closed set of collapses.
    Consistent,
    /// Vertices that exist. For collapses that were checked when they were made, and for surfaces that are no
    /// manifolds, whose levels can be drawn but may have folds.
    Drawable,
}

/// A run of raw levels that becomes one level of a partition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Batch {
    /// The lowest raw level of the run, from 1.
    pub first_level: u32,
    /// Certified error of the surface of this run and all coarser ones, in the units of the heights.
    pub error: f64,
}

/// One collapse while it is replayed.
pub struct Step<'a> {
    /// Its index in the log.
    pub index: u32,
    /// The collapse.
    pub collapse: Collapse,
    /// Its level, from 1.
    pub level: u32,
    /// The star of its edge before the collapse.
    pub star: &'a EdgeStar,
    /// Corners (`3 × triangle + k`) that it gives over from the blue vertex to the red one.
    pub moved: &'a [u32],
}

/// What a log does to every vertex and triangle of a mesh, in the mesh's numbering. Levels run from 1 to `top_level`,
/// the level of what is never removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The highest level: one more than that of any collapse.
    pub top_level: u32,
    /// Level of each collapse.
    pub collapse_levels: Vec<u32>,
    /// Level of each vertex.
    pub vertex_levels: Vec<u32>,
    /// Level of each triangle.
    pub triangle_levels: Vec<u32>,
    /// The vertex that each one collapsed into; itself where it never did.
    pub representatives: Vec<u32>,
    /// The triangle that each removed one fell onto, itself where it was not removed, and none where nothing was
    /// beside it. It may have been removed later: follow the chain.
    pub triangle_representatives: Vec<Option<u32>>,
    /// Positions after all collapses, and those that red vertices had before each. Where a vertex never collapsed,
    /// both are its last one.
    pub positions: Attribute<DVec3>,
    /// The highest level by the end of each band.
    floors: Vec<u32>,
}

impl Replay {
    /// Replays `log` on `mesh` and shows each collapse to `visit` once it is done.
    ///
    /// # Errors
    /// Where the log or the mesh is not what `demand` asks for; of collapses, the first, with its index and the reason.
    pub fn run(mesh: &Mesh, log: &CollapseLog, demand: Demand, mut visit: impl FnMut(&Step)) -> Result<Self, LogError> {
        manifold::check_corners(mesh)?;
        collapse_log::validate(log, &mesh.positions)?;
        let mut surface = ReplayedSurface {
            connectivity: Connectivity::new(mesh),
            star: EdgeStar::default(),
            moved: Vec::new(),
        };
        if demand == Demand::Consistent {
            manifold::check_stars(&surface.connectivity)?;
        }
        let mut replay = Self::before(mesh, log);
        for band in &log.bands {
            let floor = replay.top_level;
            for index in replay.collapse_levels.len()..band.end {
                let collapse = log.collapses[index];
                surface.look_at(index, collapse, demand)?;
                let level = replay.note(&surface, collapse, floor);
                visit(&surface.perform(index, collapse, level));
            }
            replay.floors.push(replay.top_level);
        }
        replay.finish();
        Ok(replay)
    }

    /// Vertices by decreasing level, those of one level in the mesh's order.
    #[must_use]
    pub fn vertex_order(&self) -> Vec<u32> {
        self.coarsest_first(&self.vertex_levels)
    }

    /// Triangles by decreasing level, those of one level in the mesh's order.
    #[must_use]
    pub fn triangle_order(&self) -> Vec<u32> {
        self.coarsest_first(&self.triangle_levels)
    }

    /// How many of `levels` are `level` or above, for each level from 0 to one past the highest.
    #[must_use]
    pub fn counts_from(&self, levels: &[u32]) -> Vec<u32> {
        let mut counts = vec![0; self.top_level as usize + 2];
        for &level in levels {
            counts[level as usize] += 1;
        }
        for level in (0..=self.top_level as usize).rev() {
            counts[level] += counts[level + 1];
        }
        counts
    }

    /// One batch for each band of the log and one for the coarsest surface: levels merged by certified error.
    /// `finest_error` is that of the mesh itself.
    #[must_use]
    pub fn band_batches(&self, log: &CollapseLog, finest_error: f64) -> Vec<Batch> {
        let firsts = [0].iter().chain(&self.floors).map(|floor| floor + 1);
        let errors = [finest_error]
            .into_iter()
            .chain(log.bands.iter().map(|band| band.error));
        firsts
            .zip(errors)
            .map(|(first_level, error)| Batch { first_level, error })
            .collect()
    }

    /// One batch for each level. The error of a level is that of the band its last collapses are from, which holds
    /// where the simplifier bounds every triangle that it makes.
    #[must_use]
    pub fn level_batches(&self, log: &CollapseLog, finest_error: f64) -> Vec<Batch> {
        let bands = self.band_batches(log, finest_error);
        let batch = |first_level| Batch {
            first_level,
            error: bands[bands.partition_point(|band| band.first_level < first_level)].error,
        };
        (1..=self.top_level).map(batch).collect()
    }

    fn before(mesh: &Mesh, log: &CollapseLog) -> Self {
        Self {
            top_level: 0,
            collapse_levels: Vec::with_capacity(log.collapses.len()),
            vertex_levels: vec![0; mesh.positions.len()],
            triangle_levels: vec![0; mesh.triangles.len()],
            representatives: (0..).take(mesh.positions.len()).collect(),
            triangle_representatives: (0..).take(mesh.triangles.len()).map(Some).collect(),
            positions: Attribute::new(mesh.positions.clone()),
            floors: Vec::with_capacity(log.bands.len()),
        }
    }

    /// Notes a collapse that is about to happen; returns its level.
    fn note(&mut self, surface: &ReplayedSurface, collapse: Collapse, floor: u32) -> u32 {
        let Collapse { blue, red, .. } = collapse;
        let levels = surface
            .star
            .vertices()
            .iter()
            .map(|&vertex| self.vertex_levels[vertex as usize]);
        let level = 1 + levels.fold(floor, u32::max);
        self.top_level = self.top_level.max(level);
        self.collapse_levels.push(level);
        self.vertex_levels[blue as usize] = level;
        self.vertex_levels[red as usize] = level;
        self.representatives[blue as usize] = red;
        self.positions.collapse(blue, red, collapse.red_after);
        for &triangle in surface.star.removed() {
            self.triangle_levels[triangle as usize] = level;
            self.triangle_representatives[triangle as usize] = surface.triangle_beside(triangle, blue, red);
        }
        level
    }

    fn finish(&mut self) {
        self.top_level += 1;
        for (vertex, &representative) in self.representatives.iter().enumerate() {
            if representative as usize == vertex {
                self.vertex_levels[vertex] = self.top_level;
                self.positions.blue[vertex] = self.positions.red[vertex];
            }
        }
        let left_over = self.triangle_levels.iter_mut().filter(|level| **level == 0);
        left_over.for_each(|level| *level = self.top_level);
    }

    fn coarsest_first(&self, levels: &[u32]) -> Vec<u32> {
        let depths = levels.iter().map(|level| self.top_level - level);
        CompressedRows::sorted(self.top_level as usize + 1, depths.zip(0..)).into_items()
    }
}

/// The connectivity while collapses are replayed, and the star of the one at hand.
struct ReplayedSurface {
    connectivity: Connectivity,
    star: EdgeStar,
    moved: Vec<u32>,
}

impl ReplayedSurface {
    /// Gathers the star of a collapse; refuses what `demand` does not allow.
    fn look_at(&mut self, index: usize, collapse: Collapse, demand: Demand) -> Result<(), LogError> {
        self.star.gather(&self.connectivity, collapse.blue, collapse.red);
        if demand == Demand::Drawable {
            return Ok(());
        }
        let checked = if collapse.closes_hole {
            self.star.closing_condition(&self.connectivity)
        } else {
            self.star.link_condition()
        };
        checked.map_err(|fault| LogError::invalid(index, collapse, fault))
    }

    fn perform(&mut self, index: usize, collapse: Collapse, level: u32) -> Step<'_> {
        self.connectivity.collapse(&self.star, &mut self.moved);
        Step {
            index: index as u32,
            collapse,
            level,
            star: &self.star,
            moved: &self.moved,
        }
    }

    fn triangle_beside(&self, triangle: u32, blue: u32, red: u32) -> Option<u32> {
        let corners = self.connectivity.corners(triangle);
        let third = corners.into_iter().find(|&corner| corner != blue && corner != red)?;
        let across = |end| self.connectivity.across(triangle, end, third);
        across(blue).or_else(|| across(red))
    }
}

#[cfg(test)]
#[path = "replay_tests.rs"]
mod tests;
