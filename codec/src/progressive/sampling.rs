//! Where the samples of a raster lie on the lattice, so that vertices which are samples are told by column and row.

use super::star::nearest;

/// Columns and rows of samples along the lattice's first two axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Lattice position of one sample.
    pub origin: [f64; 2],
    /// Lattice units from one column, or row, to the next; at least 2^−16.
    pub step: [f64; 2],
}

/// How a coordinate of a new vertex lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Fit {
    /// It is that of the vertex it is split from.
    #[default]
    Same,
    /// A sample's, or at a half or a quarter of the way between two: 0, 1, 2.
    Sample(u32),
    /// Any.
    Free,
}

impl Fit {
    /// How many there are.
    pub(super) const COUNT: usize = 5;
    const ALL: [Self; Self::COUNT] = [
        Self::Same,
        Self::Sample(0),
        Self::Sample(1),
        Self::Sample(2),
        Self::Free,
    ];

    pub(super) fn from_symbol(symbol: usize) -> Self {
        Self::ALL.get(symbol).copied().unwrap_or(Self::Free)
    }

    pub(super) fn symbol(self) -> usize {
        match self {
            Self::Same => 0,
            Self::Sample(halvings) => 1 + halvings as usize,
            Self::Free => 4,
        }
    }
}

/// The same, with what is divided by, turned over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    sampling: Sampling,
    /// Steps in a lattice unit.
    pub(super) steps: [f64; 2],
}

impl Grid {
    pub(super) fn new(sampling: Sampling) -> Self {
        Self {
            sampling,
            steps: sampling.step.map(|step| 1.0 / step),
        }
    }

    /// Number of the sample, or of the half or quarter of a step, nearest to a coordinate.
    pub(super) fn index(&self, axis: usize, halvings: u32, coordinate: f64) -> f64 {
        nearest((coordinate - self.sampling.origin[axis]) * self.steps[axis] * f64::from(1 << halvings))
    }

    /// Lattice coordinate of that number.
    pub(super) fn coordinate(&self, axis: usize, halvings: u32, index: f64) -> f64 {
        nearest(self.sampling.origin[axis] + self.sampling.step[axis] * (index / f64::from(1 << halvings)))
    }

    /// The coarsest part of a step on which a coordinate lies.
    pub(super) fn fit(&self, axis: usize, coordinate: f64) -> Fit {
        let lies_on =
            |&halvings: &u32| self.coordinate(axis, halvings, self.index(axis, halvings, coordinate)) == coordinate;
        (0..3).find(lies_on).map_or(Fit::Free, Fit::Sample)
    }
}
