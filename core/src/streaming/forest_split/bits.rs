//! A forest split as bits, and back.
//!
//! ```text
//! marks    for each edge: is it marked?
//!          vertex by vertex, clockwise around each; the vertices of a tree next once it is met, breadth first
//!          left out where both ends are in one tree already: it cannot be
//! opened   for each vertex of the boundary that is in a tree, in growing order: is the boundary opened there?
//! fills    for each triangle of the fills: does another follow on its left edge, and one on its right edge?
//!          left out where the number of triangles, which the tree of edges tells, allows one answer only
//! ```
//!
//! Breadth first, two edges of a triangle are more often known to be marked before the third is come to than in any fixed
//! order: a tenth fewer bits. Three streams, so that a coder of entropy can have a model for each.

use std::collections::VecDeque;

use super::forest::{find, unite};
use super::gap::{Branches, GapCorner};
use super::{ClosedSurface, ForestSplit, SplitError};

/// The bits of one batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SplitBits {
    /// Which edges are marked.
    pub marks: Vec<bool>,
    /// Where the boundary is opened.
    pub opened: Vec<bool>,
    /// The triangles of the fills.
    pub fills: Vec<bool>,
}

impl SplitBits {
    /// How many bits there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.marks.len() + self.opened.len() + self.fills.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The bits that mark `edges`, which are in growing order and form a forest.
fn mark_bits(surface: &ClosedSurface, edges: &[[u32; 2]]) -> Vec<bool> {
    let mut bits = Vec::new();
    ask_edges(surface, |edge| {
        bits.push(edges.binary_search(&edge).is_ok());
        bits.last().copied()
    });
    bits
}

/// The edges that `bits` mark on `surface`.
fn marked_edges(surface: &ClosedSurface, bits: &[bool]) -> Result<Vec<[u32; 2]>, SplitError> {
    let mut edges = Vec::new();
    let mut bits = bits.iter().copied();
    let answered = ask_edges(surface, |edge| {
        let bit = bits.next()?;
        edges.extend(bit.then_some(edge));
        Some(bit)
    });
    edges.sort_unstable();
    match answered.is_some() && bits.next().is_none() {
        true => Ok(edges),
        false => Err(SplitError::BitCount("marks")),
    }
}

/// Asks about each edge, unless its ends are in one tree already, whether it is marked; None where there is no answer.
fn ask_edges(surface: &ClosedSurface, mut is_marked: impl FnMut([u32; 2]) -> Option<bool>) -> Option<()> {
    let mut parents: Vec<u32> = (0..surface.vertex_count()).collect();
    let mut is_passed = vec![false; surface.half_edge_count()];
    for first in surface.leaving().into_iter().take(parents.len()).flatten() {
        let mut waiting = VecDeque::from([first]);
        while let Some(first) = waiting.pop_front() {
            for half_edge in surface.fan(first) {
                let (from, to) = (surface.origin(half_edge), surface.target(half_edge));
                let opposite = surface.opposite(half_edge);
                let was_passed = std::mem::replace(&mut is_passed[half_edge as usize], true);
                is_passed[opposite as usize] = true;
                if was_passed || surface.is_virtual(to) || find(&mut parents, from) == find(&mut parents, to) {
                    continue;
                }
                if is_marked([from.min(to), from.max(to)])? {
                    unite(&mut parents, from, to);
                    waiting.push_back(opposite);
                }
            }
        }
    }
    Some(())
}

impl ForestSplit {
    /// The bits of the split of `surface`.
    ///
    /// # Errors
    /// When it is none of `surface`.
    pub fn encode(&self, surface: &ClosedSurface) -> Result<SplitBits, SplitError> {
        let gaps = self.gaps(surface)?;
        let candidates = openable(surface, &self.edges);
        Ok(SplitBits {
            marks: mark_bits(surface, &self.edges),
            opened: candidates
                .iter()
                .map(|vertex| self.opened.binary_search(vertex).is_ok())
                .collect(),
            fills: fill_bits(&gaps, &self.fill)?,
        })
    }

    /// Reads the split of `surface` from bits. Any bits are read or refused in time and memory that grow with the surface
    /// only.
    ///
    /// # Errors
    /// When there are too few bits or too many.
    pub fn decode(bits: &SplitBits, surface: &ClosedSurface) -> Result<Self, SplitError> {
        let edges = marked_edges(surface, &bits.marks)?;
        let candidates = openable(surface, &edges);
        if candidates.len() != bits.opened.len() {
            return Err(SplitError::BitCount("opened"));
        }
        let opened = candidates.into_iter().zip(&bits.opened).filter(|(_, bit)| **bit);
        let mut split = Self {
            edges,
            opened: opened.map(|(vertex, _)| vertex).collect(),
            fill: Vec::new(),
        };
        split.fill = read_fills(&split.gaps(surface)?, &bits.fills)?;
        Ok(split)
    }
}

/// The vertices of the trees that are on the boundary.
fn openable(surface: &ClosedSurface, edges: &[[u32; 2]]) -> Vec<u32> {
    let leaving = surface.leaving();
    let is_on_boundary = |vertex: &u32| {
        let mut fan = leaving[*vertex as usize]
            .into_iter()
            .flat_map(|first| surface.fan(first));
        fan.any(|half_edge| surface.is_virtual(surface.target(half_edge)))
    };
    let mut vertices: Vec<u32> = edges.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.retain(is_on_boundary);
    vertices
}

fn fill_bits(gaps: &[Vec<GapCorner>], fill: &[Branches]) -> Result<Vec<bool>, SplitError> {
    let mut bits = Vec::new();
    let mut rest = fill;
    for gap in gaps {
        let (own, others) = rest.split_at_checked(gap.len() - 2).ok_or(SplitError::Fill)?;
        let told = ask_fill(own.len(), |triangle, side| {
            bits.push(own[triangle][side]);
            bits.last().copied()
        });
        if told.as_deref() != Some(own) {
            return Err(SplitError::Fill);
        }
        rest = others;
    }
    match rest {
        [] => Ok(bits),
        _ => Err(SplitError::Fill),
    }
}

fn read_fills(gaps: &[Vec<GapCorner>], bits: &[bool]) -> Result<Vec<Branches>, SplitError> {
    let mut fill = Vec::new();
    let mut bits = bits.iter().copied();
    for gap in gaps {
        let own = ask_fill(gap.len() - 2, |_, _| bits.next());
        fill.extend(own.ok_or(SplitError::BitCount("fills"))?);
    }
    match bits.next() {
        None => Ok(fill),
        Some(_) => Err(SplitError::BitCount("fills")),
    }
}

/// A fill of `count` triangles, of which `branch` tells whether a triangle has others on its side 0 or 1; it is asked only
/// where the count leaves a choice. None where it does not know.
fn ask_fill(count: usize, mut branch: impl FnMut(usize, usize) -> Option<bool>) -> Option<Vec<Branches>> {
    // Triangles that an earlier one has on a side, but have not come yet; those that none has so far.
    let (mut announced, mut unannounced) = (1, count.saturating_sub(1));
    let mut fill = vec![[false; 2]; count];
    for (triangle, branches) in fill.iter_mut().enumerate() {
        announced -= 1;
        for (side, has_branch) in branches.iter_mut().enumerate() {
            *has_branch = match unannounced {
                0 => false,
                _ if side == 1 && announced == 0 => true,
                _ => branch(triangle, side)?,
            };
            announced += usize::from(*has_branch);
            unannounced -= usize::from(*has_branch);
        }
    }
    Some(fill)
}

#[cfg(test)]
#[path = "bits_tests.rs"]
mod tests;
