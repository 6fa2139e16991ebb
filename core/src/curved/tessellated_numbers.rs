//! Numbers for the vertices of a tessellation, and for its normals, of which a crease has two.

use crate::curved::corner_normals::smooth_fans;
use crate::curved::model::CurvedModel;
use crate::curved::patch_lattice::{PatchLattice, Place};
use crate::topology::half_edges::NONE;

/// Where the numbers of each patch's corners, of each half-edge's cuts and of the places inside each patch begin.
pub(crate) struct Numbering {
    /// The number of the corner where each half-edge begins.
    pub(crate) corners: Vec<u32>,
    /// The number of each half-edge's first cut, in the canonical direction.
    pub(crate) edges: Vec<u32>,
    inside: Vec<u32>,
    count: u32,
}

impl Numbering {
    /// Patches that meet share the numbers of corners and cuts.
    pub(crate) fn of_vertices(model: &CurvedModel, pieces: &[u32], inside: &[u32]) -> Self {
        let vertices = (0..pieces.len() as u32)
            .map(|edge| model.topology.origin(edge))
            .collect();
        Self::new(model, vertices, pieces, inside, |_| true)
    }

    /// Patches share numbers along edges that are no creases.
    pub(crate) fn of_normals(model: &CurvedModel, pieces: &[u32], inside: &[u32]) -> Self {
        let is_smooth = |edge: u32| !model.is_crease[edge as usize];
        let fans = smooth_fans(&model.topology, is_smooth);
        Self::new(model, fans, pieces, inside, is_smooth)
    }

    /// `groups` says which corners are one, by any number below that of half-edges.
    fn new(
        model: &CurvedModel,
        groups: Vec<u32>,
        pieces: &[u32],
        inside: &[u32],
        is_shared: impl Fn(u32) -> bool,
    ) -> Self {
        let mut count = 0;
        let mut take = |numbers: u32| {
            count += numbers;
            count - numbers
        };
        let most = groups.iter().max().map_or(0, |&most| most as usize + 1);
        let mut numbers = vec![NONE; most];
        let corners = groups.into_iter().map(|group| {
            let number = &mut numbers[group as usize];
            if *number == NONE {
                *number = take(1);
            }
            *number
        });
        let corners = corners.collect();
        let mut edges = vec![NONE; pieces.len()];
        for edge in 0..pieces.len() as u32 {
            let twin = model.topology.twin(edge);
            edges[edge as usize] = match twin != NONE && twin < edge && is_shared(edge) {
                true => edges[twin as usize],
                false => take(pieces[edge as usize] - 1),
            };
        }
        let inside = inside.iter().map(|&places| take(places)).collect();
        Self {
            corners,
            edges,
            inside,
            count,
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.count as usize
    }

    /// The number of a place of a patch.
    pub(crate) fn number(&self, patch: usize, place: Place, lattice: &PatchLattice) -> u32 {
        match place {
            Place::Corner(corner) => self.corners[3 * patch + corner],
            Place::Edge(curve, cut) => self.edges[3 * patch + curve] + cut - 1,
            Place::Inside(at) => self.inside[patch] + lattice.number_inside(at),
        }
    }
}
