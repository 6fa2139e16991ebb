//! How far chains of edges that a surface keeps stray from what they were: its outline, and breaklines inside it.
//!
//! Vertices of a chain stay where they are in plan, or go. So a chain is always a part of the vertices that it had at first.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use crate::height_field::ground::Ground;
use crate::height_field::scan::ON_A_LINE;
use crate::height_field::surface::Surface;
use crate::topology::half_edges::ordered;

/// Chains of edges as they were, and which of their vertices are left. The ends of an open chain always are.
pub(crate) struct KeptChains {
    /// All chains, one after the other.
    passed: Vec<Passed>,
    /// Where each chain begins in `passed`, and the end.
    starts: Vec<usize>,
    /// For each vertex of a chain how often it is passed, and where in `passed` it last is.
    visits: BTreeMap<u32, (u8, usize)>,
}

/// A vertex of a chain where it was.
struct Passed {
    vertex: u32,
    grid: DVec2,
    /// On the ground, metres.
    place: DVec3,
    is_left: bool,
}

/// How far a chain strays from what it was along a new edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strays {
    /// Metres, at most.
    pub(crate) metres: f64,
    /// Whether it covers what it did, as the grid sees it.
    pub(crate) is_straight: bool,
}

impl Strays {
    /// Not at all.
    pub(crate) const NONE: Self = Self {
        metres: 0.0,
        is_straight: true,
    };
    const IMPOSSIBLE: Self = Self {
        metres: f64::INFINITY,
        is_straight: false,
    };
}

impl KeptChains {
    fn none() -> Self {
        Self {
            passed: Vec::new(),
            starts: vec![0],
            visits: BTreeMap::new(),
        }
    }

    /// The loops of a surface's boundary.
    pub(crate) fn of_outline(surface: &Surface) -> Self {
        let mut following: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (from, to) in surface.connectivity.boundary() {
            following.entry(from).or_default().push(to);
        }
        let mut chains = Self::none();
        let mut walked = BTreeMap::new();
        for (&origin, ends) in &following {
            for turn in 0..ends.len() {
                if walked.get(&origin).copied().unwrap_or(0) <= turn {
                    chains.walk(surface, origin, &following, &mut walked);
                }
            }
        }
        chains
    }

    /// The breaklines of a surface: a chain from each vertex where one ends, or several meet, to the next; what is left are closed ones,
    /// which begin and end at one of their vertices.
    pub(crate) fn of_breaklines(surface: &Surface) -> Self {
        let mut joined: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &[a, b] in &surface.breaklines {
            joined.entry(a).or_default().push(b);
            joined.entry(b).or_default().push(a);
        }
        let (ends, others): (Vec<u32>, Vec<u32>) = joined.keys().partition(|vertex| joined[*vertex].len() != 2);
        let mut chains = Self::none();
        let mut walked = BTreeSet::new();
        for origin in ends.into_iter().chain(others) {
            for &next in &joined[&origin] {
                if !walked.contains(&ordered([origin, next])) {
                    chains.walk_line(surface, [origin, next], &joined, &mut walked);
                }
            }
        }
        chains
    }

    /// Follows a breakline from its first edge on, to where it ends or comes back.
    fn walk_line(
        &mut self,
        surface: &Surface,
        [origin, next]: [u32; 2],
        joined: &BTreeMap<u32, Vec<u32>>,
        walked: &mut BTreeSet<[u32; 2]>,
    ) {
        self.pass(surface, origin);
        let (mut before, mut at) = (origin, next);
        loop {
            walked.insert(ordered([before, at]));
            self.pass(surface, at);
            let onwards = match joined[&at].as_slice() {
                &[a, b] if at != origin => {
                    if a == before {
                        b
                    } else {
                        a
                    }
                }
                _ => break,
            };
            (before, at) = (at, onwards);
        }
        self.starts.push(self.passed.len());
    }

    /// Puts a vertex at the end of the chain that is walked.
    fn pass(&mut self, surface: &Surface, vertex: u32) {
        let visit = self.visits.entry(vertex).or_default();
        *visit = (visit.0.saturating_add(1), self.passed.len());
        self.passed.push(Passed {
            vertex,
            grid: surface.grid(vertex),
            place: surface.reference.ground.place(surface.plan(vertex)),
            is_left: true,
        });
    }

    fn walk(
        &mut self,
        surface: &Surface,
        origin: u32,
        following: &BTreeMap<u32, Vec<u32>>,
        walked: &mut BTreeMap<u32, usize>,
    ) {
        let mut at = origin;
        loop {
            let used = walked.entry(at).or_insert(0);
            let Some(&next) = following.get(&at).and_then(|ends| ends.get(*used)) else {
                break;
            };
            *used += 1;
            self.pass(surface, at);
            at = next;
        }
        self.starts.push(self.passed.len());
    }

    /// How many times chains pass a vertex.
    pub(crate) fn visits(&self, vertex: u32) -> u8 {
        self.visits.get(&vertex).map_or(0, |visit| visit.0)
    }

    /// Whether a vertex is between the ends of one chain, and of no other.
    pub(crate) fn is_between_ends(&self, vertex: u32) -> bool {
        let Some(&(1, place)) = self.visits.get(&vertex) else {
            return false;
        };
        let (start, end) = self.chain_of(place);
        start < place && place + 1 < end
    }

    /// Edges between the vertices of open chains that are left, each once.
    pub(crate) fn left_edges(&self) -> BTreeSet<[u32; 2]> {
        let mut edges = BTreeSet::new();
        for ends in self.starts.windows(2) {
            let left = self.passed[ends[0]..ends[1]].iter().filter(|passed| passed.is_left);
            let left: Vec<u32> = left.map(|passed| passed.vertex).collect();
            edges.extend(left.windows(2).map(|pair| ordered([pair[0], pair[1]])));
        }
        edges.retain(|[a, b]| a != b);
        edges
    }

    pub(crate) fn remove(&mut self, vertex: u32) {
        if let Some(&(_, place)) = self.visits.get(&vertex) {
            self.passed[place].is_left = false;
        }
    }

    /// Forgets a hole of which these three are left: they are inside the surface now.
    pub(crate) fn close(&mut self, corners: [u32; 3]) {
        for corner in corners {
            self.remove(corner);
            self.visits.remove(&corner);
        }
    }

    /// Metres that no point of a hole, as it was at first, is further from its outline, if three vertices are left of it: half its width
    /// across one of its last three edges.
    pub(crate) fn half_width(&self, ground: Ground, corners: [u32; 3]) -> f64 {
        let [Some(&(_, a)), Some(&(_, b)), Some(&(_, c))] = corners.map(|corner| self.visits.get(&corner)) else {
            return f64::INFINITY;
        };
        let (start, end) = self.chain_of(a);
        let across = |edge: [usize; 2]| {
            let [from, to] = edge.map(|end| &self.passed[end]);
            let mut width = [0.0_f64; 2];
            for passed in &self.passed[start..end] {
                let is_left = (to.grid - from.grid).perp_dot(passed.grid - from.grid) > 0.0;
                let beside = &mut width[usize::from(is_left)];
                *beside = beside.max(ground.distance(passed.place, [from.place, to.place]));
            }
            (width[0] + width[1]) / 2.0
        };
        let widths = [[a, b], [b, c], [c, a]].map(across);
        widths.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// How far the vertices of a chain as they were are from the new edge, if its vertex `blue` collapses into `red` next to it.
    pub(crate) fn strays(&self, ground: Ground, blue: u32, red: u32) -> Strays {
        let Some(&(_, place)) = self.visits.get(&blue) else {
            return Strays::IMPOSSIBLE;
        };
        let (before, after) = (self.left_from(place, false), self.left_from(place, true));
        let [Some(before), Some(after)] = [before, after] else {
            return Strays::IMPOSSIBLE;
        };
        let ends = [&self.passed[before], &self.passed[after]];
        if ends.iter().all(|end| end.vertex != red) || ends[0].vertex == ends[1].vertex {
            return Strays::IMPOSSIBLE;
        }
        let mut strays = Strays::NONE;
        let mut index = self.step(before, true);
        while index != after {
            let passed = &self.passed[index];
            let metres = ground.distance(passed.place, ends.map(|end| end.place));
            strays.metres = strays.metres.max(metres);
            strays.is_straight &= is_on(passed.grid, ends.map(|end| end.grid));
            index = self.step(index, true);
        }
        strays
    }

    /// The nearest place along the chain, which is taken for a loop, whose vertex is left: what is between the ends of an open one comes
    /// to these first.
    fn left_from(&self, place: usize, forward: bool) -> Option<usize> {
        let mut index = self.step(place, forward);
        while index != place && !self.passed[index].is_left {
            index = self.step(index, forward);
        }
        (index != place).then_some(index)
    }

    /// Where in `passed` the chain of a place begins and ends.
    fn chain_of(&self, place: usize) -> (usize, usize) {
        let next = self.starts.partition_point(|&start| start <= place);
        (self.starts[next - 1], self.starts[next])
    }

    fn step(&self, place: usize, forward: bool) -> usize {
        let (start, end) = self.chain_of(place);
        match forward {
            true if place + 1 == end => start,
            true => place + 1,
            false if place == start => end - 1,
            false => place - 1,
        }
    }
}

/// Whether a point is on a segment, but for rounding.
fn is_on(point: DVec2, [from, to]: [DVec2; 2]) -> bool {
    let (along, before) = (to - from, point - from);
    let share = (before.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    before.distance_squared(along * share) < ON_A_LINE * ON_A_LINE
}
