//! The triangles around one vertex as seen from it: where a sample lies, and what the vertex's height does there.

use glam::DVec2;

use crate::interval::Interval;
use crate::reference::{GridPoint, ON_A_LINE, Reference};
use crate::samples::Sample;

/// Triangles around a centre of unknown height, counter-clockwise.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fan {
    centre: DVec2,
    curvature: DVec2,
    sectors: Vec<Sector>,
    is_closed: bool,
}

/// A triangle of the fan. Positions are offsets from the centre, in grid coordinates.
#[derive(Clone, Copy, Debug)]
struct Sector {
    /// The weights of the first and of the second of its outer corners rise along these.
    of_first: DVec2,
    of_second: DVec2,
    /// The height that both give to a point rises along this.
    given: DVec2,
    /// Weights may be this far below 0 by rounding.
    slack: f64,
}

impl Sector {
    #[inline]
    fn new([first, second]: [DVec2; 2], [height_of_first, height_of_second]: [f64; 2]) -> Self {
        let per_area = 1.0 / first.perp_dot(second);
        let of_first = DVec2::new(second.y, -second.x) * per_area;
        let of_second = DVec2::new(-first.y, first.x) * per_area;
        let steepness = of_first.abs() + of_second.abs();
        Self {
            of_first,
            of_second,
            given: of_first * height_of_first + of_second * height_of_second,
            slack: -ON_A_LINE * (steepness.x + steepness.y),
        }
    }
}

impl Fan {
    /// Spreads the fan from `centre` over the points of `ring`: a sector from each to the next and, if it `is_closed`,
    /// from the last to the first.
    pub(crate) fn spread(&mut self, reference: &Reference, centre: DVec2, ring: &[GridPoint], is_closed: bool) {
        self.centre = centre;
        self.curvature = reference.curvature_at(centre.y);
        self.is_closed = is_closed;
        self.sectors.clear();
        let curvature = self.curvature;
        let seen = |point: &GridPoint| {
            let offset = point.grid - centre;
            // A flat triangle hangs below the straight interpolation of its corners; it does not where these are dropped.
            (offset, point.height - curvature.dot(offset * offset))
        };
        let mut points = ring.iter().map(seen);
        let Some(start) = points.next() else { return };
        let mut before = start;
        for point in points.chain(is_closed.then_some(start)) {
            self.sectors.push(Sector::new([before.0, point.0], [before.1, point.1]));
            before = point;
        }
    }

    /// Constrains the centre's height by the samples under the fan. Stops as soon as no height is left.
    pub(crate) fn constrain(&self, samples: &[Sample], interval: &mut Interval) {
        let mut at = 0;
        for sample in samples {
            let Some(sector) = self.sector_of(sample, at) else { continue };
            at = sector;
            let (offset, sector) = (sample.at - self.centre, &self.sectors[sector]);
            let weight = 1.0 - sector.of_first.dot(offset) - sector.of_second.dot(offset);
            let target = sample.height - self.curvature.dot(offset * offset) - sector.given.dot(offset);
            interval.constrain(weight, target);
            interval.add_square(weight, target);
            if interval.is_empty() {
                return;
            }
        }
    }

    /// Number of the triangle that a sample lies in; `guess` is where to look first, since neighbours come together.
    #[inline]
    pub(crate) fn sector_of(&self, sample: &Sample, guess: usize) -> Option<usize> {
        let offset = sample.at - self.centre;
        let count = self.sectors.len();
        let mut at = guess;
        for _ in 0..count {
            let sector = &self.sectors[at];
            at = if sector.of_second.dot(offset) < sector.slack {
                if at > 0 { at - 1 } else if self.is_closed { count - 1 } else { break }
            } else if sector.of_first.dot(offset) < sector.slack {
                if at + 1 < count { at + 1 } else if self.is_closed { 0 } else { break }
            } else {
                return Some(at);
            };
        }
        self.sectors.iter().position(|sector| {
            sector.of_second.dot(offset) >= sector.slack && sector.of_first.dot(offset) >= sector.slack
        })
    }
}
