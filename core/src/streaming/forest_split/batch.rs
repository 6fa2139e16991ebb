//! From collapses to forest splits: performing them, and which of them make a batch.

use thiserror::Error;

use super::ClosedSurface;
use super::collapsing::{CollapseFault, Collapsing};
use super::forest::Forest;
use super::reading::{Coarsening, read_split};

/// Why collapses are refused.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("collapse {index}: {fault}")]
pub struct CollapseError {
    /// Index of the collapse.
    pub index: usize,
    /// What is wrong with it.
    pub fault: CollapseFault,
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
            let taken = take(&mut collapsing, &mut later, collapses[index as usize]);
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

/// Performs a collapse of a list if it fits; one that does not, or whose star is not what it was in the list because others
/// have to wait, has to wait, too.
fn take(collapsing: &mut Collapsing, later: &mut Later, ends: [u32; 2]) -> Result<bool, CollapseFault> {
    collapsing.gather(ends)?;
    if !later.is_waiting_at(collapsing.vertices_around()) {
        let candidate = collapsing.looked_at(ends)?;
        if collapsing.forest.admits(candidate) {
            collapsing.perform(candidate);
            return Ok(true);
        }
    }
    later.wait_at(ends);
    Ok(false)
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
