//! The graph search of §7: patterns on both sides of a vertex that is to go.

use smallvec::SmallVec;

use super::plan::{self, Made, Side};
use super::{Simplifier, Tag};
use crate::curved::patterns::{MergeablePair, Ring, pairs_in};
use crate::topology::half_edges::{NONE, next};

/// Half-edges that leave a vertex, one for each face of a side.
type Faces = SmallVec<[u32; 4]>;

/// So many vertices go at once at most.
const MOST_REMOVED: usize = 8;

/// What is removed, merged and decided together.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    /// Vertices that go, and a neighbour along each one's pair.
    pub(super) removed: SmallVec<[(u32, u32); 4]>,
    pub(super) sides: SmallVec<[Side; 4]>,
    pub(super) tags: SmallVec<[(u32, Tag); 16]>,
    /// Edges that arise; none may be there twice.
    joined: SmallVec<[[u32; 2]; 8]>,
}

/// How long a plan was, to go back to.
struct Mark([usize; 4]);

impl Plan {
    pub(super) fn of_one(side: Side) -> Self {
        Self {
            sides: [side].into_iter().collect(),
            ..Self::default()
        }
    }

    fn mark(&self) -> Mark {
        Mark([self.removed.len(), self.sides.len(), self.tags.len(), self.joined.len()])
    }

    fn back_to(&mut self, &Mark([removed, sides, tags, joined]): &Mark) {
        self.removed.truncate(removed);
        self.sides.truncate(sides);
        self.tags.truncate(tags);
        self.joined.truncate(joined);
    }

    fn takes(&self, slot: u32) -> bool {
        self.sides.iter().any(|side| side.slots.contains(&slot))
    }

    fn error(&self) -> f64 {
        self.sides.iter().map(Side::error).fold(0.0, f64::max)
    }
}

impl Simplifier {
    /// What the removal of a vertex certifies without any other; infinite where it cannot be.
    pub(super) fn cost(&self, vertex: u32) -> f64 {
        self.best_start(vertex, f64::INFINITY)
            .map_or(f64::INFINITY, |plan| plan.error())
    }

    /// A plan that removes a vertex, and more where patterns ask for it, inside this level's limit.
    pub(super) fn plan(&self, vertex: u32) -> Option<Plan> {
        let ring = self.model.ring(vertex);
        if is_star(&ring) {
            return self.star(vertex, &ring).filter(|plan| plan.error() <= self.limit);
        }
        let mut pairs = pairs_in(&ring, self.angle);
        pairs.sort_by(|a, b| a.angle.total_cmp(&b.angle));
        let plan = pairs.iter().find_map(|pair| self.plan_pair(vertex, &ring, pair));
        plan.or_else(|| self.best_start(vertex, self.limit))
    }

    fn plan_pair(&self, vertex: u32, ring: &Ring, pair: &MergeablePair) -> Option<Plan> {
        let mut plan = self.begin(vertex, ring, pair)?;
        let [first, second] = sides(ring, pair);
        let is_done = self.match_alone(&mut plan, &first, self.limit)
            && (second.is_empty() || self.match_unmatched(&mut plan, vertex, &second));
        is_done.then_some(plan)
    }

    /// The cheapest plan that removes this vertex alone.
    fn best_start(&self, vertex: u32, limit: f64) -> Option<Plan> {
        let ring = self.model.ring(vertex);
        if is_star(&ring) {
            return self.star(vertex, &ring);
        }
        let alone = pairs_in(&ring, self.angle).into_iter().filter_map(|pair| {
            let mut plan = self.begin(vertex, &ring, &pair)?;
            let both = sides(&ring, &pair);
            let is_done = both
                .iter()
                .all(|side| side.is_empty() || self.match_alone(&mut plan, side, limit));
            is_done.then_some(plan)
        });
        alone.min_by(|a, b| a.error().total_cmp(&b.error()))
    }

    /// A plan in which a vertex goes and the ends of its pair stay.
    fn begin(&self, vertex: u32, ring: &Ring, pair: &MergeablePair) -> Option<Plan> {
        let mut plan = Plan::default();
        self.remove(&mut plan, vertex, ring, pair.ends).then_some(plan)
    }

    /// Tags a vertex removed and the ends of its pair retained, where nothing speaks against it.
    fn remove(&self, plan: &mut Plan, vertex: u32, ring: &Ring, [a, b]: [u32; 2]) -> bool {
        let is_simple = (1..ring.ends.len()).all(|place| !ring.ends[..place].contains(&ring.ends[place]));
        if !is_simple || self.tag(plan, vertex) != Tag::Undecided || plan.removed.len() == MOST_REMOVED {
            return false;
        }
        plan.tags.push((vertex, Tag::Removed));
        plan.removed.push((vertex, a));
        self.retain(plan, a) && self.retain(plan, b) && self.join(plan, a, b)
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

    /// Notes an edge that arises; false where there is one already.
    fn join(&self, plan: &mut Plan, a: u32, b: u32) -> bool {
        let edge = [a.min(b), a.max(b)];
        let is_new = a != b && !plan.joined.contains(&edge) && !self.are_joined(a, b);
        plan.joined.push(edge);
        is_new
    }

    fn star(&self, vertex: u32, ring: &Ring) -> Option<Plan> {
        let faces = self.faces(&ring.leaving);
        let made = plan::star([&faces[0], &faces[1], &faces[2]])?;
        let mut plan = Plan::default();
        plan.tags.push((vertex, Tag::Removed));
        plan.removed.push((vertex, ring.ends[0]));
        // Where the three faces across are one, what is left would be two patches with the same corners.
        let across = ring.leaving.iter().map(|&edge| self.model.topology.twin(next(edge)));
        let across: SmallVec<[u32; 3]> = across.map(|twin| if twin == NONE { NONE } else { twin / 3 }).collect();
        let is_closed = across[0] != NONE && across.iter().all(|&face| face == across[0]);
        let is_done = !is_closed
            && ring.ends.iter().all(|&end| self.retain(&mut plan, end))
            && self.add(&mut plan, &ring.leaving, &[], &[made], None, f64::INFINITY);
        is_done.then_some(plan)
    }

    fn faces(&self, leaving: &[u32]) -> SmallVec<[Made; 4]> {
        let made = leaving
            .iter()
            .map(|&edge| plan::patch_at(&self.model, &self.errors, edge));
        made.collect()
    }

    /// Adds a side whose error is inside the limit and whose patches are allowed.
    fn add(&self, plan: &mut Plan, faces: &[u32], more: &[u32], made: &[Made], flip: Option<u32>, limit: f64) -> bool {
        let side = Side {
            slots: faces.iter().chain(more).map(|edge| edge / 3).collect(),
            made: made.iter().copied().collect(),
            flip,
        };
        let is_free = side.slots.iter().all(|&slot| !plan.takes(slot));
        let is_good = is_free && side.error() <= limit && side.made.iter().all(|made| self.is_allowed(made));
        if is_good {
            plan.sides.push(side);
        }
        is_good
    }

    /// Matches a side without removing any more: T, or the better swap and then T (Fig. 8).
    fn match_alone(&self, plan: &mut Plan, leaving: &[u32], limit: f64) -> bool {
        let faces = self.faces(leaving);
        match faces.as_slice() {
            [near, far] => {
                let apex = far.corners[1];
                let Some(made) = plan::t(near, far) else { return false };
                self.retain(plan, apex) && self.add(plan, leaving, &[], &[made], None, limit)
            }
            [first, middle, last] => {
                let near = self.swap_then_t(leaving[1], [middle, first], |inner| plan::t(inner, last));
                let far = self.swap_then_t(leaving[2], [last, middle], |inner| plan::t(first, inner));
                let mut options: SmallVec<[_; 2]> = near.into_iter().chain(far).collect();
                options.sort_by(|(_, a), (_, b)| worst(a).total_cmp(&worst(b)));
                options
                    .iter()
                    .any(|(edge, made)| self.add_swapped(plan, leaving, *edge, made, limit))
            }
            _ => false,
        }
    }

    /// The edge to swap, and what its swap and a T make of three faces.
    fn swap_then_t(
        &self,
        edge: u32,
        [upper, lower]: [&Made; 2],
        t: impl Fn(&Made) -> Option<Made>,
    ) -> Option<(u32, [Made; 2])> {
        if self.model.is_crease[edge as usize] {
            return None;
        }
        let [inner, outer] = plan::swapped(upper, lower)?;
        Some((edge, [outer, t(&inner)?]))
    }

    /// The vertex that loses an edge is retained unless it was removed; the one that gains one must stay.
    fn add_swapped(&self, plan: &mut Plan, leaving: &[u32], edge: u32, made: &[Made; 2], limit: f64) -> bool {
        let topology = &self.model.topology;
        let mark = plan.mark();
        let loses = topology.end(edge);
        let [p, q] = [leaving[1], leaving[2]].map(|edge| topology.end(edge));
        let gains = if loses == p { q } else { p };
        let end = if loses == p {
            topology.end(leaving[0])
        } else {
            topology.apex(leaving[2])
        };
        let is_done = self.retain(plan, gains)
            && (self.tag(plan, loses) == Tag::Removed || self.retain(plan, loses))
            && self.join(plan, gains, end)
            && self.add(plan, leaving, &[], made, Some(edge), limit);
        if !is_done {
            plan.back_to(&mark);
        }
        is_done
    }

    /// Matches the side of a vertex whose other side is matched: patterns that remove more vertices come first.
    fn match_unmatched(&self, plan: &mut Plan, vertex: u32, leaving: &[u32]) -> bool {
        if let [first, middle, last] = *leaving {
            let patterns = [Pattern::First, Pattern::Second, Pattern::Both];
            for pattern in patterns {
                let mark = plan.mark();
                if self.match_more(plan, vertex, [first, middle, last], pattern) {
                    return true;
                }
                plan.back_to(&mark);
            }
        }
        self.match_alone(plan, leaving, self.limit)
    }

    /// Matches 2T or T-in-T on a side of three faces, and then the other sides of the vertices that it removes.
    fn match_more(&self, plan: &mut Plan, vertex: u32, leaving: [u32; 3], pattern: Pattern) -> bool {
        let topology = &self.model.topology;
        let [a, p, q] = leaving.map(|edge| topology.end(edge));
        let b = topology.apex(leaving[2]);
        let beyond = topology.twin(next(leaving[1]));
        let x = if beyond == NONE { NONE } else { topology.apex(beyond) };
        let goes: &[(u32, [u32; 2])] = match pattern {
            Pattern::First => &[(p, [a, q])],
            Pattern::Second => &[(q, [p, b])],
            Pattern::Both if x == NONE => return false,
            Pattern::Both => &[(p, [a, x]), (q, [x, b])],
        };
        let mut others: SmallVec<[(u32, Faces); 2]> = SmallVec::new();
        for &(middle, ends) in goes {
            let ring = self.model.ring(middle);
            let Some(other) = self.other_side(&ring, ends, vertex) else {
                return false;
            };
            if !self.remove(plan, middle, &ring, ends) {
                return false;
            }
            others.push((middle, other));
        }
        let faces = self.faces(&leaving);
        let [first, middle, last] = [&faces[0], &faces[1], &faces[2]];
        let (made, more) = match pattern {
            Pattern::First => (plan::outer_t(first, middle).and_then(|near| plan::t(&near, last)), None),
            Pattern::Second => (plan::outer_t(middle, last).and_then(|far| plan::t(first, &far)), None),
            Pattern::Both => {
                let outside = plan::patch_at(&self.model, &self.errors, beyond);
                (
                    plan::triangle_in_triangle([first, middle, last, &outside]),
                    Some(beyond),
                )
            }
        };
        let Some(made) = made else { return false };
        let corner = made.corners[2];
        self.retain(plan, corner)
            && self.add(plan, &leaving, more.as_slice(), &[made], None, self.limit)
            && others
                .iter()
                .all(|(middle, faces)| faces.is_empty() || self.match_unmatched(plan, *middle, faces))
    }

    /// The faces of a pair's side that does not see a vertex, where those edges are a mergeable pair.
    fn other_side(&self, ring: &Ring, ends: [u32; 2], vertex: u32) -> Option<Faces> {
        let pairs = pairs_in(ring, self.angle);
        let pair = pairs
            .iter()
            .find(|pair| pair.ends == ends || pair.ends == [ends[1], ends[0]])?;
        let place = ring.ends.iter().position(|&end| end == vertex)?;
        let [first, second] = sides(ring, pair);
        let is_first = (pair.places[0]..=pair.places[1]).contains(&place);
        Some(if is_first { second } else { first })
    }
}

#[derive(Clone, Copy)]
enum Pattern {
    /// 2T without the first of the two vertices between the ends of a side.
    First,
    /// 2T without the second.
    Second,
    /// T-in-T, without both.
    Both,
}

fn worst(made: &[Made; 2]) -> f64 {
    made[0].error.max(made[1].error)
}

/// Three patches around a vertex inside the surface, with no crease between them.
fn is_star(ring: &Ring) -> bool {
    ring.leaving.len() == 3 && !ring.is_boundary() && !ring.has_crease()
}

/// Both sides of a pair, the second one empty on the boundary.
fn sides(ring: &Ring, pair: &MergeablePair) -> [Faces; 2] {
    let [first, second] = pair.places;
    let count = ring.leaving.len();
    let other = if ring.is_boundary() {
        count..count
    } else {
        second..count + first
    };
    [
        ring.leaving[first..second].iter().copied().collect(),
        other.map(|place| ring.leaving[place % count]).collect(),
    ]
}
