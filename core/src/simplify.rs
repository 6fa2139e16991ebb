//! Edge collapses inside a tolerance volume, in rounds of an independent set, recorded in a [`CollapseLog`].
//!
//! The volume is that of A. Guéziec, *Surface simplification inside a tolerance volume*, IBM RC 20440, 1996, made exact
//! for height fields: instead of error spheres the reference surface itself bounds every triangle. A collapse may move
//! the red vertex along the edge, and gives it the height of least squares among those that the reference allows.
//!
//! ```text
//! for each band, by growing tolerance:
//!     all vertices are worth a try
//!     repeat until a round finds nothing:
//!         for each vertex worth a try, in memory order, whose star no collapse of this round has touched:
//!             for each neighbour, nearest first, and each place for the red vertex:
//!                 check kinds, link, orientation, outline, tolerance
//!                 perform the first collapse that passes all; the star around it is worth a try again
//!     close the band in the log
//! ```
//! The stars of a round do not meet, so a round is one level of the Surface Partition. Which collapse comes first makes
//! little difference; that blocked vertices are tried again makes much.

use glam::{DVec2, DVec3};

use crate::collapse_log::{Band, Collapse, CollapseLog};
use crate::fan::Fan;
use crate::filters::{self, is_upright};
use crate::interval::Interval;
use crate::outline::OutlineChains;
use crate::reference::{Bound, GridPoint, Piece, Reference};
use crate::samples::{Sample, SampleLists};
use crate::surface::Surface;

/// Tolerances by which a vertex itself may be off the surface where the bound is at samples.
const SPIKE: f64 = 2.0;
/// Heights tried for one place: where one fails between the points that constrained it, that place is a constraint, too.
const CUTS: usize = 4;

/// What a vertex may do in a collapse.
///
/// | kind | as blue, into | as red | reason |
/// | --- | --- | --- | --- |
/// | `Free` | any but `Border` | yes, height free, place free if blue is `Free` | |
/// | `OnColumn`, `OnRow` | same line | yes, height free | the strip along a tile's side stays straight |
/// | `Outline` | along the outline | yes, height free | the hole keeps its shape within the tolerance |
/// | `Fixed` | no | yes | corners |
/// | `Border` | only by [`Simplifier::collapse_border`] | no | shared with other tiles |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// Inside the surface.
    Free,
    /// On a line of constant x.
    OnColumn,
    /// On a line of constant y.
    OnRow,
    /// On the edge of the surface.
    Outline,
    /// Stays where it is.
    Fixed,
    /// On a tile's side.
    Border,
}

impl VertexKind {
    fn keeps_height(self) -> bool {
        matches!(self, Self::Fixed | Self::Border)
    }
}

/// What a band allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// Metres that the surface may stray vertically.
    pub vertical: f64,
    /// Metres that the outline may stray from that of the mesh the simplifier began with, in plan view.
    pub outline: f64,
}

/// What holds for all bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Heights are multiples of this, metres; 0 leaves them free.
    pub height_step: f64,
    /// No edit makes a triangle of a smaller altitude than this, in plan units.
    pub least_altitude: f64,
}

/// How much work goes into few triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Collapses keep the red vertex where it is; three neighbours of each vertex are tried, once.
    Fast,
    /// The red vertex may go to the middle of the edge.
    Default,
    /// More places; edge swaps and vertex moves where no log is kept.
    Best,
}

impl Quality {
    /// Where on the edge the red vertex is tried, as shares of the way from its own place to the blue vertex's.
    fn places(self) -> &'static [f64] {
        match self {
            Self::Fast => &[0.0],
            Self::Default => &[0.0, 0.5],
            Self::Best => &[0.0, 0.5, 0.25],
        }
    }

    /// Into how many of its neighbours, the nearest first, a vertex is tried to collapse.
    fn neighbours(self) -> usize {
        match self {
            Self::Fast => 3,
            Self::Default | Self::Best => usize::MAX,
        }
    }
}

/// A mesh while it is simplified.
pub struct Simplifier<'a> {
    pub(crate) surface: Surface<'a>,
    pub(crate) samples: SampleLists,
    pub(crate) shape: Shape,
    pub(crate) quality: Quality,
    pub(crate) kinds: Vec<VertexKind>,
    pub(crate) worth_a_try: Vec<bool>,
    outline: OutlineChains,
    outline_strayed: f64,
    log: CollapseLog,
    /// The round in which each vertex was last a red one.
    touched: Vec<u32>,
    round: u32,
    pub(crate) scratch: Scratch,
}

/// What one candidate after the other needs, kept so that none allocates.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) around_blue: Vec<u32>,
    pub(crate) around_red: Vec<u32>,
    nearest_first: Vec<(f64, u32, usize)>,
    pub(crate) ring: Ring,
    /// Those under the triangles around blue, and those under the others around red, once they are needed.
    pub(crate) samples: Vec<Sample>,
    others: Vec<Sample>,
    has_others: bool,
    pub(crate) fan: Fan,
    pieces: Vec<(Piece, f64)>,
}

/// The points around the red vertex after a collapse, counter-clockwise.
#[derive(Default)]
pub(crate) struct Ring {
    pub(crate) plan: Vec<DVec2>,
    pub(crate) points: Vec<GridPoint>,
    /// Whether the last is next to the first.
    pub(crate) is_closed: bool,
}

impl Ring {
    pub(crate) fn clear(&mut self, is_closed: bool) {
        self.plan.clear();
        self.points.clear();
        self.is_closed = is_closed;
    }

    pub(crate) fn push(&mut self, surface: &Surface, vertex: u32) {
        self.plan.push(surface.plan[vertex as usize]);
        self.points.push(surface.points[vertex as usize]);
    }

    /// Whether all triangles from `centre` to the ring are counter-clockwise and high enough.
    pub(crate) fn is_seen_from(&self, centre: DVec2, least_altitude: f64) -> bool {
        let (Some(&first), Some(&last)) = (self.plan.first(), self.plan.last()) else {
            return false;
        };
        let wraps = !self.is_closed || is_upright(centre, last, first, least_altitude);
        wraps
            && self
                .plan
                .windows(2)
                .all(|pair| is_upright(centre, pair[0], pair[1], least_altitude))
    }
}

/// Where a vertex may be put, and what that leaves of the differences.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) plan: DVec2,
    pub(crate) point: GridPoint,
    /// Sum of the squared differences at the samples of its star.
    pub(crate) squares: f64,
}

/// An edge to collapse.
#[derive(Clone, Copy)]
pub(crate) struct Edge {
    pub(crate) blue: u32,
    pub(crate) red: u32,
    /// The place of red around blue.
    pub(crate) index: usize,
    pub(crate) is_on_boundary: bool,
}

/// A collapse that passed all checks.
struct Chosen {
    red: u32,
    place: Place,
    strays: f64,
}

impl<'a> Simplifier<'a> {
    /// Begins with `surface`. `kinds` tells what each vertex may do; vertices of the outline that are
    /// [`VertexKind::Free`] become [`VertexKind::Outline`], and [`VertexKind::Border`] where the outline touches itself.
    #[must_use]
    pub fn new(surface: Surface<'a>, mut kinds: Vec<VertexKind>, shape: Shape, quality: Quality) -> Self {
        let outline = OutlineChains::new(&surface);
        for (kind, vertex) in kinds.iter_mut().zip(0..) {
            match outline.visits(vertex) {
                0 => {}
                1 if *kind == VertexKind::Free => *kind = VertexKind::Outline,
                1 => {}
                _ => *kind = VertexKind::Border,
            }
        }
        Self {
            samples: SampleLists::new(&surface),
            touched: vec![0; kinds.len()],
            worth_a_try: vec![false; kinds.len()],
            surface,
            shape,
            quality,
            kinds,
            outline,
            outline_strayed: 0.0,
            log: CollapseLog::default(),
            round: 0,
            scratch: Scratch::default(),
        }
    }

    /// Collapses what a band allows and closes the band.
    pub fn simplify(&mut self, allowance: Allowance) {
        self.try_all();
        while self.round(allowance, true) > 0 {}
        self.close_band(allowance.vertical);
    }

    /// Ends a band after the collapses so far; `error` is what its surface is good for.
    pub fn close_band(&mut self, error: f64) {
        self.log.bands.push(Band {
            end: self.log.collapses.len(),
            error,
        });
    }

    /// Collapses a vertex of a tile's side into another one next to it on the side, if the surface stays within
    /// `tolerance` metres. Infinity allows what topology does: the side as a curve was simplified before. Tells
    /// whether it could.
    pub fn collapse_border(&mut self, blue: u32, red: u32, tolerance: f64) -> bool {
        // A vertex where the outline touches itself has triangles that a walk around it does not see.
        if [blue, red].into_iter().any(|vertex| self.outline.visits(vertex) > 1) {
            return false;
        }
        self.round += 1;
        let mut scratch = std::mem::take(&mut self.scratch);
        self.surface.connectivity.ring(blue, &mut scratch.around_blue);
        scratch.samples.clear();
        self.gather_around(blue, &mut scratch.samples);
        let allowance = Allowance {
            vertical: tolerance,
            outline: 0.0,
        };
        let shape = Shape {
            least_altitude: 0.0,
            ..self.shape
        };
        let place = scratch.around_blue.iter().position(|&vertex| vertex == red);
        let chosen =
            place.and_then(|place| self.checked(self.edge(blue, red, place, &scratch), shape, allowance, &mut scratch));
        if let Some(chosen) = &chosen {
            self.perform(blue, chosen, true, &mut scratch);
        }
        self.scratch = scratch;
        chosen.is_some()
    }

    /// How far, in metres, the outline strays by now from that of the mesh the simplifier began with.
    #[must_use]
    pub fn outline_strayed(&self) -> f64 {
        self.outline_strayed
    }

    /// Position of a vertex.
    #[must_use]
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.surface.position(vertex)
    }

    /// The log of all collapses so far.
    #[must_use]
    pub fn log(&self) -> &CollapseLog {
        &self.log
    }

    /// Rounds so far: each is at most one level of the Surface Partition.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.round
    }

    /// The surface as it is now.
    #[must_use]
    pub fn surface(&self) -> &Surface<'a> {
        &self.surface
    }

    /// The surface as it is now, for good.
    #[must_use]
    pub fn into_surface(self) -> Surface<'a> {
        self.surface
    }

    pub(crate) fn try_all(&mut self) {
        for vertex in 0..self.kinds.len() as u32 {
            self.try_again(vertex);
        }
    }

    pub(crate) fn try_again(&mut self, vertex: u32) {
        self.worth_a_try[vertex as usize] = self.kinds[vertex as usize] != VertexKind::Border;
    }

    /// Tries every vertex that is worth it and tells how many were collapsed. Only an independent set, if that is asked
    /// for, and then also recorded.
    pub(crate) fn round(&mut self, allowance: Allowance, is_recorded: bool) -> usize {
        self.round += 1;
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut count = 0;
        for vertex in 0..self.kinds.len() as u32 {
            if self.worth_a_try[vertex as usize] && self.surface.connectivity.is_live(vertex) {
                count += usize::from(self.try_vertex(vertex, allowance, is_recorded, &mut scratch));
            }
        }
        self.scratch = scratch;
        count
    }

    fn is_touched(&self, vertex: u32) -> bool {
        self.touched[vertex as usize] == self.round
    }

    fn try_vertex(&mut self, blue: u32, allowance: Allowance, is_recorded: bool, scratch: &mut Scratch) -> bool {
        self.surface.connectivity.ring(blue, &mut scratch.around_blue);
        if self.is_touched(blue) || scratch.around_blue.iter().any(|&vertex| self.is_touched(vertex)) {
            return false;
        }
        self.worth_a_try[blue as usize] = false;
        scratch.samples.clear();
        self.gather_around(blue, &mut scratch.samples);
        let mut nearest_first = std::mem::take(&mut scratch.nearest_first);
        self.sort_by_distance(blue, &scratch.around_blue, &mut nearest_first);
        nearest_first.truncate(self.quality.neighbours());
        let chosen = nearest_first.iter().find_map(|&(_, red, index)| {
            let edge = self.edge(blue, red, index, scratch);
            let is_allowed = filters::kinds_allow(&self.surface, &self.kinds, edge);
            is_allowed
                .then(|| self.checked(edge, self.shape, allowance, scratch))
                .flatten()
        });
        scratch.nearest_first = nearest_first;
        let Some(chosen) = chosen else { return false };
        self.perform(blue, &chosen, is_recorded, scratch);
        self.touched[chosen.red as usize] = if is_recorded { self.round } else { 0 };
        for &vertex in scratch.around_red.iter().chain([&chosen.red]) {
            self.worth_a_try[vertex as usize] = self.kinds[vertex as usize] != VertexKind::Border;
        }
        true
    }

    fn sort_by_distance(&self, centre: u32, around: &[u32], sorted: &mut Vec<(f64, u32, usize)>) {
        let at = self.surface.plan[centre as usize];
        let distance = |vertex: u32| self.surface.plan[vertex as usize].distance_squared(at);
        sorted.clear();
        sorted.extend(
            around
                .iter()
                .enumerate()
                .map(|(index, &vertex)| (distance(vertex), vertex, index)),
        );
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    fn edge(&self, blue: u32, red: u32, index: usize, scratch: &Scratch) -> Edge {
        let is_on_boundary =
            self.surface.connectivity.is_boundary(blue) && (index == 0 || index + 1 == scratch.around_blue.len());
        Edge {
            blue,
            red,
            index,
            is_on_boundary,
        }
    }

    /// Passes a collapse through all filters but that of kinds. The samples around blue are gathered before.
    fn checked(&mut self, edge: Edge, shape: Shape, allowance: Allowance, scratch: &mut Scratch) -> Option<Chosen> {
        let Edge { blue, red, .. } = edge;
        self.surface.connectivity.ring(red, &mut scratch.around_red);
        if !filters::link_allows(
            &self.surface.connectivity,
            edge,
            &scratch.around_blue,
            &scratch.around_red,
        ) {
            return None;
        }
        if scratch.around_red.iter().any(|&vertex| self.is_touched(vertex)) {
            self.worth_a_try[blue as usize] = true;
            return None;
        }
        let strays = if self.kinds[blue as usize] == VertexKind::Outline {
            self.outline.strays(blue, red)
        } else {
            0.0
        };
        if strays > allowance.outline {
            return None;
        }
        let keeps_height = self.kinds[red as usize].keeps_height();
        self.surround(edge, keeps_height, scratch);
        scratch.others.clear();
        scratch.has_others = strays > 0.0 || keeps_height;
        if strays > 0.0 {
            scratch.samples.clear();
            self.gather_under(self.surface.points[red as usize].grid, scratch);
        }
        let only = keeps_height.then(|| self.surface.points[red as usize].height);
        let place = (0..self.quality.places().len()).find_map(|number| {
            let (plan, grid) = self.place(edge, number)?;
            scratch.spread(self.surface.reference, plan, grid).then_some(())?;
            let mut interval = self.interval_at(grid, only, allowance.vertical);
            scratch.fan.constrain(&mut scratch.samples, &mut interval);
            if interval.is_empty() {
                return None;
            }
            // Most collapses fail under blue's own triangles: red's are not looked at before they must be.
            if !std::mem::replace(&mut scratch.has_others, true) {
                self.gather_around_other(red, blue, &mut scratch.others);
            }
            scratch.fan.constrain(&mut scratch.others, &mut interval);
            self.settle(plan, grid, interval, shape.least_altitude, scratch)
        });
        if strays > 0.0 {
            scratch.samples.clear();
            self.gather_around(blue, &mut scratch.samples);
        }
        place.map(|place| Chosen { red, place, strays })
    }

    /// The place of some number where the red vertex might go.
    fn place(&self, edge: Edge, number: usize) -> Option<(DVec2, DVec2)> {
        let (blue, red) = (edge.blue as usize, edge.red as usize);
        let share = self.quality.places()[number];
        if share == 0.0 {
            return Some((self.surface.plan[red], self.surface.points[red].grid));
        }
        let are_free = self.kinds[blue] == VertexKind::Free && self.kinds[red] == VertexKind::Free;
        // The middle is the same from both ends: the later of the two leaves it to the other.
        let is_left_to_red = share == 0.5 && edge.red < edge.blue && self.worth_a_try[red];
        (are_free && !is_left_to_red).then(|| {
            let plan = self.surface.plan[red].lerp(self.surface.plan[blue], share).round();
            (plan, self.surface.reference.plan.grid(plan))
        })
    }

    /// Finds what will be around the red vertex; `without_red`: only where blue's triangles go.
    ///
    /// ```text
    ///        x ─── c ─── y
    ///        │   ╱ │ ╲   │        around blue: red c x … d       around red: blue d … y c
    ///        │ blue ▶ red│        ring:        d … y c x …
    ///        │   ╲ │ ╱   │
    ///        … ─── d ─── …
    /// ```
    fn surround(&self, edge: Edge, without_red: bool, scratch: &mut Scratch) {
        let Scratch {
            around_blue,
            around_red,
            ring,
            ..
        } = scratch;
        let connectivity = &self.surface.connectivity;
        let others = || {
            around_blue[edge.index + 1..]
                .iter()
                .chain(&around_blue[..edge.index])
                .copied()
        };
        if without_red {
            ring.clear(false);
            others().for_each(|vertex| ring.push(&self.surface, vertex));
            return;
        }
        ring.clear(!connectivity.is_boundary(edge.red));
        let (is_first, is_last) = (edge.index == 0, edge.index + 1 == around_blue.len());
        let before = usize::from(!edge.is_on_boundary || is_first);
        let after = usize::from(!edge.is_on_boundary || is_last);
        let own = others().count() - before - after;
        for &vertex in around_red.iter() {
            if vertex == edge.blue {
                others()
                    .skip(before)
                    .take(own)
                    .for_each(|vertex| ring.push(&self.surface, vertex));
            } else {
                ring.push(&self.surface, vertex);
            }
        }
    }

    pub(crate) fn gather_around(&self, vertex: u32, samples: &mut Vec<Sample>) {
        for edge in self.surface.connectivity.leaving(vertex) {
            self.samples.gather(self.surface.reference, edge / 3, samples);
        }
    }

    /// The samples around a vertex but for those in triangles with another one.
    fn gather_around_other(&self, vertex: u32, other: u32, samples: &mut Vec<Sample>) {
        let connectivity = &self.surface.connectivity;
        for edge in connectivity.leaving(vertex) {
            if connectivity.end(edge) != other && connectivity.apex(edge) != other {
                self.samples.gather(self.surface.reference, edge / 3, samples);
            }
        }
    }

    /// The samples under the triangles from a place to the ring, whoever had them before.
    fn gather_under(&self, centre: DVec2, scratch: &mut Scratch) {
        for pair in scratch.ring.points.windows(2) {
            let corners = [centre, pair[0].grid, pair[1].grid];
            self.samples
                .gather_under(self.surface.reference, corners, &mut scratch.samples);
        }
    }

    /// The heights that a vertex may have at a place, whatever is around it: near the surface there. Only that keeps a
    /// vertex from standing out like a spike where its triangles hold hardly any samples and the bound is at samples.
    fn interval_at(&self, grid: DVec2, only: Option<f64>, tolerance: f64) -> Interval {
        let reference = self.surface.reference;
        let mut interval = Interval::new(tolerance, only);
        if reference.bound == Bound::Samples
            && only.is_none()
            && let Some(height) = reference.height_near(grid)
        {
            interval.constrain(1.0 / SPIKE, height / SPIKE, 1.0);
        }
        interval
    }

    /// The best height of a vertex at a place inside the ring, over all samples under it, if one is allowed.
    pub(crate) fn fit(&self, plan: DVec2, grid: DVec2, tolerance: f64, scratch: &mut Scratch) -> Option<Place> {
        let mut interval = self.interval_at(grid, None, tolerance);
        scratch.spread(self.surface.reference, plan, grid).then_some(())?;
        scratch.others.clear();
        scratch.fan.constrain(&mut scratch.samples, &mut interval);
        self.settle(plan, grid, interval, self.shape.least_altitude, scratch)
    }

    /// The best of the heights that samples allow, if the edges to the ring allow one, too.
    fn settle(
        &self,
        plan: DVec2,
        grid: DVec2,
        mut interval: Interval,
        least_altitude: f64,
        scratch: &mut Scratch,
    ) -> Option<Place> {
        let Scratch {
            ring,
            pieces,
            fan,
            samples,
            others,
            ..
        } = scratch;
        let reference = self.surface.reference;
        pieces.clear();
        if reference.bound == Bound::Surface {
            for &end in &ring.points {
                if interval.is_empty() {
                    return None;
                }
                interval.constrain_by_edge(reference, grid, end, pieces);
            }
        }
        if interval.is_empty() || !ring.is_seen_from(plan, least_altitude) {
            return None;
        }
        fan.add_squares(samples, &mut interval);
        fan.add_squares(others, &mut interval);
        let height = (0..CUTS).find_map(|_| {
            let height = interval.best(ring.points[0].height, self.shape.height_step)?;
            let is_cut = interval.cut(pieces, height);
            (!is_cut).then_some(height)
        })?;
        Some(Place {
            plan,
            point: GridPoint { grid, height },
            squares: interval.squares_at(height),
        })
    }

    fn perform(&mut self, blue: u32, chosen: &Chosen, is_recorded: bool, scratch: &mut Scratch) {
        let &Chosen { red, ref place, strays } = chosen;
        if is_recorded {
            self.log.collapses.push(Collapse {
                blue,
                red,
                red_before: self.surface.position(red),
                red_after: place.plan.extend(place.point.height),
            });
        }
        self.lift_samples(blue, scratch, true);
        self.lift_samples(red, scratch, false);
        self.surface.connectivity.collapse(blue, red);
        self.surface.plan[red as usize] = place.plan;
        self.surface.points[red as usize] = place.point;
        self.outline.remove(blue);
        self.outline_strayed = self.outline_strayed.max(strays);
        if strays > 0.0 {
            scratch.samples.clear();
            self.surround_vertex(red, scratch);
            self.gather_under(place.point.grid, scratch);
        }
        self.lay_samples(red, scratch);
    }

    /// Takes the samples around a vertex out of their lists.
    pub(crate) fn lift_samples(&mut self, vertex: u32, scratch: &mut Scratch, is_first: bool) {
        if is_first {
            scratch.samples.clear();
        }
        for edge in self.surface.connectivity.leaving(vertex) {
            self.samples
                .gather(self.surface.reference, edge / 3, &mut scratch.samples);
            self.samples.clear(edge / 3);
        }
    }

    /// Puts the samples lifted into the lists of the triangles around a vertex.
    pub(crate) fn lay_samples(&mut self, vertex: u32, scratch: &mut Scratch) {
        self.surround_vertex(vertex, scratch);
        let Scratch { ring, fan, samples, .. } = scratch;
        let centre = self.surface.points[vertex as usize].grid;
        fan.spread(self.surface.reference, centre, &ring.points, ring.is_closed);
        let mut at = 0;
        for sample in samples.iter() {
            if let Some(sector) = fan.sector_of(sample, at) {
                at = sector;
                if let Some(edge) = self.surface.connectivity.leaving(vertex).nth(sector) {
                    self.samples.put(edge / 3, sample);
                }
            }
        }
    }

    /// Finds what is around a vertex, in `around_red` and in the ring.
    pub(crate) fn surround_vertex(&self, vertex: u32, scratch: &mut Scratch) {
        let Scratch { around_red, ring, .. } = scratch;
        self.surface.connectivity.ring(vertex, around_red);
        ring.clear(!self.surface.connectivity.is_boundary(vertex));
        around_red.iter().for_each(|&other| ring.push(&self.surface, other));
    }
}

impl Scratch {
    /// Spreads the fan from a place over the ring, if all its triangles are counter-clockwise in plan.
    fn spread(&mut self, reference: &Reference, plan: DVec2, grid: DVec2) -> bool {
        let is_upright = self.fan.spread(reference, grid, &self.ring.points, self.ring.is_closed);
        is_upright || self.ring.is_seen_from(plan, 0.0)
    }

    /// Sum of the squared differences under the ring, seen from a point; none where one is beyond the tolerance.
    pub(crate) fn squares(&mut self, reference: &Reference, centre: GridPoint, tolerance: f64) -> Option<f64> {
        let mut interval = Interval::new(tolerance, Some(centre.height));
        self.fan
            .spread(reference, centre.grid, &self.ring.points, self.ring.is_closed);
        self.fan.constrain(&mut self.samples, &mut interval);
        if interval.is_empty() {
            return None;
        }
        self.fan.add_squares(&self.samples, &mut interval);
        Some(interval.squares_at(centre.height))
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
mod tests;
