//! The partial order of edge collapses: which others each one needs (Surface Partitions §3; *A Framework for Streaming
//! Geometry in VRML*, 1999, "Local surface refinement").
//!
//! ```text
//! for each collapse, in order:
//!     for each vertex in the star of its edge that was a red vertex before:
//!         the collapse needs the last one into that vertex
//!     its own red vertex was now last collapsed into by it
//! ```
//!
//! The papers record *all* collapses into such a vertex. Of those each needs the one before it (its red vertex is in
//! its star), so the last one implies the rest: the same sets of collapses are closed, and the graph stays as small as
//! the stars are. [`CollapseDag::all_influences`] gives the papers' literal graph.
//!
//! **Invariant: a set of performed collapses draws a consistent surface if it is closed**, that is, if it holds
//! everything that each of its collapses needs. Then the star of every collapse that can be performed or undone is the
//! one it had when the log was made. Collapses are numbered in the order of the log, so that what one needs has a
//! smaller number.

use crate::levels::replay::Step;
use crate::topology::compressed_rows::CompressedRows;

/// Stands for no collapse.
const NONE: u32 = u32::MAX;

/// The collapses of a log and what each needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CollapseDag {
    constraints: CompressedRows,
    split_constraints: CompressedRows,
    /// For each collapse the one before it into the same red vertex, or [`NONE`].
    earlier_into_red: Vec<u32>,
}

impl CollapseDag {
    /// What must be performed before `collapse`: its collapse constraints, growing.
    #[must_use]
    pub fn constraints(&self, collapse: u32) -> &[u32] {
        self.constraints.row(collapse)
    }

    /// What must be undone before `collapse` is: its split constraints, growing.
    #[must_use]
    pub fn split_constraints(&self, collapse: u32) -> &[u32] {
        self.split_constraints.row(collapse)
    }

    /// How many collapses there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.constraints.len()
    }

    /// Whether there are no collapses.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.constraints.is_empty()
    }

    /// The graph as the papers record it: each collapse with every collapse into a vertex of its star. Where one
    /// vertex swallows a large part of a mesh, its size grows with the square of that part.
    #[must_use]
    pub fn all_influences(&self) -> CompressedRows {
        let mut all = CompressedRows::default();
        for row in self.constraints.rows() {
            let mut influences: Vec<u32> = row.iter().flat_map(|&last| self.collapses_up_to(last)).collect();
            influences.sort_unstable();
            all.push(influences);
        }
        all
    }

    /// The smallest graph with the same closed sets: no constraint that others imply.
    #[must_use]
    pub fn transitive_reduction(&self) -> CompressedRows {
        let mut reduced = CompressedRows::default();
        let mut reached_by = vec![NONE; self.len()];
        for (collapse, row) in (0..).zip(self.constraints.rows()) {
            let smallest = row.first().copied().unwrap_or(0);
            let mut kept = Vec::with_capacity(row.len());
            for &constraint in row.iter().rev() {
                if reached_by[constraint as usize] != collapse {
                    kept.push(constraint);
                    self.reach(constraint, smallest, collapse, &mut reached_by);
                }
            }
            kept.reverse();
            reduced.push(kept);
        }
        reduced
    }

    /// Raises errors to the largest of what each collapse needs. With such errors the two queues never keep a collapse
    /// of a large error because one of a smaller error rests on it.
    #[must_use]
    pub fn monotone_errors(&self, errors: &[f64]) -> Vec<f64> {
        let mut monotone = errors.to_vec();
        for (collapse, row) in self.constraints.rows().enumerate() {
            let needed = row.iter().map(|&constraint| monotone[constraint as usize]);
            monotone[collapse] = needed.fold(monotone[collapse], f64::max);
        }
        monotone
    }

    /// Whether the set of the collapses for which `is_performed` holds is closed.
    #[must_use]
    pub fn is_closed(&self, is_performed: impl Fn(u32) -> bool) -> bool {
        let mut performed = (0..self.len() as u32).filter(|&collapse| is_performed(collapse));
        performed.all(|collapse| self.constraints(collapse).iter().all(|&needed| is_performed(needed)))
    }

    /// `last` and the collapses before it into the same red vertex.
    fn collapses_up_to(&self, last: u32) -> impl Iterator<Item = u32> + '_ {
        let earlier = |&collapse: &u32| Some(self.earlier_into_red[collapse as usize]).filter(|&found| found != NONE);
        std::iter::successors(Some(last), earlier)
    }

    /// Marks what `from` needs, directly or not, down to `smallest`.
    fn reach(&self, from: u32, smallest: u32, mark: u32, reached_by: &mut [u32]) {
        let mut open = vec![from];
        while let Some(collapse) = open.pop() {
            for &needed in self.constraints(collapse) {
                if needed >= smallest && reached_by[needed as usize] != mark {
                    reached_by[needed as usize] = mark;
                    open.push(needed);
                }
            }
        }
    }
}

/// Builds a [`CollapseDag`] from the steps of a replay, in time that grows with the stars.
pub struct DagBuilder {
    constraints: CompressedRows,
    earlier_into_red: Vec<u32>,
    /// For each vertex the last collapse into it, or [`NONE`].
    last_into: Vec<u32>,
    /// The row that is being made.
    needed: Vec<u32>,
}

impl DagBuilder {
    /// For a mesh of that many vertices.
    #[must_use]
    pub fn new(vertex_count: usize) -> Self {
        Self {
            constraints: CompressedRows::default(),
            earlier_into_red: Vec::new(),
            last_into: vec![NONE; vertex_count],
            needed: Vec::new(),
        }
    }

    /// Adds the next collapse of the log.
    pub fn add(&mut self, step: &Step) {
        let last_into = |&vertex: &u32| self.last_into[vertex as usize];
        self.needed.clear();
        self.needed
            .extend(step.star.vertices().iter().map(last_into).filter(|&last| last != NONE));
        self.needed.sort_unstable();
        self.constraints.push(self.needed.iter().copied());
        let last = &mut self.last_into[step.collapse.red as usize];
        self.earlier_into_red.push(std::mem::replace(last, step.index));
    }

    /// The graph of all collapses added.
    #[must_use]
    pub fn finish(self) -> CollapseDag {
        CollapseDag {
            split_constraints: self.constraints.transposed(),
            constraints: self.constraints,
            earlier_into_red: self.earlier_into_red,
        }
    }
}

#[cfg(test)]
#[path = "dag_tests.rs"]
mod tests;
