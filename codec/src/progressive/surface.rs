//! A surface that grows by vertex splits: flat arrays of triangles and of vertices.

use glam::DVec3;

use super::ring::{Cuts, NONE, Ring, Side, Spoke, are_possible, next, previous};
use super::sampling::Fit;

/// What is known of a vertex. All of it stands together, for whoever looks at one thing looks at the others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) position: DVec3,
    /// What differences of heights around it were like.
    pub(super) roughness: f64,
    /// A half-edge from it: the first of its walk.
    leaving: u32,
    /// How many neighbours it has.
    pub(super) valence: u32,
    /// Whether a walk around it ends where it began: it is inside the surface.
    pub(super) is_closed: bool,
    /// Whether it is in the queue.
    pub(super) is_queued: bool,
    /// How its first coordinate lies to the samples.
    pub(super) fit: Fit,
}

impl Vertex {
    pub(super) fn new(position: DVec3, fit: Fit) -> Self {
        Self {
            position,
            roughness: 0.0,
            leaving: NONE,
            valence: 0,
            is_closed: false,
            is_queued: false,
            fit,
        }
    }
}

/// A triangle and what is on the other sides of its edges; aligned, so that it never lies in two lines of a cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Triangle {
    corners: [u32; 3],
    twins: [u32; 3],
}

/// Vertices and triangles so far.
#[derive(Debug, Default)]
pub(super) struct GrowingSurface {
    pub(super) vertices: Vec<Vertex>,
    triangles: Vec<Triangle>,
}

impl GrowingSurface {
    /// Joins triangles whose corners are `vertices`. An edge of more than two triangles, or of two that run along it in one
    /// direction, is left open; of fans that meet in nothing but a vertex, one is walked.
    pub(super) fn new(vertices: Vec<Vertex>, triangles: &[[u32; 3]]) -> Self {
        let triangle = |&corners: &[u32; 3]| Triangle {
            corners,
            twins: [NONE; 3],
        };
        let mut surface = Self {
            vertices,
            triangles: triangles.iter().map(triangle).collect(),
        };
        let edges = || (0..triangles.len() as u32).flat_map(|triangle| (0..3).map(move |corner| 4 * triangle + corner));
        surface.join_all(edges());
        for edge in edges() {
            let (origin, is_first) = (surface.origin(edge), surface.twin(edge) == NONE);
            let leaving = &mut surface.vertices[origin as usize].leaving;
            if *leaving == NONE || is_first {
                *leaving = edge;
            }
        }
        let mut ring = Ring::default();
        for vertex in 0..surface.vertices.len() {
            surface.walk(vertex as u32, &mut ring);
            surface.vertices[vertex].valence = ring.spokes.len() as u32;
            surface.vertices[vertex].is_closed = ring.is_closed();
        }
        surface
    }

    fn join_all(&mut self, edges: impl Iterator<Item = u32>) {
        let mut along: Vec<(u32, u32, u32)> = edges
            .map(|edge| {
                let [a, b] = [self.origin(edge), self.origin(next(edge))];
                (a.min(b), a.max(b), edge)
            })
            .collect();
        along.sort_unstable();
        for group in along.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if let &[(_, _, one), (_, _, other)] = group
                && self.origin(one) != self.origin(other)
            {
                self.join(one, other);
            }
        }
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The corners of each triangle.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.triangles.iter().map(|triangle| triangle.corners)
    }

    fn origin(&self, edge: u32) -> u32 {
        self.triangles[(edge >> 2) as usize].corners[(edge & 3) as usize]
    }

    fn twin(&self, edge: u32) -> u32 {
        self.triangles[(edge >> 2) as usize].twins[(edge & 3) as usize]
    }

    /// Walks around a vertex.
    pub(super) fn walk(&self, vertex: u32, ring: &mut Ring) {
        ring.spokes.clear();
        ring.roughness = 0.0;
        (ring.sum, ring.sizes) = (DVec3::ZERO, DVec3::ZERO);
        ring.is_open = false;
        let Vertex { position, leaving, .. } = self.vertices[vertex as usize];
        let mut edge = leaving;
        while edge != NONE {
            let Triangle { corners, twins } = self.triangles[(edge >> 2) as usize];
            self.reach(ring, edge, corners[(next(edge) & 3) as usize], position);
            let back = (previous(edge) & 3) as usize;
            edge = twins[back];
            if edge == leaving {
                return;
            }
            if edge == NONE {
                self.reach(ring, NONE, corners[back], position);
            }
        }
        ring.is_open = true;
    }

    #[inline]
    fn reach(&self, ring: &mut Ring, edge: u32, vertex: u32, from: DVec3) {
        let neighbour = &self.vertices[vertex as usize];
        let to = neighbour.position - from;
        ring.roughness += neighbour.roughness;
        ring.sum += to;
        ring.sizes += to.abs();
        ring.spokes.push(Spoke { edge, vertex, to });
    }

    /// Whether the star of a vertex, whose walk is `ring`, can be cut so: the third vertex of a hole is on no boundary before.
    pub(super) fn can_split(&self, ring: &Ring, cuts: Cuts) -> bool {
        let is_inside = |place: usize| self.vertices[ring.spokes[place].vertex as usize].is_closed;
        are_possible(cuts, ring) && cuts.hole().is_none_or(is_inside)
    }

    /// Splits a vertex off `red`, whose walk is `ring`. The cuts must be possible ([`Self::can_split`]).
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
    /// A hole is made where one of the two triangles would be: its edges have nothing on that side.
    pub(super) fn split(&mut self, red: u32, ring: &Ring, cuts: Cuts, blue: Vertex) {
        let number = self.vertices.len() as u32;
        self.vertices.push(blue);
        self.count_neighbours(red, ring, cuts);
        if cuts.side == Side::Outer {
            self.give(&ring.spokes, number);
            self.vertices[number as usize].leaving = self.vertices[red as usize].leaving;
            self.open(number, red, ring, cuts);
        } else {
            self.open(red, number, ring, cuts);
        }
    }

    /// Notes how many neighbours red and blue have after the split, and that the vertices at the cuts have one more.
    fn count_neighbours(&mut self, red: u32, ring: &Ring, cuts: Cuts) {
        let count = ring.spokes.len();
        let (first, second) = (cuts.first, cuts.second);
        let inner = match cuts.side {
            Side::Front => second + 2,
            Side::Back => count - first + 1,
            _ if first < second => second - first + 2,
            _ => second + count - first + 2,
        };
        let shared = usize::from(cuts.side.has_first_cut()) + usize::from(cuts.side.has_second_cut());
        let outer = count + 2 + shared - inner;
        let is_outer = cuts.side == Side::Outer;
        let [of_red, of_blue] = if is_outer { [inner, outer] } else { [outer, inner] };
        let blue = self.vertices.len() - 1;
        self.vertices[blue].valence = of_blue as u32;
        self.vertices[blue].is_closed = cuts.side == Side::Inner;
        self.vertices[red as usize].valence = of_red as u32;
        let is_red_closed = &mut self.vertices[red as usize].is_closed;
        *is_red_closed = is_outer || *is_red_closed && !cuts.side.opens_hole();
        if cuts.side.has_first_cut() {
            self.vertices[ring.spokes[first].vertex as usize].valence += 1;
        }
        if cuts.side.has_second_cut() {
            self.vertices[ring.spokes[second].vertex as usize].valence += 1;
        }
    }

    /// Gives the `inner` vertex its part of the star of the `outer` one, and fills the cuts.
    fn open(&mut self, outer: u32, inner: u32, ring: &Ring, cuts: Cuts) {
        let (first, second) = (cuts.first, cuts.second);
        match cuts.side {
            Side::Front => self.give(&ring.spokes[..second], inner),
            Side::Back => self.give(&ring.spokes[first..], inner),
            _ if first < second => self.give(&ring.spokes[first..second], inner),
            _ => {
                self.give(&ring.spokes[first..], inner);
                self.give(&ring.spokes[..second], inner);
            }
        }
        let mut sides = [NONE; 2];
        if cuts.side == Side::HoleFirst {
            self.open_hole(ring.edge_before(first), ring.edge_at(first));
        } else if cuts.side.has_first_cut() {
            let edge = self.add_triangle([outer, ring.spokes[first].vertex, inner]);
            self.join(edge, ring.edge_before(first));
            self.join(edge + 1, ring.edge_at(first));
            self.lead(edge + 1);
            sides[0] = edge + 2;
            if first == 0 || ring.is_closed() {
                self.vertices[outer as usize].leaving = edge;
            }
            self.vertices[inner as usize].leaving = edge + 2;
        }
        if cuts.side == Side::HoleSecond {
            self.open_hole(ring.edge_before(second), ring.edge_at(second));
        } else if cuts.side.has_second_cut() {
            let edge = self.add_triangle([outer, inner, ring.spokes[second].vertex]);
            self.join(edge + 1, ring.edge_before(second));
            self.join(edge + 2, ring.edge_at(second));
            self.lead(edge + 2);
            sides[1] = edge;
            if cuts.side == Side::HoleFirst {
                self.vertices[outer as usize].leaving = edge;
            }
            if cuts.side == Side::Front {
                self.vertices[outer as usize].leaving = edge;
                self.vertices[inner as usize].leaving = if second == 0 { edge + 1 } else { ring.spokes[0].edge };
            }
        }
        if sides[0] != NONE {
            self.join(sides[0], sides[1]);
        }
    }

    /// Parts the two half-edges along an edge, of which one leads to the third vertex of a hole and the other from it: all walks there
    /// begin beside the hole.
    fn open_hole(&mut self, one: u32, other: u32) {
        for edge in [one, other] {
            self.set_twin(edge, NONE);
            self.lead(edge);
            let origin = self.origin(edge);
            self.vertices[origin as usize].is_closed = false;
        }
    }

    fn give(&mut self, spokes: &[Spoke], vertex: u32) {
        for spoke in spokes.iter().filter(|spoke| spoke.edge != NONE) {
            self.triangles[(spoke.edge >> 2) as usize].corners[(spoke.edge & 3) as usize] = vertex;
        }
    }

    fn add_triangle(&mut self, corners: [u32; 3]) -> u32 {
        let edge = 4 * self.triangles.len() as u32;
        self.triangles.push(Triangle {
            corners,
            twins: [NONE; 3],
        });
        edge
    }

    /// Lets walks around a half-edge's origin begin with it if nothing is to its right.
    fn lead(&mut self, edge: u32) {
        if self.twin(edge) == NONE {
            let origin = self.origin(edge);
            self.vertices[origin as usize].leaving = edge;
        }
    }

    fn join(&mut self, edge: u32, twin: u32) {
        self.set_twin(edge, twin);
        if twin != NONE {
            self.set_twin(twin, edge);
        }
    }

    fn set_twin(&mut self, edge: u32, twin: u32) {
        self.triangles[(edge >> 2) as usize].twins[(edge & 3) as usize] = twin;
    }
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
