//! The two coordinates of a new vertex across the surface.
//!
//! ```text
//! fit         the same as red's, on a sample, at a half or a quarter between two, or free
//! distance    in steps of the samples, or parts of them, or in lattice units; its size and sign guessed from the star
//! ```

use super::number::{NumberModel, SIGNS, code_symbol};
use super::range_coder::{Coder, Probability};
use super::sampling::{Fit, Grid, Sampling};

/// What is known of a coordinate before it is coded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// Which of the two.
    pub(super) axis: usize,
    /// Whether the vertex is split off along the boundary.
    pub(super) is_along: bool,
    /// How the other one fits, or for the first, how red's does.
    pub(super) fit: Fit,
    /// Red's coordinate.
    pub(super) from: f64,
    /// What the star says.
    pub(super) expected: Expected,
}

/// How far a coordinate is expected to be from red's, and on which side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    distance: f64,
    sign: usize,
}

impl Expected {
    /// From the differences of `count` neighbours' coordinates, their sum and that of their sizes: how far they are on the average,
    /// and to which side they lean.
    pub(super) fn of(count: f64, sum: f64, sizes: f64) -> Self {
        let lean = if sizes > 0.0 { sum / sizes } else { 0.0 };
        Self {
            distance: sizes / count,
            sign: ((lean + 1.0) * ((SIGNS - 1) / 2) as f64 + 0.5) as i32 as usize,
        }
    }
}

/// What such coordinates were like so far.
#[derive(Debug)]
pub(super) struct PlanModel {
    grid: Option<Grid>,
    fits: [[[Probability; 8]; Fit::COUNT]; 4],
    steps: [NumberModel; 2],
    units: [NumberModel; 2],
}

impl PlanModel {
    pub(super) fn new(sampling: Option<Sampling>) -> Self {
        Self {
            grid: sampling.map(Grid::new),
            fits: Default::default(),
            steps: Default::default(),
            units: Default::default(),
        }
    }

    /// How a coordinate lies to the samples.
    pub(super) fn fit(&self, axis: usize, coordinate: f64) -> Fit {
        self.grid.map_or(Fit::Free, |grid| grid.fit(axis, coordinate))
    }

    /// Codes a coordinate; tells it and how it fits.
    #[inline]
    pub(super) fn code(&mut self, coder: &mut impl Coder, known: Known, told: f64) -> (f64, Fit) {
        let Known {
            axis, from, expected, ..
        } = known;
        let fit = coder.told(|| match told {
            _ if told == from => Fit::Same,
            _ => self.fit(axis, told),
        });
        let fits = &mut self.fits[2 * usize::from(known.is_along) + axis][known.fit.symbol()];
        let fit = Fit::from_symbol(code_symbol(coder, fits, fit.symbol()));
        let coordinate = match (fit, self.grid) {
            (Fit::Same, _) => from,
            (Fit::Sample(halvings), Some(grid)) => {
                let start = grid.index(axis, halvings, from);
                let end = coder.told(|| grid.index(axis, halvings, told));
                let guess = expected.distance * grid.steps[axis] * f64::from(1 << halvings);
                let steps = self.steps[axis].code(coder, guess, expected.sign, end - start);
                grid.coordinate(axis, halvings, start + steps)
            }
            _ => from + self.units[axis].code(coder, expected.distance, expected.sign, told - from),
        };
        (coordinate, fit)
    }
}
