//! The triangles around one vertex as seen from it: where a sample lies, and what the vertex's height does there.
//!
//! ```text
//!          v                    d = sample − centre;  weights of u, v and the centre over `area`:
//!         ╱│                    first  = d × v
//!        ╱ │                    second = u × d
//!       ╱ ·d                    area − first − second
//!  centre──u
//! ```
//! All is multiplied by the triangle's area, so that only the height itself needs a division.

use glam::DVec2;

use crate::interval::Interval;
use crate::reference::{GridPoint, ON_A_LINE, Reference};
use crate::samples::Sample;

/// Triangles around a centre of unknown height, counter-clockwise in plan. Positions are offsets from the centre on the
/// grid, mirrored where the grid is against the plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fan {
    centre: DVec2,
    curvature: DVec2,
    /// (±1, 1)
    mirror: DVec2,
    /// Outer corners; in a closed fan the first is there again at the end.
    corners: Vec<Corner>,
    is_closed: bool,
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    offset: DVec2,
    /// Metres. A flat triangle hangs below the straight interpolation of its corners; it does not where these are dropped
    /// by the sagitta.
    height: f64,
    /// Of the triangle with the next corner, doubled.
    area: f64,
}

/// A sample's triangle, and the weights of its outer corners times its area.
#[derive(Clone, Copy)]
struct Seat {
    sector: usize,
    first: f64,
    second: f64,
}

impl Fan {
    /// Spreads the fan from `centre` over the points of `ring`: a triangle from each to the next and, if it `is_closed`,
    /// from the last to the first. Tells whether all are counter-clockwise on the grid; where a map projection bends long
    /// straight lines, a triangle that is in plan may not be, and no sample is seen in it.
    pub(crate) fn spread(&mut self, reference: &Reference, centre: DVec2, ring: &[GridPoint], is_closed: bool) -> bool {
        self.centre = centre;
        self.curvature = reference.curvature_at(centre.y);
        self.mirror = DVec2::new(reference.plan.handedness(), 1.0);
        self.is_closed = is_closed;
        self.corners.clear();
        let mut is_upright = true;
        for point in ring.iter().chain(ring.first().filter(|_| is_closed)) {
            let offset = (point.grid - centre) * self.mirror;
            if let Some(before) = self.corners.last_mut() {
                before.area = before.offset.perp_dot(offset);
                is_upright &= before.area > 0.0;
            }
            let height = point.height - self.curvature.dot(offset * offset);
            self.corners.push(Corner {
                offset,
                height,
                area: 0.0,
            });
        }
        is_upright
    }

    /// Constrains the centre's height by samples, those under the fan, and tells whether all looked at were. Where no height
    /// is left the sample at fault comes first from then on: it will be at fault again for a centre next to this one.
    pub(crate) fn constrain(&self, samples: &mut [Sample], interval: &mut Interval) -> bool {
        let mut guess = 0;
        let mut is_whole = true;
        for index in 0..samples.len() {
            let offset = (samples[index].at - self.centre) * self.mirror;
            let Some(seat) = self.seat(offset, guess) else {
                is_whole = false;
                continue;
            };
            guess = seat.sector;
            let (weight, target, area) = self.scaled(&seat, offset, samples[index].height);
            interval.constrain(weight, target, area);
            if interval.is_empty() {
                samples.swap(0, index);
                break;
            }
        }
        is_whole
    }

    /// Lets samples count in the least squares.
    pub(crate) fn add_squares(&self, samples: &[Sample], interval: &mut Interval) {
        let mut guess = 0;
        for sample in samples {
            let offset = (sample.at - self.centre) * self.mirror;
            if let Some(seat) = self.seat(offset, guess) {
                guess = seat.sector;
                let (weight, target, area) = self.scaled(&seat, offset, sample.height);
                interval.add_square(weight / area, target / area);
            }
        }
    }

    /// Number of the triangle that a sample lies in; `guess` is where to look first, since neighbours come together.
    pub(crate) fn sector_of(&self, sample: &Sample, guess: usize) -> Option<usize> {
        self.seat((sample.at - self.centre) * self.mirror, guess)
            .map(|seat| seat.sector)
    }

    /// The centre's weight and the height that a centre at 0 leaves to be reached, both times the area, and the area.
    #[inline(always)]
    fn scaled(&self, seat: &Seat, offset: DVec2, height: f64) -> (f64, f64, f64) {
        let &Seat { sector, first, second } = seat;
        let (u, v) = (&self.corners[sector], &self.corners[sector + 1]);
        let dropped = height - self.curvature.dot(offset * offset);
        (
            u.area - first - second,
            dropped * u.area - first * u.height - second * v.height,
            u.area,
        )
    }

    #[inline(always)]
    fn seat(&self, offset: DVec2, guess: usize) -> Option<Seat> {
        let count = self.corners.len() - 1;
        let mut sector = guess;
        for _ in 0..count {
            let second = self.corners[sector].offset.perp_dot(offset);
            let first = offset.perp_dot(self.corners[sector + 1].offset);
            if second < 0.0 {
                sector = if sector > 0 { sector } else { count } - 1;
            } else if first < 0.0 {
                sector = if sector + 1 < count { sector + 1 } else { 0 };
            } else if self.corners[sector].area > 0.0 {
                return Some(Seat { sector, first, second });
            } else {
                break;
            }
        }
        self.nearest_seat(offset)
    }

    /// The triangle that a point is least outside of, where rounding or the bend of a map projection puts it beside its
    /// own; none if it is further off, and nothing else is there.
    #[cold]
    fn nearest_seat(&self, offset: DVec2) -> Option<Seat> {
        let outside = |seat: &Seat| {
            let reach = |corner: usize| ON_A_LINE * self.corners[corner].offset.abs().element_sum();
            (-seat.second - reach(seat.sector)).max(-seat.first - reach(seat.sector + 1))
        };
        let upright = (0..self.corners.len() - 1).filter(|&sector| self.corners[sector].area > 0.0);
        let seats = upright.map(|sector| Seat {
            sector,
            first: offset.perp_dot(self.corners[sector + 1].offset),
            second: self.corners[sector].offset.perp_dot(offset),
        });
        let nearest = seats.min_by(|a, b| outside(a).total_cmp(&outside(b)))?;
        (self.is_closed || outside(&nearest) <= 0.0).then_some(nearest)
    }
}
