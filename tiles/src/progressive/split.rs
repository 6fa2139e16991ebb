//! One vertex split in bits: where the star opens, where the new vertex is and where the old one was.
//!
//! ```text
//! side      which part of an open star goes over                      only on the boundary
//! blue      its plan, then the difference of its height from the star's triangles there
//! red       whether and how it moves back, its height                 not before the first level is complete
//! cuts      the rank of each among the neighbours, by the angle under which they see the edge from red to blue
//! ```

use glam::DVec3;

use super::number::{NumberModel, SIGNS, code_symbol};
use super::plan_model::{Expected, Known, PlanModel};
use super::range_coder::{Coder, Probability};
use super::sampling::Sampling;
use super::star::{Axes, Star, is_candidate};
use super::surface::{Cuts, Ring, Side, Surface};

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

/// A star that is about to split.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) surface: &'a Surface,
    pub(super) vertex: u32,
    pub(super) ring: &'a Ring,
    /// Whether the vertex stays where it is.
    pub(super) is_still: bool,
}

/// What splits looked like so far.
#[derive(Debug)]
pub(super) struct SplitModel {
    is_height_field: bool,
    sides: [Probability; 4],
    plan: PlanModel,
    heights: [NumberModel; 2],
    red: RedModel,
    ranks: [[[Probability; LEADS.len() + 1]; RANKS]; 2],
    /// What height differences around each vertex were like.
    roughness: Vec<f64>,
    star: Star,
    candidates: Vec<(f64, usize)>,
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
    pub(super) fn new(is_height_field: bool, sampling: Option<Sampling>, vertex_count: usize) -> Self {
        Self {
            is_height_field,
            sides: Default::default(),
            plan: PlanModel::new(sampling),
            heights: Default::default(),
            red: RedModel::default(),
            ranks: Default::default(),
            roughness: vec![0.0; vertex_count],
            star: Star::default(),
            candidates: Vec::new(),
        }
    }

    /// Codes the split of a vertex.
    pub(super) fn code(&mut self, coder: &mut impl Coder, place: Place, told: Split) -> Split {
        let Place {
            surface, vertex, ring, ..
        } = place;
        self.star.gather(surface, vertex, ring);
        let axes = if self.is_height_field {
            Axes::PLAN
        } else {
            self.star.turn()
        };
        let centre = axes.ordered(surface.positions[vertex as usize]);
        let side = self.code_side(coder, ring, told.cuts.side);
        let (mut blue, height) = self.code_plan(coder, side, centre, axes.ordered(told.blue));
        let expected = self.expected_difference(vertex, ring);
        let model = &mut self.heights[usize::from(place.is_still)];
        let difference = model.code(coder, expected, NO_SIGN, axes.ordered(told.blue).z - height);
        blue.z = height + difference;
        let roughness = &mut self.roughness[vertex as usize];
        *roughness += (difference.abs() - *roughness) * NEWS;
        let roughness = *roughness;
        self.roughness.push(roughness);
        let mut red = centre;
        if !place.is_still {
            let expected = roughness * RED_SHARE + difference.abs() * RED_SHARE;
            red = self
                .red
                .code(coder, centre, blue, [expected, difference], axes.ordered(told.red));
        }
        let cuts = self.code_cuts(coder, ring, [red - centre, blue - centre], Cuts { side, ..told.cuts });
        Split {
            cuts,
            blue: axes.restored(blue),
            red: axes.restored(red),
        }
    }

    fn code_side(&mut self, coder: &mut impl Coder, ring: &Ring, told: Side) -> Side {
        if ring.is_closed() {
            return Side::Inner;
        }
        Side::ALL[code_symbol(coder, &mut self.sides, told as usize)]
    }

    /// Codes blue's place in plan; tells it and the height of the star's triangles there.
    fn code_plan(&mut self, coder: &mut impl Coder, side: Side, centre: DVec3, told: DVec3) -> (DVec3, f64) {
        let spokes = self.star.toward(side);
        let is_along = matches!(side, Side::Front | Side::Back);
        let nowhere = Expected::default();
        let known = Known {
            axis: 0,
            is_along,
            fit: self.plan.fit(0, centre.x),
            from: centre.x,
            expected: Expected::of(spokes.iter().map(|spoke| spoke.x)).unwrap_or(nowhere),
        };
        let (x, fit) = self.plan.code(coder, known, told.x);
        let ahead = x - centre.x;
        let on_that_side = spokes.iter().filter(|spoke| spoke.x * ahead > 0.0).map(|spoke| spoke.y);
        let known = Known {
            axis: 1,
            is_along,
            fit,
            from: centre.y,
            expected: Expected::of(on_that_side)
                .or_else(|| Expected::of(spokes.iter().map(|spoke| spoke.y)))
                .unwrap_or(nowhere),
        };
        let (y, _) = self.plan.code(coder, known, told.y);
        let blue = DVec3::new(x, y, centre.z);
        let height = centre.z + (self.star.height_at(side, blue - centre) + 0.5).floor();
        (blue, height)
    }

    fn expected_difference(&self, vertex: u32, ring: &Ring) -> f64 {
        let neighbours = ring
            .vertices
            .iter()
            .map(|&neighbour| self.roughness[neighbour as usize]);
        let around = neighbours.sum::<f64>() / ring.vertices.len() as f64;
        self.roughness[vertex as usize] * OWN + around * (1.0 - OWN)
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
        if told.side.has_first_cut() {
            self.rank(edge, false, 0..ring.vertices.len());
            cuts.first = self.code_cut(coder, 0, told.first);
        }
        if told.side.has_second_cut() {
            let is_closed = ring.is_closed();
            let places = (0..ring.vertices.len()).filter(|&place| is_candidate(cuts, place, is_closed));
            self.rank(edge, true, places);
            cuts.second = self.code_cut(coder, 1, told.second);
        }
        cuts
    }

    /// Sorts the neighbours at which the star may be cut, the best first.
    fn rank(&mut self, edge: [DVec3; 2], is_second: bool, places: impl Iterator<Item = usize>) {
        self.candidates.clear();
        for place in places {
            let misfit = self.star.misfit(place, edge, is_second);
            let better = self.candidates.iter().rposition(|other| other.0 <= misfit);
            self.candidates
                .insert(better.map_or(0, |index| index + 1), (misfit, place));
        }
    }

    /// Codes how many neighbours fit better than the one at which the star is cut.
    fn code_cut(&mut self, coder: &mut impl Coder, which: usize, told: usize) -> usize {
        for (rank, pair) in self.candidates.windows(2).enumerate() {
            let lead = pair[1].0 - pair[0].0;
            let clarity = LEADS.iter().filter(|&&least| lead > least).count();
            let probability = &mut self.ranks[which][rank.min(RANKS - 1)][clarity];
            if coder.bit(probability, pair[0].1 == told) {
                return pair[0].1;
            }
        }
        self.candidates.last().map_or(0, |last| last.1)
    }
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
