//! The level of detail that is drawn, and the way from any one to any other (Surface Partitions §2.2, §2.3).
//!
//! A prefix of the triangles is drawn, each corner as the root of its representatives. Roots are found as corners are
//! visited and remembered by path compression (R. Tarjan, *Data Structures and Network Algorithms*, 1983): in all
//! O(m α(n)) for the m corners drawn, whatever was drawn before.
//!
//! ```text
//! from level i to a finer j:    undo the collapses of vertices end(i) .. end(j), in order
//! from level j to a coarser i:  perform those of vertices end(j) .. end(i) again, backwards
//! ```
//!
//! Only the vertices that come or go are visited; levels between have no part in it.

use std::ops::Range;

use glam::DVec3;

use crate::levels::attribute::Attribute;
use crate::levels::partition::SurfacePartition;
use crate::mesh::Mesh;

/// One level of detail of a partition, to be changed at will.
#[derive(Clone, Debug)]
pub struct LevelView<'a> {
    partition: &'a SurfacePartition,
    level: usize,
    positions: Attribute<DVec3>,
    roots: Roots,
}

impl<'a> LevelView<'a> {
    /// Begins with the coarsest level of a valid partition.
    #[must_use]
    pub fn new(partition: &'a SurfacePartition) -> Self {
        Self {
            partition,
            level: 0,
            positions: partition.position_attribute(),
            roots: Roots::new(partition.positions.len()),
        }
    }

    /// The level that is drawn; 0 is the coarsest.
    #[must_use]
    pub fn level(&self) -> usize {
        self.level
    }

    /// Goes to another level, at the cost of the vertices that come or go. Returns which they are, for other
    /// attributes to follow by [`Attribute::undo`] (finer) or [`Attribute::redo`] (coarser).
    ///
    /// # Panics
    /// Where the partition has no such level.
    pub fn set_level(&mut self, level: usize) -> Range<usize> {
        let [before, after] = [self.level, level].map(|index| self.partition.levels[index].vertex_end as usize);
        let changed = before.min(after)..before.max(after);
        if before < after {
            self.positions.undo(&self.partition.representatives, changed.clone());
        } else {
            self.positions.redo(&self.partition.representatives, changed.clone());
        }
        self.level = level;
        self.roots.forget();
        changed
    }

    /// Positions of the vertices of this level.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions.red[..self.vertex_end()]
    }

    /// The vertex of this level that stands for `vertex` of the partition.
    pub fn root(&mut self, vertex: u32) -> u32 {
        self.roots
            .find(vertex, self.vertex_end() as u32, &self.partition.representatives)
    }

    /// The triangles of this level.
    pub fn triangles(&mut self) -> impl Iterator<Item = [u32; 3]> {
        let level = self.partition.levels[self.level];
        let Self { partition, roots, .. } = self;
        partition.triangles[..level.triangle_end as usize]
            .iter()
            .map(move |triangle| {
                triangle.map(|corner| roots.find(corner, level.vertex_end, &partition.representatives))
            })
    }

    /// This level as a mesh of its own.
    #[must_use]
    pub fn mesh(&mut self) -> Mesh {
        Mesh {
            triangles: self.triangles().collect(),
            positions: self.positions().to_vec(),
        }
    }

    fn vertex_end(&self) -> usize {
        self.partition.levels[self.level].vertex_end as usize
    }
}

/// Roots found since the level was last changed: the paper's pc-rep array.
#[derive(Clone, Debug)]
struct Roots {
    /// For each vertex a vertex that stands for it, and the turn in which that was found.
    found: Vec<(u32, u32)>,
    turn: u32,
}

impl Roots {
    fn new(vertex_count: usize) -> Self {
        Self {
            found: vec![(0, 0); vertex_count],
            turn: 1,
        }
    }

    fn forget(&mut self) {
        self.turn += 1;
    }

    /// The first vertex below `end` on the way from `vertex` along its representatives.
    fn find(&mut self, vertex: u32, end: u32, representatives: &[u32]) -> u32 {
        let mut root = vertex;
        while root >= end {
            root = self.toward_root(root, representatives);
        }
        let mut at = vertex;
        while at >= end {
            let next = self.toward_root(at, representatives);
            self.found[at as usize] = (root, self.turn);
            at = next;
        }
        root
    }

    fn toward_root(&self, vertex: u32, representatives: &[u32]) -> u32 {
        let (found, turn) = self.found[vertex as usize];
        if turn == self.turn {
            found
        } else {
            representatives[vertex as usize]
        }
    }
}

#[cfg(test)]
#[path = "level_view_tests.rs"]
mod tests;
