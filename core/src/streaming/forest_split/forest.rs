//! Which collapses may be undone together by one forest split.
//!
//! The triangles that a collapse `blue → red` removes leave two marked edges behind, from red to the two *wings* across
//! the collapsed edge. Seen together, the removed triangles must form trees and so must the marked edges, and those of two
//! trees must have no vertex in common: where they have, the cut has more sides than there are triangles to fill it.
//!
//! ```text
//!            x                    x           may be added to what has been marked when, of blue, red, x and y,
//!          ╱ │ ╲                  ┃             none is in a tree:                a new tree
//!     blue ──┼── red     ▶       red            two are, joined by a marked edge,
//!          ╲ │ ╱                  ┃               but not x and y:                the tree grows by that edge
//!            y                    y             all are, red and x joined by one,
//!                                                 blue and y by one of another
//!                                                 tree, or x and y exchanged:     two trees become one
//! ```
//!
//! In each case the new triangles are glued to edges of the gaps so far and share nothing else with them.
//!
//! At a boundary a wing is the virtual vertex. For a tree it is a leaf, beside red and nobody else's, although it stands
//! for the same point in all trees: a leaf is not cut apart.

/// The edges that are marked so far, on the surface as the collapses so far have left it.
#[derive(Clone, Debug)]
pub(super) struct Forest {
    /// The other ends of the marked edges at each real vertex.
    neighbours: Vec<Vec<u32>>,
    /// Whether the edge from a real vertex to the virtual one is marked.
    is_opened: Vec<bool>,
    /// The trees as disjoint sets of vertices.
    parents: Vec<u32>,
}

/// A collapse and what lies across its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) blue: u32,
    pub(super) red: u32,
    pub(super) wings: [u32; 2],
}

impl Candidate {
    /// The collapse of the same edge the other way.
    pub(super) fn reversed(self) -> Self {
        Self {
            blue: self.red,
            red: self.blue,
            wings: self.wings,
        }
    }
}

impl Forest {
    /// No marks on a surface of so many real vertices.
    pub(super) fn new(vertex_count: u32) -> Self {
        let vertices = vertex_count as usize;
        Self {
            neighbours: vec![Vec::new(); vertices],
            is_opened: vec![false; vertices],
            parents: (0..vertex_count).collect(),
        }
    }

    /// Whether the collapse can be one of the batch, by the rule above.
    pub(super) fn admits(&mut self, Candidate { blue, red, wings }: Candidate) -> bool {
        let [x, y] = wings;
        if self.is_opened_at(blue) && self.is_opened_at(red) {
            // The boundary would have to be opened twice at one vertex.
            return false;
        }
        let ends = [blue, red].map(|end| self.is_in_tree(end));
        let tips = wings.map(|wing| self.is_tip(wing, [blue, red]));
        match (ends, tips) {
            ([false, false], [false, false]) => true,
            ([true, true], [false, false]) => self.are_joined(blue, red),
            ([true, false], [true, false]) => self.are_joined(blue, x),
            ([true, false], [false, true]) => self.are_joined(blue, y),
            ([false, true], [true, false]) => self.are_joined(red, x),
            ([false, true], [false, true]) => self.are_joined(red, y),
            ([true, true], [true, true]) => {
                let crossed = self.are_joined(red, x) && self.are_joined(blue, y);
                let straight = self.are_joined(blue, x) && self.are_joined(red, y);
                (crossed || straight) && self.tree(blue) != self.tree(red)
            }
            _ => false,
        }
    }

    /// Whether the collapse would add to a tree that is there already.
    pub(super) fn touches(&self, Candidate { blue, red, wings }: Candidate) -> bool {
        let ends = [blue, red];
        ends.iter().any(|&end| self.is_in_tree(end)) || wings.iter().any(|&wing| self.is_tip(wing, ends))
    }

    /// Marks what an admitted collapse leaves behind.
    pub(super) fn add(&mut self, Candidate { blue, red, wings }: Candidate) {
        for other in std::mem::take(&mut self.neighbours[blue as usize]) {
            self.neighbours[other as usize].retain(|&vertex| vertex != blue);
            if other != red {
                self.mark(red, other);
            }
        }
        self.is_opened[red as usize] |= std::mem::take(&mut self.is_opened[blue as usize]);
        self.unite(blue, red);
        wings.into_iter().for_each(|wing| self.mark(red, wing));
    }

    /// The marked edges between real vertices, each once, and the vertices at which the boundary is opened.
    pub(super) fn marks(&self) -> (Vec<[u32; 2]>, Vec<u32>) {
        let mut edges = Vec::new();
        for (vertex, others) in (0..).zip(&self.neighbours) {
            edges.extend(
                others
                    .iter()
                    .filter(|&&other| vertex < other)
                    .map(|&other| [vertex, other]),
            );
        }
        let vertices = (0..).zip(&self.is_opened);
        let opened = vertices.filter(|(_, is_opened)| **is_opened).map(|(vertex, _)| vertex);
        (edges, opened.collect())
    }

    fn mark(&mut self, red: u32, other: u32) {
        if self.is_virtual(other) {
            self.is_opened[red as usize] = true;
        } else if !self.are_joined(red, other) {
            self.neighbours[red as usize].push(other);
            self.neighbours[other as usize].push(red);
            self.unite(red, other);
        }
    }

    fn is_virtual(&self, vertex: u32) -> bool {
        vertex as usize >= self.neighbours.len()
    }

    fn is_in_tree(&self, vertex: u32) -> bool {
        !self.neighbours[vertex as usize].is_empty()
    }

    fn is_opened_at(&self, vertex: u32) -> bool {
        self.is_opened[vertex as usize]
    }

    /// Whether a wing is in a tree; the virtual one is in that of the end that is opened.
    fn is_tip(&self, wing: u32, ends: [u32; 2]) -> bool {
        match self.is_virtual(wing) {
            true => ends.iter().any(|&end| self.is_opened_at(end)),
            false => self.is_in_tree(wing),
        }
    }

    fn are_joined(&self, end: u32, other: u32) -> bool {
        match self.is_virtual(other) {
            true => self.is_opened_at(end),
            false => self.neighbours[end as usize].contains(&other),
        }
    }

    fn tree(&mut self, vertex: u32) -> u32 {
        find(&mut self.parents, vertex)
    }

    fn unite(&mut self, a: u32, b: u32) {
        unite(&mut self.parents, a, b);
    }
}

/// The set that `vertex` is in, path halving on the way (R. Tarjan, *Data Structures and Network Algorithms*, 1983).
pub(super) fn find(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let above = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

/// Makes one set of two; tells whether they were two.
pub(super) fn unite(parents: &mut [u32], a: u32, b: u32) -> bool {
    let (a, b) = (find(parents, a), find(parents, b));
    parents[a as usize] = b;
    a != b
}

#[cfg(test)]
#[path = "forest_tests.rs"]
mod tests;
