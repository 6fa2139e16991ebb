//! Curved levels of detail by merging patches (§7, §8), each with a certified error (§10).
//!
//! ```text
//! for each level, until few enough patches are left:
//!     tag every vertex undecided
//!     for each vertex by what its removal certifies, least first, up to this level's limit:
//!         if it is undecided, and a plan is found for it:
//!             match one side of its mergeable pair: T, or a swap and then T
//!             match the other one: T, 2T, T-in-T, or a swap and then T
//!             match, by the same rules, the other side of each vertex that 2T and T-in-T remove
//!             swap, merge, tag vertices removed and retained
//!     where that was little: turn edges that take from vertices of high degree, and let pairs deviate more
//! ```
//! A plan tags vertices as it grows, so that no vertex goes that another pattern needs as a corner, and takes its tags back
//! where it fails.
//!
//! **What holds after every plan:** patches meet as before, to the bit; the surface is a manifold of the same topology, no two of
//! its vertices joined by a new second edge; every patch's error bounds its distance from the part of the model it stands for,
//! both ways: a merged patch's is what it deviates from each of its parts plus that part's own. A patch whose normals turn
//! farther than [`Options::least_cosine`] from its chord triangle's does not arise, nor one with a longer side than
//! [`Options::longest_side`].

mod plan;
mod search;

use glam::DVec3;

use self::plan::{Made, Side};
use self::search::Plan;
use crate::curved::levels::{CurvedLevels, LevelPatch};
use crate::curved::model::CurvedModel;
use crate::curved::patch::CURVES;
use crate::topology::half_edges::{NONE, edges_of, next};

/// When to stop, and what may become of patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// No patch has a larger certified error, in the model's units.
    pub max_error: f64,
    /// No level begins once there are so few patches.
    pub patches: usize,
    /// How far from straight on the edges of a pair may be, in radians, to begin with.
    pub angle: f64,
    /// The same where nothing else is left.
    pub largest_angle: f64,
    /// The curvature guard: the least cosine between a new patch's normals at its corners and the normal of its corners' triangle.
    pub least_cosine: f64,
    /// The size guard: the longest distance between two corners of a new patch.
    pub longest_side: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_error: f64::INFINITY,
            patches: 0,
            angle: 0.4,
            largest_angle: 1.2,
            least_cosine: 0.3,
            longest_side: f64::INFINITY,
        }
    }
}

/// What is decided of a vertex, for one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tag {
    Undecided,
    Retained,
    Removed,
}

/// Of the removals that can be done a level does those that certify the least, this part of them.
const SHARE_OF_A_LEVEL: f64 = 0.5;

/// A level that removes a smaller part of all vertices is stuck.
const STUCK: f64 = 0.01;

/// How much more edges of a pair may deviate after a level that was stuck.
const RELAXED: f64 = 1.5;

/// Makes levels of detail of a model, each coarser than the one before. After each level `progress` is told how many patches
/// are left.
pub fn simplify(model: CurvedModel, options: &Options, progress: impl FnMut(usize)) -> CurvedLevels {
    let mut simplifier = Simplifier::new(model, options);
    simplifier.run(progress);
    simplifier.into_levels()
}

struct Simplifier {
    options: Options,
    /// The surface; patches stay at their places until they are merged.
    model: CurvedModel,
    /// For each place.
    errors: Vec<f64>,
    born: Vec<u32>,
    patch_count: usize,
    gone: Vec<LevelPatch>,
    level: u32,
    tags: Vec<Tag>,
    /// What the removal of each vertex certifies; infinite where it cannot be removed.
    costs: Vec<f64>,
    is_stale: Vec<bool>,
    /// Whether the edges around each vertex were not looked at since they changed.
    may_turn: Vec<bool>,
    angle: f64,
    limit: f64,
}

impl Simplifier {
    fn new(model: CurvedModel, options: &Options) -> Self {
        let vertices = model.topology.vertex_slots() as usize;
        let patches = model.patches.len();
        Self {
            options: *options,
            model,
            errors: vec![0.0; patches],
            born: vec![0; patches],
            patch_count: patches,
            gone: Vec::new(),
            level: 0,
            tags: vec![Tag::Undecided; vertices],
            costs: vec![f64::INFINITY; vertices],
            is_stale: vec![true; vertices],
            may_turn: vec![true; vertices],
            angle: options.angle,
            limit: 0.0,
        }
    }

    fn run(&mut self, mut progress: impl FnMut(usize)) {
        let mut live: Vec<u32> = (0..self.tags.len() as u32).collect();
        while self.patch_count > self.options.patches {
            live.retain(|&vertex| self.model.topology.is_live(vertex));
            self.reset(&live);
            self.level += 1;
            let removed = self.remove_cheapest(&live);
            let is_stuck = (removed as f64) < STUCK * live.len() as f64;
            let turned = if is_stuck { self.reduce_degrees(&live) } else { 0 };
            if is_stuck && !self.relax(&live) && removed + turned == 0 {
                self.level -= 1;
                break;
            }
            progress(self.patch_count);
        }
    }

    fn reset(&mut self, live: &[u32]) {
        for &vertex in live {
            self.tags[vertex as usize] = Tag::Undecided;
            if std::mem::replace(&mut self.is_stale[vertex as usize], false) {
                self.costs[vertex as usize] = self.cost(vertex);
            }
        }
    }

    /// Lets pairs deviate more; false where they cannot.
    fn relax(&mut self, live: &[u32]) -> bool {
        let relaxed = (self.angle * RELAXED).min(self.options.largest_angle);
        let is_more = relaxed > self.angle;
        self.angle = relaxed;
        if is_more {
            live.iter().for_each(|&vertex| self.is_stale[vertex as usize] = true);
        }
        is_more
    }

    /// One pass over the vertices, cheapest first; how many went.
    fn remove_cheapest(&mut self, live: &[u32]) -> usize {
        let cost = |vertex: &u32| self.costs[*vertex as usize];
        let mut order: Vec<u32> = live
            .iter()
            .copied()
            .filter(|vertex| cost(vertex) <= self.options.max_error)
            .collect();
        order.sort_unstable_by(|a, b| cost(a).total_cmp(&cost(b)).then(a.cmp(b)));
        order.retain(|vertex| cost(vertex) < f64::INFINITY);
        let Some(&last) = order.get((order.len() as f64 * SHARE_OF_A_LEVEL) as usize) else {
            return 0;
        };
        self.limit = self.limit.max(cost(&last));
        let mut removed = 0;
        for vertex in order {
            if self.costs[vertex as usize] > self.limit || self.patch_count <= self.options.patches {
                break;
            }
            let is_free = self.tags[vertex as usize] == Tag::Undecided && !self.is_stale[vertex as usize];
            if let Some(plan) = is_free.then(|| self.plan(vertex)).flatten() {
                removed += plan.removed.len();
                self.perform(&plan);
            }
        }
        removed
    }

    /// Swaps and merges; tags what the plan decided.
    fn perform(&mut self, plan: &Plan) {
        for &(vertex, tag) in &plan.tags {
            self.tags[vertex as usize] = tag;
        }
        for side in &plan.sides {
            side.slots.iter().for_each(|&slot| self.bury(slot));
            if let Some(edge) = side.flip {
                self.model.topology.flip(edge);
            }
        }
        for &(vertex, red) in &plan.removed {
            self.model.topology.collapse(vertex, red);
            self.costs[vertex as usize] = f64::INFINITY;
        }
        let placed: Vec<u32> = plan.sides.iter().flat_map(|side| self.place(side)).collect();
        self.patch_count += placed.len();
        self.patch_count -= plan.sides.iter().map(|side| side.slots.len()).sum::<usize>();
        placed.iter().for_each(|&slot| self.weld(slot));
        placed.iter().for_each(|&slot| self.expire_around(slot));
    }

    /// Notes a patch that is about to go, if a level has it.
    fn bury(&mut self, slot: u32) {
        if self.born[slot as usize] < self.level {
            self.gone.push(self.level_patch(slot, self.level));
        }
    }

    fn level_patch(&self, slot: u32, died: u32) -> LevelPatch {
        LevelPatch {
            patch: self.model.patches[slot as usize],
            corners: self.model.topology.triangles()[slot as usize],
            creases: self.model.creases(slot),
            error: self.errors[slot as usize],
            born: self.born[slot as usize],
            died,
        }
    }

    /// Puts what a side made to the places that are left of it.
    fn place(&mut self, side: &Side) -> Vec<u32> {
        let left = side
            .slots
            .iter()
            .copied()
            .filter(|&slot| self.model.topology.corners(slot).is_some());
        let left: Vec<u32> = left.collect();
        assert_eq!(
            left.len(),
            side.made.len(),
            "a side leaves a place for each patch that it makes"
        );
        for &slot in &left {
            let corners = self.model.topology.triangles()[slot as usize];
            let fits = |made: &Made| made.from(corners[0]).filter(|made| made.corners == corners);
            let made = side.made.iter().find_map(fits);
            let made = made.expect("the topology has the corners that the plan says");
            self.model.patches[slot as usize] = made.patch;
            self.errors[slot as usize] = made.error;
            self.born[slot as usize] = self.level;
            for (edge, is_crease) in edges_of(slot).into_iter().zip(made.creases) {
                self.model.is_crease[edge as usize] = is_crease;
            }
        }
        left
    }

    /// Takes the control points of a patch's curves from across, which differ by rounding at most.
    fn weld(&mut self, slot: u32) {
        for edge in edges_of(slot) {
            let twin = self.model.topology.twin(edge);
            if twin != NONE {
                let mut curve = self.model.patches[twin as usize / 3].curve(twin as usize % 3);
                curve.reverse();
                for (place, point) in CURVES[edge as usize % 3].into_iter().zip(curve) {
                    self.model.patches[slot as usize].points[place] = point;
                }
            }
        }
    }

    /// What the removals of the vertices around a new patch cost has to be found anew.
    fn expire_around(&mut self, slot: u32) {
        for corner in self.model.topology.triangles()[slot as usize] {
            self.is_stale[corner as usize] = true;
            self.may_turn[corner as usize] = true;
            for edge in self.model.topology.leaving(corner) {
                self.is_stale[self.model.topology.end(edge) as usize] = true;
                self.is_stale[self.model.topology.apex(edge) as usize] = true;
            }
        }
    }

    /// Whether a patch may arise in the place of others (§8: curvature and size).
    fn is_allowed(&self, made: &Made) -> bool {
        let points = &made.patch.points;
        let [a, b, c] = [points[0], points[6], points[9]];
        let Some(chord) = (b - a).cross(c - a).try_normalize() else {
            return false;
        };
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        let fans = [[1, 2, 0], [7, 3, 6], [5, 8, 9]];
        let turns = fans.map(|[first, second, corner]| {
            let normal = (points[first] - points[corner]).cross(points[second] - points[corner]);
            normal.normalize_or_zero().dot(chord)
        });
        made.patch.points.iter().all(|point: &DVec3| point.is_finite())
            && longest.sqrt() <= self.options.longest_side
            && turns.into_iter().all(|cosine| cosine >= self.options.least_cosine)
    }

    /// Turns edges of vertices that have too many, where that evens degrees out (§8.2, Fig. 7); how many.
    fn reduce_degrees(&mut self, live: &[u32]) -> usize {
        let mut turned = 0;
        for &vertex in live {
            while std::mem::replace(&mut self.may_turn[vertex as usize], false)
                && self.model.topology.is_live(vertex)
                && self.tags[vertex as usize] != Tag::Removed
                && self.model.topology.leaving(vertex).count() > 6
            {
                let Some(side) = self.best_turn(vertex) else { break };
                self.perform(&Plan::of_one(side));
                turned += 1;
            }
        }
        turned
    }

    /// The swap of one of a vertex's edges that certifies the least, of those that even degrees out.
    fn best_turn(&self, vertex: u32) -> Option<Side> {
        let turns = self.model.topology.leaving(vertex).filter_map(|edge| self.turn(edge));
        turns.min_by(|a, b| a.error().total_cmp(&b.error()))
    }

    fn turn(&self, edge: u32) -> Option<Side> {
        let topology = &self.model.topology;
        let twin = topology.twin(edge);
        if twin == NONE || self.model.is_crease[edge as usize] {
            return None;
        }
        let [from, to, left, right] = topology.quadrilateral(edge);
        let degree = |vertex: u32| topology.leaving(vertex).count();
        let evens = degree(from) + degree(to) > degree(left) + degree(right) + 2;
        if !evens || self.are_joined(left, right) || left == right {
            return None;
        }
        let upper = plan::patch_at(&self.model, &self.errors, edge);
        let lower = plan::patch_at(&self.model, &self.errors, next(twin));
        let made = plan::swapped(&upper, &lower)?;
        let side = Side {
            slots: [edge / 3, twin / 3].into_iter().collect(),
            made: made.into_iter().collect(),
            flip: Some(edge),
        };
        (side.error() <= self.limit && side.made.iter().all(|made| self.is_allowed(made))).then_some(side)
    }

    fn are_joined(&self, a: u32, b: u32) -> bool {
        let topology = &self.model.topology;
        topology.edge_between(a, b).is_some() || topology.edge_between(b, a).is_some()
    }

    fn into_levels(mut self) -> CurvedLevels {
        let levels = self.level + 1;
        let left = (0..self.errors.len() as u32).filter(|&slot| self.model.topology.corners(slot).is_some());
        let left: Vec<LevelPatch> = left.map(|slot| self.level_patch(slot, levels)).collect();
        self.gone.extend(left);
        CurvedLevels::new(self.gone, levels)
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
mod tests;
