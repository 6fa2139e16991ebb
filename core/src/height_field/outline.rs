//! How far the simplified edge of a surface strays from what it was: the chains of boundary vertices.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::height_field::reference::Reference;
use crate::height_field::scan::ON_A_LINE;
use crate::height_field::surface::Surface;

/// The boundary loops of a mesh as they were, and which of their vertices are left.
pub(crate) struct OutlineChains {
    /// All loops, one after the other.
    passed: Vec<Passed>,
    /// Where each loop begins in `passed`, and the end.
    starts: Vec<usize>,
    /// For each vertex of the boundary how often it is passed, and where in `passed` it last is.
    visits: BTreeMap<u32, (u8, usize)>,
}

/// A vertex of the boundary where it was.
struct Passed {
    vertex: u32,
    grid: DVec2,
    is_left: bool,
}

impl OutlineChains {
    pub(crate) fn new(surface: &Surface) -> Self {
        let mut following: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (from, to) in surface.connectivity.boundary() {
            following.entry(from).or_default().push(to);
        }
        let mut chains = Self {
            passed: Vec::new(),
            starts: vec![0],
            visits: BTreeMap::new(),
        };
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
            let visit = self.visits.entry(at).or_default();
            *visit = (visit.0.saturating_add(1), self.passed.len());
            self.passed.push(Passed {
                vertex: at,
                grid: surface.grid(at),
                is_left: true,
            });
            at = next;
        }
        self.starts.push(self.passed.len());
    }

    /// How many times the boundary passes a vertex: 0 inside the surface.
    pub(crate) fn visits(&self, vertex: u32) -> u8 {
        self.visits.get(&vertex).map_or(0, |visit| visit.0)
    }

    pub(crate) fn remove(&mut self, vertex: u32) {
        if let Some(&(_, place)) = self.visits.get(&vertex) {
            self.passed[place].is_left = false;
        }
    }

    /// Largest distance in metres between the boundary vertices as they were and the new edge, if the boundary vertex
    /// `blue` collapses into `red` next to it.
    pub(crate) fn strays(&self, reference: &Reference, blue: u32, red: u32) -> f64 {
        let Some(&(_, place)) = self.visits.get(&blue) else {
            return f64::INFINITY;
        };
        let (before, after) = (self.left_from(place, false), self.left_from(place, true));
        let [Some(before), Some(after)] = [before, after] else {
            return f64::INFINITY;
        };
        if self.passed[before].vertex != red && self.passed[after].vertex != red {
            return f64::INFINITY;
        }
        let (from, to) = (self.passed[before].grid, self.passed[after].grid);
        let mut farthest: f64 = 0.0;
        let mut index = self.step(before, true);
        while index != after {
            farthest = farthest.max(distance_to_segment(reference, self.passed[index].grid, from, to));
            index = self.step(index, true);
        }
        farthest
    }

    /// The nearest place along the loop whose vertex is left.
    fn left_from(&self, place: usize, forward: bool) -> Option<usize> {
        let mut index = self.step(place, forward);
        while index != place && !self.passed[index].is_left {
            index = self.step(index, forward);
        }
        (index != place).then_some(index)
    }

    fn step(&self, place: usize, forward: bool) -> usize {
        let next_loop = self.starts.partition_point(|&start| start <= place);
        let (start, end) = (self.starts[next_loop - 1], self.starts[next_loop]);
        match forward {
            true if place + 1 == end => start,
            true => place + 1,
            false if place == start => end - 1,
            false => place - 1,
        }
    }
}

/// Metres from a point of the grid to the nearest of a segment, as long as they can be: a column is longer towards the
/// equator.
fn distance_to_segment(reference: &Reference, point: DVec2, from: DVec2, to: DVec2) -> f64 {
    let ground = reference.ground_at(point.y);
    let (along, before) = ((to - from) * ground, (point - from) * ground);
    let share = (before.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let nearest = from.lerp(to, share);
    if nearest.distance_squared(point) < ON_A_LINE * ON_A_LINE {
        // On the segment: what is left is rounding.
        return 0.0;
    }
    let longest = ground.max(reference.ground_at(nearest.y));
    ((nearest - point) * longest).length()
}
