//! How far the simplified edge of a surface strays from what it was: the chains of boundary vertices.

use std::collections::HashMap;

use glam::DVec2;

use crate::mesh::boundary_edges;

/// The boundary loops of a mesh as they were, and which of their vertices are left.
pub(crate) struct OutlineChains {
    /// Plan position of each vertex in metres.
    metres: Vec<DVec2>,
    /// All loops, one after the other.
    vertices: Vec<u32>,
    /// Where each loop begins in `vertices`, and the end.
    starts: Vec<usize>,
    /// How often the boundary passes each vertex, and the place in `vertices` where it last does.
    visits: Vec<(u8, usize)>,
    is_left: Vec<bool>,
}

impl OutlineChains {
    pub(crate) fn new(triangles: &[[u32; 3]], metres: Vec<DVec2>) -> Self {
        let following = following(triangles);
        let mut chains = Self {
            visits: vec![(0, 0); metres.len()],
            is_left: vec![true; metres.len()],
            metres,
            vertices: Vec::new(),
            starts: vec![0],
        };
        let mut walked = HashMap::new();
        let mut origins: Vec<u32> = following.keys().copied().collect();
        origins.sort_unstable();
        for origin in origins {
            for turn in 0..following[&origin].len() {
                chains.walk(origin, turn, &following, &mut walked);
            }
        }
        chains
    }

    fn walk(&mut self, origin: u32, turn: usize, following: &HashMap<u32, Vec<u32>>, walked: &mut HashMap<u32, usize>) {
        if walked.get(&origin).copied().unwrap_or(0) > turn {
            return;
        }
        let mut at = origin;
        loop {
            let used = walked.entry(at).or_insert(0);
            let Some(&next) = following.get(&at).and_then(|ends| ends.get(*used)) else {
                break;
            };
            *used += 1;
            let visit = &mut self.visits[at as usize];
            *visit = (visit.0.saturating_add(1), self.vertices.len());
            self.vertices.push(at);
            at = next;
        }
        self.starts.push(self.vertices.len());
    }

    /// How many times the boundary passes a vertex: 0 inside the surface.
    pub(crate) fn visits(&self, vertex: u32) -> u8 {
        self.visits[vertex as usize].0
    }

    pub(crate) fn remove(&mut self, vertex: u32) {
        self.is_left[vertex as usize] = false;
    }

    /// Largest distance in metres between the boundary vertices as they were and the new edge, if the boundary vertex
    /// `blue` collapses into `red` next to it.
    pub(crate) fn strays(&self, blue: u32, red: u32) -> f64 {
        let place = self.visits[blue as usize].1;
        let (before, after) = (self.left_from(place, false), self.left_from(place, true));
        let [Some(before), Some(after)] = [before, after] else {
            return f64::INFINITY;
        };
        if self.vertices[before] != red && self.vertices[after] != red {
            return f64::INFINITY;
        }
        let (from, to) = (self.metres_at(before), self.metres_at(after));
        let mut farthest: f64 = 0.0;
        let mut index = self.step(before, true);
        while index != after {
            farthest = farthest.max(distance_to_segment(self.metres_at(index), from, to));
            index = self.step(index, true);
        }
        farthest
    }

    fn metres_at(&self, index: usize) -> DVec2 {
        self.metres[self.vertices[index] as usize]
    }

    /// The nearest place along the loop whose vertex is left.
    fn left_from(&self, place: usize, forward: bool) -> Option<usize> {
        let mut index = self.step(place, forward);
        while index != place && !self.is_left[self.vertices[index] as usize] {
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

/// For each vertex where boundary edges begin, their ends in order.
fn following(triangles: &[[u32; 3]]) -> HashMap<u32, Vec<u32>> {
    let mut following: HashMap<u32, Vec<u32>> = HashMap::new();
    for (from, to) in boundary_edges(triangles) {
        following.entry(from).or_default().push(to);
    }
    following
}

fn distance_to_segment(point: DVec2, from: DVec2, to: DVec2) -> f64 {
    let along = to - from;
    let t = ((point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(from + along * t)
}
