//! A surface whose edges collapse, and the forest of the triangles that go.

use glam::DVec3;
use thiserror::Error;

use super::ClosedSurface;
use super::forest::{Candidate, Forest};
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

    /// Gathers the star of an edge.
    pub(super) fn gather(&mut self, [blue, red]: [u32; 2]) -> Result<(), CollapseFault> {
        if blue == red || blue.max(red) >= self.fine.vertex_count() {
            return Err(CollapseFault::BadVertices);
        }
        self.star.gather(&self.connectivity, blue, red);
        Ok(())
    }

    /// The vertices of the star that was gathered last.
    pub(super) fn vertices_around(&self) -> &[u32] {
        self.star.vertices()
    }

    /// The collapse whose star was gathered last, if the edge can collapse.
    pub(super) fn looked_at(&self, ends: [u32; 2]) -> Result<Candidate, CollapseFault> {
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

    pub(super) fn perform_admitted(&mut self, ends: [u32; 2]) -> Result<(), CollapseFault> {
        let candidate = self.look(ends)?;
        if !self.forest.admits(candidate) {
            return Err(CollapseFault::NotForest);
        }
        self.perform(candidate);
        Ok(())
    }
}
