//! Vertex clustering by the cells of ever coarser grids, which works for any mesh.
//!
//! After J. Rossignac, P. Borrel, *Multi-resolution 3D approximations for rendering complex scenes*, 1993. Each grid's cells
//! are two of the finer one's wide, so that cells only ever grow together; a cell's vertex is the mean of the vertices of
//! the mesh inside it.

use std::collections::HashMap;

use thiserror::Error;

use super::Clustering;

/// Why there can be no grid.
#[derive(Debug, Error, PartialEq)]
pub enum GridError {
    /// The size of a cell is no positive number.
    #[error("the finest cell must have a positive size, not {0}")]
    BadCell(f64),
    /// A coordinate is no number, or so far from the others that cells of this size cannot be counted.
    #[error("vertex {0} is not finite, or too many cells away from the others; use larger cells")]
    OutOfReach(usize),
}

/// Cells that can be counted exactly along one axis.
const MOST_CELLS: f64 = (1_u64 << 53) as f64;

/// `count` clusterings of vertices at `positions`, the first by cells of size `finest_cell`, in the units of the
/// coordinates, each further one by cells twice as large.
///
/// # Errors
/// When cells of that size cannot be numbered.
pub fn grid_clusterings<const DIMENSION: usize>(
    positions: &[[f64; DIMENSION]],
    finest_cell: f64,
    count: usize,
) -> Result<Vec<Clustering<DIMENSION>>, GridError> {
    if !(finest_cell.is_finite() && finest_cell > 0.0) {
        return Err(GridError::BadCell(finest_cell));
    }
    let mut cells = finest_cells(positions, finest_cell)?;
    let mut sums: Vec<Sum<DIMENSION>> = positions.iter().map(|&total| Sum { total, count: 1.0 }).collect();
    let mut clusterings = Vec::with_capacity(count);
    for _ in 0..count {
        let (mapping, occupied) = number(&cells);
        sums = merge(&sums, &mapping, occupied.len());
        clusterings.push(Clustering {
            positions: sums.iter().map(Sum::mean).collect(),
            mapping,
        });
        cells = occupied.into_iter().map(|cell| cell.map(|along| along / 2)).collect();
    }
    Ok(clusterings)
}

/// Which cell of the finest grid each vertex is in, counted from the smallest coordinates.
fn finest_cells<const DIMENSION: usize>(
    positions: &[[f64; DIMENSION]],
    cell: f64,
) -> Result<Vec<[u64; DIMENSION]>, GridError> {
    let mut lowest = [f64::INFINITY; DIMENSION];
    for position in positions {
        lowest = std::array::from_fn(|axis| lowest[axis].min(position[axis]));
    }
    let cell_of = |(vertex, position): (usize, &[f64; DIMENSION])| {
        let along: [f64; DIMENSION] = std::array::from_fn(|axis| ((position[axis] - lowest[axis]) / cell).floor());
        match along.iter().all(|&cells| cells < MOST_CELLS) {
            true => Ok(along.map(|cells| cells as u64)),
            false => Err(GridError::OutOfReach(vertex)),
        }
    };
    positions.iter().enumerate().map(cell_of).collect()
}

/// Numbers the occupied cells by the first vertex in each: the number of each vertex's cell, and the cells.
fn number<const DIMENSION: usize>(cells: &[[u64; DIMENSION]]) -> (Vec<u32>, Vec<[u64; DIMENSION]>) {
    let mut numbers = HashMap::new();
    let mut occupied = Vec::new();
    let mut number_of = |&cell: &[u64; DIMENSION]| {
        *numbers.entry(cell).or_insert_with(|| {
            occupied.push(cell);
            occupied.len() as u32 - 1
        })
    };
    let mapping = cells.iter().map(&mut number_of).collect();
    (mapping, occupied)
}

/// Vertices of the mesh that are in one cell, added up.
#[derive(Clone, Copy)]
struct Sum<const DIMENSION: usize> {
    total: [f64; DIMENSION],
    count: f64,
}

impl<const DIMENSION: usize> Sum<DIMENSION> {
    const ZERO: Self = Self {
        total: [0.0; DIMENSION],
        count: 0.0,
    };

    fn mean(&self) -> [f64; DIMENSION] {
        self.total.map(|coordinate| coordinate / self.count)
    }
}

fn merge<const DIMENSION: usize>(sums: &[Sum<DIMENSION>], mapping: &[u32], count: usize) -> Vec<Sum<DIMENSION>> {
    let mut merged = vec![Sum::ZERO; count];
    for (sum, &new) in sums.iter().zip(mapping) {
        let into = &mut merged[new as usize];
        into.count += sum.count;
        into.total
            .iter_mut()
            .zip(sum.total)
            .for_each(|(total, own)| *total += own);
    }
    merged
}

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;
