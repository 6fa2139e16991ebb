//! One vertex split in bits: where the star opens, where the new vertex is and where the old one was.
//!
//! ```text
//! side      which part of an open star goes over                      only on the boundary
//!           whether a closed star opens into a hole, and at which cut  only where any does
//! blue      its plan, then the difference of its height from the star's triangles there
//! red       whether and how it moves back, its height                 not before the first level is complete
//! cuts      the rank of each among the neighbours, by the angle under which they see the edge from red to blue
//! ```

use glam::DVec3;

use super::number::{NumberModel, SIGNS, code_symbol};
use super::plan_model::{Expected, Known, PlanModel};
use super::range_coder::{Coder, Probability};
use super::ring::{Cuts, Ring, Side};
use super::sampling::{Fit, Sampling};
use super::star::{Axes, along, height_at, misfits, nearest, turn};
use super::surface::Vertex;

/// Ranks that have statistics of their own.
const RANKS: usize = 8;
/// By how much the cotangent of the next neighbour must be larger to count as clearly worse, more clearly …
const LEADS: [f64; 6] = [0.25, 0.5, 1.0, 2.0, 5.0, 1e20];
/// Share of the latest difference in what is remembered of those around a vertex.
const NEWS: f64 = 0.6;
/// Share of a vertex's own differences in what is expected of the next; the rest is its neighbours'.
const OWN: f64 = 0.3;
/// How much of what was expected and of what was found for blue is expected for red.
const RED_SHARE: f64 = 0.4;
/// Of [`SIGNS`], the one that says nothing of a sign.
const NO_SIGN: usize = (SIGNS - 1) / 2;

/// A vertex split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Split {
    pub(super) cuts: Cuts,
    /// Where the new vertex is.
    pub(super) blue: DVec3,
    /// Where the other one is from now on.
    pub(super) red: DVec3,
}

/// What splits looked like so far.
#[derive(Debug)]
pub(super) struct SplitModel {
    is_height_field: bool,
    opens_holes: bool,
    sides: [Probability; 4],
    holes: [Probability; 2],
    is_hole_second: Probability,
    plan: PlanModel,
    heights: [NumberModel; 2],
    red: RedModel,
    ranks: [[[Probability; LEADS.len() + 1]; RANKS]; 2],
    /// How ill each neighbour fits the first cut, and the second; infinitely where it cannot be it.
    misfits: [Vec<f64>; 2],
}

/// How the old vertex moves.
#[derive(Debug, Default)]
struct RedModel {
    moves: Probability,
    is_midway: Probability,
    rounds: [Probability; 2],
    distances: NumberModel,
    heights: [NumberModel; 2],
}

impl SplitModel {
    pub(super) fn new(is_height_field: bool, sampling: Option<Sampling>, opens_holes: bool) -> Self {
        Self {
            is_height_field,
            opens_holes,
            sides: Default::default(),
            holes: Default::default(),
            is_hole_second: Probability::default(),
            plan: PlanModel::new(sampling),
            heights: Default::default(),
            red: RedModel::default(),
            ranks: Default::default(),
            misfits: Default::default(),
        }
    }

    /// A vertex at a place, of which nothing else is known.
    pub(super) fn vertex(&self, position: DVec3) -> Vertex {
        Vertex::new(position, self.plan.fit(0, position.x))
    }

    /// Codes the split of a vertex that stays where it is if it is still; tells it as it is afterwards, the new one, and the cuts.
    pub(super) fn code(
        &mut self,
        coder: &mut impl Coder,
        red: &mut Vertex,
        ring: &mut Ring,
        is_still: bool,
        told: Split,
    ) -> (Vertex, Cuts) {
        let axes = if self.is_height_field { Axes::PLAN } else { turn(ring) };
        let centre = axes.ordered(red.position);
        let side = self.code_side(coder, ring, is_still, told.cuts.side);
        let (mut place, height, fit) =
            self.code_plan(coder, ring, side, axes, (centre, red.fit), axes.ordered(told.blue));
        let expected = red.roughness * OWN + ring.roughness / ring.spokes.len() as f64 * (1.0 - OWN);
        let model = &mut self.heights[usize::from(is_still)];
        let difference = model.code(coder, expected, NO_SIGN, axes.ordered(told.blue).z - height);
        place.z = height + difference;
        red.roughness += (difference.abs() - red.roughness) * NEWS;
        let mut blue = Vertex::new(axes.restored(place), fit);
        blue.roughness = red.roughness;
        let mut end = centre;
        if !is_still {
            let expected = red.roughness * RED_SHARE + difference.abs() * RED_SHARE;
            end = self
                .red
                .code(coder, centre, place, [expected, difference], axes.ordered(told.red));
            if end.x != centre.x {
                red.fit = self.plan.fit(0, end.x);
            }
            red.position = axes.restored(end);
        }
        let cuts = self.code_cuts(coder, ring, [end - centre, place - centre], Cuts { side, ..told.cuts });
        (blue, cuts)
    }

    fn code_side(&mut self, coder: &mut impl Coder, ring: &Ring, is_still: bool, told: Side) -> Side {
        if !ring.is_closed() {
            return Side::OF_BOUNDARY[code_symbol(coder, &mut self.sides, told as usize)];
        }
        let opens_hole = self.opens_holes && coder.bit(&mut self.holes[usize::from(is_still)], told.opens_hole());
        if !opens_hole {
            Side::Inner
        } else if coder.bit(&mut self.is_hole_second, told == Side::HoleSecond) {
            Side::HoleSecond
        } else {
            Side::HoleFirst
        }
    }

    /// Codes blue's place in plan; tells it, the height of the star's triangles there, and how its first coordinate fits.
    fn code_plan(
        &mut self,
        coder: &mut impl Coder,
        ring: &Ring,
        side: Side,
        axes: Axes,
        (centre, fit): (DVec3, Fit),
        told: DVec3,
    ) -> (DVec3, f64, Fit) {
        let is_along = matches!(side, Side::Front | Side::Back);
        let [expected, otherwise] = expected_plan(ring, side, axes);
        let known = Known {
            axis: 0,
            is_along,
            fit,
            from: centre.x,
            expected,
        };
        let (x, x_fit) = self.plan.code(coder, known, told.x);
        let known = Known {
            axis: 1,
            is_along,
            fit: x_fit,
            from: centre.y,
            expected: if is_along {
                None
            } else {
                expected_ahead(ring, x - centre.x)
            }
            .unwrap_or(otherwise),
        };
        let (y, _) = self.plan.code(coder, known, told.y);
        let blue = DVec3::new(x, y, centre.z);
        let height = centre.z + nearest(height_at(ring, side, blue - centre));
        (blue, height, if x_fit == Fit::Same { fit } else { x_fit })
    }

    fn code_cuts(&mut self, coder: &mut impl Coder, ring: &Ring, [red, blue]: [DVec3; 2], told: Cuts) -> Cuts {
        let mut cuts = Cuts {
            side: told.side,
            ..Cuts::default()
        };
        let edge = if told.side == Side::Outer {
            [blue, red]
        } else {
            [red, blue]
        };
        self.measure(ring, edge);
        if told.side.has_first_cut() {
            cuts.first = self.code_cut(coder, 0, ring.spokes.len(), told.first);
        }
        if told.side.has_second_cut() {
            let left = self.leave_to_second(cuts, ring.is_closed());
            cuts.second = self.code_cut(coder, 1, left, told.second);
        }
        cuts
    }

    /// Finds how well the star can be cut at each neighbour.
    fn measure(&mut self, ring: &Ring, edge: [DVec3; 2]) {
        let [firsts, seconds] = &mut self.misfits;
        firsts.clear();
        seconds.clear();
        for spoke in &ring.spokes {
            let [first, second] = misfits(spoke.to, edge);
            firsts.push(first);
            seconds.push(second);
        }
    }

    /// Takes those that the first cut rules out from the candidates for the second; tells how many are left.
    fn leave_to_second(&mut self, cuts: Cuts, is_closed: bool) -> usize {
        let seconds = &mut self.misfits[1];
        let ruled_out = match cuts.side {
            Side::Front | Side::Back => 0..0,
            _ if is_closed => cuts.first..cuts.first + 1,
            _ => 0..cuts.first + 1,
        };
        let left = seconds.len() - ruled_out.len();
        seconds[ruled_out].fill(f64::INFINITY);
        left
    }

    /// Codes how many of the candidates fit better than the one at which the star is cut.
    fn code_cut(&mut self, coder: &mut impl Coder, which: usize, candidates: usize, told: usize) -> usize {
        let misfits = &mut self.misfits[which];
        for rank in 0..candidates.saturating_sub(1) {
            let (best, lead) = least(misfits);
            let clarity = LEADS.iter().map(|&least| usize::from(lead > least)).sum::<usize>();
            let probability = &mut self.ranks[which][rank.min(RANKS - 1)][clarity];
            if coder.bit(probability, best == told) {
                return best;
            }
            misfits[best] = f64::INFINITY;
        }
        least(misfits).0
    }
}

/// Place of the smallest misfit, and by how much the next one's is larger.
fn least(misfits: &[f64]) -> (usize, f64) {
    let (mut best, mut least, mut next) = (0, f64::INFINITY, f64::INFINITY);
    for (place, &misfit) in misfits.iter().enumerate() {
        let is_better = misfit < least;
        let worse = if is_better { least } else { misfit };
        next = if worse < next { worse } else { next };
        least = if is_better { misfit } else { least };
        best = if is_better { place } else { best };
    }
    (best, next - least)
}

/// What the star says of how far the new vertex is, along each axis of the plan: all of it, or the edge along the boundary.
fn expected_plan(ring: &Ring, side: Side, axes: Axes) -> [Expected; 2] {
    if let Some(spoke) = along(ring, side) {
        return [spoke.x, spoke.y].map(|coordinate| Expected::of(1.0, coordinate, coordinate.abs()));
    }
    let count = ring.spokes.len() as f64;
    let (sum, sizes) = (axes.ordered(ring.sum), axes.ordered(ring.sizes));
    [Expected::of(count, sum.x, sizes.x), Expected::of(count, sum.y, sizes.y)]
}

/// What those neighbours say of the second coordinate that are on the side where the first is; none if there are none.
fn expected_ahead(ring: &Ring, ahead: f64) -> Option<Expected> {
    let (mut count, mut sum, mut sizes) = (0.0, 0.0, 0.0);
    for spoke in &ring.spokes {
        let share = if spoke.to.x * ahead > 0.0 { 1.0 } else { 0.0 };
        count += share;
        sum += share * spoke.to.y;
        sizes += share * spoke.to.y.abs();
    }
    (count > 0.0).then(|| Expected::of(count, sum, sizes))
}

impl RedModel {
    /// Codes where the old vertex was: at its place, as far on the other side of it as blue, or anywhere. `expected` is how much its
    /// height changes, `difference` how blue's differed.
    fn code(
        &mut self,
        coder: &mut impl Coder,
        centre: DVec3,
        blue: DVec3,
        [expected, difference]: [f64; 2],
        told: DVec3,
    ) -> DVec3 {
        let moves = coder.bit(&mut self.moves, told.x != centre.x || told.y != centre.y);
        let mut red = if moves {
            self.code_move(coder, centre, blue, told)
        } else {
            centre
        };
        let sign = match difference {
            _ if difference < 0.0 => 1,
            _ if difference > 0.0 => 2,
            _ => NO_SIGN,
        };
        red.z += self.heights[usize::from(moves)].code(coder, expected, sign, told.z - red.z);
        red
    }

    fn code_move(&mut self, coder: &mut impl Coder, centre: DVec3, blue: DVec3, told: DVec3) -> DVec3 {
        let midway = 2.0 * centre - blue;
        let rounding = midway - told;
        let is_rounding = |number: f64| number == 0.0 || number == 1.0;
        let mut red = centre;
        if coder.bit(&mut self.is_midway, is_rounding(rounding.x) && is_rounding(rounding.y)) {
            let rounds = [0, 1].map(|axis| coder.bit(&mut self.rounds[axis], rounding[axis] == 1.0));
            red.x = midway.x - f64::from(u8::from(rounds[0]));
            red.y = midway.y - f64::from(u8::from(rounds[1]));
            red.z = midway.z;
        } else {
            red.x += self
                .distances
                .code(coder, (blue.x - centre.x).abs(), NO_SIGN, told.x - centre.x);
            red.y += self
                .distances
                .code(coder, (blue.y - centre.y).abs(), NO_SIGN, told.y - centre.y);
        }
        red
    }
}
