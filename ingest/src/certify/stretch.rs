//! Straight edges in space over a raster: parabolas, stretch by stretch.

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid;
use terrain_core::height_field::blocks::{Block, Relief};
use terrain_core::height_field::scan;

use super::place::Place;
use super::worst::Worst;
use crate::georeference::GeoReference;

/// Cells by which a straight edge in space may leave its parabola, or a parabola a straight line on the grid, before they are
/// cut.
const STRAIGHT: f64 = 1e-4;
/// Cells by which a part of a parabola that is looked for among blocks may leave the straight line.
const THIN: f64 = 0.25;
/// Cells that rounding may add to that.
const ROUNDING: f64 = 1e-6;
/// Halvings of an edge, at most: near a pole no parabola is close to it.
const HALVINGS: u32 = 24;
/// What terms beyond the second order may add to the summit of a difference inside a block, as a share.
const HIGHER_ORDER: f64 = 2.0;

/// Part of a straight edge in space, so short that it is a parabola over the grid: column, row and height are
/// `from + t (slope + t bend)`, with t from 0 to 1.
pub(super) struct Stretch {
    from: DVec3,
    slope: DVec3,
    bend: DVec3,
}

/// Cells by which an edge leaves the straight line on the grid.
pub(super) fn bulge(stretches: &[Stretch]) -> f64 {
    let [Some(first), Some(last)] = [stretches.first(), stretches.last()] else {
        return 0.0;
    };
    let (from, to) = (first.from.truncate(), last.at(1.0).truncate());
    let along = to - from;
    let beside = |at: DVec2| {
        let t = (at - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        at.distance(from + along * t.clamp(0.0, 1.0))
    };
    let places = stretches
        .iter()
        .flat_map(|stretch| [0.5, 1.0].map(|t| stretch.at(t).truncate()));
    places.map(beside).fold(0.0, f64::max)
}

impl Stretch {
    /// A whole edge. At a pole it runs along the other end's meridian.
    pub(super) fn all(georeference: &GeoReference, a: Place, b: Place) -> Vec<Self> {
        if a.space == b.space || a.is_pole && b.is_pole {
            return Vec::new();
        }
        let longitude = if a.is_pole { b.longitude } else { a.longitude };
        let seen = |t: f64| {
            let mut geodetic = ellipsoid::to_geodetic(a.space.lerp(b.space, t));
            geodetic.longitude += ((longitude - geodetic.longitude) / 360.0).round() * 360.0;
            let at = DVec2::new(geodetic.longitude, geodetic.latitude);
            (georeference.grid(at).extend(geodetic.height), geodetic.latitude)
        };
        let end = |place: Place, other: Place| {
            let column = if place.is_pole { other.grid.x } else { place.grid.x };
            DVec3::new(column, place.grid.y, place.height)
        };
        let mut stretches = Vec::new();
        let length = a.space.distance(b.space);
        // The last of those waiting is the next along the edge.
        let mut waiting = vec![(0.0, 1.0, end(a, b), end(b, a), 0)];
        while let Some((first, last, from, to, halvings)) = waiting.pop() {
            let half = (first + last) / 2.0;
            let (middle, latitude) = seen(half);
            let bulge = (middle - (from + to) / 2.0).truncate().abs().max_element();
            let distance_to_pole = ellipsoid::MEAN_RADIUS * latitude.to_radians().cos().max(1e-12);
            let beyond_parabola = bulge * length * (last - first) / distance_to_pole;
            if beyond_parabola <= STRAIGHT || halvings == HALVINGS {
                stretches.push(Self::through([from, middle, to]));
            } else {
                waiting.push((half, last, middle, to, halvings + 1));
                waiting.push((first, half, from, middle, halvings + 1));
            }
        }
        stretches
    }

    /// The parabola through its two ends and, between these, its middle.
    fn through([from, middle, to]: [DVec3; 3]) -> Self {
        let bend = 2.0 * (from - 2.0 * middle + to);
        let slope = to - from - bend;
        Self { from, slope, bend }
    }

    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.from + t * (self.slope + t * self.bend)
    }

    /// Cells by which it leaves the straight line between two parameters.
    fn bulge_between(&self, first: f64, last: f64) -> f64 {
        self.bend.truncate().length() * (last - first) * (last - first) / 4.0
    }

    /// Equal parts of the parameters between two, so that none is further from the straight line than that many cells.
    fn parts(&self, first: f64, last: f64, cells: f64) -> impl Iterator<Item = [f64; 2]> + use<> {
        let count = (self.bulge_between(first, last) / cells).sqrt().ceil().max(1.0);
        let at = move |number: usize| first + (last - first) * (number as f64 / count);
        (0..count as usize).map(move |number| [at(number), at(number + 1)])
    }

    /// Takes the differences from the surface into account.
    pub(super) fn meet(&self, relief: &Relief, worst: &Worst) {
        for [first, last] in self.parts(0.0, 1.0, THIN) {
            let [from, to] = [first, last].map(|t| self.at(t).truncate());
            let beside = self.bulge_between(first, last) + ROUNDING;
            let in_block = |block: &Block| {
                let low = block.first - beside;
                let high = block.first + block.side + beside;
                let within = |[start, end]: [f64; 2]| [start, end].map(|share| first + share * (last - first));
                clip(from, to, low, high).map(within)
            };
            let may_matter = |block: &Block| {
                in_block(block).is_some_and(|[start, end]| worst.is_worth_a_look(self.bound_in(block, start, end)))
            };
            relief.visit_blocks([from, to, to], beside, may_matter, |block| {
                if let Some([start, end]) = in_block(block) {
                    worst.meet(self.deviation_between(relief, start, end));
                }
            });
        }
    }

    /// What the difference inside a block is at most.
    fn bound_in(&self, block: &Block, start: f64, end: f64) -> f64 {
        let [first, middle, last] = [start, (start + end) / 2.0, end].map(|t| {
            let at = self.at(t);
            block.height(at.truncate()) - at.z
        });
        let bend = HIGHER_ORDER * (first - 2.0 * middle + last).abs() / 8.0;
        let greatest = first.max(middle).max(last) + bend + block.residual[1];
        let least = first.min(middle).min(last) - bend + block.residual[0];
        greatest.max(-least)
    }

    /// The largest difference between two parameters, cell by cell.
    fn deviation_between(&self, relief: &Relief, start: f64, end: f64) -> f64 {
        let mut worst: f64 = 0.0;
        for [first, last] in self.parts(start, end, STRAIGHT) {
            let [from, to] = [first, last].map(|t| self.at(t).truncate());
            scan::visit_cells(from, to, |start, end| {
                let [start, end] = [start, end].map(|share| first + share * (last - first));
                worst = worst.max(self.deviation_in_cell(relief, start, end));
            });
        }
        worst
    }

    /// The largest difference between two parameters inside one cell; nothing where that is void.
    fn deviation_in_cell(&self, relief: &Relief, first: f64, last: f64) -> f64 {
        let middle = (first + last) / 2.0;
        let Some((corner, patch)) = relief.cell(self.at(middle).truncate()) else {
            return 0.0;
        };
        let cell = Block {
            first: DVec2::new(corner[0] as f64, corner[1] as f64),
            side: 1.0,
            patch,
            residual: [0.0; 2],
            is_sampled: true,
        };
        let difference = |t: f64| {
            let at = self.at(t);
            at.z - cell.height(at.truncate())
        };
        let [at_first, at_middle, at_last] = [first, middle, last].map(difference);
        let worst = at_first.abs().max(at_middle.abs()).max(at_last.abs());
        let bend = at_first - 2.0 * at_middle + at_last;
        let summit = (at_first - at_last) / (4.0 * bend);
        if bend == 0.0 || summit.abs() >= 0.5 {
            return worst;
        }
        worst.max(difference(middle + summit * (last - first)).abs())
    }
}

/// The part of the line `from → to`, as parameters, that is in a rectangle.
fn clip(from: DVec2, to: DVec2, low: DVec2, high: DVec2) -> Option<[f64; 2]> {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let step = to[axis] - from[axis];
        if step == 0.0 {
            if from[axis] < low[axis] || from[axis] > high[axis] {
                return None;
            }
            continue;
        }
        let [enter, leave] = [low[axis], high[axis]].map(|line| (line - from[axis]) / step);
        start = start.max(enter.min(leave));
        end = end.min(enter.max(leave));
    }
    (start <= end).then_some([start, end])
}
