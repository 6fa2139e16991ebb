//! Multilevel meshes of arrays that are there as a whole, those of a Surface Partition among them.

use glam::DVec3;
use thiserror::Error;

use super::{LevelBatch, LevelEnd, LevelError, MultilevelLimits, MultilevelMesh};
use crate::levels::partition::{self, Level, PartitionError, SurfacePartition};

/// Why a Surface Partition cannot be a multilevel mesh.
#[derive(Debug, Error, PartialEq)]
pub enum FromPartitionError {
    /// The arrays are no Surface Partition.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// One of its levels cannot be drawn.
    #[error(transparent)]
    Level(#[from] LevelError),
}

impl MultilevelMesh {
    /// The levels of a Surface Partition: the paper's "From edge collapses to a progressive multilevel representation".
    /// Vertices have their positions of the finest surface in every level, because the paper's file has but one.
    ///
    /// # Errors
    /// When the arrays are no Surface Partition, or a triangle has a corner that its level cannot draw.
    pub fn from_partition(partition: &SurfacePartition) -> Result<Self, FromPartitionError> {
        partition::validate(partition)?;
        let mut positions: Vec<[f64; 3]> = partition.positions.iter().map(|p| p.to_array()).collect();
        for (vertex, &representative) in partition.representatives.iter().enumerate() {
            positions[representative as usize] = partition.blue_positions[vertex].to_array();
        }
        let ends = partition.levels.iter().map(|level| LevelEnd {
            vertices: level.vertex_end,
            triangles: level.triangle_end,
        });
        let (triangles, representatives) = (&partition.triangles, &partition.representatives);
        Ok(Self::from_arrays(&positions, triangles, representatives, ends)?)
    }

    /// The levels as a Surface Partition whose vertices do not move. Its errors are infinite, which is to say not known. A
    /// vertex without a representative is one that no coarser level draws anything at; it gets vertex 0.
    ///
    /// # Errors
    /// When the mesh has no level, its coarsest one has no vertex, or vertices are missing.
    pub fn to_partition(&self) -> Result<SurfacePartition, PartitionError> {
        let red = self.ends.first().map_or(0, |end| end.vertices);
        let representative = |vertex: u32| match self.representative(vertex) {
            _ if vertex < red => vertex,
            Some(representative) => representative,
            None => 0,
        };
        let positions: Vec<DVec3> = self.positions.iter().copied().map(DVec3::from_array).collect();
        let representatives: Vec<u32> = (0..).take(positions.len()).map(representative).collect();
        let at = |&vertex: &u32| positions[vertex as usize];
        let level = |end: &LevelEnd| Level {
            vertex_end: end.vertices,
            triangle_end: end.triangles,
            error: f64::INFINITY,
        };
        let partition = SurfacePartition {
            blue_positions: representatives.iter().map(at).collect(),
            positions,
            representatives,
            triangles: self.triangles.clone(),
            levels: self.ends.iter().map(level).collect(),
        };
        partition::validate(&partition)?;
        Ok(partition)
    }
}

impl<const DIMENSION: usize> MultilevelMesh<DIMENSION> {
    /// Whole arrays as a mesh, by way of [`add_level`](Self::add_level), which checks them. A vertex without
    /// representative has itself; `ends` stand coarsest first, inside the arrays.
    pub(crate) fn from_arrays(
        positions: &[[f64; DIMENSION]],
        triangles: &[[u32; 3]],
        representatives: &[u32],
        ends: impl Iterator<Item = LevelEnd>,
    ) -> Result<Self, LevelError> {
        let mut mesh = Self::new(MultilevelLimits::NONE);
        let pairs = (0_u32..).zip(representatives.iter().copied());
        let mut pairs: Vec<(u32, u32)> = pairs.filter(|(vertex, own)| vertex != own).collect();
        let mut start = LevelEnd::default();
        for end in ends {
            mesh.add_level(LevelBatch {
                positions: positions[start.vertices as usize..end.vertices as usize].to_vec(),
                triangles: triangles[start.triangles as usize..end.triangles as usize].to_vec(),
                representatives: std::mem::take(&mut pairs),
            })?;
            start = end;
        }
        Ok(mesh)
    }
}

#[cfg(test)]
#[path = "build_tests.rs"]
mod tests;
