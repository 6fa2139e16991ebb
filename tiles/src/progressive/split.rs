//! One vertex split in bits: where the star opens, where the new vertex is and where the old one was.
//!
//! ```text
//! side      which part of an open star goes over                      only on the boundary
//! blue      plan: how it lies to the samples, the distance from red, in steps of theirs or in lattice units
//!           height: the difference from the star's triangles there
//! red       whether and how it moves back, its height                 not before the first level is complete
//! cuts      the rank of each among the neighbours, by the angle under which they see the edge from red to blue
//! ```

use glam::DVec3;

use super::number::{NumberModel, SIGNS, code_symbol};
use super::range_coder::{Coder, Probability};
use super::sampling::{Fit, Sampling};
use super::star::{Axes, Star, is_candidate};
use super::surface::{Cuts, Ring, Side, Surface};

/// Ranks and numbers of candidates that have statistics of their own.
const RANKS: usize = 8;
/// Share of the latest difference in what is remembered of those around a vertex.
const NEWS: f64 = 0.3;

/// A vertex split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Split {
    pub(super) cuts: Cuts,
    /// Where the new vertex is.
    pub(super) blue: DVec3,
    /// Where the other one is from now on.
    pub(super) red: DVec3,
}

/// What is known before any split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    /// Whether the third coordinate is a height over the other two.
    pub(super) is_height_field: bool,
    /// Where samples lie.
    pub(super) sampling: Option<Sampling>,
}

/// What splits looked like so far.
#[derive(Debug)]
pub(super) struct SplitModel {
    space: Space,
    sides: [Probability; 4],
    fits: [[[Probability; 8]; 8]; 4],
    distances: [NumberModel; 4],
    heights: NumberModel,
    red: RedModel,
    ranks: [[[Probability; RANKS]; RANKS]; 2],
    /// What height differences around each vertex were like.
    roughness: Vec<f64>,
    star: Star,
}

#[derive(Debug, Default)]
struct RedModel {
    moves: [Probability; 2],
    is_midway: Probability,
    rounds: [Probability; 2],
    distances: NumberModel,
    heights: [NumberModel; 2],
}

impl SplitModel {
    pub(super) fn new(space: Space, vertex_count: usize) -> Self {
        Self {
            space,
            sides: Default::default(),
            fits: Default::default(),
            distances: Default::default(),
            heights: NumberModel::default(),
            red: RedModel::default(),
            ranks: Default::default(),
            roughness: vec![0.0; vertex_count],
            star: Star::default(),
        }
    }

    /// Codes the split of `vertex`, whose walk is `ring`; one that does not move it if `is_still`.
    pub(super) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        surface: &Surface,
        vertex: u32,
        ring: &Ring,
        is_still: bool,
        split: Split,
    ) -> Split {
        self.star.gather(surface, vertex, ring);
        let axes = if self.space.is_height_field {
            Axes::PLAN
        } else {
            Axes::across(&self.star)
        };
        self.star.reorder(axes);
        let centre = axes.ordered(surface.positions[vertex as usize]);
        let side = self.code_side(coder, ring, split.cuts.side);
        let blue = self.code_blue(coder, vertex, side, centre, axes.ordered(split.blue));
        let red = if is_still {
            centre
        } else {
            self.code_red(coder, vertex, centre, blue, axes.ordered(split.red))
        };
        let cuts = self.code_cuts(coder, ring, [red - centre, blue - centre], Cuts { side, ..split.cuts });
        self.roughness.push(self.roughness[vertex as usize]);
        Split {
            cuts,
            blue: axes.restored(blue),
            red: axes.restored(red),
        }
    }

    fn code_side<C: Coder>(&mut self, coder: &mut C, ring: &Ring, side: Side) -> Side {
        if ring.is_closed() {
            return Side::Inner;
        }
        Side::ALL[code_symbol(coder, &mut self.sides, side as usize)]
    }

    fn code_blue<C: Coder>(&mut self, coder: &mut C, vertex: u32, side: Side, centre: DVec3, blue: DVec3) -> DVec3 {
        let spokes = self.star.toward(side);
        let mut place = centre;
        let is_along = matches!(side, Side::Front | Side::Back);
        let red_fit = self.space.sampling.map_or(Fit::Free, |sampling| sampling.fit(0, centre.x));
        let context = 2 * usize::from(is_along);
        let expected = Expected::of(spokes.iter().map(|spoke| spoke.x));
        let (fit, x) = code_coordinate(
            coder, self.space.sampling, 0, &mut self.fits[context][red_fit.symbol()], &mut self.distances[..2],
            expected, centre.x, blue.x,
        );
        place.x = x;
        let ahead = x - centre.x;
        let same_side = spokes.iter().filter(|spoke| spoke.x * ahead > 0.0).map(|spoke| spoke.y);
        let mut expected = Expected::of(same_side);
        if expected.count == 0 {
            expected = Expected::of(spokes.iter().map(|spoke| spoke.y));
        }
        let (_, y) = code_coordinate(
            coder, self.space.sampling, 1, &mut self.fits[context + 1][fit.symbol()], &mut self.distances[2..],
            expected, centre.y, blue.y,
        );
        place.y = y;
        let predicted = centre.z + (self.star.height_at(side, place - centre) + 0.5).floor();
        let guess = self.roughness[vertex as usize];
        let difference = self.heights.code(coder, guess as u64, 4, (blue.z - predicted) as i64) as f64;
        self.roughness[vertex as usize] = guess + (difference.abs() - guess) * NEWS;
        place.z = predicted + difference;
        place
    }

    fn code_red<C: Coder>(&mut self, coder: &mut C, vertex: u32, centre: DVec3, blue: DVec3, red: DVec3) -> DVec3 {
        let model = &mut self.red;
        let moves = red.x != centre.x || red.y != centre.y;
        let mut place = centre;
        let mut kind = 0;
        if coder.bit(&mut model.moves[0], moves) {
            kind = 1;
            let midway = 2.0 * centre - blue;
            let rounding = midway - red;
            let is_round = |number: f64| number == 0.0 || number == 1.0;
            if coder.bit(&mut model.is_midway, is_round(rounding.x) && is_round(rounding.y)) {
                for axis in 0..2 {
                    let rounds = coder.bit(&mut model.rounds[axis], rounding[axis] == 1.0);
                    place[axis] = midway[axis] - f64::from(u8::from(rounds));
                }
                place.z = midway.z;
            } else {
                for axis in 0..2 {
                    let guess = (blue[axis] - centre[axis]).abs() as u64;
                    place[axis] += model.distances.code(coder, guess, 0, (red[axis] - centre[axis]) as i64) as f64;
                }
            }
        }
        let guess = self.roughness[vertex as usize] as u64;
        place.z += model.heights[kind].code(coder, guess, 4, (red.z - place.z) as i64) as f64;
        place
    }

    fn code_cuts<C: Coder>(&mut self, coder: &mut C, ring: &Ring, [red, blue]: [DVec3; 2], told: Cuts) -> Cuts {
        let mut cuts = Cuts { side: told.side, ..Cuts::default() };
        let mirrored = told.side == Side::Outer;
        let [red, blue] = if mirrored { [blue, red] } else { [red, blue] };
        if told.side.has_first_cut() {
            cuts.first = self.code_cut(coder, ring, [red, blue], cuts, told.first, false);
        }
        if told.side.has_second_cut() {
            cuts.second = self.code_cut(coder, ring, [red, blue], cuts, told.second, true);
        }
        cuts
    }

    /// Codes how many neighbours fit better than the one at which the star is cut.
    fn code_cut<C: Coder>(
        &mut self,
        coder: &mut C,
        ring: &Ring,
        [red, blue]: [DVec3; 2],
        cuts: Cuts,
        told: usize,
        is_second: bool,
    ) -> usize {
        let count = ring.vertices.len();
        let mut open: Vec<(f64, usize)> = (0..count)
            .filter(|&place| !is_second || is_candidate(cuts, place, ring.is_closed()))
            .map(|place| (self.star.misfit(place, red, blue, is_second), place))
            .collect();
        let context = open.len().min(RANKS - 1);
        let mut rank = 0;
        loop {
            let Some(best) = (0..open.len()).min_by(|&a, &b| open[a].0.total_cmp(&open[b].0)) else {
                return 0;
            };
            let (_, place) = open.swap_remove(best);
            if open.is_empty() || coder.bit(&mut self.ranks[usize::from(is_second)][context][rank], place == told) {
                return place;
            }
            rank = (rank + 1).min(RANKS - 1);
        }
    }
}

/// How far a coordinate is expected to be from the centre's, and on which side.
#[derive(Clone, Copy, Debug)]
struct Expected {
    count: usize,
    distance: f64,
    sign: usize,
}

impl Expected {
    fn of(differences: impl Iterator<Item = f64>) -> Self {
        let (mut count, mut sum, mut distance) = (0, 0.0, 0.0);
        for difference in differences {
            count += 1;
            sum += difference;
            distance += difference.abs();
        }
        let lean = if distance > 0.0 { sum / distance } else { 0.0 };
        Self {
            count,
            distance: if count > 0 { distance / count as f64 } else { 0.0 },
            sign: ((lean + 1.0) * (SIGNS - 1) as f64 / 2.0 + 0.5).floor() as usize,
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "prototype")]
fn code_coordinate<C: Coder>(
    coder: &mut C,
    sampling: Option<Sampling>,
    axis: usize,
    fits: &mut [Probability],
    distances: &mut [NumberModel],
    expected: Expected,
    centre: f64,
    blue: f64,
) -> (Fit, f64) {
    let fit = if blue == centre {
        Fit::Same
    } else {
        sampling.map_or(Fit::Free, |sampling| sampling.fit(axis, blue))
    };
    let fit = Fit::from_symbol(code_symbol(coder, fits, fit.symbol()));
    let coordinate = match (fit, sampling) {
        (Fit::Same, _) => centre,
        (Fit::Sample(halvings), Some(sampling)) => {
            let [from, to] = [centre, blue].map(|coordinate| sampling.index(axis, halvings, coordinate));
            let guess = expected.distance / sampling.step[axis] * f64::from(1 << halvings);
            let steps = distances[0].code(coder, guess as u64, expected.sign, (to - from) as i64) as f64;
            sampling.coordinate(axis, halvings, from + steps)
        }
        _ => centre + distances[1].code(coder, expected.distance as u64, expected.sign, (blue - centre) as i64) as f64,
    };
    (fit, coordinate)
}
