//! The graph search of §7: patterns on both sides of a vertex that is to go.

use smallvec::SmallVec;

use super::curves::{self, Candidate, Candidates, FittedCurve};
use super::plan::{self, Crossing, NewCurve, On, Plan, Side, SideOf, Tag};
use super::shared_curves::CurveUse;
use super::state::Simplifier;
use crate::curved::merging;
use crate::curved::patterns::{MergeablePair, Ring, pairs_in};
use crate::topology::half_edges::{NONE, next, previous};

/// So many vertices go at once at most.
const MOST_REMOVED: usize = 16;

/// Diagonals that cross nearer to an end, as a share of their length, are not swapped.
const NEAR_AN_END: f64 = 0.05;

/// How far a plan may go beyond one vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// No other vertex goes.
    Alone,
    /// 2T and T-in-T are tried first.
    More,
}

#[derive(Clone, Copy, Debug)]
enum Pattern {
    /// 2T without the first of the two vertices between the ends of a side.
    First,
    /// 2T without the second.
    Second,
    /// T-in-T, without both.
    Both,
}

/// Three patches around a vertex inside the surface, with no crease between them.
pub(super) fn is_star(ring: &Ring) -> bool {
    ring.leaving.len() == 3 && !ring.is_boundary() && !ring.has_crease()
}

impl Simplifier {
    /// What a vertex's pairs become, those that deviate least first.
    pub(super) fn found_candidates(&self, ring: &Ring) -> Candidates {
        let mut candidates: Candidates = pairs_in(ring, self.angle)
            .into_iter()
            .filter_map(|pair| {
                let [mut left, right] = pair.places.map(|place| self.points_at(ring, place));
                left.reverse();
                curves::fit(left, right).map(|curve| Candidate { pair, curve })
            })
            .collect();
        candidates.sort_by(|a, b| a.curve.deviation.total_cmp(&b.curve.deviation));
        candidates
    }

    /// The control points of an edge of a ring, from its vertex on.
    fn points_at(&self, ring: &Ring, place: usize) -> [glam::DVec3; 4] {
        match ring.leaving.get(place) {
            Some(&edge) => self.surface.points_along(edge),
            None => {
                let mut points = self.surface.points_along(previous(ring.leaving[place - 1]));
                points.reverse();
                points
            }
        }
    }

    /// Removes a vertex by one of its pairs.
    pub(super) fn plan(&self, vertex: u32, ring: &Ring, candidate: &Candidate, reach: Reach) -> Option<Plan> {
        let mut plan = Plan::default();
        let on = self.add_removal(&mut plan, vertex, ring, candidate)?;
        let [first, second] = self.sides(ring, &candidate.pair, on);
        let is_done = self.match_unmatched(&mut plan, vertex, &first, reach)
            && (second.faces.is_empty() || self.match_unmatched(&mut plan, vertex, &second, reach));
        is_done.then_some(plan)
    }

    /// Removes a vertex with three patches around it.
    pub(super) fn plan_star(&self, vertex: u32, ring: &Ring) -> Option<Plan> {
        let topology = &self.surface.topology;
        let faces = [ring.leaving[0], ring.leaving[1], ring.leaving[2]];
        let [opposite, after] = [faces[1], next(next(faces[2]))].map(|edge| self.surface.patch_at(edge));
        // (S, B, C) and (A, S, C).
        let at = merging::star_parameters([&opposite, &after, &after])?;
        // Where the three faces across are one, what is left would be two patches with the same corners.
        let across = faces.map(|edge| topology.twin(next(edge)));
        let is_closed = across[0] != NONE && across.iter().all(|edge| edge / 3 == across[0] / 3);
        let mut plan = Plan::default();
        plan.tags.push((vertex, Tag::Removed));
        plan.removed.push((vertex, ring.ends[0]));
        let is_possible = !is_closed && is_simple(ring) && ring.ends.iter().all(|&end| self.retain(&mut plan, end));
        let corners = [ring.ends[0], ring.ends[1], ring.ends[2]];
        let curves = faces.map(|edge| self.surface.curve(next(edge)));
        plan.sides.push(plan::star(faces, corners, curves, at));
        is_possible.then_some(plan)
    }

    /// Swaps the diagonal of two patches.
    pub(super) fn plan_swap(&self, edge: u32) -> Option<Plan> {
        let topology = &self.surface.topology;
        let [e0, e1, f0, f1] = topology.quadrilateral(edge);
        let twin = topology.twin(edge);
        let mut plan = Plan::default();
        let (fitted, t) = self.cross(edge)?;
        let crossing = self
            .join(&mut plan, [f1, f0], &fitted, false)
            .map(|on| Crossing { t, new: on.reversed() })?;
        let around = [previous(edge), next(twin), previous(twin), next(edge)];
        let sides = around.map(|edge| self.surface.curve(edge));
        plan.sides
            .push(plan::swap([edge, twin], [e0, e1, f0, f1], sides, &crossing));
        Some(plan)
    }

    /// Tags a vertex removed and the ends of its pair retained, where nothing speaks against it; where it was on their curve.
    fn add_removal(&self, plan: &mut Plan, vertex: u32, ring: &Ring, candidate: &Candidate) -> Option<On> {
        let is_free = self.tag(plan, vertex) == Tag::Undecided && plan.removed.len() < MOST_REMOVED;
        let [a, b] = candidate.pair.ends;
        plan.tags.push((vertex, Tag::Removed));
        plan.removed.push((vertex, a));
        let is_possible = is_free && is_simple(ring) && self.retain(plan, a) && self.retain(plan, b);
        let is_crease = ring.is_crease(candidate.pair.places[0]);
        is_possible
            .then(|| self.join(plan, [a, b], &candidate.curve, is_crease))
            .flatten()
    }

    fn tag(&self, plan: &Plan, vertex: u32) -> Tag {
        let own = plan.tags.iter().rev().find(|(tagged, _)| *tagged == vertex);
        own.map_or(self.tags[vertex as usize], |(_, tag)| *tag)
    }

    fn retain(&self, plan: &mut Plan, vertex: u32) -> bool {
        let is_possible = self.tag(plan, vertex) != Tag::Removed;
        plan.tags.push((vertex, Tag::Retained));
        is_possible
    }

    /// Adds a curve; none where its ends are joined already.
    fn join(&self, plan: &mut Plan, ends: [u32; 2], curve: &FittedCurve, is_crease: bool) -> Option<On> {
        let [a, b] = ends;
        if a == b || plan.joins(a, b) || self.surface.are_joined(a, b) {
            return None;
        }
        let index = self.surface.frame.curves.len() + plan.curves.len();
        plan.deviation = plan.deviation.max(curve.deviation);
        plan.curves.push(NewCurve {
            ends,
            inner: curve.inner,
            is_crease,
        });
        Some(On {
            curve: CurveUse::new(index, false),
            t: curve.t,
        })
    }

    /// Both sides of a pair, the second one empty on the boundary.
    fn sides(&self, ring: &Ring, pair: &MergeablePair, on: On) -> [SideOf; 2] {
        let [first, second] = pair.places;
        let count = ring.leaving.len();
        let other = if ring.is_boundary() {
            count..count
        } else {
            second..count + first
        };
        let side = |places: std::ops::Range<usize>, middle: On, ends: [u32; 2]| {
            let faces: SmallVec<[u32; 3]> = places.map(|place| ring.leaving[place % count]).collect();
            SideOf {
                opposite: faces.iter().map(|&edge| self.surface.curve(next(edge))).collect(),
                faces,
                middle,
                ends,
            }
        };
        let [a, b] = pair.ends;
        [side(first..second, on, [a, b]), side(other, on.reversed(), [b, a])]
    }

    /// Adds a side whose faces are free.
    fn add(&self, plan: &mut Plan, side: Side) -> bool {
        let is_free = side.slots.iter().all(|&slot| !plan.takes(slot));
        plan.sides.push(side);
        is_free
    }

    /// Matches a side without removing any more: T, or a swap and then T (Fig. 8), of two the one whose diagonal is better.
    fn match_alone(&self, plan: &mut Plan, side: &SideOf) -> bool {
        let topology = &self.surface.topology;
        if let [_, second] = *side.faces.as_slice() {
            let x = topology.end(second);
            return self.retain(plan, x) && self.add(plan, side.t(x));
        }
        let [p, q] = [side.faces[1], side.faces[2]].map(|edge| topology.end(edge));
        let options = [(side.faces[1], p, q), (side.faces[2], q, p)];
        let mut options: SmallVec<[_; 2]> = options
            .into_iter()
            .filter(|(edge, ..)| !self.surface.is_crease(*edge))
            .filter_map(|(edge, loses, gains)| self.cross(edge).map(|crossed| (loses, gains, crossed)))
            .collect();
        options.sort_by(|(.., (a, _)), (.., (b, _))| a.deviation.total_cmp(&b.deviation));
        options.iter().any(|&(loses, gains, crossed)| {
            let mark = plan.mark();
            let is_done = self.match_swapped(plan, side, [p, q], [loses, gains], crossed);
            if !is_done {
                plan.back_to(&mark);
            }
            is_done
        })
    }

    /// The vertex that loses an edge is retained unless it was removed; the one that gains one must stay.
    fn match_swapped(
        &self,
        plan: &mut Plan,
        side: &SideOf,
        [p, q]: [u32; 2],
        [loses, gains]: [u32; 2],
        (fitted, t): (FittedCurve, f64),
    ) -> bool {
        let [a, b] = side.ends;
        let is_near = loses == p;
        let is_possible =
            self.retain(plan, gains) && (self.tag(plan, loses) == Tag::Removed || self.retain(plan, loses));
        let ends = if is_near { [a, q] } else { [p, b] };
        let new = is_possible.then(|| self.join(plan, ends, &fitted, false)).flatten();
        new.is_some_and(|new| {
            let crossing = Crossing { t, new };
            let side = if is_near {
                side.swap_near([p, q], &crossing)
            } else {
                side.swap_far([p, q], &crossing)
            };
            self.add(plan, side)
        })
    }

    /// The curve from the vertex right of an edge to that left of it, and where it crosses the edge (§6.2).
    fn cross(&self, edge: u32) -> Option<(FittedCurve, f64)> {
        let topology = &self.surface.topology;
        let twin = topology.twin(edge);
        let ends = topology.quadrilateral(edge).map(|corner| self.surface.position(corner));
        let (t, s) = merging::crossing([ends[0], ends[1]], [ends[3], ends[2]])?;
        let is_inside = |t: f64| t > NEAR_AN_END && t < 1.0 - NEAR_AN_END;
        if !is_inside(t) || !is_inside(s) {
            return None;
        }
        let right = self.surface.patch_at(edge).split_first_curve(t)[0].curve(1);
        let mut left = self.surface.patch_at(twin).split_first_curve(1.0 - t)[0].curve(1);
        left.reverse();
        let fitted = curves::fit(left, right).filter(|fitted| is_inside(fitted.t))?;
        Some((fitted, t))
    }

    /// Matches the side of a vertex whose other side is matched: patterns that remove more vertices come first.
    fn match_unmatched(&self, plan: &mut Plan, vertex: u32, side: &SideOf, reach: Reach) -> bool {
        if side.faces.len() == 3 && reach == Reach::More {
            for pattern in [Pattern::Both, Pattern::First, Pattern::Second] {
                let mark = plan.mark();
                if self.match_more(plan, vertex, side, pattern) {
                    return true;
                }
                plan.back_to(&mark);
            }
        }
        self.match_alone(plan, side)
    }

    /// Matches 2T or T-in-T on a side of three faces, and then the other sides of the vertices that it removes.
    fn match_more(&self, plan: &mut Plan, vertex: u32, side: &SideOf, pattern: Pattern) -> bool {
        let topology = &self.surface.topology;
        let [a, b] = side.ends;
        let [p, q] = [side.faces[1], side.faces[2]].map(|edge| topology.end(edge));
        let beyond = topology.twin(next(side.faces[1]));
        let goes: SmallVec<[(u32, [u32; 2]); 2]> = match pattern {
            Pattern::First => [(p, [a, q])].into_iter().collect(),
            Pattern::Second => [(q, [p, b])].into_iter().collect(),
            Pattern::Both if beyond == NONE => return false,
            Pattern::Both => {
                let x = topology.apex(beyond);
                [(p, [a, x]), (q, [x, b])].into_iter().collect()
            }
        };
        let mut found: SmallVec<[(On, SideOf); 2]> = SmallVec::new();
        for &(middle, ends) in &goes {
            match self.remove_between(plan, middle, ends, vertex) {
                Some(removed) => found.push(removed),
                None => return false,
            }
        }
        let (x, merged) = match (pattern, found.as_slice()) {
            (Pattern::First, [(on, _)]) => (q, side.two_t_first(q, *on)),
            (Pattern::Second, [(on, _)]) => (p, side.two_t_second(p, *on)),
            (_, [(p_on, _), (q_on, _)]) => {
                let x = topology.apex(beyond);
                (x, side.triangle_in_triangle(x, [*p_on, *q_on], beyond))
            }
            _ => return false,
        };
        let middles = goes.iter().map(|(middle, _)| *middle);
        self.retain(plan, x)
            && self.add(plan, merged)
            && middles.zip(&found).all(|(middle, (_, other))| {
                other.faces.is_empty() || self.match_unmatched(plan, middle, other, Reach::More)
            })
    }

    /// Removes a vertex between two ends, if they are a mergeable pair of it: where it was on the way from the first to the
    /// second, and the pair's side that does not see `vertex`.
    fn remove_between(&self, plan: &mut Plan, middle: u32, ends: [u32; 2], vertex: u32) -> Option<(On, SideOf)> {
        if self.is_stale[middle as usize] {
            return None;
        }
        let candidates = &self.candidates[middle as usize];
        let [a, b] = ends;
        let is_it = |candidate: &&Candidate| candidate.pair.ends == [a, b] || candidate.pair.ends == [b, a];
        let candidate = candidates.iter().find(is_it)?;
        if candidate.curve.deviation > self.limit {
            return None;
        }
        let ring = self.surface.ring(middle);
        let on = self.add_removal(plan, middle, &ring, candidate)?;
        let place = ring.ends.iter().position(|&end| end == vertex)?;
        let [first, second] = self.sides(&ring, &candidate.pair, on);
        let [from, to] = candidate.pair.places;
        let other = if (from..=to).contains(&place) { second } else { first };
        let is_as_asked = candidate.pair.ends == ends;
        Some((if is_as_asked { on } else { on.reversed() }, other))
    }
}

/// Whether no two edges lead to the same vertex, or back to this one.
fn is_simple(ring: &Ring) -> bool {
    (1..ring.ends.len()).all(|place| !ring.ends[..place].contains(&ring.ends[place]))
}
