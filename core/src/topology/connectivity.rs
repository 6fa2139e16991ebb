//! The connectivity of a surface while edges collapse: flat arrays, and no coordinates.
//!
//! Corner `3t + k` is the `k`th corner of triangle `t`. The corners that meet in a vertex form a ring, linked in both
//! directions, in no particular order, so that any set of triangles can be held, a 2-manifold or not.
//!
//! That is what the half-edges of `half_edges.rs` cannot do, on which the simplifiers of height fields swap edges and split
//! triangles: they walk around a vertex in order, and need a 2-manifold for it. Logs, models and clusterings come from
//! anywhere, and whether they are manifold is found out here.
//!
//! ```text
//!            x                        x
//!          ╱ │ ╲                      │ ╲        removed: (blue, red, x), (red, blue, y)
//!        ╱   │   ╲                    │   ╲      the other corners at blue go over to red:
//!     blue ──┼── red         ▶       red ── …    their rings are joined
//!        ╲   │   ╱                    │   ╱
//!          ╲ │ ╱                      │ ╱
//!            y                        y
//! ```

use crate::mesh::Mesh;

/// Stands for no corner.
const NONE: u32 = u32::MAX;

/// Triangles, and for each vertex those around it.
#[derive(Clone, Debug)]
pub struct Connectivity {
    triangles: Vec<Triangle>,
    /// One corner at each vertex, or [`NONE`].
    first: Vec<u32>,
}

/// For each corner its vertex, and the next and the previous corner around that vertex. What is used together stands
/// together: going through a ring is bound by memory.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    vertices: [u32; 3],
    next: [u32; 3],
    previous: [u32; 3],
}

impl Connectivity {
    /// The connectivity of `mesh`, whose triangles must use its vertices only.
    #[must_use]
    pub fn new(mesh: &Mesh) -> Self {
        let unlinked = |&vertices: &[u32; 3]| Triangle {
            vertices,
            next: [NONE; 3],
            previous: [NONE; 3],
        };
        let mut connectivity = Self {
            triangles: mesh.triangles.iter().map(unlinked).collect(),
            first: vec![NONE; mesh.positions.len()],
        };
        for (corner, &vertex) in (0_u32..).zip(mesh.triangles.as_flattened()) {
            connectivity.link(corner, vertex);
        }
        connectivity
    }

    /// How many vertices there were at the start.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.first.len()
    }

    /// The vertices of a triangle; of a removed one, those that it had.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        self.triangles[triangle as usize].vertices
    }

    /// The triangles around a vertex, in no particular order.
    pub fn star(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        self.ring(vertex).map(|corner| corner / 3)
    }

    /// The other triangle along the edge from `a` to `b`. On a surface that is not a manifold, one of them.
    #[must_use]
    pub fn across(&self, triangle: u32, a: u32, b: u32) -> Option<u32> {
        self.star(a)
            .find(|&other| other != triangle && self.corners(other).contains(&b))
    }

    /// The two neighbours of a vertex along the boundary, the smaller first; none where there are not two.
    #[must_use]
    pub fn along_boundary(&self, vertex: u32) -> Option<[u32; 2]> {
        let mut others: Vec<u32> = self
            .star(vertex)
            .flat_map(|triangle| self.corners(triangle))
            .filter(|&corner| corner != vertex)
            .collect();
        others.sort_unstable();
        let mut once = others
            .chunk_by(|a, b| a == b)
            .filter(|same| same.len() == 1)
            .map(|same| same[0]);
        let ends = [once.next()?, once.next()?];
        once.next().is_none().then_some(ends)
    }

    /// Performs the collapse that `star` was gathered for, and fills `moved` with the corners that go over from the
    /// blue vertex to the red one.
    pub fn collapse(&mut self, star: &EdgeStar, moved: &mut Vec<u32>) {
        for &triangle in star.removed() {
            for corner in 3 * triangle..3 * triangle + 3 {
                self.unlink(corner);
            }
        }
        moved.clear();
        moved.extend(self.ring(star.blue));
        for &corner in moved.iter() {
            self.triangles[corner as usize / 3].vertices[corner as usize % 3] = star.red;
        }
        self.join_rings(star.blue, star.red);
    }

    fn ring(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let first = Some(self.first[vertex as usize]).filter(|&corner| corner != NONE);
        std::iter::successors(first, move |&corner| {
            Some(self.next(corner)).filter(|&next| Some(next) != first)
        })
    }

    fn link(&mut self, corner: u32, vertex: u32) {
        let first = self.first[vertex as usize];
        if first == NONE {
            self.first[vertex as usize] = corner;
            self.tie(corner, corner);
        } else {
            let last = self.previous(first);
            self.tie(last, corner);
            self.tie(corner, first);
        }
    }

    fn unlink(&mut self, corner: u32) {
        let vertex = self.triangles[corner as usize / 3].vertices[corner as usize % 3] as usize;
        let (previous, next) = (self.previous(corner), self.next(corner));
        self.tie(previous, next);
        if self.first[vertex] == corner {
            self.first[vertex] = if next == corner { NONE } else { next };
        }
    }

    fn join_rings(&mut self, blue: u32, red: u32) {
        let (from, into) = (self.first[blue as usize], self.first[red as usize]);
        self.first[blue as usize] = NONE;
        if into == NONE {
            self.first[red as usize] = from;
        } else if from != NONE {
            let (last_from, last_into) = (self.previous(from), self.previous(into));
            self.tie(last_into, from);
            self.tie(last_from, into);
        }
    }

    fn tie(&mut self, corner: u32, next: u32) {
        self.triangles[corner as usize / 3].next[corner as usize % 3] = next;
        self.triangles[next as usize / 3].previous[next as usize % 3] = corner;
    }

    fn next(&self, corner: u32) -> u32 {
        self.triangles[corner as usize / 3].next[corner as usize % 3]
    }

    fn previous(&self, corner: u32) -> u32 {
        self.triangles[corner as usize / 3].previous[corner as usize % 3]
    }
}

/// One end of an edge: how many triangles are around it, and its neighbours, growing.
#[derive(Clone, Debug, Default)]
struct End {
    triangles: usize,
    neighbours: Vec<u32>,
}

impl End {
    fn gather(&mut self, connectivity: &Connectivity, end: u32) {
        self.triangles = 0;
        self.neighbours.clear();
        for triangle in connectivity.star(end) {
            self.triangles += 1;
            let corners = connectivity.corners(triangle).into_iter();
            self.neighbours.extend(corners.filter(|&vertex| vertex != end));
        }
        self.neighbours.sort_unstable();
        self.neighbours.dedup();
    }

    /// Around an inner vertex of a manifold there are as many neighbours as triangles.
    fn is_on_boundary(&self) -> bool {
        self.triangles != self.neighbours.len()
    }

    fn is_inner_with_three_triangles(&self) -> bool {
        self.triangles == 3 && !self.is_on_boundary()
    }
}

/// Why an edge cannot collapse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkFault {
    /// No triangle uses both vertices.
    #[error("no edge joins the two vertices")]
    NoEdge,
    /// More than two triangles share the edge.
    #[error("more than two triangles share the edge")]
    TooManyTriangles,
    /// The surface would be pinched to a single vertex between two of its sides.
    #[error("an interior edge between two vertices of the boundary")]
    JoinsBoundary,
    /// The surface would be folded onto itself.
    #[error("the two vertices have a common neighbour that is not in a triangle with both")]
    CommonNeighbour,
    /// The three are not the corners of a hole, or not of that alone.
    #[error("the edge is not one of a hole of three vertices")]
    NotAHole,
    /// A lone triangle or a tetrahedron.
    #[error("nothing but a flat remainder would be left of the surface")]
    Last,
}

/// The star of an edge: every triangle around its endpoints, looked at from the collapse `blue → red`.
///
/// One is made for a whole run of collapses; gathering again reuses its memory.
#[derive(Clone, Debug, Default)]
pub struct EdgeStar {
    blue: u32,
    red: u32,
    blue_end: End,
    red_end: End,
    vertices: Vec<u32>,
    removed: Vec<u32>,
}

impl EdgeStar {
    /// Looks at the edge between two different vertices.
    pub fn gather(&mut self, connectivity: &Connectivity, blue: u32, red: u32) {
        (self.blue, self.red) = (blue, red);
        self.blue_end.gather(connectivity, blue);
        self.red_end.gather(connectivity, red);
        let along = |&triangle: &u32| connectivity.corners(triangle).contains(&red);
        self.removed.clear();
        self.removed.extend(connectivity.star(blue).filter(along));
        let neighbours = &self.blue_end.neighbours;
        let is_news = |vertex: &&u32| **vertex != blue && neighbours.binary_search(vertex).is_err();
        self.vertices.clear();
        self.vertices.push(blue);
        self.vertices.extend(neighbours);
        self.vertices.extend(self.red_end.neighbours.iter().filter(is_news));
        if self.removed.is_empty() {
            self.vertices.push(red);
        }
    }

    /// The endpoints and all their neighbours, each once.
    #[must_use]
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The triangles along the edge, which the collapse removes: two inside the surface, one on its boundary.
    #[must_use]
    pub fn removed(&self) -> &[u32] {
        &self.removed
    }

    /// The link condition, its boundary part included (T. Dey et al., *Topology preserving edge contraction*, 1999),
    /// for surfaces that are 2-manifolds: what the collapse leaves is a 2-manifold of the same topology.
    ///
    /// # Errors
    /// What stands against the collapse.
    pub fn link_condition(&self) -> Result<(), LinkFault> {
        let (blue, red) = (&self.blue_end, &self.red_end);
        match self.removed.len() {
            0 => Err(LinkFault::NoEdge),
            1 if blue.triangles == 1 && red.triangles == 1 => Err(LinkFault::Last),
            2 if blue.is_on_boundary() && red.is_on_boundary() => Err(LinkFault::JoinsBoundary),
            1 | 2 if self.common_neighbours() != self.removed.len() => Err(LinkFault::CommonNeighbour),
            2 if blue.is_inner_with_three_triangles() && red.is_inner_with_three_triangles() => Err(LinkFault::Last),
            1 | 2 => Ok(()),
            _ => Err(LinkFault::TooManyTriangles),
        }
    }

    /// What a collapse that closes a hole must fulfil: the edge is one of a hole of three vertices, and the collapse is one that the
    /// link condition allowed if a triangle were in the hole. The surface must be a 2-manifold.
    ///
    /// # Errors
    /// What stands against the collapse.
    pub fn closing_condition(&self, connectivity: &Connectivity) -> Result<(), LinkFault> {
        let (blue, red) = (self.blue, self.red);
        let third = connectivity
            .along_boundary(blue)
            .and_then(|ends| ends.into_iter().find(|&end| end != red))
            .ok_or(LinkFault::NotAHole)?;
        let corners = [[blue, red, third], [red, blue, third], [third, blue, red]];
        let is_hole = corners
            .iter()
            .all(|&[corner, a, b]| connectivity.along_boundary(corner) == Some([a.min(b), a.max(b)]));
        match self.removed.len() {
            1 if !is_hole => Err(LinkFault::NotAHole),
            1 if self.common_neighbours() != 2 => Err(LinkFault::CommonNeighbour),
            1 if self.blue_end.triangles == 2 && self.red_end.triangles == 2 => Err(LinkFault::Last),
            1 => Ok(()),
            _ => Err(LinkFault::NotAHole),
        }
    }

    fn common_neighbours(&self) -> usize {
        let is_common = |vertex: &&u32| self.red_end.neighbours.binary_search(vertex).is_ok();
        self.blue_end.neighbours.iter().filter(is_common).count()
    }
}

#[cfg(test)]
#[path = "connectivity_tests.rs"]
mod tests;
