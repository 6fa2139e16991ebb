//! The triangles around one vertex as seen from it: where a sample lies, and what the vertex's height does there.
//!
//! ```text
//!          v        d = sample − centre, in the triangle while  u × d ≥ 0 and d × v ≥ 0
//!         ╱│        its height where the centre's is h:  h · (1 − fall · d) + slope · d
//!        ╱ │        fall   = gradient of the weight of u and v together
//!       ╱ ·d        slope  = gradient of what they contribute
//!  centre──u
//! ```

use glam::DVec2;

use crate::height_field::interval::Interval;
use crate::height_field::reference::{GridPoint, Reference};
use crate::height_field::samples::Sample;
use crate::height_field::scan::ON_A_LINE;

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

/// An outer corner, and the triangle to the next one.
#[derive(Clone, Copy, Debug)]
struct Corner {
    offset: DVec2,
    /// Metres. A flat triangle hangs below the straight interpolation of its corners; it does not where these are dropped
    /// by the sagitta.
    height: f64,
    /// Doubled.
    area: f64,
    /// Found when a sample asks for it: most fans are done with at their first samples.
    gradients: Option<Gradients>,
}

/// How a triangle changes with the offset from the centre.
#[derive(Clone, Copy, Debug)]
struct Gradients {
    /// By which the centre's weight falls, from 1 at the centre.
    fall: DVec2,
    /// Of the height, where the centre's is 0.
    slope: DVec2,
}

impl Gradients {
    fn new(from: &Corner, to: &Corner) -> Self {
        let per_area = 1.0 / from.area;
        let first = to.offset.perp() * -per_area;
        let second = from.offset.perp() * per_area;
        Self {
            fall: first + second,
            slope: first * from.height + second * to.height,
        }
    }
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
            let corner = Corner {
                offset,
                height: point.height - self.curvature.dot(offset * offset),
                area: 0.0,
                gradients: None,
            };
            if let Some(before) = self.corners.last_mut() {
                before.area = before.offset.perp_dot(offset);
                is_upright &= before.area > 0.0;
            }
            self.corners.push(corner);
        }
        is_upright
    }

    /// Constrains the centre's height by samples, those under the fan, and lets them count in the least squares; tells whether
    /// all looked at were under it. Where no height is left the sample at fault comes first from then on: it will be at fault
    /// again for a centre next to this one.
    pub(crate) fn constrain(&mut self, samples: &mut [Sample], interval: &mut Interval) -> bool {
        let mut guess = 0;
        let mut is_whole = true;
        for index in 0..samples.len() {
            let offset = (samples[index].at - self.centre) * self.mirror;
            let Some(sector) = self.sector(offset, guess) else {
                is_whole = false;
                continue;
            };
            guess = sector;
            let Gradients { fall, slope } = self.gradients(sector);
            let weight = 1.0 - fall.dot(offset);
            let target = samples[index].height - self.curvature.dot(offset * offset) - slope.dot(offset);
            interval.constrain(weight, target);
            interval.add_square(weight, target);
            if interval.is_empty() {
                samples.swap(0, index);
                break;
            }
        }
        is_whole
    }

    /// Number of the triangle that a sample lies in; `guess` is where to look first, since neighbours come together.
    pub(crate) fn sector_of(&self, sample: &Sample, guess: usize) -> Option<usize> {
        self.sector((sample.at - self.centre) * self.mirror, guess)
    }

    #[inline(always)]
    fn gradients(&mut self, sector: usize) -> Gradients {
        if let Some(known) = self.corners[sector].gradients {
            return known;
        }
        let found = Gradients::new(&self.corners[sector], &self.corners[sector + 1]);
        self.corners[sector].gradients = Some(found);
        found
    }

    #[inline(always)]
    fn sector(&self, offset: DVec2, guess: usize) -> Option<usize> {
        let count = self.corners.len() - 1;
        let mut sector = guess;
        for _ in 0..count {
            if self.corners[sector].offset.perp_dot(offset) < 0.0 {
                sector = if sector > 0 { sector } else { count } - 1;
            } else if offset.perp_dot(self.corners[sector + 1].offset) < 0.0 {
                sector = if sector + 1 < count { sector + 1 } else { 0 };
            } else if self.corners[sector].area > 0.0 {
                return Some(sector);
            } else {
                break;
            }
        }
        self.nearest_sector(offset)
    }

    /// The triangle that a point is least outside of, where rounding or the bend of a map projection puts it beside its
    /// own; none if it is further off, and nothing else is there.
    #[cold]
    fn nearest_sector(&self, offset: DVec2) -> Option<usize> {
        let reach = |corner: &Corner| ON_A_LINE * corner.offset.abs().element_sum();
        let outside = |sector: usize| {
            let [from, to] = [&self.corners[sector], &self.corners[sector + 1]];
            let [before, after] = [from.offset.perp_dot(offset), offset.perp_dot(to.offset)];
            (-before - reach(from)).max(-after - reach(to))
        };
        let upright = (0..self.corners.len() - 1).filter(|&sector| self.corners[sector].area > 0.0);
        let nearest = upright.min_by(|&a, &b| outside(a).total_cmp(&outside(b)))?;
        (self.is_closed || outside(nearest) <= 0.0).then_some(nearest)
    }
}
