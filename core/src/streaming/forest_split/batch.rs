//! From collapses to forest splits: performing them, and which of them make a batch.

use glam::DVec3;
use thiserror::Error;

use super::forest::{Candidate, Forest};
use super::reading::read_split;
use super::{ClosedSurface, ForestSplit};
use crate::mesh::Mesh;
use crate::topology::connectivity::{Connectivity, EdgeStar, LinkFault};

/// What is wrong with a collapse.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CollapseFault {
    /// Blue and red must be two vertices of the surface.
    #[error("its vertices are out of range or equal")]
    BadVertices,
    /// It would leave no surface.
    #[error(transparent)]
    Link(#[from] LinkFault),
    /// Together with those before it, it is not one cut along a forest.
    #[error("its triangles and those of the collapses before it do not form a forest")]
    NotForest,
}

/// Why collapses are refused.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("collapse {index}: {fault}")]
pub struct CollapseError {
    /// Index of the collapse.
    pub index: usize,
    /// What is wrong with it.
    pub fault: CollapseFault,
}

/// A coarser surface and the way back.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarsening {
    /// What the collapses leave; vertices and triangles in the order of the fine surface.
    pub surface: ClosedSurface,
    /// Refines it again.
    pub split: ForestSplit,
    /// For each vertex of the refined surface the vertex of the fine one that it is.
    pub refined_to_fine: Vec<u32>,
}

/// Performs `collapses`, pairs of a blue and a red vertex, on `fine` and finds the split that undoes all of them at once.
///
/// # Errors
/// With the first collapse that cannot be performed or cannot be part of the same forest.
pub fn coarsen(fine: &ClosedSurface, collapses: &[[u32; 2]]) -> Result<Coarsening, CollapseError> {
    let mut collapsing = Collapsing::new(fine);
    for (index, &ends) in collapses.iter().enumerate() {
        let result = collapsing.perform_admitted(ends);
        result.map_err(|fault| CollapseError { index, fault })?;
    }
    // Of admitted collapses there always is one.
    read_split(&collapsing).ok_or(CollapseError {
        index: collapses.len(),
        fault: CollapseFault::NotForest,
    })
}

/// Cuts a list of collapses, such as those of a [`CollapseLog`](crate::CollapseLog), into batches that are forests, each with
/// the indices of its collapses in order; the batches one after the other leave what the list leaves. Each batch takes, from
/// the front of what is left, every collapse that fits and does not rest on one that did not fit.
///
/// # Errors
/// With the first collapse that cannot be performed.
pub fn forest_batches(fine: &ClosedSurface, collapses: &[[u32; 2]]) -> Result<Vec<Vec<u32>>, CollapseError> {
    let mut collapsing = Collapsing::new(fine);
    let mut rest: Vec<u32> = (0..collapses.len() as u32).collect();
    let mut batches = Vec::new();
    while !rest.is_empty() {
        collapsing.forest = Forest::new(fine.vertex_count());
        let mut batch = Vec::new();
        let mut later = Later::new(fine);
        for index in rest {
            let taken = collapsing.take(collapses[index as usize], &mut later);
            let index_of_fault = index as usize;
            match taken.map_err(|fault| CollapseError {
                index: index_of_fault,
                fault,
            })? {
                true => batch.push(index),
                false => later.collapses.push(index),
            }
        }
        batches.push(batch);
        rest = later.collapses;
    }
    Ok(batches)
}

/// Collapses that have to wait for another batch, and the vertices that they would change.
struct Later {
    collapses: Vec<u32>,
    is_waiting: Vec<bool>,
}

impl Later {
    fn new(surface: &ClosedSurface) -> Self {
        Self {
            collapses: Vec::new(),
            is_waiting: vec![false; surface.closed_vertex_count() as usize],
        }
    }

    fn wait_at(&mut self, ends: [u32; 2]) {
        for end in ends {
            self.is_waiting[end as usize] = true;
        }
    }

    fn is_waiting_at(&self, vertices: &[u32]) -> bool {
        vertices.iter().any(|&vertex| self.is_waiting[vertex as usize])
    }
}

/// A closed surface on which edges collapse, and the forest that they leave behind.
pub(super) struct Collapsing<'a> {
    pub(super) fine: &'a ClosedSurface,
    pub(super) connectivity: Connectivity,
    pub(super) forest: Forest,
    pub(super) is_removed: Vec<bool>,
    pub(super) is_blue: Vec<bool>,
    star: EdgeStar,
    moved: Vec<u32>,
}

impl<'a> Collapsing<'a> {
    pub(super) fn new(fine: &'a ClosedSurface) -> Self {
        // Connectivity has no use for coordinates but to count them.
        let closed = Mesh {
            positions: vec![DVec3::ZERO; fine.closed_vertex_count() as usize],
            triangles: fine.closed_triangles().to_vec(),
        };
        Self {
            fine,
            connectivity: Connectivity::new(&closed),
            star: EdgeStar::default(),
            forest: Forest::new(fine.vertex_count()),
            is_removed: vec![false; closed.triangles.len()],
            is_blue: vec![false; closed.positions.len()],
            moved: Vec::new(),
        }
    }

    /// What a collapse and its two triangles would concern, whether it can be performed or not; None where not two triangles
    /// share the edge.
    pub(super) fn candidate(&self, [blue, red]: [u32; 2]) -> Option<Candidate> {
        let around = self
            .connectivity
            .star(blue)
            .map(|triangle| self.connectivity.corners(triangle));
        let along = around.filter(|corners| corners.contains(&red));
        let mut wings = along.map(|[a, b, c]| a ^ b ^ c ^ blue ^ red);
        let pair = [wings.next()?, wings.next()?];
        wings.next().is_none().then_some(Candidate { blue, red, wings: pair })
    }

    /// Gathers the star of an edge and checks that it can collapse.
    pub(super) fn look(&mut self, ends: [u32; 2]) -> Result<Candidate, CollapseFault> {
        self.gather(ends)?;
        self.looked_at(ends)
    }

    fn gather(&mut self, [blue, red]: [u32; 2]) -> Result<(), CollapseFault> {
        if blue == red || blue.max(red) >= self.fine.vertex_count() {
            return Err(CollapseFault::BadVertices);
        }
        self.star.gather(&self.connectivity, blue, red);
        Ok(())
    }

    /// The collapse whose star was gathered last.
    fn looked_at(&self, ends: [u32; 2]) -> Result<Candidate, CollapseFault> {
        self.star.link_condition()?;
        Ok(self.candidate(ends).ok_or(LinkFault::NoEdge)?)
    }

    /// Performs the collapse that was looked at last.
    pub(super) fn perform(&mut self, candidate: Candidate) {
        self.is_blue[candidate.blue as usize] = true;
        for &triangle in self.star.removed() {
            self.is_removed[triangle as usize] = true;
        }
        self.connectivity.collapse(&self.star, &mut self.moved);
        self.forest.add(candidate);
    }

    /// The corners that the last collapse gave over from its blue vertex to its red one.
    pub(super) fn moved(&self) -> &[u32] {
        &self.moved
    }

    fn perform_admitted(&mut self, ends: [u32; 2]) -> Result<(), CollapseFault> {
        let candidate = self.look(ends)?;
        if !self.forest.admits(candidate) {
            return Err(CollapseFault::NotForest);
        }
        self.perform(candidate);
        Ok(())
    }

    /// Performs a collapse of a list if it fits; one that does not, or whose star is not what it was in the list because
    /// others have to wait, has to wait, too.
    fn take(&mut self, ends: [u32; 2], later: &mut Later) -> Result<bool, CollapseFault> {
        self.gather(ends)?;
        if !later.is_waiting_at(self.star.vertices()) {
            let candidate = self.looked_at(ends)?;
            if self.forest.admits(candidate) {
                self.perform(candidate);
                return Ok(true);
            }
        }
        later.wait_at(ends);
        Ok(false)
    }
}
