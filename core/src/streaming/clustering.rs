//! Multilevel meshes from vertex clusterings: any mesh will do, manifold or not, and its topology may change.
//!
//! After A. Guéziec, G. Taubin, B. Horn, F. Lazarus, *A Framework for Streaming Geometry in VRML*, IEEE Computer Graphics
//! and Applications 19(2), 1999, "Vertex clustering".
//!
//! ```text
//! for each clustering, finest first:
//!     of the vertices that become one, the one nearest to it stays: the preferred ancestor
//!     the others get this level, and the one that stays as their representative
//!     triangles that lose a corner get this level, too
//! what is left gets the coarsest level; sort by level, coarsest first
//! ```
//!
//! Triangles that come to lie on each other stay, each of them. A level of detail has the preferred ancestors' own
//! positions, since the file has no others; those of the clusters only tell which ancestor is preferred.

mod grid;

use thiserror::Error;

use crate::streaming::multilevel::{LevelEnd, LevelError, MultilevelMesh};

pub use grid::{GridError, grid_clusterings};

/// One step to a coarser mesh: each vertex becomes part of a new one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clustering<const DIMENSION: usize = 3> {
    /// Vertices of the coarser mesh.
    pub positions: Vec<[f64; DIMENSION]>,
    /// For each vertex of the finer mesh the one of the coarser mesh that it becomes.
    pub mapping: Vec<u32>,
}

/// What clusterings make of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusteredMesh<const DIMENSION: usize = 3> {
    /// The levels, with a representative for every vertex that disappears.
    pub mesh: MultilevelMesh<DIMENSION>,
    /// For each vertex of `mesh` its index in the mesh that was given.
    pub vertex_order: Vec<u32>,
    /// For each triangle of `mesh` its index in the mesh that was given.
    pub triangle_order: Vec<u32>,
}

/// Why a mesh cannot be clustered.
#[derive(Debug, Error, PartialEq)]
pub enum ClusteringError {
    /// A mapping needs one entry for each vertex of the finer mesh.
    #[error("clustering {clustering} maps {mapped} vertices, but the mesh before it has {count}")]
    MappingLength {
        /// Index of the clustering.
        clustering: usize,
        /// Entries of its mapping.
        mapped: usize,
        /// Vertices of the mesh before it.
        count: usize,
    },
    /// A vertex becomes one that the clustering does not have.
    #[error("clustering {clustering} maps vertex {vertex} to one that it does not have")]
    MappingRange {
        /// Index of the clustering.
        clustering: usize,
        /// Vertex of the mesh before it.
        vertex: usize,
    },
    /// No vertex becomes this one.
    #[error("clustering {clustering} maps no vertex to its vertex {vertex}")]
    Empty {
        /// Index of the clustering.
        clustering: usize,
        /// Vertex of the clustering.
        vertex: usize,
    },
    /// The mesh itself is no mesh: a corner out of range or used twice, a coordinate that is no number.
    #[error("the mesh cannot be used")]
    Mesh(#[from] LevelError),
}

/// Gives every vertex and triangle of a mesh a level, `clusterings.len()` + 1 of them.
///
/// # Errors
/// When a clustering does not fit the mesh before it, or the mesh is faulty.
pub fn clustered_mesh<const DIMENSION: usize>(
    positions: &[[f64; DIMENSION]],
    triangles: &[[u32; 3]],
    clusterings: &[Clustering<DIMENSION>],
) -> Result<ClusteredMesh<DIMENSION>, ClusteringError> {
    // A mesh of one level finds what is wrong with the mesh before anything is made of it.
    let whole = LevelEnd {
        vertices: positions.len() as u32,
        triangles: triangles.len() as u32,
    };
    MultilevelMesh::from_arrays(positions, triangles, &[], [whole].into_iter())?;
    let mut levels = Levels::new(positions, triangles);
    for (index, clustering) in clusterings.iter().enumerate() {
        check(index, clustering, levels.ancestors.len())?;
        levels.cluster(index as u32, clustering)?;
    }
    levels.sort(positions, triangles, clusterings.len() as u32)
}

fn check<const DIMENSION: usize>(
    clustering: usize,
    Clustering { positions, mapping }: &Clustering<DIMENSION>,
    count: usize,
) -> Result<(), ClusteringError> {
    let mapped = mapping.len();
    if mapped != count {
        return Err(ClusteringError::MappingLength {
            clustering,
            mapped,
            count,
        });
    }
    match mapping.iter().position(|&new| new as usize >= positions.len()) {
        Some(vertex) => Err(ClusteringError::MappingRange { clustering, vertex }),
        None => Ok(()),
    }
}

/// Levels and representatives by the numbers of the mesh that was given, while clustering goes on.
struct Levels<const DIMENSION: usize> {
    /// For each vertex of the current mesh the one of the mesh given that stands for it.
    ancestors: Vec<u32>,
    positions: Vec<[f64; DIMENSION]>,
    /// Corners in the current mesh; meaningless once the triangle has a level.
    triangles: Vec<[u32; 3]>,
    vertex_levels: Vec<Option<u32>>,
    triangle_levels: Vec<Option<u32>>,
    representatives: Vec<u32>,
}

impl<const DIMENSION: usize> Levels<DIMENSION> {
    fn new(positions: &[[f64; DIMENSION]], triangles: &[[u32; 3]]) -> Self {
        let own: Vec<u32> = (0..).take(positions.len()).collect();
        Self {
            ancestors: own.clone(),
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            vertex_levels: vec![None; positions.len()],
            triangle_levels: vec![None; triangles.len()],
            representatives: own,
        }
    }

    fn cluster(&mut self, level: u32, clustering: &Clustering<DIMENSION>) -> Result<(), ClusteringError> {
        let preferred = self.preferred_ancestors(level as usize, clustering)?;
        for (vertex, &new) in clustering.mapping.iter().enumerate() {
            let (own, stays) = (self.ancestors[vertex], preferred[new as usize]);
            if own != stays {
                self.vertex_levels[own as usize] = Some(level);
                self.representatives[own as usize] = stays;
            }
        }
        let triangles = self.triangles.iter_mut().zip(&mut self.triangle_levels);
        for (corners, found) in triangles.filter(|(_, found)| found.is_none()) {
            let [a, b, c] = corners.map(|corner| clustering.mapping[corner as usize]);
            *corners = [a, b, c];
            *found = (a == b || b == c || c == a).then_some(level);
        }
        self.ancestors = preferred;
        self.positions.clone_from(&clustering.positions);
        Ok(())
    }

    /// For each new vertex the vertex that was given, of those that become it, whose current position is nearest; the
    /// first of them where several are.
    fn preferred_ancestors(
        &self,
        clustering: usize,
        Clustering { positions, mapping }: &Clustering<DIMENSION>,
    ) -> Result<Vec<u32>, ClusteringError> {
        let mut nearest = vec![None; positions.len()];
        for (vertex, &new) in mapping.iter().enumerate() {
            let own_distance = squared_distance(self.positions[vertex], positions[new as usize]);
            let best = &mut nearest[new as usize];
            if best.is_none_or(|(distance, _)| own_distance < distance) {
                *best = Some((own_distance, self.ancestors[vertex]));
            }
        }
        let found = nearest.into_iter().enumerate().map(|(vertex, best)| match best {
            Some((_, ancestor)) => Ok(ancestor),
            None => Err(ClusteringError::Empty { clustering, vertex }),
        });
        found.collect()
    }

    fn sort(
        self,
        positions: &[[f64; DIMENSION]],
        triangles: &[[u32; 3]],
        coarsest: u32,
    ) -> Result<ClusteredMesh<DIMENSION>, ClusteringError> {
        let (vertex_order, vertex_ends) = coarsest_first(&self.vertex_levels, coarsest);
        let (triangle_order, triangle_ends) = coarsest_first(&self.triangle_levels, coarsest);
        let mut places = vec![0; vertex_order.len()];
        for (place, &vertex) in (0_u32..).zip(&vertex_order) {
            places[vertex as usize] = place;
        }
        let gather = |&vertex: &u32| positions[vertex as usize];
        let representative = |&vertex: &u32| places[self.representatives[vertex as usize] as usize];
        let corners = |&triangle: &u32| triangles[triangle as usize].map(|corner| places[corner as usize]);
        let ends = vertex_ends.into_iter().zip(triangle_ends);
        let mesh = MultilevelMesh::from_arrays(
            &vertex_order.iter().map(gather).collect::<Vec<_>>(),
            &triangle_order.iter().map(corners).collect::<Vec<_>>(),
            &vertex_order.iter().map(representative).collect::<Vec<_>>(),
            ends.map(|(vertices, triangles)| LevelEnd { vertices, triangles }),
        )?;
        Ok(ClusteredMesh {
            mesh,
            vertex_order,
            triangle_order,
        })
    }
}

/// Indices by decreasing level, where none is the coarsest, and where each level ends, coarsest first.
fn coarsest_first(levels: &[Option<u32>], coarsest: u32) -> (Vec<u32>, Vec<u32>) {
    let level_of = |index: &u32| levels[*index as usize].unwrap_or(coarsest);
    let mut order: Vec<u32> = (0..).take(levels.len()).collect();
    order.sort_by_key(|index| std::cmp::Reverse(level_of(index)));
    let end = |level| order.partition_point(|index| level_of(index) >= level) as u32;
    let ends = (0..=coarsest).rev().map(end).collect();
    (order, ends)
}

fn squared_distance<const DIMENSION: usize>(a: [f64; DIMENSION], b: [f64; DIMENSION]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

#[cfg(test)]
#[path = "clustering_tests.rs"]
mod tests;
