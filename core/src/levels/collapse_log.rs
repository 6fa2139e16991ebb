//! The ordered list of edge collapses: the one interface between any simplifier and everything after it
//! (Surface Partitions §2.4).

use glam::DVec3;
use thiserror::Error;

use crate::topology::connectivity::LinkFault;
use crate::topology::manifold::ManifoldError;

/// One directed edge collapse `blue → red`. The blue vertex leaves the surface; the red one stays and may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collapse {
    /// The vertex that is removed.
    pub blue: u32,
    /// The vertex that remains and represents it.
    pub red: u32,
    /// Where the red vertex was.
    pub red_before: DVec3,
    /// Where the red vertex is from now on.
    pub red_after: DVec3,
    /// Whether it closes a hole: one of three vertices, two of which are the ends of the edge. The third is inside the surface
    /// then, too.
    pub closes_hole: bool,
}

/// A run of collapses that ends with a surface of known error. Levels never span two bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// One past the band's last collapse.
    pub end: usize,
    /// Certified error of the surface after the band, in the units of the heights.
    pub error: f64,
}

/// Collapses in the order in which they were performed, and the bands they fall into, finest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollapseLog {
    /// In the order performed.
    pub collapses: Vec<Collapse>,
    /// Ends grow; the last one is `collapses.len()`. A band may be empty.
    pub bands: Vec<Band>,
}

/// Why a log cannot be replayed.
#[derive(Debug, Error, PartialEq)]
pub enum LogError {
    /// A vertex is not of the mesh, or blue and red are one.
    #[error("collapse {0}: its vertices are out of range or equal")]
    BadVertices(usize),
    /// The blue or the red vertex was removed by an earlier collapse.
    #[error("collapse {0}: vertex {1} was removed before")]
    Removed(usize, u32),
    /// `red_before` is not where the replay has the red vertex.
    #[error("collapse {0}: the red vertex is not where the log says")]
    Misplaced(usize),
    /// The ends of the bands do not grow up to the number of collapses.
    #[error("band {0} does not end where it should")]
    BadBand(usize),
    /// The mesh is not a 2-manifold.
    #[error("collapses of this mesh cannot be replayed")]
    NotManifold(#[from] ManifoldError),
    /// The collapse would leave a surface that is no 2-manifold, or one of another topology than it says.
    #[error("collapse {index}, {blue} → {red}: {fault}")]
    Invalid {
        /// Its index in the log.
        index: usize,
        /// Its blue vertex.
        blue: u32,
        /// Its red vertex.
        red: u32,
        /// What stands against it.
        fault: LinkFault,
    },
}

impl LogError {
    pub(crate) fn invalid(index: usize, collapse: Collapse, fault: LinkFault) -> Self {
        let Collapse { blue, red, .. } = collapse;
        Self::Invalid {
            index,
            blue,
            red,
            fault,
        }
    }
}

/// Checks that `log` can be replayed on vertices at `positions`: every vertex alive when used, every red vertex
/// where the log says it is, bands in order.
///
/// # Errors
/// The first fault, with the index of its collapse or band.
pub fn validate(log: &CollapseLog, positions: &[DVec3]) -> Result<(), LogError> {
    let mut current = positions.to_vec();
    let mut alive = vec![true; positions.len()];
    for (index, collapse) in log.collapses.iter().enumerate() {
        let (blue, red) = (collapse.blue as usize, collapse.red as usize);
        if blue >= alive.len() || red >= alive.len() || blue == red {
            return Err(LogError::BadVertices(index));
        }
        if let Some(vertex) = [collapse.blue, collapse.red].into_iter().find(|&v| !alive[v as usize]) {
            return Err(LogError::Removed(index, vertex));
        }
        if current[red] != collapse.red_before {
            return Err(LogError::Misplaced(index));
        }
        alive[blue] = false;
        current[red] = collapse.red_after;
    }
    let mut previous = 0;
    for (index, band) in log.bands.iter().enumerate() {
        let last = index + 1 == log.bands.len();
        if band.end < previous || band.end > log.collapses.len() || (last && band.end != log.collapses.len()) {
            return Err(LogError::BadBand(index));
        }
        previous = band.end;
    }
    if log.bands.is_empty() && !log.collapses.is_empty() {
        return Err(LogError::BadBand(0));
    }
    Ok(())
}
