//! Forest splits: a batch of refinement as a cut along a forest of edges, opened and filled with triangles.
//!
//! After A. Guéziec, G. Taubin, B. Horn, F. Lazarus, *A Framework for Streaming Geometry in VRML*, IEEE Computer Graphics
//! and Applications 19(2), 1999, "Coupling with a geometry-compression method", and G. Taubin, A. Guéziec, W. Horn, F.
//! Lazarus, *Progressive Forest Split Compression*, SIGGRAPH 1998, which it cites.
//!
//! ```text
//! encode:  collapse edges of the fine surface, of which the removed triangles and the marked edges form a forest
//!          mark on the coarse surface the edges that collapsed triangles have become
//!          for each tree: walk around it; read how removed triangles fill the gap
//! decode:  cut the coarse surface along the marked edges; for each tree:
//!          walk around it, a new vertex for every visit of a vertex but the first; fill the gap
//! ```
//!
//! What the papers leave open, and how it is here:
//!
//! - *Boundaries.* Each boundary loop is closed by a fan of virtual triangles around a virtual vertex ([`ClosedSurface`]).
//!   Collapsing an edge of the boundary marks the edge to the virtual vertex. All trees may have that vertex as a leaf; a
//!   leaf is not cut apart, so they stay disjoint. Such a mark costs one bit for each vertex of the boundary that is in a
//!   tree, and none elsewhere. Virtual triangles are filled in like others and dropped.
//! - *Which collapses.* Trees must have no vertex in common (see `forest.rs`). [`forest_batches`] cuts any list of
//!   collapses into batches; [`largest_batch`] chooses collapses itself, so that the batch about halves the surface.
//! - *Order of bits*, trees and new vertices, and which copy keeps the number: see [`SplitBits`] and `gap.rs`.
//!
//! A batch costs one bit for each edge of the coarse surface, less those that would close a cycle, and two for each added
//! triangle, less those that the size of a gap tells: at most 3.5 bits for each added triangle if the batch about doubles
//! the surface, and more the smaller it is.

mod batch;
mod bits;
mod collapsing;
mod forest;
mod gap;
mod growth;
mod reading;
mod surface;

use std::collections::{HashMap, HashSet};

use thiserror::Error;

use forest::unite;
use gap::{Branches, GapCorner, fill_triangles, gaps, polygon};

pub use batch::{CollapseError, coarsen, forest_batches};
pub use bits::SplitBits;
pub use collapsing::CollapseFault;
pub use growth::largest_batch;
pub use reading::Coarsening;
pub use surface::{ClosedSurface, SurfaceError};

/// One batch of refinement of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForestSplit {
    /// The marked edges, smaller vertex first, in growing order.
    pub edges: Vec<[u32; 2]>,
    /// The vertices at which the cut goes on through the boundary, in growing order.
    pub opened: Vec<u32>,
    /// For each triangle of the fills, virtual ones included, whether others follow on its left and on its right edge; trees
    /// in the order of their smallest edges.
    pub fill: Vec<[bool; 2]>,
}

/// Why a split cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SplitError {
    /// No such edge, or one out of order.
    #[error("{0}–{1} is no edge of the surface, or out of order")]
    NoEdge(u32, u32),
    /// The marked edges contain a cycle.
    #[error("edge {0}–{1} closes a cycle of marked edges")]
    Cycle(u32, u32),
    /// Only vertices of the boundary that are in a tree can be opened.
    #[error("vertex {0} is not at the boundary, in no tree, or out of order")]
    NotOpenable(u32),
    /// The triangles are no trees that fill the gaps.
    #[error("the triangles do not fill the gaps")]
    Fill,
    /// There are too few bits in a stream, or too many.
    #[error("the bits of the {0} are not as many as the surface asks for")]
    BitCount(&'static str),
    /// What it would make of the surface is none.
    #[error("the split leaves no surface")]
    Result(#[from] SurfaceError),
}

/// A surface after a split.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// The refined surface. Vertices and triangles of the coarse one keep their numbers, the new ones follow.
    pub surface: ClosedSurface,
    /// For each new vertex the vertex of the coarse surface that it was split off: its representative.
    pub origins: Vec<u32>,
    /// The gaps, tree by tree, as polygons of the refined surface's vertices, counter-clockwise. Where the boundary is opened
    /// two corners follow each other that no edge need join.
    pub gaps: Vec<Vec<u32>>,
}

impl ForestSplit {
    /// Refines `surface`.
    ///
    /// # Errors
    /// When the split is none of this surface, or would leave no surface.
    pub fn apply(&self, surface: &ClosedSurface) -> Result<Refinement, SplitError> {
        let mut triangles = surface.triangles().to_vec();
        let (mut added, mut origins, mut polygons) = (Vec::new(), Vec::new(), Vec::new());
        let mut rest = self.fill.as_slice();
        for gap in self.gaps(surface)? {
            let copies = number_copies(surface, &gap, &mut origins);
            give_copies(&mut triangles, &gap, &copies);
            let (own, others) = rest.split_at_checked(gap.len() - 2).ok_or(SplitError::Fill)?;
            let mut polygon = polygon(&copies);
            fill(&polygon, own, &mut added)?;
            polygon.retain(|&vertex| vertex != OUTSIDE);
            polygons.push(polygon);
            rest = others;
        }
        if !rest.is_empty() {
            return Err(SplitError::Fill);
        }
        triangles.extend(added);
        let vertex_count = surface.vertex_count() + origins.len() as u32;
        Ok(Refinement {
            surface: ClosedSurface::new(vertex_count, &triangles)?,
            origins,
            gaps: polygons,
        })
    }

    /// The marked edges tree by tree, in the order in which the trees are split.
    ///
    /// # Errors
    /// When the split is none of this surface.
    pub fn trees(&self, surface: &ClosedSurface) -> Result<Vec<Vec<[u32; 2]>>, SplitError> {
        let gaps = self.gaps(surface)?;
        let tree_of: HashMap<u32, usize> = gaps
            .iter()
            .enumerate()
            .flat_map(|(tree, gap)| gap.iter().map(move |corner| (corner.vertex, tree)))
            .collect();
        let mut trees = vec![Vec::new(); gaps.len()];
        for &edge in &self.edges {
            trees[tree_of[&edge[0]]].push(edge);
        }
        Ok(trees)
    }

    /// The gaps of the cut, after a check that these are marks of `surface`.
    fn gaps(&self, surface: &ClosedSurface) -> Result<Vec<Vec<GapCorner>>, SplitError> {
        Ok(gaps(surface, &self.marked_half_edges(surface)?))
    }

    fn marked_half_edges(&self, surface: &ClosedSurface) -> Result<Vec<bool>, SplitError> {
        let mut is_marked = vec![false; surface.half_edge_count()];
        let mut parents: Vec<u32> = (0..surface.vertex_count()).collect();
        let mut is_in_tree = vec![false; parents.len()];
        let half_edges = half_edges_by_ends(surface);
        for (index, &[a, b]) in self.edges.iter().enumerate() {
            let is_next = a < b && (index == 0 || self.edges[index - 1] < [a, b]);
            let half_edge = half_edges
                .get(&[a, b])
                .filter(|_| is_next)
                .ok_or(SplitError::NoEdge(a, b))?;
            mark(surface, *half_edge, &mut is_marked);
            if !unite(&mut parents, a, b) {
                return Err(SplitError::Cycle(a, b));
            }
            is_in_tree[a as usize] = true;
            is_in_tree[b as usize] = true;
        }
        for (index, &vertex) in self.opened.iter().enumerate() {
            let is_next = index == 0 || self.opened[index - 1] < vertex;
            let is_in_tree = is_in_tree.get(vertex as usize) == Some(&true);
            let outward = half_edges.get(&[vertex, OUTSIDE]).filter(|_| is_next && is_in_tree);
            mark(
                surface,
                *outward.ok_or(SplitError::NotOpenable(vertex))?,
                &mut is_marked,
            );
        }
        Ok(is_marked)
    }
}

/// Stands for any virtual vertex.
const OUTSIDE: u32 = u32::MAX;

/// A half-edge for each edge that goes from a real vertex to a larger one or to a virtual one.
fn half_edges_by_ends(surface: &ClosedSurface) -> HashMap<[u32; 2], u32> {
    let ends = (0..surface.half_edge_count() as u32).map(|half_edge| {
        let target = surface.target(half_edge);
        let target = if surface.is_virtual(target) { OUTSIDE } else { target };
        ([surface.origin(half_edge), target], half_edge)
    });
    ends.filter(|([from, to], _)| from < to && !surface.is_virtual(*from))
        .collect()
}

fn mark(surface: &ClosedSurface, half_edge: u32, is_marked: &mut [bool]) {
    is_marked[half_edge as usize] = true;
    is_marked[surface.opposite(half_edge) as usize] = true;
}

/// The vertex at each corner of a gap: the first visit keeps the vertex, every other one has a new vertex, and virtual ones
/// are [`OUTSIDE`].
fn number_copies(surface: &ClosedSurface, gap: &[GapCorner], origins: &mut Vec<u32>) -> Vec<u32> {
    let mut visited = HashSet::with_capacity(gap.len());
    let number = |corner: &GapCorner| {
        if surface.is_virtual(corner.vertex) {
            return OUTSIDE;
        }
        if visited.insert(corner.vertex) {
            return corner.vertex;
        }
        origins.push(corner.vertex);
        surface.vertex_count() + origins.len() as u32 - 1
    };
    gap.iter().map(number).collect()
}

/// Gives each triangle at the gap the copy of the vertex that is on its side.
fn give_copies(triangles: &mut [[u32; 3]], gap: &[GapCorner], copies: &[u32]) {
    let corners = triangles.as_flattened_mut();
    for (corner, &copy) in gap.iter().zip(copies) {
        for &half_edge in &corner.sector {
            // Virtual triangles, behind the real ones, are made anew.
            if let Some(vertex) = corners.get_mut(half_edge as usize) {
                *vertex = copy;
            }
        }
    }
}

/// Appends the triangles of a fill but the virtual ones.
fn fill(polygon: &[u32], branches: &[Branches], triangles: &mut Vec<[u32; 3]>) -> Result<(), SplitError> {
    for places in fill_triangles(polygon.len(), branches).ok_or(SplitError::Fill)? {
        let corners = places.map(|place| polygon[place]);
        match corners.iter().filter(|&&vertex| vertex == OUTSIDE).count() {
            0 => triangles.push(corners),
            1 => {}
            _ => return Err(SplitError::Fill),
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "forest_split_tests.rs"]
mod tests;
