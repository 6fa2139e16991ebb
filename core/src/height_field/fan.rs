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

use crate::height_field::flat::{self, GridPoint};
use crate::height_field::interval::Interval;
use crate::height_field::reference::Reference;
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
    /// One triangle after the other.
    sectors: Vec<Sector>,
    is_closed: bool,
}

/// How a fan lies on the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    /// Whether all its triangles are counter-clockwise there.
    pub(crate) is_upright: bool,
    /// Metres, seen from above, by which one that is not lies over others.
    pub(crate) fold: f64,
}

/// A triangle from the centre over two outer corners.
#[derive(Clone, Copy, Debug)]
struct Sector {
    from: Corner,
    to: Corner,
    /// Doubled.
    area: f64,
    /// Found when a sample asks for it: most fans are done with at their first samples.
    gradients: Option<Gradients>,
}

/// An outer corner.
#[derive(Clone, Copy, Debug)]
struct Corner {
    offset: DVec2,
    /// Metres. A flat triangle hangs below the straight interpolation of its corners; it does not where these are dropped
    /// by the sagitta.
    height: f64,
}

/// How a triangle changes with the offset from the centre.
#[derive(Clone, Copy, Debug)]
struct Gradients {
    /// By which the centre's weight falls, from 1 at the centre.
    fall: DVec2,
    /// Of the height, where the centre's is 0.
    slope: DVec2,
}

impl Sector {
    #[inline(always)]
    fn holds(&self, offset: DVec2) -> bool {
        self.from.offset.perp_dot(offset) >= 0.0 && offset.perp_dot(self.to.offset) >= 0.0 && self.area > 0.0
    }
}

impl Gradients {
    fn new(sector: &Sector) -> Self {
        let Sector { from, to, area, .. } = sector;
        let per_area = 1.0 / area;
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
    /// from the last to the first. Tells whether all are counter-clockwise on the grid, and how far they are folded if not; where a
    /// map projection bends long straight lines, a triangle that is in plan may not be, and no sample is seen in it.
    pub(crate) fn spread(
        &mut self,
        reference: &Reference,
        centre: DVec2,
        ring: &[GridPoint],
        is_closed: bool,
    ) -> Spread {
        self.centre = centre;
        self.curvature = reference.curvature_at(centre.y);
        self.mirror = DVec2::new(reference.plan.handedness(), 1.0);
        self.is_closed = is_closed;
        self.sectors.clear();
        let (mut is_upright, mut cells) = (true, 0.0_f64);
        let mut before: Option<Corner> = None;
        for point in ring.iter().chain(ring.first().filter(|_| is_closed)) {
            let offset = (point.grid - centre) * self.mirror;
            let to = Corner {
                offset,
                height: point.height - self.curvature.dot(offset * offset),
            };
            if let Some(from) = before.replace(to) {
                let area = from.offset.perp_dot(to.offset);
                if area <= 0.0 {
                    is_upright = false;
                    cells = cells.max(flat::altitude([DVec2::ZERO, from.offset, offset]));
                }
                self.sectors.push(Sector {
                    from,
                    to,
                    area,
                    gradients: None,
                });
            }
        }
        Spread {
            is_upright,
            fold: if is_upright {
                0.0
            } else {
                cells * reference.cell_at(centre.y)
            },
        }
    }

    /// Constrains the centre's height by samples, those under the fan, and lets them count in the least squares; tells whether
    /// all looked at were under it. Where no height is left the two samples at fault come first from then on: they will be at fault
    /// again for a centre next to this one.
    pub(crate) fn constrain(&mut self, samples: &mut [Sample], interval: &mut Interval) -> bool {
        if self.sectors.is_empty() {
            return samples.is_empty();
        }
        let (mut place, mut sector, mut gradients) = (0, self.sectors[0], self.gradients(0));
        let (mut seen, mut limits, mut last) = (*interval, [0; 2], None);
        let mut is_whole = true;
        for (index, sample) in samples.iter().enumerate() {
            let offset = (sample.at - self.centre) * self.mirror;
            if !sector.holds(offset) {
                let Some(found) = self.sector(offset, place) else {
                    is_whole = false;
                    continue;
                };
                (place, sector, gradients) = (found, self.sectors[found], self.gradients(found));
            }
            let weight = 1.0 - gradients.fall.dot(offset);
            let target = sample.height - (self.curvature * offset + gradients.slope).dot(offset);
            let tightens = seen.constrain(weight, target);
            seen.add_square(weight, target);
            for (limit, tightens) in limits.iter_mut().zip(tightens) {
                *limit = if tightens { index } else { *limit };
            }
            if seen.is_empty() {
                last = Some(index);
                break;
            }
        }
        *interval = seen;
        if let Some(last) = last {
            // The last is one of the two.
            let other = if limits[0] == last { limits[1] } else { limits[0] };
            samples.swap(1.min(last), other);
            samples.swap(0, last);
        }
        is_whole
    }

    /// Number of the triangle that a sample lies in; `guess` is where to look first, since neighbours come together.
    pub(crate) fn sector_of(&self, sample: &Sample, guess: usize) -> Option<usize> {
        self.sector((sample.at - self.centre) * self.mirror, guess)
    }

    #[inline(always)]
    fn gradients(&mut self, place: usize) -> Gradients {
        let sector = &mut self.sectors[place];
        match sector.gradients {
            Some(known) => known,
            None => *sector.gradients.insert(Gradients::new(sector)),
        }
    }

    #[inline(always)]
    fn sector(&self, offset: DVec2, guess: usize) -> Option<usize> {
        let count = self.sectors.len();
        let mut place = guess;
        for _ in 0..count {
            let sector = &self.sectors[place];
            if sector.from.offset.perp_dot(offset) < 0.0 {
                place = if place > 0 { place } else { count } - 1;
            } else if offset.perp_dot(sector.to.offset) < 0.0 {
                place = if place + 1 < count { place + 1 } else { 0 };
            } else if sector.area > 0.0 {
                return Some(place);
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
        let outside = |place: usize| {
            let Sector { from, to, .. } = &self.sectors[place];
            let [before, after] = [from.offset.perp_dot(offset), offset.perp_dot(to.offset)];
            (-before - reach(from)).max(-after - reach(to))
        };
        let upright = (0..self.sectors.len()).filter(|&place| self.sectors[place].area > 0.0);
        let nearest = upright.min_by(|&a, &b| outside(a).total_cmp(&outside(b)))?;
        (self.is_closed || outside(nearest) <= 0.0).then_some(nearest)
    }
}
