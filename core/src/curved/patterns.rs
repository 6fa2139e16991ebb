//! Mergeable edge pairs (§6.1) and the patterns that they are part of (§7).
//!
//! Two edges of a vertex are a mergeable pair where they go on in each other's direction, and where there are two or three
//! faces between them on either side (*restricted incident faces*); on the boundary only its two edges are one, with two or
//! three faces on their one side. Where a crease passes, only its two edges are.

use glam::DVec3;
use smallvec::SmallVec;

use crate::curved::model::CurvedModel;
use crate::curved::patch::CURVES;
use crate::topology::half_edges::{NONE, next, previous};

/// Two edges of a vertex that go on in each other's direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeablePair {
    /// The vertices that the edges lead to. Going round counter-clockwise, the second comes after the first; which is the
    /// first is arbitrary inside the surface.
    pub ends: [u32; 2],
    /// The angle between both directions, in radians.
    pub angle: f64,
    /// Where both edges stand in the ring of the vertex.
    pub(crate) places: [usize; 2],
}

/// The patches on one side of a pair that can become one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// Which one.
    pub kind: PatternKind,
    /// From where to where the side is swept, counter-clockwise.
    pub side: [u32; 2],
    /// The vertices that go, growing.
    pub removed: SmallVec<[u32; 3]>,
    /// The corners that stay: both ends of the side and the one across.
    pub corners: [u32; 3],
}

/// The patterns of Fig. 5 with a mergeable pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatternKind {
    /// Two patches.
    T,
    /// Three patches and two removed vertices.
    TwoT,
    /// Four patches and three removed vertices.
    TriangleInTriangle,
}

/// The edges around a vertex, counter-clockwise.
pub(crate) struct Ring {
    /// The vertex at the other end of each edge.
    pub(crate) ends: SmallVec<[u32; 8]>,
    /// How each edge starts: its direction, not of unit length.
    directions: SmallVec<[DVec3; 8]>,
    creases: SmallVec<[bool; 8]>,
    /// Half-edges that leave; one a face.
    pub(crate) leaving: SmallVec<[u32; 8]>,
}

impl Ring {
    pub(crate) fn is_boundary(&self) -> bool {
        self.ends.len() > self.leaving.len()
    }

    pub(crate) fn has_crease(&self) -> bool {
        self.creases.contains(&true)
    }

    fn angle(&self, first: usize, second: usize) -> f64 {
        let (a, b) = (-self.directions[first], self.directions[second]);
        a.cross(b).length().atan2(a.dot(b))
    }

    fn is_allowed(&self, first: usize, second: usize) -> bool {
        match self.creases.iter().filter(|&&is_crease| is_crease).count() {
            0 => true,
            2 => self.creases[first] && self.creases[second],
            _ => false,
        }
    }
}

impl CurvedModel {
    pub(crate) fn ring(&self, vertex: u32) -> Ring {
        let mut ring = Ring {
            ends: SmallVec::new(),
            directions: SmallVec::new(),
            creases: SmallVec::new(),
            leaving: self.topology.leaving(vertex).collect(),
        };
        for index in 0..ring.leaving.len() {
            let edge = ring.leaving[index];
            self.push_edge(&mut ring, edge, [0, 1], self.topology.end(edge));
        }
        if let Some(&last) = ring.leaving.last()
            && self.topology.is_boundary(vertex)
        {
            self.push_edge(&mut ring, previous(last), [3, 2], self.topology.apex(last));
        }
        ring
    }

    /// Appends an edge; `along` are the control points of its curve from the vertex on.
    fn push_edge(&self, ring: &mut Ring, edge: u32, along: [usize; 2], end: u32) {
        let points = &self.patches[edge as usize / 3].points;
        let [from, to] = along.map(|place| points[CURVES[edge as usize % 3][place]]);
        ring.ends.push(end);
        ring.directions.push(to - from);
        ring.creases.push(self.is_crease[edge as usize]);
    }

    /// The mergeable pairs of a vertex whose edges deviate by `tolerance` radians at most.
    #[must_use]
    pub fn mergeable_pairs(&self, vertex: u32, tolerance: f64) -> SmallVec<[MergeablePair; 3]> {
        pairs_in(&self.ring(vertex), tolerance)
    }

    /// The patterns on both sides of every mergeable pair of a vertex; on a side of three faces, all that match.
    #[must_use]
    pub fn patterns(&self, vertex: u32, tolerance: f64) -> Vec<Pattern> {
        let ring = self.ring(vertex);
        let mut patterns = Vec::new();
        for pair in pairs_in(&ring, tolerance) {
            let [first, second] = pair.places;
            let count = ring.leaving.len();
            self.match_side(
                vertex,
                &ring.leaving[first..second.min(count)],
                tolerance,
                &mut patterns,
            );
            if !ring.is_boundary() {
                let other: SmallVec<[u32; 4]> = (second..count + first)
                    .map(|place| ring.leaving[place % count])
                    .collect();
                self.match_side(vertex, &other, tolerance, &mut patterns);
            }
        }
        patterns
    }

    /// The patterns on the side of `faces`, half-edges that leave `vertex`.
    fn match_side(&self, vertex: u32, faces: &[u32], tolerance: f64, patterns: &mut Vec<Pattern>) {
        let (from, to) = (self.topology.end(faces[0]), self.topology.apex(faces[faces.len() - 1]));
        let mut push = |kind, removed: &[u32], apex| {
            let mut removed = SmallVec::from_slice(removed);
            removed.sort_unstable();
            patterns.push(Pattern {
                kind,
                side: [from, to],
                removed,
                corners: [from, to, apex],
            });
        };
        if let [_, second] = faces {
            return push(PatternKind::T, &[vertex], self.topology.end(*second));
        }
        let [p, q] = [faces[1], faces[2]].map(|edge| self.topology.end(edge));
        let is_pair = |middle: u32, a: u32, b: u32| {
            let pairs = self.mergeable_pairs(middle, tolerance);
            pairs.iter().any(|pair| pair.ends == [a, b] || pair.ends == [b, a])
        };
        if is_pair(p, from, q) {
            push(PatternKind::TwoT, &[vertex, p], q);
        }
        if is_pair(q, p, to) {
            push(PatternKind::TwoT, &[vertex, q], p);
        }
        let across = self.topology.twin(next(faces[1]));
        if across != NONE {
            let apex = self.topology.apex(across);
            if is_pair(p, from, apex) && is_pair(q, apex, to) {
                push(PatternKind::TriangleInTriangle, &[vertex, p, q], apex);
            }
        }
    }
}

/// The mergeable pairs in a ring.
pub(crate) fn pairs_in(ring: &Ring, tolerance: f64) -> SmallVec<[MergeablePair; 3]> {
    let (edges, faces) = (ring.ends.len(), ring.leaving.len());
    let mut pairs = SmallVec::new();
    let is_side = |count: usize| count == 2 || count == 3;
    let mut add = |first: usize, second: usize| {
        let angle = ring.angle(first, second);
        if angle <= tolerance && ring.is_allowed(first, second) {
            pairs.push(MergeablePair {
                ends: [ring.ends[first], ring.ends[second]],
                angle,
                places: [first, second],
            });
        }
    };
    if ring.is_boundary() {
        if is_side(faces) {
            add(0, edges - 1);
        }
        return pairs;
    }
    for first in 0..edges {
        for second in first + 2..edges {
            if is_side(second - first) && is_side(edges - (second - first)) {
                add(first, second);
            }
        }
    }
    pairs
}

#[cfg(test)]
#[path = "patterns_tests.rs"]
mod tests;
