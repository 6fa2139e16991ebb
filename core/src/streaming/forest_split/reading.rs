//! Reading the split that undoes collapses off the triangles that they have removed.

use std::collections::HashMap;

use super::collapsing::Collapsing;
use super::gap::{Branches, GapCorner, find_fill, gaps, polygon};
use super::{ClosedSurface, ForestSplit, OUTSIDE, number_copies};

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

/// The split of what `collapsing` has left; None where the removed triangles do not fill the gaps.
pub(super) fn read_split(collapsing: &Collapsing) -> Option<Coarsening> {
    let reading = Reading::new(collapsing);
    let (surface, mut refined_to_fine) = reading.coarse_surface()?;
    let mut split = reading.marks(&refined_to_fine);
    let mut origins = Vec::new();
    for gap in gaps(&surface, &split.marked_half_edges(&surface).ok()?) {
        let corners = reading.fine_corners(&surface, &gap);
        let copies = number_copies(&surface, &gap, &mut origins);
        refined_to_fine.resize(surface.vertex_count() as usize + origins.len(), OUTSIDE);
        for (&copy, corner) in copies.iter().zip(&corners).filter(|(copy, _)| **copy != OUTSIDE) {
            refined_to_fine[copy as usize] = corner.vertex;
        }
        split.fill.extend(reading.fill(&polygon(&corners))?);
    }
    Some(Coarsening {
        surface,
        split,
        refined_to_fine,
    })
}

/// A corner of a gap on the fine surface.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct FineCorner {
    /// The vertex of the fine surface.
    vertex: u32,
    /// The vertex of the coarse surface; at a virtual corner, that at which the boundary is opened.
    coarse: u32,
}

struct Reading<'a> {
    collapsing: &'a Collapsing<'a>,
    /// The triangles that are left, by their numbers in the fine surface.
    kept: Vec<u32>,
    /// For each directed edge of a removed triangle the vertex across.
    across: HashMap<(u32, u32), u32>,
}

impl<'a> Reading<'a> {
    fn new(collapsing: &'a Collapsing<'a>) -> Self {
        let mut kept = Vec::new();
        let mut across = HashMap::new();
        let triangles = collapsing.fine.closed_triangles();
        for ((triangle, &[a, b, c]), &is_removed) in (0..).zip(triangles).zip(&collapsing.is_removed) {
            if is_removed {
                across.extend([((a, b), c), ((b, c), a), ((c, a), b)]);
            } else {
                kept.push(triangle);
            }
        }
        Self {
            collapsing,
            kept,
            across,
        }
    }

    /// What is left, in numbers of its own, and the number of each of its vertices in the fine surface.
    fn coarse_surface(&self) -> Option<(ClosedSurface, Vec<u32>)> {
        let Collapsing { fine, connectivity, .. } = self.collapsing;
        let is_left = |vertex: &u32| !self.collapsing.is_blue[*vertex as usize];
        let mut fine_vertices: Vec<u32> = (0..fine.closed_vertex_count()).filter(is_left).collect();
        let mut numbers = vec![0; fine.closed_vertex_count() as usize];
        for (number, &vertex) in (0..).zip(&fine_vertices) {
            numbers[vertex as usize] = number;
        }
        let corners = |&triangle: &u32| connectivity.corners(triangle).map(|vertex| numbers[vertex as usize]);
        let triangles = self.kept.iter().map(corners).collect();
        let real_end = fine.triangles().len() as u32;
        let triangle_count = self.kept.partition_point(|&triangle| triangle < real_end) as u32;
        fine_vertices.retain(|&vertex| !fine.is_virtual(vertex));
        let surface = ClosedSurface::from_closed(fine_vertices.len() as u32, triangle_count, triangles).ok()?;
        Some((surface, fine_vertices))
    }

    /// The marks in the numbers of the coarse surface; `fine_vertices` has those of the fine one, growing.
    fn marks(&self, fine_vertices: &[u32]) -> ForestSplit {
        let (edges, opened) = self.collapsing.forest.marks();
        let coarse = |vertex: u32| fine_vertices.partition_point(|&fine| fine < vertex) as u32;
        let mut edges: Vec<[u32; 2]> = edges.into_iter().map(|edge| edge.map(coarse)).collect();
        edges.sort_unstable();
        ForestSplit {
            edges,
            opened: opened.into_iter().map(coarse).collect(),
            fill: Vec::new(),
        }
    }

    fn fine_corners(&self, surface: &ClosedSurface, gap: &[GapCorner]) -> Vec<FineCorner> {
        let fine = self.collapsing.fine;
        let mut coarse = OUTSIDE;
        let corner = |corner: &GapCorner| {
            let vertex = match corner.sector.first() {
                Some(&half_edge) => {
                    coarse = corner.vertex;
                    fine.origin(3 * self.kept[half_edge as usize / 3] + half_edge % 3)
                }
                None => corner.vertex - surface.vertex_count() + fine.vertex_count(),
            };
            FineCorner { vertex, coarse }
        };
        gap.iter().map(corner).collect()
    }

    /// How removed triangles fill a gap. A virtual vertex may be several of its corners, one for each vertex at which the
    /// boundary is opened; both ends of a removed edge of the boundary have become that vertex.
    fn fill(&self, polygon: &[FineCorner]) -> Option<Vec<Branches>> {
        let places: HashMap<FineCorner, usize> = polygon.iter().copied().zip(0..).collect();
        let real_places: HashMap<u32, usize> = polygon.iter().map(|corner| corner.vertex).zip(0..).collect();
        find_fill(polygon.len(), |first, last| {
            let FineCorner { vertex: to, coarse } = polygon[first];
            let vertex = *self.across.get(&(polygon[last].vertex, to))?;
            let place = match self.collapsing.fine.is_virtual(vertex) {
                true => places.get(&FineCorner { vertex, coarse }),
                false => real_places.get(&vertex),
            };
            place.copied()
        })
    }
}
