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

use glam::DVec3;

use crate::height_field::collapse::{Edge, Ring, Scratch};
use crate::height_field::filters;
use crate::height_field::outline::OutlineChains;
use crate::height_field::samples::SampleLists;
use crate::height_field::surface::Surface;
use crate::levels::collapse_log::{Band, CollapseLog};

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
    pub(crate) fn keeps_height(self) -> bool {
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
    /// The red vertex may go to the middle of the edge; four neighbours are tried, again wherever something changed.
    Default,
    /// All neighbours, more places; edge swaps and vertex moves where no log is kept.
    Best,
}

impl Quality {
    /// Where on the edge the red vertex is tried, as shares of the way from its own place to the blue vertex's.
    pub(crate) fn places(self) -> &'static [f64] {
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
            Self::Default => 4,
            Self::Best => usize::MAX,
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
    pub(crate) outline: OutlineChains,
    pub(crate) outline_strayed: f64,
    pub(crate) log: CollapseLog,
    /// The round in which each vertex was last a red one.
    pub(crate) touched: Vec<u32>,
    pub(crate) round: u32,
    pub(crate) scratch: Scratch,
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
        scratch.around_blue.surround(&self.surface, blue);
        scratch.clear_samples();
        self.gather_around(blue, &mut scratch.samples);
        let allowance = Allowance {
            vertical: tolerance,
            outline: 0.0,
        };
        let shape = Shape {
            least_altitude: 0.0,
            ..self.shape
        };
        let place = scratch.around_blue.vertices.iter().position(|&vertex| vertex == red);
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

    pub(crate) fn is_touched(&self, vertex: u32) -> bool {
        self.touched[vertex as usize] == self.round
    }

    fn try_vertex(&mut self, blue: u32, allowance: Allowance, is_recorded: bool, scratch: &mut Scratch) -> bool {
        scratch.around_blue.surround(&self.surface, blue);
        let around_blue = &scratch.around_blue.vertices;
        if self.is_touched(blue) || around_blue.iter().any(|&vertex| self.is_touched(vertex)) {
            return false;
        }
        self.worth_a_try[blue as usize] = false;
        scratch.clear_samples();
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
        for &vertex in scratch.ring.vertices.iter().chain([&chosen.red]) {
            self.try_again(vertex);
        }
        true
    }

    fn sort_by_distance(&self, centre: u32, around: &Ring, sorted: &mut Vec<(f64, u32, usize)>) {
        let at = self.surface.plan(centre);
        let distances = around.plan.iter().map(|plan| plan.distance_squared(at));
        let numbered = distances.zip(&around.vertices).enumerate();
        sorted.clear();
        sorted.extend(numbered.map(|(index, (distance, &vertex))| (distance, vertex, index)));
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    fn edge(&self, blue: u32, red: u32, index: usize, scratch: &Scratch) -> Edge {
        let is_on_boundary = self.surface.connectivity.is_boundary(blue)
            && (index == 0 || index + 1 == scratch.around_blue.vertices.len());
        Edge {
            blue,
            red,
            index,
            is_on_boundary,
        }
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
mod tests;
