//! From collapses to forest splits: which of them make a batch, and what splits their surface again.

use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashMap};

use glam::DVec3;
use thiserror::Error;

use super::forest::{Candidate, Forest};
use super::gap::{Branches, GapCorner, find_fill, gaps, polygon};
use super::{ForestSplit, OUTSIDE, Surface, number_copies};
use crate::connectivity::{Connectivity, EdgeStar, LinkFault};
use crate::mesh::Mesh;

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
    pub surface: Surface,
    /// Refines it again.
    pub split: ForestSplit,
    /// For each vertex of the refined surface the vertex of the fine one that it is.
    pub refined_to_fine: Vec<u32>,
}

/// Performs `collapses`, pairs of a blue and a red vertex, on `fine` and finds the split that undoes all of them at once.
///
/// # Errors
/// With the first collapse that cannot be performed or cannot be part of the same forest.
pub fn coarsen(fine: &Surface, collapses: &[[u32; 2]]) -> Result<Coarsening, CollapseError> {
    let mut collapsing = Collapsing::new(fine);
    let mut is_blue = vec![false; fine.vertex_count() as usize];
    let mut index = 0;
    for &[blue, red] in collapses {
        let at = |fault| CollapseError { index, fault };
        let candidate = collapsing.look([blue, red]).map_err(at)?;
        if !collapsing.forest.admits(candidate) {
            return Err(at(CollapseFault::NotForest));
        }
        collapsing.perform(candidate);
        is_blue[blue as usize] = true;
        index += 1;
    }
    // A forest of admitted collapses always has a split.
    Reading::of(fine, &collapsing, &is_blue).ok_or(CollapseError {
        index,
        fault: CollapseFault::NotForest,
    })
}

/// Cuts a list of collapses into batches that are forests, each with the indices of its collapses in order; the batches one
/// after the other leave what the list leaves. Each batch takes, from the front of what is left, every collapse that fits
/// and does not rest on one that did not fit.
///
/// # Errors
/// With the first collapse that cannot be performed.
pub fn forest_batches(fine: &Surface, collapses: &[[u32; 2]]) -> Result<Vec<Vec<u32>>, CollapseError> {
    let mut collapsing = Collapsing::new(fine);
    let mut rest: Vec<u32> = (0..collapses.len() as u32).collect();
    let mut batches = Vec::new();
    while !rest.is_empty() {
        collapsing.forest = Forest::new(fine.vertex_count());
        let mut batch = Vec::new();
        let mut later = Later::new(fine);
        for index in rest {
            match collapsing.take(collapses[index as usize], &mut later) {
                Ok(true) => batch.push(index),
                Ok(false) => later.collapses.push(index),
                Err(fault) => {
                    let index = index as usize;
                    return Err(CollapseError { index, fault });
                }
            }
        }
        batches.push(batch);
        rest = later.collapses;
    }
    Ok(batches)
}

/// Chooses collapses that make one forest, until there are none left that fit: where the surface allows it, about as many
/// as leave half of its vertices. Of those that fit, the one of the smallest cost is next.
///
/// `cost` is asked with the blue vertex, the red one and the triangles around the blue vertex that would have the red one in
/// its place; None forbids the collapse.
pub fn largest_batch(fine: &Surface, cost: impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64>) -> Vec<[u32; 2]> {
    let mut collapsing = Collapsing::new(fine);
    let mut queue = BinaryHeap::new();
    for vertex in 0..fine.vertex_count() {
        collapsing.enqueue(vertex, &cost, &mut queue);
    }
    let mut new_trees = BinaryHeap::new();
    let mut collapses = Vec::new();
    while let Some(Reverse(queued)) = queue.pop().or_else(|| new_trees.pop()) {
        let [blue, red] = queued.ends;
        let Ok(candidate) = collapsing.look([blue, red]) else {
            continue;
        };
        let is_current = collapsing.cost(candidate, &cost) == Some(queued.cost);
        if !is_current || !collapsing.forest.admits(candidate) {
            continue;
        }
        if queued.may_grow && !collapsing.forest.touches(candidate) {
            new_trees.push(Reverse(Queued {
                may_grow: false,
                ..queued
            }));
            continue;
        }
        collapsing.perform(candidate);
        collapses.push([blue, red]);
        for vertex in [red].into_iter().chain(candidate.wings) {
            collapsing.enqueue(vertex, &cost, &mut queue);
        }
    }
    collapses
}

/// A collapse that waits for its turn, by cost and then by its vertices.
#[derive(Clone, Copy, PartialEq)]
struct Queued {
    cost: f64,
    ends: [u32; 2],
    may_grow: bool,
}

impl Eq for Queued {}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.ends.cmp(&other.ends))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Collapses that have to wait for another batch, and the vertices that they would change.
struct Later {
    collapses: Vec<u32>,
    is_waiting: Vec<bool>,
}

impl Later {
    fn new(surface: &Surface) -> Self {
        Self {
            collapses: Vec::new(),
            is_waiting: vec![false; surface.closed_vertex_count() as usize],
        }
    }
}

/// A closed surface on which edges collapse, and the forest that they leave behind.
struct Collapsing<'a> {
    fine: &'a Surface,
    connectivity: Connectivity,
    star: EdgeStar,
    forest: Forest,
    is_removed: Vec<bool>,
    moved: Vec<u32>,
}

impl<'a> Collapsing<'a> {
    fn new(fine: &'a Surface) -> Self {
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
            moved: Vec::new(),
        }
    }

    /// Gathers the star of an edge.
    fn look(&mut self, [blue, red]: [u32; 2]) -> Result<Candidate, CollapseFault> {
        if blue == red || blue.max(red) >= self.fine.vertex_count() {
            return Err(CollapseFault::BadVertices);
        }
        self.star.gather(&self.connectivity, blue, red);
        self.star.link_condition()?;
        let &[first, second] = self.star.removed() else {
            return Err(LinkFault::NoEdge.into());
        };
        let wing = |triangle| {
            let [a, b, c] = self.connectivity.corners(triangle);
            a ^ b ^ c ^ blue ^ red
        };
        let wings = [wing(first), wing(second)];
        Ok(Candidate { blue, red, wings })
    }

    /// Performs the collapse that was looked at last.
    fn perform(&mut self, candidate: Candidate) {
        for &triangle in self.star.removed() {
            self.is_removed[triangle as usize] = true;
        }
        self.connectivity.collapse(&self.star, &mut self.moved);
        self.forest.add(candidate);
    }

    /// Performs a collapse of a list if it fits; one that does not, or whose star is not what it was in the list because
    /// others have to wait, has to wait, too.
    fn take(&mut self, [blue, red]: [u32; 2], later: &mut Later) -> Result<bool, CollapseFault> {
        if blue == red || blue.max(red) >= self.fine.vertex_count() {
            return Err(CollapseFault::BadVertices);
        }
        self.star.gather(&self.connectivity, blue, red);
        let rests_on_others = self
            .star
            .vertices()
            .iter()
            .any(|&vertex| later.is_waiting[vertex as usize]);
        if !rests_on_others {
            let candidate = self.look([blue, red])?;
            if self.forest.admits(candidate) {
                self.perform(candidate);
                return Ok(true);
            }
        }
        later.is_waiting[blue as usize] = true;
        later.is_waiting[red as usize] = true;
        Ok(false)
    }

    /// Puts every edge at `vertex` into the queue, in both directions.
    fn enqueue(
        &mut self,
        vertex: u32,
        cost: &impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64>,
        queue: &mut BinaryHeap<Reverse<Queued>>,
    ) {
        if self.fine.is_virtual(vertex) {
            return;
        }
        let triangles = self
            .connectivity
            .star(vertex)
            .map(|triangle| self.connectivity.corners(triangle));
        let mut others: Vec<u32> = triangles.flatten().filter(|&other| other != vertex).collect();
        others.sort_unstable();
        others.dedup();
        for ends in others.into_iter().flat_map(|other| [[vertex, other], [other, vertex]]) {
            let Ok(candidate) = self.look(ends) else { continue };
            let may_grow = true;
            let cost = self.cost(candidate, cost);
            queue.extend(cost.map(|cost| Reverse(Queued { cost, ends, may_grow })));
        }
    }

    fn cost(
        &self,
        Candidate { blue, red, .. }: Candidate,
        cost: impl Fn(u32, u32, &[[u32; 3]]) -> Option<f64>,
    ) -> Option<f64> {
        let triangles = self
            .connectivity
            .star(blue)
            .map(|triangle| self.connectivity.corners(triangle));
        let is_kept = |corners: &[u32; 3]| {
            corners
                .iter()
                .all(|&vertex| vertex != red && !self.fine.is_virtual(vertex))
        };
        let mut kept: Vec<[u32; 3]> = triangles.filter(is_kept).collect();
        kept.sort_unstable();
        cost(blue, red, &kept)
    }
}

/// Reading the split off the triangles that collapses have removed.
struct Reading<'a> {
    fine: &'a Surface,
    /// The triangles that are left, by their numbers in the fine surface.
    kept: Vec<u32>,
    /// For each directed edge of a removed triangle the vertex across.
    across: HashMap<(u32, u32), u32>,
}

impl<'a> Reading<'a> {
    fn of(fine: &'a Surface, collapsing: &Collapsing, is_blue: &[bool]) -> Option<Coarsening> {
        let reading = Self::new(fine, &collapsing.is_removed);
        let (surface, fine_vertices) = reading.coarse_surface(collapsing, is_blue)?;
        let (edges, opened) = collapsing.forest.marks();
        let coarse = |vertex: u32| fine_vertices.partition_point(|&fine| fine < vertex) as u32;
        let mut split = ForestSplit {
            edges: edges.into_iter().map(|edge| edge.map(coarse)).collect(),
            opened: opened.into_iter().map(coarse).collect(),
            fill: Vec::new(),
        };
        split.edges.sort_unstable();
        let mut refined_to_fine = fine_vertices;
        let mut origins = Vec::new();
        for gap in gaps(&surface, &split.marked_half_edges(&surface).ok()?) {
            let corners: Vec<(u32, u32)> = reading.fine_corners(&surface, &gap);
            let copies = number_copies(&surface, &gap, &mut origins);
            refined_to_fine.resize(surface.vertex_count() as usize + origins.len(), OUTSIDE);
            for (&copy, &(vertex, _)) in copies.iter().zip(&corners).filter(|(copy, _)| **copy != OUTSIDE) {
                refined_to_fine[copy as usize] = vertex;
            }
            split.fill.extend(reading.fill(&polygon(&corners))?);
        }
        Some(Coarsening {
            surface,
            split,
            refined_to_fine,
        })
    }

    fn new(fine: &'a Surface, is_removed: &[bool]) -> Self {
        let mut kept = Vec::new();
        let mut across = HashMap::new();
        for ((triangle, &[a, b, c]), &is_removed) in (0..).zip(fine.closed_triangles()).zip(is_removed) {
            if is_removed {
                across.extend([((a, b), c), ((b, c), a), ((c, a), b)]);
            } else {
                kept.push(triangle);
            }
        }
        Self { fine, kept, across }
    }

    /// What is left, in numbers of its own, and the number of each of its vertices in the fine surface.
    fn coarse_surface(&self, collapsing: &Collapsing, is_blue: &[bool]) -> Option<(Surface, Vec<u32>)> {
        let real = (0..)
            .zip(is_blue)
            .filter(|(_, is_blue)| !**is_blue)
            .map(|(vertex, _)| vertex);
        let fine_vertices: Vec<u32> = real.collect();
        let vertex_count = fine_vertices.len() as u32;
        let mut numbers = vec![0; self.fine.closed_vertex_count() as usize];
        let virtual_vertices = self.fine.vertex_count()..self.fine.closed_vertex_count();
        for (number, vertex) in (0..).zip(fine_vertices.iter().copied().chain(virtual_vertices)) {
            numbers[vertex as usize] = number;
        }
        let corners = |&triangle: &u32| collapsing.connectivity.corners(triangle).map(|v| numbers[v as usize]);
        let triangles = self.kept.iter().map(corners).collect();
        let real_end = self.fine.triangles().len() as u32;
        let triangle_count = self.kept.partition_point(|&triangle| triangle < real_end) as u32;
        let surface = Surface::from_closed(vertex_count, triangle_count, triangles).ok()?;
        Some((surface, fine_vertices))
    }

    /// For each corner of a gap, its vertex of the fine surface and that of the coarse one; at a virtual corner, the vertex of
    /// the coarse surface that the boundary is opened at.
    fn fine_corners(&self, coarse: &Surface, gap: &[GapCorner]) -> Vec<(u32, u32)> {
        let mut beside = gap.last().map_or(OUTSIDE, |corner| corner.vertex);
        let corner = |corner: &GapCorner| {
            let vertex = match corner.sector.first() {
                Some(&half_edge) => {
                    beside = corner.vertex;
                    self.fine.origin(3 * self.kept[half_edge as usize / 3] + half_edge % 3)
                }
                None => corner.vertex - coarse.vertex_count() + self.fine.vertex_count(),
            };
            (vertex, beside)
        };
        gap.iter().map(corner).collect()
    }

    fn fill(&self, polygon: &[(u32, u32)]) -> Option<Vec<Branches>> {
        let places: HashMap<(u32, u32), usize> = polygon.iter().copied().zip(0..).collect();
        let place_of = |vertex: u32, beside: u32| places.get(&(vertex, beside)).copied();
        let real_places: HashMap<u32, usize> = polygon.iter().map(|corner| corner.0).zip(0..).collect();
        find_fill(polygon.len(), |first, last| {
            let (from, to) = (polygon[last], polygon[first]);
            let vertex = *self.across.get(&(from.0, to.0))?;
            match self.fine.is_virtual(vertex) {
                true => place_of(vertex, to.1),
                false => real_places.get(&vertex).copied(),
            }
        })
    }
}
