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
//!
//! A hole that has come down to three vertices is closed by the collapse of one of its edges, where all of it is within what
//! the outline may stray: no sample is under it that constrains the surface, and its other two edges become one.

use glam::{DVec2, DVec3};

use crate::height_field::attempts::Attempts;
use crate::height_field::evaluator::Evaluator;
use crate::height_field::filters;
use crate::height_field::sampled_surface::{Chosen, SampledSurface};
use crate::height_field::surface::Surface;
use crate::levels::collapse_log::{Band, Collapse, CollapseLog};
use crate::topology::edge_collapse::Edge;

pub use crate::height_field::rules::{Allowance, Quality, Shape, VertexKind};

/// A mesh while it is simplified.
pub struct Simplifier<'a> {
    pub(crate) sampled: SampledSurface<'a>,
    pub(crate) evaluator: Evaluator,
    pub(crate) attempts: Attempts,
    /// Neighbours of the vertex that is tried: squared distance, number, place around it.
    nearest_first: Vec<(f64, u32, usize)>,
    log: CollapseLog,
}

impl<'a> Simplifier<'a> {
    /// Begins with `surface`. `kinds` tells what each vertex may do; vertices of the outline that are
    /// [`VertexKind::Free`] become [`VertexKind::Outline`], and [`VertexKind::Border`] where the outline touches itself.
    #[must_use]
    pub fn new(surface: Surface<'a>, kinds: Vec<VertexKind>, shape: Shape, quality: Quality) -> Self {
        Self {
            attempts: Attempts::new(kinds.len()),
            sampled: SampledSurface::new(surface, kinds),
            evaluator: Evaluator::new(shape, quality),
            nearest_first: Vec::new(),
            log: CollapseLog::default(),
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
        if [blue, red]
            .into_iter()
            .any(|vertex| self.sampled.outline.visits(vertex) > 1)
        {
            return false;
        }
        self.attempts.begin_round();
        self.evaluator.around_blue.surround(&self.sampled.surface, blue);
        self.evaluator.gather(&self.sampled, blue);
        let around = &self.evaluator.around_blue.vertices;
        let Some(index) = around.iter().position(|&vertex| vertex == red) else {
            return false;
        };
        let allowance = Allowance {
            vertical: tolerance,
            outline: 0.0,
            // Along the side that is a straight line; but not to a neighbour that is not along it.
            breaklines: f64::MAX,
        };
        let least_altitude = std::mem::replace(&mut self.evaluator.shape.least_altitude, 0.0);
        let chosen = self.checked(blue, index, allowance);
        self.evaluator.shape.least_altitude = least_altitude;
        if let Some(chosen) = &chosen {
            self.perform(blue, chosen, true);
        }
        chosen.is_some()
    }

    /// How far, in metres, the outline strays by now from that of the mesh the simplifier began with.
    #[must_use]
    pub fn outline_strayed(&self) -> f64 {
        self.sampled.outline_strayed
    }

    /// The same of breaklines.
    #[must_use]
    pub fn breaklines_strayed(&self) -> f64 {
        self.sampled.breaklines_strayed
    }

    /// The edges along breaklines that are left, by the vertices' places in plan.
    #[must_use]
    pub fn breaklines(&self) -> Vec<[DVec2; 2]> {
        let edges = self.sampled.breaklines.left_edges().into_iter();
        edges
            .map(|edge| edge.map(|end| self.sampled.surface.plan(end)))
            .collect()
    }

    /// Position of a vertex.
    #[must_use]
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.sampled.surface.position(vertex)
    }

    /// The log of all collapses so far.
    #[must_use]
    pub fn log(&self) -> &CollapseLog {
        &self.log
    }

    /// Rounds so far: each is at most one level of the Surface Partition.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        self.attempts.rounds()
    }

    /// The surface as it is now.
    #[must_use]
    pub fn surface(&self) -> &Surface<'a> {
        &self.sampled.surface
    }

    /// The surface as it is now, for good.
    #[must_use]
    pub fn into_surface(self) -> Surface<'a> {
        self.sampled.into_surface()
    }

    pub(crate) fn try_all(&mut self) {
        for vertex in 0..self.sampled.kinds.len() as u32 {
            self.try_again(vertex);
        }
    }

    pub(crate) fn try_again(&mut self, vertex: u32) {
        let is_border = self.sampled.kinds[vertex as usize] == VertexKind::Border;
        self.attempts.set_worth_it(vertex, !is_border);
    }

    /// Tries every vertex that is worth it and tells how many were collapsed. Only an independent set, if that is asked
    /// for, and then also recorded.
    pub(crate) fn round(&mut self, allowance: Allowance, is_recorded: bool) -> usize {
        self.attempts.begin_round();
        let mut count = 0;
        for vertex in 0..self.sampled.kinds.len() as u32 {
            if self.attempts.is_worth_it(vertex) && self.sampled.surface.connectivity.is_live(vertex) {
                count += usize::from(self.try_vertex(vertex, allowance, is_recorded));
            }
        }
        count
    }

    fn try_vertex(&mut self, blue: u32, allowance: Allowance, is_recorded: bool) -> bool {
        self.evaluator.around_blue.surround(&self.sampled.surface, blue);
        let around_blue = &self.evaluator.around_blue.vertices;
        if self.attempts.is_any_touched(&[blue]) || self.attempts.is_any_touched(around_blue) {
            return false;
        }
        self.attempts.set_worth_it(blue, false);
        self.evaluator.gather(&self.sampled, blue);
        self.sort_neighbours(blue);
        let count = self.nearest_first.len().min(self.evaluator.quality.neighbours());
        let chosen = (0..count).find_map(|number| self.checked(blue, self.nearest_first[number].2, allowance));
        let Some(chosen) = chosen else { return false };
        self.perform(blue, &chosen, is_recorded);
        if is_recorded {
            self.attempts.touch(chosen.red);
        }
        for place in 0..self.sampled.ring.vertices.len() {
            self.try_again(self.sampled.ring.vertices[place]);
        }
        self.try_again(chosen.red);
        true
    }

    /// Passes the collapse of a vertex into a neighbour, numbered around it, through all filters.
    fn checked(&mut self, blue: u32, index: usize, allowance: Allowance) -> Option<Chosen> {
        let Self {
            sampled,
            evaluator,
            attempts,
            ..
        } = self;
        let surface = &sampled.surface;
        let mut edge = Edge::new(&surface.connectivity, blue, &evaluator.around_blue.vertices, index);
        edge.closes = sampled.closes(edge);
        let is_of_side = sampled.kinds[blue as usize] == VertexKind::Border;
        if !is_of_side && !filters::kinds_allow(surface, &sampled.kinds, edge) {
            return None;
        }
        evaluator.checked(sampled, attempts, edge, allowance)
    }

    fn perform(&mut self, blue: u32, chosen: &Chosen, is_recorded: bool) {
        let Chosen { red, place, .. } = chosen;
        if is_recorded {
            self.log.collapses.push(Collapse {
                blue,
                red: *red,
                red_before: self.sampled.surface.position(*red),
                red_after: place.plan.extend(place.point.height),
                closes_hole: chosen.closes.is_some(),
            });
        }
        self.sampled.collapse(blue, chosen, &mut self.evaluator.gathered);
    }

    fn sort_neighbours(&mut self, centre: u32) {
        let at = self.sampled.surface.plan(centre);
        let around = &self.evaluator.around_blue;
        let distances = around.plan.iter().map(|plan| plan.distance_squared(at));
        let numbered = distances.zip(&around.vertices).enumerate();
        self.nearest_first.clear();
        self.nearest_first
            .extend(numbered.map(|(index, (distance, &vertex))| (distance, vertex, index)));
        self.nearest_first
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
mod tests;
