//! Edge collapses of polygonal models: surfaces in space that are 2-manifolds, closed or with boundaries, of any topology.
//!
//! The scheme is that of [`crate::simplify`] for height fields: rounds of independent collapses, in bands of growing
//! tolerance. Where the red vertex goes is from M. Garland, P. Heckbert, *Surface Simplification Using Quadric Error
//! Metrics*, 1997; that a collapse has to keep within a distance of the given surface, and not of the one before it, is
//! from A. Guéziec, *Surface simplification inside a tolerance volume*, IBM RC 20440, 1996, with the model's own vertices in
//! the place of error spheres: bounds that are summed up from collapse to collapse are several times too large.
//!
//! ```text
//! for each band, until half of the triangles are gone:
//!     for each tolerance, the next being the least where a share of the vertices has hope:
//!         repeat until a round finds nothing:
//!             for each vertex worth a try, in memory order, whose star no collapse of this round has touched:
//!                 for each neighbour, least quadric first, and each place for the red vertex:
//!                     check quadric, link, orientation, samples of the model, way back to the model
//!                     perform the first collapse that passes all; the star around it is worth a try again
//!     close the band in the log
//! ```
//!
//! **What holds after every collapse:** the surface is a 2-manifold of the model's topology; no triangle has turned over;
//! every point of the surface is within the tolerance of the model, beyond doubt; and so is every vertex of the model, and the
//! middle of each of its edges, of the surface (on its boundary, of the boundary). What is left open, the rest of the model,
//! [`crate::hausdorff`] measures for a finished level. Until then no error is certified, and the log's bands say infinity.

mod quadric;
mod samples;
mod star;

use glam::DVec3;

use self::quadric::Quadric;
use self::samples::SampleLists;
use self::star::Star;
use crate::collapse::Edge;
use crate::collapse_log::{Band, Collapse, CollapseLog};
use crate::connectivity::Connectivity;
use crate::filters;
use crate::half_edges::{HalfEdges, edges_of};
use crate::hausdorff::SurfaceTree;
use crate::manifold::{self, ManifoldError};
use crate::mesh::Mesh;

/// A band's tolerance over that of the one before it, at least.
const STEP: f64 = std::f64::consts::SQRT_2;
/// A band begins where one in so many vertices might collapse.
const HOPEFUL: usize = 8;

/// Where red vertices may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Every vertex stays where it is in the model.
    Stay,
    /// To where the squared distances from the planes around both ends are least.
    Best,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The largest tolerance of a band, in the model's units.
    pub tolerance: f64,
    /// No collapse begins once there are so few triangles.
    pub triangles: usize,
}

/// A model while it is simplified.
pub struct ModelSimplifier {
    connectivity: HalfEdges,
    positions: Vec<DVec3>,
    /// Around [`Self::centre`], so that large coordinates cost no digits.
    quadrics: Vec<Quadric>,
    centre: DVec3,
    samples: SampleLists,
    /// The model as it was given.
    model: SurfaceTree,
    placement: Placement,
    triangle_count: usize,
    log: CollapseLog,
    /// Tolerance of the last band.
    tolerance: f64,
    /// For each vertex a tolerance below which it cannot collapse as things are.
    needed: Vec<f64>,
    /// The round in which each vertex was last a red one.
    touched: Vec<u32>,
    round: u32,
    scratch: Scratch,
}

/// What one candidate after the other needs, kept so that none allocates.
#[derive(Default)]
struct Scratch {
    around_blue: Vec<u32>,
    around_red: Vec<u32>,
    candidates: Vec<Candidate>,
    star: Star,
}

/// A collapse that might be.
#[derive(Clone, Copy)]
struct Candidate {
    edge: Edge,
    /// Where the quadrics are least, if the red vertex may go there.
    best: Option<DVec3>,
    /// Root of the mean squared distance of the planes from there.
    distance: f64,
}

impl ModelSimplifier {
    /// Begins with `mesh`, whose positions are finite.
    ///
    /// # Errors
    /// Where it is no oriented 2-manifold.
    pub fn new(mesh: &Mesh, placement: Placement) -> Result<Self, ManifoldError> {
        manifold::check_corners(mesh)?;
        manifold::check_stars(&Connectivity::new(mesh))?;
        let connectivity = HalfEdges::new(mesh.positions.len(), mesh.triangles.clone());
        let (low, high) = mesh.bounds();
        let model = SurfaceTree::new(mesh);
        let mut simplifier = Self {
            samples: SampleLists::new(&mesh.positions, &connectivity),
            tolerance: model.least(),
            model,
            connectivity,
            positions: mesh.positions.clone(),
            quadrics: vec![Quadric::ZERO; mesh.positions.len()],
            centre: (low + high) / 2.0,
            placement,
            triangle_count: mesh.triangles.len(),
            log: CollapseLog::default(),
            needed: vec![0.0; mesh.positions.len()],
            touched: vec![0; mesh.positions.len()],
            round: 0,
            scratch: Scratch::default(),
        };
        simplifier.add_planes();
        Ok(simplifier)
    }

    /// Collapses until half of the triangles are gone, by growing tolerance, and closes the band; tells whether a further one
    /// might come nearer to the goal.
    pub fn next_band(&mut self, goal: Goal) -> bool {
        let half = self.triangle_count / 2;
        let mut goes_on = true;
        while goes_on && self.triangle_count > half {
            goes_on = self.next_tolerance(goal);
        }
        self.close_band();
        goes_on
    }

    /// Triangles by now.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// The log of all collapses so far. Its bands' errors are infinite, which is to say not known.
    #[must_use]
    pub fn log(&self) -> &CollapseLog {
        &self.log
    }

    /// Collapses what the next tolerance allows; tells whether a further one might come nearer to the goal.
    fn next_tolerance(&mut self, goal: Goal) -> bool {
        self.tolerance = self.hopeful_tolerance().max(self.tolerance * STEP).min(goal.tolerance);
        while self.round(goal.triangles) > 0 {}
        self.triangle_count > goal.triangles && self.tolerance < goal.tolerance && self.live_needs().any(f64::is_finite)
    }

    fn close_band(&mut self) {
        let begin = self.log.bands.last().map_or(0, |band| band.end);
        let end = self.log.collapses.len();
        if end > begin {
            let error = f64::INFINITY;
            self.log.bands.push(Band { end, error });
        }
    }

    /// The tolerance from which on one in [`HOPEFUL`] of the vertices might collapse.
    fn hopeful_tolerance(&self) -> f64 {
        let mut needs: Vec<f64> = self.live_needs().collect();
        let place = needs.len() / HOPEFUL;
        if needs.is_empty() {
            return 0.0;
        }
        *needs.select_nth_unstable_by(place, f64::total_cmp).1
    }

    fn live_needs(&self) -> impl Iterator<Item = f64> + '_ {
        let live = |&(vertex, _): &(u32, &f64)| self.connectivity.is_live(vertex);
        (0..).zip(&self.needed).filter(live).map(|(_, &needed)| needed)
    }

    /// Planes of the triangles, weighted by area, and upright ones along the boundary.
    fn add_planes(&mut self) {
        for triangle in 0..self.connectivity.triangle_slots() {
            for edge in edges_of(triangle) {
                let ends = [self.connectivity.origin(edge), self.connectivity.end(edge)];
                let [from, to] = ends.map(|vertex| self.positions[vertex as usize] - self.centre);
                let apex = self.positions[self.connectivity.apex(edge) as usize] - self.centre;
                let doubled = (to - from).cross(apex - from);
                let normal = doubled.normalize_or_zero();
                let plane = Quadric::plane(from, normal, doubled.length());
                let quadric = &mut self.quadrics[ends[0] as usize];
                *quadric = *quadric + plane;
                if self.connectivity.twin(edge) == crate::half_edges::NONE {
                    let across = (to - from).cross(normal).normalize_or_zero();
                    let upright = Quadric::plane(from, across, from.distance_squared(to));
                    for end in ends {
                        let quadric = &mut self.quadrics[end as usize];
                        *quadric = *quadric + upright;
                    }
                }
            }
        }
    }

    /// Tries every vertex that is worth it, down to `fewest` triangles, and tells how many were collapsed.
    fn round(&mut self, fewest: usize) -> usize {
        self.round += 1;
        let mut scratch = std::mem::take(&mut self.scratch);
        let mut count = 0;
        for vertex in 0..self.positions.len() as u32 {
            let is_worth_it = self.needed[vertex as usize] <= self.tolerance && self.connectivity.is_live(vertex);
            if is_worth_it && self.triangle_count > fewest {
                count += usize::from(self.try_vertex(vertex, &mut scratch));
            }
        }
        self.scratch = scratch;
        count
    }

    fn is_touched(&self, vertex: u32) -> bool {
        self.touched[vertex as usize] == self.round
    }

    fn try_vertex(&mut self, blue: u32, scratch: &mut Scratch) -> bool {
        self.connectivity.ring(blue, &mut scratch.around_blue);
        if self.is_touched(blue) || scratch.around_blue.iter().any(|&vertex| self.is_touched(vertex)) {
            return false;
        }
        self.list_candidates(blue, scratch);
        let mut needed = f64::INFINITY;
        for index in 0..scratch.candidates.len() {
            let candidate = scratch.candidates[index];
            match self.check(&candidate, scratch) {
                Ok(place) => {
                    self.perform(candidate.edge, place, scratch);
                    return true;
                }
                Err(tolerance) => needed = needed.min(tolerance),
            }
        }
        self.needed[blue as usize] = needed;
        false
    }

    /// The neighbours that a vertex may collapse into, the least quadric first.
    fn list_candidates(&self, blue: u32, scratch: &mut Scratch) {
        let Scratch {
            around_blue,
            candidates,
            ..
        } = scratch;
        let on_boundary = self.connectivity.is_boundary(blue);
        let last = around_blue.len() - 1;
        candidates.clear();
        for (index, &red) in around_blue.iter().enumerate() {
            let is_on_boundary = on_boundary && (index == 0 || index == last);
            if on_boundary && !is_on_boundary {
                continue;
            }
            candidates.push(self.candidate(Edge {
                blue,
                red,
                index,
                is_on_boundary,
            }));
        }
        candidates.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.edge.red.cmp(&b.edge.red)));
    }

    fn candidate(&self, edge: Edge) -> Candidate {
        let [blue, red] = [edge.blue, edge.red].map(|vertex| self.positions[vertex as usize] - self.centre);
        let sum = self.quadrics[edge.blue as usize] + self.quadrics[edge.red as usize];
        let may_move = self.placement == Placement::Best
            && self.connectivity.is_boundary(edge.blue) == self.connectivity.is_boundary(edge.red);
        let place = if may_move {
            sum.best_place((blue + red) / 2.0)
        } else {
            red
        };
        // The best place is the same from both ends: one that failed from the other needs no second try.
        let is_news = self.needed[edge.red as usize] <= self.tolerance;
        Candidate {
            edge,
            best: (may_move && is_news).then_some(place + self.centre),
            distance: sum.mean_distance(place),
        }
    }

    /// Where the red vertex can go.
    ///
    /// # Errors
    /// A tolerance below which it can go nowhere; infinity where that is for another reason than distance.
    fn check(&self, candidate: &Candidate, scratch: &mut Scratch) -> Result<DVec3, f64> {
        if candidate.distance > self.tolerance {
            return Err(candidate.distance);
        }
        let Edge { blue, red, .. } = candidate.edge;
        let Scratch {
            around_blue,
            around_red,
            star,
            ..
        } = scratch;
        self.connectivity.ring(red, around_red);
        if around_red.iter().any(|&vertex| self.is_touched(vertex)) {
            return Err(self.tolerance);
        }
        if !filters::link_allows(&self.connectivity, candidate.edge, around_blue, around_red) {
            return Err(f64::INFINITY);
        }
        star.gather(&self.connectivity, &self.positions, &self.samples, [blue, red]);
        let own = self.positions[red as usize];
        let mut needed = f64::INFINITY;
        for place in candidate.best.into_iter().chain([own]) {
            if !star.keeps_sides(place) {
                continue;
            }
            let there = star.keeps_samples(place, self.tolerance);
            let and_back = |()| {
                star.triangles(place)
                    .try_for_each(|corners| self.model.holds(corners, self.tolerance))
            };
            match there.and_then(and_back) {
                Ok(()) => return Ok(place),
                Err(distance) => needed = needed.min(distance),
            }
        }
        Err(needed)
    }

    fn perform(&mut self, edge: Edge, place: DVec3, scratch: &mut Scratch) {
        let Edge { blue, red, .. } = edge;
        self.log.collapses.push(Collapse {
            blue,
            red,
            red_before: self.positions[red as usize],
            red_after: place,
        });
        scratch.star.lay_samples(place, &mut self.samples);
        self.connectivity.collapse(blue, red);
        self.triangle_count -= if edge.is_on_boundary { 1 } else { 2 };
        self.positions[red as usize] = place;
        self.quadrics[red as usize] = self.quadrics[red as usize] + self.quadrics[blue as usize];
        self.touched[red as usize] = self.round;
        self.connectivity.ring(red, &mut scratch.around_red);
        for &vertex in scratch.around_red.iter().chain([&red]) {
            self.needed[vertex as usize] = 0.0;
        }
    }
}

#[cfg(test)]
#[path = "model_tests.rs"]
pub(crate) mod tests;
