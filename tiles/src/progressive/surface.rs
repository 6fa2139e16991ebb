//! A surface that grows by vertex splits: flat arrays of half-edges and of lattice positions.
//!
//! Half-edge `3t + k` starts at the `k`th corner of triangle `t`. A walk around a vertex is counter-clockwise; on the boundary it
//! begins at the half-edge that has nothing to its right.

use glam::DVec3;

/// Stands for no half-edge.
const NONE: u32 = u32::MAX;

fn next(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

fn previous(edge: u32) -> u32 {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

/// Which part of the triangles around a vertex goes over to the vertex that is split off it.
///
/// ```text
///   Inner              Front              Back               Outer
///    b ─── …            b ─── …          ══ a ─── …         ══ a ─── …
///   ╱ ╲   ╱            ╱ ╲   ╱             ╱ ╲   ╱             ╱ ╲   ╱
///  … blue─red         ═ blue═red          red ═ blue ═       … red─blue ═
///   ╲ ╱   ╲                                                     ╲ ╱   ╲
///    a ─── …            ═ boundary                           ══ b ─── …
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Side {
    /// Those between two cuts: blue is inside the surface.
    #[default]
    Inner,
    /// Those from the beginning of the walk to a cut: both are on the boundary.
    Front,
    /// Those from a cut to the end of the walk: both are on the boundary.
    Back,
    /// Those before the first cut and after the second: red is inside the surface.
    Outer,
}

impl Side {
    pub(super) const ALL: [Self; 4] = [Self::Inner, Self::Front, Self::Back, Self::Outer];

    pub(super) fn has_first_cut(self) -> bool {
        self != Self::Front
    }

    pub(super) fn has_second_cut(self) -> bool {
        self != Self::Back
    }
}

/// Where the star of a vertex is cut open: places in the walk around it, the first where blue's triangles begin (red's, if
/// outer), the second where they end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cuts {
    pub(super) side: Side,
    pub(super) first: usize,
    pub(super) second: usize,
}

/// The walk around a vertex.
#[derive(Debug, Default)]
pub(super) struct Ring {
    /// Half-edges that leave the vertex, one a triangle.
    pub(super) edges: Vec<u32>,
    /// Its neighbours; on the boundary one more than triangles.
    pub(super) vertices: Vec<u32>,
}

impl Ring {
    pub(super) fn is_closed(&self) -> bool {
        self.edges.len() == self.vertices.len()
    }
}

/// Positions and triangles so far.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub(super) positions: Vec<DVec3>,
    /// Vertex at which each half-edge starts: the corners of the triangles.
    pub(super) origins: Vec<u32>,
    twins: Vec<u32>,
    /// A half-edge from each vertex: the first of its walk.
    leaving: Vec<u32>,
    /// How many neighbours each vertex has.
    valences: Vec<u32>,
    /// Whether a walk around each vertex ends where it began.
    closed: Vec<bool>,
}

impl Surface {
    /// Joins triangles whose corners are vertices of `positions`. An edge of more than two triangles, or of two that run along
    /// it in one direction, is left open; of fans that meet in nothing but a vertex, one is walked.
    pub(super) fn new(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Self {
        let mut surface = Self {
            leaving: vec![NONE; positions.len()],
            valences: vec![0; positions.len()],
            closed: vec![false; positions.len()],
            positions,
            origins: triangles.as_flattened().to_vec(),
            twins: vec![NONE; 3 * triangles.len()],
        };
        let mut edges: Vec<(u32, u32, u32)> = (0..surface.origins.len() as u32)
            .map(|edge| {
                let [a, b] = [surface.origin(edge), surface.origin(next(edge))];
                (a.min(b), a.max(b), edge)
            })
            .collect();
        edges.sort_unstable();
        for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if let &[(_, _, one), (_, _, other)] = group
                && surface.origin(one) != surface.origin(other)
            {
                surface.join(one, other);
            }
        }
        for edge in 0..surface.origins.len() as u32 {
            let leaving = &mut surface.leaving[surface.origins[edge as usize] as usize];
            if *leaving == NONE || surface.twins[edge as usize] == NONE {
                *leaving = edge;
            }
        }
        let mut ring = Ring::default();
        for vertex in 0..surface.positions.len() {
            surface.walk(vertex as u32, &mut ring);
            surface.valences[vertex] = ring.vertices.len() as u32;
            surface.closed[vertex] = ring.is_closed();
        }
        surface
    }

    /// How many neighbours a vertex has.
    pub(super) fn valence(&self, vertex: u32) -> u32 {
        self.valences[vertex as usize]
    }

    /// Whether a vertex is inside the surface.
    pub(super) fn is_closed(&self, vertex: u32) -> bool {
        self.closed[vertex as usize]
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.origins.len() / 3
    }

    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        self.origins.as_chunks().0
    }

    fn origin(&self, edge: u32) -> u32 {
        self.origins[edge as usize]
    }

    /// Walks around a vertex.
    pub(super) fn walk(&self, vertex: u32, ring: &mut Ring) {
        ring.edges.clear();
        ring.vertices.clear();
        let first = self.leaving[vertex as usize];
        let mut edge = first;
        while edge != NONE {
            ring.edges.push(edge);
            ring.vertices.push(self.origin(next(edge)));
            let back = previous(edge);
            edge = self.twins[back as usize];
            if edge == first {
                return;
            }
            if edge == NONE {
                ring.vertices.push(self.origin(back));
            }
        }
    }

    /// Splits a vertex off `red`, whose walk is `ring`. The cuts must be possible ([`are_possible`]).
    ///
    /// ```text
    ///         second                     second
    ///        ╱  │  ╲                    ╱  │  ╲
    ///       ╱   │   ╲                  ╱   │   ╲
    ///      … ─ red ─ …      ▶        … ─ red│blue ─ …       (red, first, blue) and (red, blue, second) are new,
    ///       ╲   │   ╱                  ╲   │   ╱           in this order
    ///        ╲  │  ╱                    ╲  │  ╱
    ///         first                      first
    /// ```
    pub(super) fn split(&mut self, red: u32, ring: &Ring, cuts: Cuts, position: DVec3) {
        let blue = self.positions.len() as u32;
        self.positions.push(position);
        self.leaving.push(NONE);
        self.count_neighbours(red, ring, cuts);
        if cuts.side == Side::Outer {
            self.give(&ring.edges, blue);
            self.leaving[blue as usize] = self.leaving[red as usize];
            self.open(blue, red, ring, cuts);
        } else {
            self.open(red, blue, ring, cuts);
        }
    }

    /// Notes how many neighbours red and blue have after the split, and that the vertices at the cuts have one more.
    fn count_neighbours(&mut self, red: u32, ring: &Ring, cuts: Cuts) {
        let count = ring.vertices.len();
        let (first, second) = (cuts.first, cuts.second);
        let inner = match cuts.side {
            Side::Front => second + 2,
            Side::Back => count - first + 1,
            Side::Inner | Side::Outer => (second + count - first) % count + 2,
        };
        let shared = usize::from(cuts.side.has_first_cut()) + usize::from(cuts.side.has_second_cut());
        let outer = count + 2 + shared - inner;
        let is_outer = cuts.side == Side::Outer;
        let [of_red, of_blue] = if is_outer { [inner, outer] } else { [outer, inner] };
        self.valences[red as usize] = of_red as u32;
        self.valences.push(of_blue as u32);
        self.closed.push(cuts.side == Side::Inner);
        self.closed[red as usize] |= is_outer;
        if cuts.side.has_first_cut() {
            self.valences[ring.vertices[first] as usize] += 1;
        }
        if cuts.side.has_second_cut() {
            self.valences[ring.vertices[second] as usize] += 1;
        }
    }

    /// Gives the `inner` vertex its part of the star of the `outer` one, and fills the cuts.
    fn open(&mut self, outer: u32, inner: u32, ring: &Ring, cuts: Cuts) {
        let count = ring.vertices.len();
        let (first, second) = (cuts.first, cuts.second);
        match cuts.side {
            Side::Front => self.give(&ring.edges[..second], inner),
            Side::Back => self.give(&ring.edges[first..], inner),
            _ if first < second => self.give(&ring.edges[first..second], inner),
            _ => {
                self.give(&ring.edges[first..], inner);
                self.give(&ring.edges[..second], inner);
            }
        }
        let edge_at = |place: usize| ring.edges.get(place).copied().unwrap_or(NONE);
        let edge_before = |place: usize| match place {
            0 if ring.is_closed() => previous(ring.edges[count - 1]),
            0 => NONE,
            _ => previous(ring.edges[place - 1]),
        };
        let mut sides = [NONE; 2];
        if cuts.side.has_first_cut() {
            let edge = self.add_triangle([outer, ring.vertices[first], inner]);
            self.join(edge, edge_before(first));
            self.join(edge + 1, edge_at(first));
            self.lead(edge + 1);
            sides[0] = edge + 2;
            if first == 0 || ring.is_closed() {
                self.leaving[outer as usize] = edge;
            }
            self.leaving[inner as usize] = edge + 2;
        }
        if cuts.side.has_second_cut() {
            let edge = self.add_triangle([outer, inner, ring.vertices[second]]);
            self.join(edge + 1, edge_before(second));
            self.join(edge + 2, edge_at(second));
            self.lead(edge + 2);
            sides[1] = edge;
            if cuts.side == Side::Front {
                self.leaving[outer as usize] = edge;
                self.leaving[inner as usize] = if second == 0 { edge + 1 } else { ring.edges[0] };
            }
        }
        if sides[0] != NONE {
            self.join(sides[0], sides[1]);
        }
    }

    fn give(&mut self, edges: &[u32], vertex: u32) {
        for &edge in edges {
            self.origins[edge as usize] = vertex;
        }
    }

    fn add_triangle(&mut self, corners: [u32; 3]) -> u32 {
        let edge = self.origins.len() as u32;
        self.origins.extend(corners);
        self.twins.extend([NONE; 3]);
        edge
    }

    /// Lets walks around a half-edge's origin begin with it if nothing is to its right.
    fn lead(&mut self, edge: u32) {
        if self.twins[edge as usize] == NONE {
            self.leaving[self.origins[edge as usize] as usize] = edge;
        }
    }

    fn join(&mut self, edge: u32, twin: u32) {
        self.twins[edge as usize] = twin;
        if twin != NONE {
            self.twins[twin as usize] = edge;
        }
    }
}

/// Whether cuts leave each vertex at least a triangle of the ring, where it needs one.
pub(super) fn are_possible(cuts: Cuts, ring: &Ring) -> bool {
    let count = ring.vertices.len();
    let in_ring = cuts.first < count && cuts.second < count;
    let is_boundary = !ring.is_closed();
    in_ring
        && match cuts.side {
            Side::Inner if !is_boundary => cuts.first != cuts.second,
            Side::Inner | Side::Outer => is_boundary && cuts.first < cuts.second,
            Side::Front | Side::Back => is_boundary,
        }
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
