//! Curved levels of detail by merging patches (§7, §8), each with a certified error (§10).
//!
//! ```text
//! for each iteration, until few enough patches are left:
//!     estimate what each vertex's removal certifies, where its surroundings have changed: by its best mergeable pair
//!     the limit ← what the iteration before had, or more where that removed little
//!     tag every vertex undecided
//!     for each vertex within the limit, by its estimate, least first:
//!         if it is undecided, and a plan is found for it:
//!             match one side of its mergeable pair: T, or a swap and then T
//!             match the other one: T, 2T, T-in-T, or a swap and then T
//!             match, by the same rules, the other side of each vertex that 2T and T-in-T remove
//!             fit the new patches to the pieces of the model that they stand for, and measure them
//!             if they keep the limit and the guards: swap, merge, tag vertices removed and retained
//!     where no vertex can go: turn edges that take from vertices of high degree, and let pairs deviate more
//! ```
//! A plan tags vertices as it grows, so that no vertex goes that another pattern needs as a corner.
//!
//! **What holds after every plan:** patches meet as before, to the bit, since they share their curves; the surface is a manifold
//! of the same topology, no two of its vertices joined by a new second edge; every patch's error bounds its distance from the
//! part of the model it stands for, both ways ([`cover`]). A patch whose normals turn farther than
//! [`Options::least_cosine`] from its chord triangle's does not arise, nor one with a longer side than
//! [`Options::longest_side`].

mod cover;
mod curves;
mod nearest;
mod plan;
mod search;
mod shared_curves;
mod state;
mod surface;

use glam::DVec3;
use smallvec::SmallVec;

use self::plan::{Made, Plan, Side, Tag, Target};
use self::search::{Reach, is_star};
use self::shared_curves::CurveUse;
use self::state::Simplifier;
use self::surface::Surface;
use crate::curved::levels::CurvedLevels;
use crate::curved::model::CurvedModel;
use crate::curved::patch::{CENTRE, CubicPatch};
use crate::curved::patterns::Ring;
use crate::topology::half_edges::NONE;

pub use self::state::Options;

/// A level is finished once so large a part of its vertices was removed.
const LEVEL: f64 = 0.02;

/// Where an iteration removes a smaller part of all vertices, the next one's limit grows.
const PACE: f64 = 0.04;

/// How much it grows.
const GROWTH: f64 = 1.25;

/// How much more edges of a pair may deviate when nothing else is left.
const RELAXED: f64 = 1.5;

/// How much of what was found for a vertex is expected after its surroundings have changed.
const REMEMBERED: f64 = 1.0;

/// Patterns that remove more vertices are looked for where a pair's curve deviates by less than this share of the limit.
const SMOOTH: f64 = 0.25;

/// So many pairs of a vertex are tried.
const MOST_PAIRS: usize = 2;

/// Makes levels of detail of a model, each coarser than the one before. After each iteration `progress` is told how many
/// patches are left.
pub fn simplify(model: CurvedModel, options: &Options, progress: impl FnMut(usize)) -> CurvedLevels {
    let mut simplifier = Simplifier::new(model, options);
    simplifier.run(progress);
    simplifier.surface.into_levels()
}

impl Simplifier {
    fn run(&mut self, mut progress: impl FnMut(usize)) {
        let mut live: Vec<u32> = (0..self.tags.len() as u32).collect();
        while self.surface.patch_count > self.options.patches {
            live.retain(|&vertex| self.surface.topology.is_live(vertex));
            self.refresh(&live);
            let least = live.iter().map(|&vertex| self.costs[vertex as usize]);
            let least = least.fold(f64::INFINITY, f64::min);
            self.begin_level(live.len());
            if least > self.options.max_error || least == f64::INFINITY {
                if !self.unstick(&live) {
                    break;
                }
                continue;
            }
            self.limit = self.limit.max(least);
            let removed = self.iterate(&live);
            self.removed += removed;
            if (removed as f64) < PACE * live.len() as f64 {
                self.limit = (self.limit * GROWTH).min(self.options.max_error);
            }
            progress(self.surface.patch_count);
        }
        if self.removed == 0 {
            self.surface.level -= 1;
        }
    }

    fn begin_level(&mut self, live: usize) {
        if self.removed as f64 >= LEVEL * live as f64 {
            self.surface.level += 1;
            self.removed = 0;
        }
    }

    fn refresh(&mut self, live: &[u32]) {
        for &vertex in live {
            self.tags[vertex as usize] = Tag::Undecided;
            if std::mem::replace(&mut self.is_stale[vertex as usize], false) {
                self.costs[vertex as usize] = self.estimate(vertex);
            }
        }
    }

    /// What a vertex's removal will certify, more or less.
    fn estimate(&mut self, vertex: u32) -> f64 {
        let ring = self.surface.ring(vertex);
        let present = ring.leaving.iter().map(|edge| self.surface.error(edge / 3));
        let present = present.fold(0.0, f64::max);
        if is_star(&ring) {
            return present;
        }
        self.candidates[vertex as usize] = self.found_candidates(&ring);
        match self.candidates[vertex as usize].first() {
            Some(best) => present
                .hypot(best.curve.deviation)
                .max(REMEMBERED * self.found[vertex as usize]),
            None => f64::INFINITY,
        }
    }

    /// One pass over the vertices within the limit, cheapest first; how many went.
    fn iterate(&mut self, live: &[u32]) -> usize {
        let cost = |vertex: u32| self.costs[vertex as usize];
        let mut order: Vec<u32> = live
            .iter()
            .copied()
            .filter(|&vertex| cost(vertex) <= self.limit)
            .collect();
        order.sort_unstable_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
        let mut removed = 0;
        for vertex in order {
            if self.surface.patch_count <= self.options.patches {
                break;
            }
            if self.tags[vertex as usize] == Tag::Undecided && !self.is_stale[vertex as usize] {
                removed += self.remove(vertex);
            }
        }
        removed
    }

    /// Removes a vertex, and more where patterns ask for it; how many.
    fn remove(&mut self, vertex: u32) -> usize {
        let ring = self.surface.ring(vertex);
        let mut cost = f64::INFINITY;
        if is_star(&ring) {
            let plan = self.plan_star(vertex, &ring);
            match plan.map(|plan| self.attempt(&plan)) {
                Some(Ok(removed)) => return removed,
                Some(Err(found)) => cost = found,
                None => {}
            }
        } else {
            let candidates = self.candidates[vertex as usize].clone();
            for candidate in candidates.iter().take(MOST_PAIRS) {
                let is_smooth = candidate.curve.deviation <= SMOOTH * self.limit;
                let reaches: &[Reach] = if is_smooth {
                    &[Reach::More, Reach::Alone]
                } else {
                    &[Reach::Alone]
                };
                for &reach in reaches {
                    let Some(plan) = self.plan(vertex, &ring, candidate, reach) else {
                        continue;
                    };
                    if reach == Reach::More && plan.removed.len() == 1 {
                        continue;
                    }
                    match self.attempt(&plan) {
                        Ok(removed) => return removed,
                        Err(found) => cost = cost.min(found),
                    }
                }
            }
        }
        self.costs[vertex as usize] = cost;
        self.found[vertex as usize] = if cost.is_finite() { cost } else { 0.0 };
        0
    }

    /// Performs a plan if it keeps the limit: how many vertices went, or else what it would certify at least.
    fn attempt(&mut self, plan: &Plan) -> Result<usize, f64> {
        if plan.deviation > self.limit {
            return Err(plan.deviation);
        }
        let made = self.make(plan)?;
        for &(vertex, tag) in &plan.tags {
            self.tags[vertex as usize] = tag;
        }
        for &(vertex, _) in &plan.removed {
            self.costs[vertex as usize] = f64::INFINITY;
        }
        let placed = self.surface.perform(plan, made);
        placed.iter().for_each(|&slot| self.expire_around(slot));
        Ok(plan.removed.len())
    }

    /// What the removals of the vertices around a new patch cost has to be found anew.
    fn expire_around(&mut self, slot: u32) {
        let topology = &self.surface.topology;
        for corner in topology.triangles()[slot as usize] {
            self.is_stale[corner as usize] = true;
            self.may_turn[corner as usize] = true;
        }
    }

    /// Makes all patches of a plan, or tells what the first that is not allowed has for an error.
    fn make(&mut self, plan: &Plan) -> Result<Vec<Made>, f64> {
        let counts = self.surface.parts.counts();
        let made = plan.sides.iter().try_fold(Vec::new(), |mut made, side| {
            self.make_side(plan, side, &mut made)?;
            Ok(made)
        });
        if made.is_err() {
            self.surface.parts.truncate(counts);
        }
        made
    }

    fn make_side(&mut self, plan: &Plan, side: &Side, made: &mut Vec<Made>) -> Result<(), f64> {
        let patches: SmallVec<[CubicPatch; 2]> =
            side.targets.iter().map(|target| self.patch_of(plan, target)).collect();
        if !patches.iter().all(|patch| self.is_allowed(patch)) {
            return Err(f64::INFINITY);
        }
        let mut samples: SmallVec<[Vec<(DVec3, DVec3)>; 2]> =
            side.targets.iter().map(|_| Vec::with_capacity(28)).collect();
        for (slot, cell) in side.slots.iter().zip(&side.cells) {
            nearest::samples(&self.surface.patch_at(3 * slot), cell, &mut samples);
        }
        for (patch, samples) in patches.iter().zip(&samples) {
            let rough = nearest::rough_error(*patch, samples);
            if rough > self.limit {
                return Err(rough);
            }
        }
        let Surface { covers, parts, .. } = &mut self.surface;
        let faces = side.slots.iter().map(|&slot| &covers[slot as usize]).zip(&side.cells);
        let covers = self.carrier.carried(faces, side.targets.len(), parts);
        for (without, mut cover) in patches.into_iter().zip(covers) {
            let (patch, error) = nearest::fit(without, &mut cover, parts, self.limit, &mut self.scratch)?;
            made.push(Made {
                centre: patch.points[CENTRE],
                error,
                cover,
            });
        }
        Ok(())
    }

    /// A target without its centre.
    fn patch_of(&self, plan: &Plan, target: &Target) -> CubicPatch {
        let frame = &self.surface.frame;
        let inner = |use_of: CurveUse| match use_of.curve().checked_sub(frame.curves.len()) {
            None => frame.inner(use_of),
            Some(new) => use_of.directed(plan.curves[new].inner),
        };
        let [a, b, c] = target.corners.map(|corner| self.surface.position(corner));
        let [ab, bc, ca] = target.curves.map(inner);
        CubicPatch::from_curves([a, b, c], [ab, bc, ca], DVec3::ZERO)
    }

    /// Whether a patch may arise in the place of others (§8: curvature and size).
    fn is_allowed(&self, patch: &CubicPatch) -> bool {
        let points = &patch.points;
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
        points.iter().all(|point: &DVec3| point.is_finite())
            && longest.sqrt() <= self.options.longest_side
            && turns.into_iter().all(|cosine| cosine >= self.options.least_cosine)
    }

    /// Where no vertex can go (§8.2); false where there is nothing to do.
    fn unstick(&mut self, live: &[u32]) -> bool {
        let is_new = std::mem::replace(&mut self.stuck_at, self.surface.patch_count) != self.surface.patch_count;
        let turned = if is_new { self.reduce_degrees(live) } else { 0 };
        self.removed += turned;
        let relaxed = (self.angle * RELAXED).min(self.options.largest_angle);
        let is_more = relaxed > self.angle;
        self.angle = relaxed;
        if is_more {
            live.iter().for_each(|&vertex| self.is_stale[vertex as usize] = true);
        }
        is_more || turned > 0
    }

    /// Turns edges away from vertices, until as few are left as a pattern takes (§8.2, Fig. 7), where that keeps the limit; how
    /// many. Vertices around one that lost edges keep theirs.
    fn reduce_degrees(&mut self, live: &[u32]) -> usize {
        let mut turned = 0;
        self.tags.fill(Tag::Undecided);
        for &vertex in live {
            let may_turn = std::mem::replace(&mut self.may_turn[vertex as usize], false);
            if !may_turn || self.tags[vertex as usize] != Tag::Undecided {
                continue;
            }
            let ring = self.surface.ring(vertex);
            let fewest = fewest_faces(&ring);
            let before = turned;
            while self.surface.topology.leaving(vertex).count() > fewest && self.turn_one_of(vertex) {
                turned += 1;
            }
            if turned > before {
                ring.ends
                    .iter()
                    .for_each(|&end| self.tags[end as usize] = Tag::Retained);
            }
        }
        turned
    }

    /// Swaps the first of a vertex's edges that can be.
    fn turn_one_of(&mut self, vertex: u32) -> bool {
        let edges: SmallVec<[u32; 8]> = self.surface.topology.leaving(vertex).collect();
        edges.into_iter().any(|edge| {
            let is_inside = self.surface.topology.twin(edge) != NONE && !self.surface.is_crease(edge);
            let plan = is_inside.then(|| self.plan_swap(edge)).flatten();
            plan.is_some_and(|plan| self.attempt(&plan).is_ok())
        })
    }
}

/// A star has three faces, T two, on each side that there is.
fn fewest_faces(ring: &Ring) -> usize {
    match (ring.is_boundary(), ring.has_crease()) {
        (true, _) => 2,
        (false, true) => 4,
        (false, false) => 3,
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
mod tests;
