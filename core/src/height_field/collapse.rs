//! One collapse: what is around the vertex it makes, whether some height there keeps the tolerance, and the edit itself.
//!
//! ```text
//! ring  ← neighbours of both ends, counter-clockwise
//! for each place on the edge:
//!     interval ← heights that blue's samples allow, then red's, then the spokes from the place to the ring
//!     height   ← the best of the interval; where it fails between the points checked, cut the interval there, again
//! perform: lift the samples under both stars, collapse, lay them into the lists of the new star
//! ```

use glam::DVec2;

use crate::height_field::fan::Fan;
use crate::height_field::filters::{self, is_upright};
use crate::height_field::finer::SurfacePoint;
use crate::height_field::interval::Interval;
use crate::height_field::outline::Strays;
use crate::height_field::reference::{Bound, GridPoint, Piece, Reference};
use crate::height_field::samples::Sample;
use crate::height_field::simplify::{Allowance, Shape, Simplifier, VertexKind};
use crate::height_field::surface::Surface;
use crate::levels::collapse_log::Collapse;

/// Tolerances by which a vertex itself may be off the surface where the bound is at samples.
pub(crate) const SPIKE: f64 = 2.0;
/// Heights tried for one place: where one fails between the points that constrained it, that place is a constraint, too.
const CUTS: usize = 4;
/// The same where the points that constrain are few at first.
const FINER_CUTS: usize = 8;

/// What one candidate after the other needs, kept so that none allocates.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) around_blue: Ring,
    pub(crate) around_red: Vec<u32>,
    pub(crate) nearest_first: Vec<(f64, u32, usize)>,
    pub(crate) ring: Ring,
    /// Those under the triangles around blue, and those under the others around red, once they are needed.
    pub(crate) samples: Vec<Sample>,
    others: Vec<Sample>,
    has_others: bool,
    pub(crate) fan: Fan,
    /// Half-edges to the ring.
    spokes: Vec<u32>,
    pieces: Vec<(Piece, f64)>,
    /// Places between the samples where a candidate was too far from the surface.
    found: Vec<Sample>,
}

/// The vertices around one, counter-clockwise, with their places side by side.
#[derive(Default)]
pub(crate) struct Ring {
    pub(crate) vertices: Vec<u32>,
    pub(crate) plan: Vec<DVec2>,
    pub(crate) points: Vec<GridPoint>,
    /// Whether the last is next to the first.
    pub(crate) is_closed: bool,
}

impl Ring {
    pub(crate) fn clear(&mut self, is_closed: bool) {
        self.vertices.clear();
        self.plan.clear();
        self.points.clear();
        self.is_closed = is_closed;
    }

    pub(crate) fn push(&mut self, surface: &Surface, vertex: u32) {
        self.vertices.push(vertex);
        self.plan.push(surface.plan(vertex));
        self.points.push(surface.point(vertex));
    }

    /// Becomes the ring around a vertex of a surface.
    pub(crate) fn surround(&mut self, surface: &Surface, vertex: u32) {
        self.clear(false);
        surface.connectivity.ring(vertex, &mut self.vertices);
        self.is_closed = !self.vertices.is_empty() && !surface.connectivity.is_boundary(vertex);
        self.plan.extend(self.vertices.iter().map(|&other| surface.plan(other)));
        self.points
            .extend(self.vertices.iter().map(|&other| surface.point(other)));
    }

    /// Appends `count` vertices of another ring from the one numbered `first` on, and after its last one its first.
    fn extend_around(&mut self, other: &Self, first: usize, count: usize) {
        let whole = other.vertices.len();
        let first = if first < whole { first } else { first - whole };
        let end = first + count;
        for part in [first..end.min(whole), 0..end.saturating_sub(whole)] {
            self.vertices.extend_from_slice(&other.vertices[part.clone()]);
            self.plan.extend_from_slice(&other.plan[part.clone()]);
            self.points.extend_from_slice(&other.points[part]);
        }
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

/// The heights that samples allow, and whether all of them were under the fan that told so.
struct Seen {
    interval: Interval,
    is_whole: bool,
}

/// A collapse that passed all checks.
pub(crate) struct Chosen {
    pub(crate) red: u32,
    place: Place,
    strays: Strays,
}

impl Simplifier<'_> {
    /// Passes a collapse through all filters but that of kinds. What is around blue was found before.
    pub(crate) fn checked(
        &mut self,
        edge: Edge,
        shape: Shape,
        allowance: Allowance,
        scratch: &mut Scratch,
    ) -> Option<Chosen> {
        // Most collapses fail under blue's own triangles, so nothing else is looked at before these.
        let at_red = self.seen_from_red(edge, allowance.vertical, scratch);
        if at_red.interval.is_empty() && !self.may_move(edge) || !self.is_possible(edge, scratch) {
            return None;
        }
        let strays = self.strays(edge);
        if strays.metres > allowance.outline {
            return None;
        }
        self.surround(edge, scratch);
        scratch.others.clear();
        let place = if !strays.is_straight {
            self.place_along_outline(edge, at_red, shape, scratch)
        } else {
            scratch.has_others = self.keeps_height(edge.red);
            self.first_place(edge, at_red, shape, scratch)
        };
        self.keep_found(edge, scratch);
        place.map(|place| Chosen {
            red: edge.red,
            place,
            strays,
        })
    }

    /// The first place that will do where the outline strays: what is under the new triangles was not all under the old.
    fn place_along_outline(&self, edge: Edge, at_red: Seen, shape: Shape, scratch: &mut Scratch) -> Option<Place> {
        scratch.samples.clear();
        self.gather_under(self.surface.grid(edge.red), scratch);
        scratch.has_others = true;
        let seen = Seen {
            is_whole: false,
            ..at_red
        };
        let place = self.first_place(edge, seen, shape, scratch);
        scratch.samples.clear();
        self.gather_around(edge.blue, &mut scratch.samples);
        place
    }

    /// The first place that will do, with the best height there.
    fn first_place(&self, edge: Edge, at_red: Seen, shape: Shape, scratch: &mut Scratch) -> Option<Place> {
        (0..self.quality.places().len()).find_map(|number| {
            let (plan, grid) = self.place(edge, number)?;
            let is_red = number == 0;
            if is_red && at_red.interval.is_empty() || !scratch.spread(self.surface.reference, plan, grid) {
                return None;
            }
            let mut interval = at_red.interval;
            if !(is_red && at_red.is_whole) {
                interval = self.interval_of(edge.red, is_red, interval.tolerance);
                scratch.fan.constrain(&mut scratch.samples, &mut interval);
            }
            if !interval.is_empty() && !std::mem::replace(&mut scratch.has_others, true) {
                self.gather_around_other(edge.red, edge.blue, &mut scratch.others);
            }
            scratch.fan.constrain(&mut scratch.others, &mut interval);
            scratch.fan.constrain(&mut scratch.found, &mut interval);
            self.settle(plan, grid, interval, shape.least_altitude, scratch)
        })
    }

    /// What the samples around blue allow red to do where it is. Its triangles cover blue's then, whatever else is around.
    fn seen_from_red(&self, edge: Edge, tolerance: f64, scratch: &mut Scratch) -> Seen {
        let (plan, grid) = (self.surface.plan(edge.red), self.surface.grid(edge.red));
        let mut interval = self.interval_of(edge.red, true, tolerance);
        scratch.surround_blue(edge);
        if !scratch.spread(self.surface.reference, plan, grid) {
            return Seen {
                interval: Interval::empty(tolerance),
                is_whole: true,
            };
        }
        let is_whole = scratch.fan.constrain(&mut scratch.samples, &mut interval);
        Seen { interval, is_whole }
    }

    fn keeps_height(&self, vertex: u32) -> bool {
        self.kinds[vertex as usize].keeps_height()
    }

    /// Whether there is another place for red than its own.
    fn may_move(&self, edge: Edge) -> bool {
        (1..self.quality.places().len()).any(|number| self.place(edge, number).is_some())
    }

    /// Whether topology allows a collapse, and this round, too. Finds what is around red.
    fn is_possible(&mut self, edge: Edge, scratch: &mut Scratch) -> bool {
        let Edge { blue, red, .. } = edge;
        let connectivity = &self.surface.connectivity;
        connectivity.ring(red, &mut scratch.around_red);
        if !filters::link_allows(connectivity, edge, &scratch.around_blue.vertices, &scratch.around_red) {
            return false;
        }
        let is_touched = scratch.around_red.iter().any(|&vertex| self.is_touched(vertex));
        self.worth_a_try[blue as usize] |= is_touched;
        !is_touched
    }

    /// How far the outline would stray.
    fn strays(&self, edge: Edge) -> Strays {
        if self.kinds[edge.blue as usize] == VertexKind::Outline {
            self.outline.strays(self.surface.reference.ground, edge.blue, edge.red)
        } else {
            Strays::NONE
        }
    }

    /// The place of some number where the red vertex might go.
    fn place(&self, edge: Edge, number: usize) -> Option<(DVec2, DVec2)> {
        let Edge { blue, red, .. } = edge;
        let share = self.quality.places()[number];
        if share == 0.0 {
            return Some((self.surface.plan(red), self.surface.grid(red)));
        }
        let are_free = [blue, red].map(|end| self.kinds[end as usize]) == [VertexKind::Free; 2];
        // The middle is the same from both ends: the later of the two leaves it to the other.
        let is_left_to_red = share == 0.5 && red < blue && self.worth_a_try[red as usize];
        (are_free && !is_left_to_red).then(|| {
            let plan = self.surface.plan(red).lerp(self.surface.plan(blue), share).round();
            (plan, self.surface.reference.plan.grid(plan))
        })
    }

    /// Finds what will be around the red vertex; where it cannot change, only where blue's triangles go.
    ///
    /// ```text
    ///        x ─── c ─── y
    ///        │   ╱ │ ╲   │        around blue: red c x … d       around red: blue d … y c
    ///        │ blue ▶ red│        ring:        d … y c x …
    ///        │   ╲ │ ╱   │
    ///        … ─── d ─── …
    /// ```
    fn surround(&self, edge: Edge, scratch: &mut Scratch) {
        if self.keeps_height(edge.red) {
            scratch.surround_blue(edge);
            return;
        }
        let Scratch {
            around_blue,
            around_red,
            ring,
            ..
        } = scratch;
        ring.clear(!self.surface.connectivity.is_boundary(edge.red));
        let count = around_blue.vertices.len();
        let (is_first, is_last) = (edge.index == 0, edge.index + 1 == count);
        let is_shared_after = !edge.is_on_boundary || is_first;
        let is_shared_before = !edge.is_on_boundary || is_last;
        let first = edge.index + 1 + usize::from(is_shared_after);
        let own = count - 1 - usize::from(is_shared_after) - usize::from(is_shared_before);
        for &vertex in around_red.iter() {
            if vertex == edge.blue {
                ring.extend_around(around_blue, first, own);
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

    /// The heights that a red vertex may have, whatever is around it.
    fn interval_of(&self, red: u32, is_at_its_place: bool, tolerance: f64) -> Interval {
        let keeps = is_at_its_place && self.keeps_height(red);
        Interval::new(tolerance, keeps.then(|| self.surface.height(red)))
    }

    /// Keeps a vertex near the surface at its place. Where the bound is at samples, only that keeps it from standing out like
    /// a spike when its triangles hold hardly any.
    fn constrain_spike(&self, grid: DVec2, interval: &mut Interval) {
        if !interval.is_single()
            && let Some(height) = self.surface.reference.heights.height_near(grid)
        {
            interval.constrain(1.0 / SPIKE, height / SPIKE);
        }
    }

    /// The best height of a vertex at a place inside the ring, over all samples under it, if one is allowed.
    pub(crate) fn fit(&self, plan: DVec2, grid: DVec2, tolerance: f64, scratch: &mut Scratch) -> Option<Place> {
        let mut interval = Interval::new(tolerance, None);
        scratch.spread(self.surface.reference, plan, grid).then_some(())?;
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
        let reference = self.surface.reference;
        if interval.is_empty() || !scratch.ring.is_seen_from(plan, least_altitude) {
            return None;
        }
        scratch.pieces.clear();
        match (reference.bound, reference.finer) {
            (Bound::Samples, _) => self.constrain_spike(grid, &mut interval),
            (Bound::Surface, Some(finer)) => {
                if let Some(height) = finer.height(grid) {
                    interval.constrain(1.0, height);
                }
            }
            (Bound::Surface, None) => {
                let Scratch { ring, pieces, .. } = scratch;
                interval.constrain_by_edges(reference, grid, &ring.points, pieces);
            }
        }
        let cuts = if reference.finer.is_some() { FINER_CUTS } else { CUTS };
        let height = (0..cuts).find_map(|_| {
            let height = interval.best(scratch.ring.points[0].height, self.shape.height_step)?;
            let is_cut = interval.cut(&scratch.pieces, height)
                || scratch.is_cut_between_samples(reference, GridPoint { grid, height }, &mut interval);
            (!is_cut).then_some(height)
        })?;
        Some(Place {
            plan,
            point: GridPoint { grid, height },
            squares: interval.squares_at(height),
        })
    }

    /// Puts the places found between samples into the lists of the triangles above them, so that the next candidate fails
    /// quickly there.
    fn keep_found(&mut self, edge: Edge, scratch: &mut Scratch) {
        while let Some(found) = scratch.found.pop() {
            let Some((triangle, is_around_blue)) = self.triangle_above(edge, found.at) else {
                continue;
            };
            let sample = self.samples.add(SurfacePoint {
                at: found.at,
                height: found.height,
            });
            self.samples.put(triangle, &sample);
            if is_around_blue {
                scratch.samples.push(sample);
            } else {
                scratch.others.push(sample);
            }
        }
    }

    /// The triangle around one of an edge's ends with a place, and whether it is around the blue one.
    fn triangle_above(&self, edge: Edge, at: DVec2) -> Option<(u32, bool)> {
        let connectivity = &self.surface.connectivity;
        let turn = self.surface.reference.plan.handedness();
        let holds = |triangle: u32| {
            let corners = connectivity
                .corners(triangle)
                .map(|c| c.map(|corner| self.surface.grid(corner)));
            corners.is_some_and(|[a, b, c]| {
                [(a, b), (b, c), (c, a)]
                    .into_iter()
                    .all(|(from, to)| turn * (to - from).perp_dot(at - from) >= 0.0)
            })
        };
        let around = |vertex: u32| {
            connectivity
                .leaving(vertex)
                .map(|edge| edge / 3)
                .find(|&triangle| holds(triangle))
        };
        let around_blue = around(edge.blue).map(|triangle| (triangle, true));
        around_blue.or_else(|| around(edge.red).map(|triangle| (triangle, false)))
    }

    pub(crate) fn perform(&mut self, blue: u32, chosen: &Chosen, is_recorded: bool, scratch: &mut Scratch) {
        let &Chosen { red, ref place, strays } = chosen;
        if is_recorded {
            self.log.collapses.push(Collapse {
                blue,
                red,
                red_before: self.surface.position(red),
                red_after: place.plan.extend(place.point.height),
            });
        }
        self.clear_samples(blue);
        if place.plan == self.surface.plan(red) && strays.is_straight {
            // Red's other triangles are in plan what they were.
            scratch.others.clear();
        } else {
            self.clear_samples(red);
        }
        self.surface.connectivity.collapse(blue, red);
        self.surface.put(red, place.plan, place.point);
        self.outline.remove(blue);
        self.outline_strayed = self.outline_strayed.max(strays.metres);
        if !strays.is_straight {
            scratch.clear_samples();
            scratch.ring.surround(&self.surface, red);
            self.gather_under(place.point.grid, scratch);
        }
        self.lay_samples(red, scratch);
    }

    /// Takes the samples around a vertex out of their lists.
    pub(crate) fn clear_samples(&mut self, vertex: u32) {
        for edge in self.surface.connectivity.leaving(vertex) {
            self.samples.clear(edge / 3);
        }
    }

    /// Puts the samples gathered into the lists of the triangles around a vertex.
    pub(crate) fn lay_samples(&mut self, vertex: u32, scratch: &mut Scratch) {
        let Scratch {
            ring,
            fan,
            samples,
            others,
            spokes,
            ..
        } = scratch;
        ring.surround(&self.surface, vertex);
        spokes.clear();
        spokes.extend(self.surface.connectivity.leaving(vertex));
        let centre = self.surface.grid(vertex);
        fan.spread(self.surface.reference, centre, &ring.points, ring.is_closed);
        let mut at = 0;
        for sample in samples.iter().chain(others.iter()) {
            if let Some(sector) = fan.sector_of(sample, at) {
                at = sector;
                self.samples.put(spokes[sector] / 3, sample);
            }
        }
    }
}

impl Scratch {
    /// Looks for a place between the samples where the fan from `centre` is beyond the tolerance; constrains by it. Tells whether
    /// there is one.
    fn is_cut_between_samples(&mut self, reference: &Reference, centre: GridPoint, interval: &mut Interval) -> bool {
        let Some(finer) = reference.finer.filter(|_| interval.tolerance.is_finite()) else {
            return false;
        };
        let Ring { points, is_closed, .. } = &self.ring;
        let curvature = reference.curvature_at(centre.grid.y);
        let fan = (centre, points.as_slice(), *is_closed);
        let Some(found) = finer.beyond(fan, curvature, reference.bound, interval.tolerance) else {
            return false;
        };
        let mut found = [Sample::from(found)];
        self.fan.constrain(&mut found, interval);
        self.found.extend(found);
        true
    }

    /// Forgets the samples gathered.
    pub(crate) fn clear_samples(&mut self) {
        self.samples.clear();
        self.others.clear();
        self.found.clear();
    }

    /// Makes the ring of all around blue but red, beginning after red.
    fn surround_blue(&mut self, edge: Edge) {
        self.ring.clear(false);
        let count = self.around_blue.vertices.len() - 1;
        self.ring.extend_around(&self.around_blue, edge.index + 1, count);
    }

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
        Some(interval.squares_at(centre.height))
    }
}
