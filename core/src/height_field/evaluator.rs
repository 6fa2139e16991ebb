//! Candidates: what is around the vertex that a collapse makes, and whether some height there keeps the tolerance.
//!
//! ```text
//! ring  ← neighbours of both ends, counter-clockwise
//! for each place on the edge:
//!     interval ← heights that blue's samples allow, then red's, then the spokes from the place to the ring
//!     height   ← the best of the interval; where it fails between the points checked, cut the interval there, again
//! ```

use glam::DVec2;

use crate::height_field::attempts::Attempts;
use crate::height_field::bilinear::Piece;
use crate::height_field::fan::Fan;
use crate::height_field::finer::{Finer, FinerFan, SurfacePoint};
use crate::height_field::flat::GridPoint;
use crate::height_field::interval::Interval;
use crate::height_field::reference::{Bound, Reference};
use crate::height_field::ring::Ring;
use crate::height_field::rules::{Allowance, Quality, Shape, VertexKind};
use crate::height_field::sampled_surface::{Chosen, Gathered, Place, SampledSurface};
use crate::height_field::samples::Sample;
use crate::topology::edge_collapse::{Edge, link_allows, link_allows_closing};

/// Tolerances by which a vertex itself may be off the surface where the bound is at samples.
pub(crate) const SPIKE: f64 = 2.0;
/// Tolerances between the heights that samples ask for at red's place beyond which no other place is looked at: of
/// forty that were, one would do.
const WORTH_A_MOVE: f64 = 0.5;
/// Heights tried for one place: where one fails between the points that constrained it, that place is a constraint, too.
const CUTS: usize = 4;
/// The same where the points that constrain are few at first.
const FINER_CUTS: usize = 8;

/// Looks at one candidate after the other; what that needs is kept, so that none allocates.
pub(crate) struct Evaluator {
    pub(crate) shape: Shape,
    pub(crate) quality: Quality,
    pub(crate) around_blue: Ring,
    around_red: Vec<u32>,
    /// What will be around the red vertex.
    pub(crate) ring: Ring,
    pub(crate) gathered: Gathered,
    has_others: bool,
    fan: Fan,
    pieces: Vec<(Piece, f64)>,
    /// Places between the samples where a candidate was too far from the surface.
    found: Vec<Sample>,
}

/// The heights that samples allow, and whether all of them were under the fan that told so.
struct Seen {
    interval: Interval,
    is_whole: bool,
}

impl Evaluator {
    pub(crate) fn new(shape: Shape, quality: Quality) -> Self {
        Self {
            shape,
            quality,
            around_blue: Ring::default(),
            around_red: Vec::new(),
            ring: Ring::default(),
            gathered: Gathered::default(),
            has_others: false,
            fan: Fan::default(),
            pieces: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Finds the samples around the vertex that [`Self::around_blue`] surrounds.
    pub(crate) fn gather(&mut self, sampled: &SampledSurface, blue: u32) {
        self.gathered.clear();
        self.found.clear();
        sampled.gather_around(blue, &mut self.gathered.around_blue);
    }

    /// Passes a collapse through all filters but that of kinds. What is around blue was found before.
    pub(crate) fn checked(
        &mut self,
        sampled: &mut SampledSurface,
        attempts: &mut Attempts,
        edge: Edge,
        allowance: Allowance,
    ) -> Option<Chosen> {
        // Most collapses fail under blue's own triangles, so nothing else is looked at before these.
        let at_red = self.seen_from_red(sampled, edge, allowance.vertical);
        let is_hopeless = at_red.interval.is_empty()
            && (at_red.interval.gap() > WORTH_A_MOVE * allowance.vertical || !self.may_move(sampled, attempts, edge));
        if is_hopeless || !self.is_possible(sampled, attempts, edge) {
            return None;
        }
        let strays = sampled.strays(edge);
        let breakline_strays = sampled.breakline_strays(edge);
        if strays.metres > allowance.outline || breakline_strays > allowance.breaklines {
            return None;
        }
        self.surround(sampled, edge);
        self.gathered.others.clear();
        let place = if !strays.is_straight {
            self.place_along_outline(sampled, attempts, edge, at_red)
        } else {
            self.has_others = sampled.keeps_height(edge.red);
            self.first_place(sampled, attempts, edge, at_red)
        };
        self.keep_found(sampled, edge);
        place.map(|place| Chosen {
            red: edge.red,
            place,
            strays,
            breakline_strays,
            closes: edge.closes,
        })
    }

    /// Whether there is another place for red than its own.
    fn may_move(&self, sampled: &SampledSurface, attempts: &Attempts, edge: Edge) -> bool {
        (1..self.quality.places().len()).any(|number| self.place(sampled, attempts, edge, number).is_some())
    }

    /// The first place that will do where the outline strays: what is under the new triangles was not all under the old.
    fn place_along_outline(
        &mut self,
        sampled: &SampledSurface,
        attempts: &Attempts,
        edge: Edge,
        at_red: Seen,
    ) -> Option<Place> {
        self.gathered.around_blue.clear();
        let centre = sampled.surface.grid(edge.red);
        sampled.gather_under(centre, &self.ring, &mut self.gathered.around_blue);
        self.has_others = true;
        let seen = Seen {
            is_whole: false,
            ..at_red
        };
        let place = self.first_place(sampled, attempts, edge, seen);
        self.gathered.around_blue.clear();
        sampled.gather_around(edge.blue, &mut self.gathered.around_blue);
        place
    }

    /// The first place that will do, with the best height there.
    fn first_place(
        &mut self,
        sampled: &SampledSurface,
        attempts: &Attempts,
        edge: Edge,
        at_red: Seen,
    ) -> Option<Place> {
        (0..self.quality.places().len()).find_map(|number| {
            let (plan, grid) = self.place(sampled, attempts, edge, number)?;
            let is_red = number == 0;
            let tolerance = at_red.interval.tolerance;
            if is_red && at_red.interval.is_empty() || !self.spread(sampled.surface.reference, plan, grid, tolerance) {
                return None;
            }
            let mut interval = at_red.interval;
            if !(is_red && at_red.is_whole) {
                interval = interval_of(sampled, edge.red, is_red, tolerance);
                self.fan.constrain(&mut self.gathered.around_blue, &mut interval);
            }
            if !interval.is_empty() && !std::mem::replace(&mut self.has_others, true) {
                sampled.gather_around_other(edge.red, edge.blue, &mut self.gathered.others);
            }
            self.fan.constrain(&mut self.gathered.others, &mut interval);
            self.fan.constrain(&mut self.found, &mut interval);
            self.settle(sampled.surface.reference, plan, grid, interval)
        })
    }

    /// What the samples around blue allow red to do where it is. Its triangles cover blue's then, whatever else is around.
    fn seen_from_red(&mut self, sampled: &SampledSurface, edge: Edge, tolerance: f64) -> Seen {
        let surface = &sampled.surface;
        let mut interval = interval_of(sampled, edge.red, true, tolerance);
        self.surround_blue(edge);
        if !self.spread(
            surface.reference,
            surface.plan(edge.red),
            surface.grid(edge.red),
            tolerance,
        ) {
            return Seen {
                interval: Interval::empty(tolerance),
                is_whole: true,
            };
        }
        let is_whole = self.fan.constrain(&mut self.gathered.around_blue, &mut interval);
        Seen { interval, is_whole }
    }

    /// Whether topology allows a collapse, and this round, too. Finds what is around red.
    fn is_possible(&mut self, sampled: &SampledSurface, attempts: &mut Attempts, edge: Edge) -> bool {
        let connectivity = &sampled.surface.connectivity;
        connectivity.ring(edge.red, &mut self.around_red);
        let around_blue = &self.around_blue.vertices;
        let is_allowed = match edge.closes {
            Some(_) => link_allows_closing(around_blue, &self.around_red),
            None => link_allows(connectivity, edge, around_blue, &self.around_red),
        };
        if !is_allowed {
            return false;
        }
        let is_touched = attempts.is_any_touched(&self.around_red);
        if is_touched {
            attempts.set_worth_it(edge.blue, true);
        }
        !is_touched
    }

    /// The place of some number where the red vertex might go.
    fn place(
        &self,
        sampled: &SampledSurface,
        attempts: &Attempts,
        edge: Edge,
        number: usize,
    ) -> Option<(DVec2, DVec2)> {
        let Edge { blue, red, .. } = edge;
        let surface = &sampled.surface;
        let share = self.quality.places()[number];
        if share == 0.0 {
            return Some((surface.plan(red), surface.grid(red)));
        }
        let are_free = [blue, red].map(|end| sampled.kinds[end as usize]) == [VertexKind::Free; 2];
        // The middle is the same from both ends: the later of the two leaves it to the other.
        let is_left_to_red = share == 0.5 && red < blue && attempts.is_worth_it(red);
        (are_free && !is_left_to_red).then(|| {
            let plan = surface.plan(red).lerp(surface.plan(blue), share).round();
            (plan, surface.reference.plan.grid(plan))
        })
    }

    /// Finds what will be around the red vertex; where it cannot change, only where blue's triangles go.
    fn surround(&mut self, sampled: &SampledSurface, edge: Edge) {
        if sampled.keeps_height(edge.red) {
            self.surround_blue(edge);
        } else {
            self.ring
                .surround_collapsed(&sampled.surface, edge, &self.around_blue, &self.around_red);
        }
    }

    /// Makes the ring of all around blue but red, beginning after red.
    fn surround_blue(&mut self, edge: Edge) {
        self.ring.clear(false);
        let count = self.around_blue.vertices.len() - 1;
        self.ring.extend_around(&self.around_blue, edge.index + 1, count);
    }

    /// Spreads the fan from a place over the ring, if all its triangles are counter-clockwise in plan, and none lies over others by
    /// more than the tolerance.
    fn spread(&mut self, reference: &Reference, plan: DVec2, grid: DVec2, tolerance: f64) -> bool {
        let spread = self.fan.spread(reference, grid, &self.ring.points, self.ring.is_closed);
        spread.is_upright || spread.fold <= tolerance && self.ring.is_seen_from(plan, 0.0)
    }

    /// The best height of a vertex at a place inside the ring, over all samples under it, if one is allowed.
    pub(crate) fn fit(&mut self, reference: &Reference, plan: DVec2, grid: DVec2, tolerance: f64) -> Option<Place> {
        let mut interval = Interval::new(tolerance, None);
        self.spread(reference, plan, grid, tolerance).then_some(())?;
        self.fan.constrain(&mut self.gathered.around_blue, &mut interval);
        self.settle(reference, plan, grid, interval)
    }

    /// The best of the heights that samples allow, if the edges to the ring allow one, too.
    fn settle(&mut self, reference: &Reference, plan: DVec2, grid: DVec2, mut interval: Interval) -> Option<Place> {
        if interval.is_empty() || !self.ring.is_seen_from(plan, self.shape.least_altitude) {
            return None;
        }
        self.pieces.clear();
        match (reference.bound, reference.finer) {
            (Bound::Samples, _) => constrain_spike(reference, grid, &mut interval),
            (Bound::Surface, Some(finer)) => {
                if let Some(height) = finer.height(grid) {
                    interval.constrain(1.0, height);
                }
            }
            (Bound::Surface, None) => {
                interval.constrain_by_edges(reference, grid, &self.ring.points, &mut self.pieces);
            }
        }
        let cuts = if reference.finer.is_some() { FINER_CUTS } else { CUTS };
        let height = (0..cuts).find_map(|_| {
            let height = interval.best(self.ring.points[0].height, self.shape.height_step)?;
            let is_cut = interval.cut(&self.pieces, height)
                || self.is_cut_between_samples(reference, GridPoint { grid, height }, &mut interval);
            (!is_cut).then_some(height)
        })?;
        Some(Place {
            plan,
            point: GridPoint { grid, height },
            squares: interval.squares_at(height),
        })
    }

    /// Looks for a place between the samples where the fan from `centre` is beyond the tolerance; constrains by it. Tells whether
    /// there is one.
    fn is_cut_between_samples(&mut self, reference: &Reference, centre: GridPoint, interval: &mut Interval) -> bool {
        let Some(finer) = reference.finer.filter(|_| interval.tolerance.is_finite()) else {
            return false;
        };
        let Some(found) = self.beyond(finer, reference, centre, interval.tolerance) else {
            return false;
        };
        let mut found = [Sample::from(found)];
        self.fan.constrain(&mut found, interval);
        self.found.extend(found);
        true
    }

    /// A place between the samples where the fan from `centre` is beyond the tolerance.
    fn beyond(&self, finer: Finer, reference: &Reference, centre: GridPoint, tolerance: f64) -> Option<SurfacePoint> {
        let Ring { points, is_closed, .. } = &self.ring;
        let curvature = reference.curvature_at(centre.grid.y);
        let fan = FinerFan {
            centre,
            ring: points,
            is_closed: *is_closed,
            curvature,
        };
        let under = finer.beyond_under(&fan, tolerance);
        under.or_else(|| match reference.bound {
            Bound::Surface => finer.beyond_along(&fan, tolerance),
            Bound::Samples => None,
        })
    }

    /// Puts the places found between samples into the lists of the triangles above them, so that the next candidate fails
    /// quickly there.
    fn keep_found(&mut self, sampled: &mut SampledSurface, edge: Edge) {
        while let Some(found) = self.found.pop() {
            let around_blue = sampled.triangle_around(edge.blue, found.at);
            let Some(triangle) = around_blue.or_else(|| sampled.triangle_around(edge.red, found.at)) else {
                continue;
            };
            let sample = sampled.samples.add(SurfacePoint {
                at: found.at,
                height: found.height,
            });
            sampled.samples.put(triangle, &sample);
            if around_blue.is_some() {
                self.gathered.around_blue.push(sample);
            } else {
                self.gathered.others.push(sample);
            }
        }
    }

    /// Sum of the squared differences under the ring, seen from a point; none where one is beyond the tolerance.
    pub(crate) fn squares(&mut self, reference: &Reference, centre: GridPoint, tolerance: f64) -> Option<f64> {
        let mut interval = Interval::new(tolerance, Some(centre.height));
        let spread = self
            .fan
            .spread(reference, centre.grid, &self.ring.points, self.ring.is_closed);
        if spread.fold > tolerance {
            return None;
        }
        self.fan.constrain(&mut self.gathered.around_blue, &mut interval);
        if interval.is_empty() {
            return None;
        }
        Some(interval.squares_at(centre.height))
    }
}

/// The heights that a red vertex may have, whatever is around it.
fn interval_of(sampled: &SampledSurface, red: u32, is_at_its_place: bool, tolerance: f64) -> Interval {
    let keeps = is_at_its_place && sampled.keeps_height(red);
    Interval::new(tolerance, keeps.then(|| sampled.surface.height(red)))
}

/// Keeps a vertex near the surface at its place. Where the bound is at samples, only that keeps it from standing out like a spike
/// when its triangles hold hardly any.
fn constrain_spike(reference: &Reference, grid: DVec2, interval: &mut Interval) {
    if !interval.is_single()
        && let Some(height) = reference.heights.height_near(grid)
    {
        interval.constrain(1.0 / SPIKE, height / SPIKE);
    }
}
