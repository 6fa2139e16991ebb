//! Edge collapses of polygonal models: surfaces in space that are 2-manifolds, closed or with boundaries, of any topology.
//!
//! Where the red vertex goes is from M. Garland, P. Heckbert, *Surface Simplification Using Quadric Error Metrics*, 1997; that a
//! collapse has to keep within a distance of the given surface, and not of the one before it, is from A. Guéziec, *Surface
//! simplification inside a tolerance volume*, IBM RC 20440, 1996, with the model's own vertices in the place of error spheres:
//! bounds that are summed up from collapse to collapse are several times too large.
//!
//! ```text
//! all vertices wait on the lowest rung of tolerances, a quarter of a power of two each
//! for each band, until half of the triangles are gone:
//!     take the vertex on the lowest rung that has waited longest
//!     for each neighbour, least quadric first, and each place for the red vertex:
//!         check quadric, link, orientation, samples of the model, way back to the model, all for that rung's tolerance
//!     perform the first collapse that passes all; the star around it waits on this rung again
//!     if there is none, it waits on the first rung where there is hope
//!     close the band in the log
//! ```
//!
//! **What holds after every collapse:** the surface is a 2-manifold of the model's topology; no triangle has turned over; every
//! vertex of the model, and the middle of each of its edges, is within the tolerance of the surface (on its boundary, of the
//! boundary); and so is every vertex of the surface, and the middle of each of its edges and triangles, of the model. That is
//! nearly all: what lies between them [`crate::space::hausdorff`] measures for a finished level. Until then no error is certified, and
//! the log's bands say infinity.

mod quadric;
mod queue;
mod samples;
mod star;

use glam::DVec3;

use self::quadric::Quadric;
use self::queue::{Queue, Rung};
use self::samples::SampleLists;
use self::star::Star;
use crate::levels::collapse_log::{Band, Collapse, CollapseLog};
use crate::mesh::Mesh;
use crate::space::hausdorff::SurfaceTree;
use crate::topology::connectivity::Connectivity;
use crate::topology::edge_collapse::{Edge, link_allows};
use crate::topology::half_edges::{HalfEdges, edges_of};
use crate::topology::manifold::{self, ManifoldError};

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
    /// The largest tolerance of a collapse, in the model's units.
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
    queue: Queue,
    /// The facet of the model that each vertex was found near.
    beside: Vec<u32>,
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
    /// Where the quadrics are least, if the red vertex may go there, and where it is.
    choices: [Option<Choice>; 2],
    /// The lesser distance of both.
    distance: f64,
}

/// A place for the red vertex.
#[derive(Clone, Copy)]
struct Choice {
    at: DVec3,
    /// Root of the mean squared distance of the planes from there.
    distance: f64,
}

/// What collapses are tried for.
#[derive(Clone, Copy)]
struct Attempt {
    rung: Rung,
    tolerance: f64,
}

/// Where a red vertex can go, and a facet of the model near there.
#[derive(Clone, Copy)]
struct Place {
    at: DVec3,
    beside: u32,
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
            queue: Queue::new(mesh.positions.len()),
            model,
            connectivity,
            positions: mesh.positions.clone(),
            quadrics: vec![Quadric::ZERO; mesh.positions.len()],
            centre: (low + high) / 2.0,
            placement,
            triangle_count: mesh.triangles.len(),
            log: CollapseLog::default(),
            beside: vec![0; mesh.positions.len()],
            scratch: Scratch::default(),
        };
        simplifier.add_planes();
        simplifier.queue_all();
        Ok(simplifier)
    }

    /// Collapses until half of the triangles are gone, by growing tolerance, and closes the band; tells whether a further one
    /// might come nearer to the goal.
    pub fn next_band(&mut self, goal: Goal) -> bool {
        let fewest = goal.triangles.max(self.triangle_count / 2);
        let mut goes_on = true;
        while goes_on && self.triangle_count > fewest {
            goes_on = self.next_vertex(goal.tolerance);
        }
        self.close_band();
        goes_on && self.triangle_count > goal.triangles
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

    /// Tries the next vertex; tells whether there was one that might collapse within a tolerance.
    fn next_vertex(&mut self, tolerance: f64) -> bool {
        let Some((rung, vertex)) = self.queue.take() else {
            return false;
        };
        if rung.start() > tolerance {
            self.queue.put(vertex, rung);
            return false;
        }
        let attempt = Attempt {
            rung,
            tolerance: rung.next().start().min(tolerance),
        };
        let mut scratch = std::mem::take(&mut self.scratch);
        self.try_vertex(vertex, attempt, &mut scratch);
        self.scratch = scratch;
        true
    }

    fn close_band(&mut self) {
        let begin = self.log.bands.last().map_or(0, |band| band.end);
        let end = self.log.collapses.len();
        if end > begin {
            let error = f64::INFINITY;
            self.log.bands.push(Band { end, error });
        }
    }

    /// Lets all vertices of triangles wait on the lowest rung.
    fn queue_all(&mut self) {
        let lowest = Rung::of(self.model.least());
        let live = (0..self.positions.len() as u32).filter(|&vertex| self.connectivity.is_live(vertex));
        live.for_each(|vertex| self.queue.put(vertex, lowest));
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
                if self.connectivity.twin(edge) == crate::topology::half_edges::NONE {
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

    /// Collapses a vertex, or puts it on the rung where that might be possible, if there is one.
    fn try_vertex(&mut self, blue: u32, attempt: Attempt, scratch: &mut Scratch) {
        self.connectivity.ring(blue, &mut scratch.around_blue);
        self.list_candidates(blue, attempt, scratch);
        let mut needed = f64::INFINITY;
        for index in 0..scratch.candidates.len() {
            let candidate = scratch.candidates[index];
            match self.check(&candidate, attempt.tolerance, scratch) {
                Ok(place) => return self.perform(candidate.edge, place, attempt, scratch),
                Err(tolerance) => needed = needed.min(tolerance),
            }
        }
        if needed.is_finite() {
            self.queue.put(blue, Rung::of(needed).max(attempt.rung.next()));
        }
    }

    /// The neighbours that a vertex may collapse into, the least quadric first.
    fn list_candidates(&self, blue: u32, attempt: Attempt, scratch: &mut Scratch) {
        let Scratch {
            around_blue,
            candidates,
            ..
        } = scratch;
        let on_boundary = self.connectivity.is_boundary(blue);
        let edges = (0..around_blue.len()).map(|index| Edge::new(&self.connectivity, blue, around_blue, index));
        let along = edges.filter(|edge| edge.is_on_boundary || !on_boundary);
        candidates.clear();
        candidates.extend(along.map(|edge| self.candidate(edge, attempt)));
        candidates.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.edge.red.cmp(&b.edge.red)));
    }

    fn candidate(&self, edge: Edge, attempt: Attempt) -> Candidate {
        let [blue, red] = [edge.blue, edge.red].map(|vertex| self.positions[vertex as usize] - self.centre);
        let sum = self.quadrics[edge.blue as usize] + self.quadrics[edge.red as usize];
        let choice = |place: DVec3| Choice {
            at: place + self.centre,
            distance: sum.mean_distance(place),
        };
        let may_move = self.placement == Placement::Best
            && self.connectivity.is_boundary(edge.blue) == self.connectivity.is_boundary(edge.red);
        // The best place is the same from both ends: one that failed from the other needs no second try.
        let is_news = !self.queue.is_past(edge.red, attempt.rung);
        let best = (may_move && is_news).then(|| choice(sum.best_place((blue + red) / 2.0)));
        let own = Choice {
            at: self.positions[edge.red as usize],
            ..choice(red)
        };
        Candidate {
            edge,
            choices: [best, Some(own)],
            distance: best.map_or(own.distance, |best| best.distance.min(own.distance)),
        }
    }

    /// Where the red vertex can go.
    ///
    /// # Errors
    /// A tolerance below which it can go nowhere; infinity where that is for another reason than distance.
    fn check(&self, candidate: &Candidate, tolerance: f64, scratch: &mut Scratch) -> Result<Place, f64> {
        if candidate.distance > tolerance {
            return Err(candidate.distance);
        }
        let edge = candidate.edge;
        self.connectivity.ring(edge.red, &mut scratch.around_red);
        if !link_allows(&self.connectivity, edge, &scratch.around_blue, &scratch.around_red) {
            return Err(f64::INFINITY);
        }
        let star = &mut scratch.star;
        star.gather(&self.connectivity, &self.positions, [edge.blue, edge.red]);
        let mut needed = f64::INFINITY;
        for Choice { at, distance } in candidate.choices.into_iter().flatten() {
            if distance > tolerance {
                needed = needed.min(distance);
            } else if star.keeps_sides(at) {
                match self.check_distances(star, at, tolerance, self.beside[edge.red as usize]) {
                    Ok(beside) => return Ok(Place { at, beside }),
                    Err(distance) => needed = needed.min(distance),
                }
            }
        }
        Err(needed)
    }

    /// Whether the model's samples are within `tolerance` of a star with the red vertex at `place`, and its points of the
    /// model; tells a facet that the place is near, which may be `expected`.
    ///
    /// # Errors
    /// The first distance that is more.
    fn check_distances(&self, star: &mut Star, place: DVec3, tolerance: f64, expected: u32) -> Result<u32, f64> {
        let beside = self.model.facet_within(tolerance, place, expected)?;
        star.keeps_samples(place, tolerance, &self.samples)?;
        let mut expected = beside;
        for point in star.points(place) {
            expected = self.model.facet_within(tolerance, point, expected)?;
        }
        Ok(beside)
    }

    fn perform(&mut self, edge: Edge, place: Place, attempt: Attempt, scratch: &mut Scratch) {
        let Edge { blue, red, .. } = edge;
        self.log.collapses.push(Collapse {
            blue,
            red,
            red_before: self.positions[red as usize],
            red_after: place.at,
            closes_hole: false,
        });
        scratch.star.lay_samples(place.at, &mut self.samples);
        self.connectivity.collapse(blue, red);
        self.triangle_count -= if edge.is_on_boundary { 1 } else { 2 };
        self.positions[red as usize] = place.at;
        self.beside[red as usize] = place.beside;
        self.quadrics[red as usize] = self.quadrics[red as usize] + self.quadrics[blue as usize];
        self.connectivity.ring(red, &mut scratch.around_red);
        for &vertex in scratch.around_red.iter().chain([&red]) {
            self.queue.put(vertex, attempt.rung);
        }
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
pub(crate) mod tests;
