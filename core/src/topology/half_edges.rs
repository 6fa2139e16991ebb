//! Which triangle meets which in a manifold: half-edges by arithmetic, in three flat arrays, and the four edits of a
//! triangulation.
//!
//! Half-edge `3t + i` runs from corner `i` of triangle `t` to the next one, counter-clockwise; its *twin* runs the
//! other way in the triangle across, or is [`NONE`] on the boundary. Every vertex knows one half-edge that leaves it;
//! on the boundary it is the one with nothing to its right, so that a walk counter-clockwise sees the whole fan.

use crate::topology::compressed_rows::CompressedRows;

/// No half-edge, no triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// The half-edge that follows in its triangle.
pub(crate) fn next(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// The half-edge before it in its triangle.
pub(crate) fn previous(edge: u32) -> u32 {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

/// The half-edges of a triangle.
pub(crate) fn edges_of(triangle: u32) -> [u32; 3] {
    [3 * triangle, 3 * triangle + 1, 3 * triangle + 2]
}

/// The ends of an edge, the lower number first.
pub(crate) fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Triangles as half-edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct HalfEdges {
    /// Where each half-edge begins; [`NONE`] in removed triangles.
    origins: Vec<u32>,
    twins: Vec<u32>,
    /// A half-edge that leaves each vertex; [`NONE`] for removed ones.
    leaving: Vec<u32>,
}

impl HalfEdges {
    /// Connects triangles that are an oriented manifold, edge by edge. Of a vertex with several fans one is kept.
    pub(crate) fn new(vertex_count: usize, triangles: Vec<[u32; 3]>) -> Self {
        let origins = triangles.into_flattened();
        let mut connectivity = Self {
            twins: vec![NONE; origins.len()],
            leaving: vec![NONE; vertex_count],
            origins,
        };
        connectivity.pair_twins(vertex_count);
        connectivity.choose_leaving();
        connectivity
    }

    /// The same with the twin of each half-edge, or [`NONE`], told: vertices may be joined by several edges.
    pub(crate) fn with_twins(vertex_count: usize, triangles: Vec<[u32; 3]>, twins: Vec<u32>) -> Self {
        let mut connectivity = Self {
            origins: triangles.into_flattened(),
            twins,
            leaving: vec![NONE; vertex_count],
        };
        connectivity.choose_leaving();
        connectivity
    }

    /// Chooses the half-edge that the walk around each vertex begins with.
    fn choose_leaving(&mut self) {
        for edge in 0..self.origins.len() as u32 {
            let leaving = &mut self.leaving[self.origins[edge as usize] as usize];
            if *leaving == NONE || self.twins[edge as usize] == NONE {
                *leaving = edge;
            }
        }
    }

    /// Looks for each half-edge's twin among those that begin where it ends.
    fn pair_twins(&mut self, vertex_count: usize) {
        let leaving = CompressedRows::sorted(vertex_count, self.origins.iter().copied().zip(0..));
        for edge in 0..self.origins.len() as u32 {
            let (from, to) = (self.origin(edge), self.end(edge));
            if let Some(&twin) = leaving.row(to).iter().find(|&&other| self.end(other) == from) {
                self.twins[edge as usize] = twin;
            }
        }
    }

    /// Keeps the vertices of `order` alone, numbers them in that order, and triangles in the order in which those see them
    /// first.
    pub(crate) fn reorder(&mut self, order: &[u32]) {
        let mut triangles = self.triangles_around(order);
        let count = triangles.len();
        triangles.extend((0..self.triangle_slots()).filter(|&triangle| self.corners(triangle).is_none()));
        for edges in [&mut self.origins, &mut self.twins] {
            permute_triangles(edges, &triangles, count);
        }
        let numbers_of_triangles = inverse(&triangles, triangles.len());
        drop(triangles);
        let moved = |edge: u32| match edge {
            NONE => NONE,
            edge => 3 * numbers_of_triangles[edge as usize / 3] + edge % 3,
        };
        self.twins.iter_mut().for_each(|twin| *twin = moved(*twin));
        let numbers_of_vertices = inverse(order, self.leaving.len());
        self.origins
            .iter_mut()
            .for_each(|origin| *origin = numbers_of_vertices[*origin as usize]);
        self.leaving = order
            .iter()
            .map(|&vertex| moved(self.leaving[vertex as usize]))
            .collect();
    }

    /// All triangles: first those around the first vertex, then further ones around the second …; at last those that no
    /// walk around a vertex sees.
    fn triangles_around(&self, vertices: &[u32]) -> Vec<u32> {
        let mut is_listed = vec![false; self.triangle_slots() as usize];
        let around = vertices
            .iter()
            .flat_map(|&vertex| self.leaving(vertex))
            .map(|edge| edge / 3);
        let all = around.chain((0..self.triangle_slots()).filter(|&triangle| self.corners(triangle).is_some()));
        all.filter(|&triangle| !std::mem::replace(&mut is_listed[triangle as usize], true))
            .collect()
    }

    /// Corners of all triangles, none of which was removed.
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        self.origins.as_chunks().0
    }

    pub(crate) fn vertex_slots(&self) -> u32 {
        self.leaving.len() as u32
    }

    pub(crate) fn triangle_slots(&self) -> u32 {
        (self.origins.len() / 3) as u32
    }

    pub(crate) fn origin(&self, edge: u32) -> u32 {
        self.origins[edge as usize]
    }

    pub(crate) fn end(&self, edge: u32) -> u32 {
        self.origins[next(edge) as usize]
    }

    /// The vertex across from a half-edge in its triangle.
    pub(crate) fn apex(&self, edge: u32) -> u32 {
        self.origins[previous(edge) as usize]
    }

    /// Start and end of an edge with two triangles, and the vertices across from it on its left and on its right.
    pub(crate) fn quadrilateral(&self, edge: u32) -> [u32; 4] {
        [
            self.origin(edge),
            self.end(edge),
            self.apex(edge),
            self.apex(self.twin(edge)),
        ]
    }

    pub(crate) fn twin(&self, edge: u32) -> u32 {
        self.twins[edge as usize]
    }

    /// Corners of a triangle; none if it was removed.
    pub(crate) fn corners(&self, triangle: u32) -> Option<[u32; 3]> {
        let first = 3 * triangle as usize;
        let corners = [self.origins[first], self.origins[first + 1], self.origins[first + 2]];
        (corners[0] != NONE).then_some(corners)
    }

    pub(crate) fn is_live(&self, vertex: u32) -> bool {
        self.leaving[vertex as usize] != NONE
    }

    /// Whether the boundary passes a vertex.
    pub(crate) fn is_boundary(&self, vertex: u32) -> bool {
        self.twin(self.leaving[vertex as usize]) == NONE
    }

    /// Half-edges that leave a vertex, counter-clockwise; one a triangle.
    pub(crate) fn leaving(&self, vertex: u32) -> Leaving<'_> {
        let first = self.leaving[vertex as usize];
        Leaving {
            connectivity: self,
            first,
            next: first,
        }
    }

    /// Writes the neighbours of a vertex to `ring`, counter-clockwise; on the boundary from its first to its last.
    pub(crate) fn ring(&self, vertex: u32, ring: &mut Vec<u32>) {
        ring.clear();
        let mut last = NONE;
        for edge in self.leaving(vertex) {
            ring.push(self.end(edge));
            last = edge;
        }
        if last != NONE && self.is_boundary(vertex) {
            ring.push(self.apex(last));
        }
    }

    /// The half-edge from one vertex to another. Between neighbours on the boundary only one of the two exists.
    pub(crate) fn edge_between(&self, from: u32, to: u32) -> Option<u32> {
        self.leaving(from).find(|&edge| self.end(edge) == to)
    }

    /// Half-edges with nothing to their right, as pairs of vertices.
    pub(crate) fn boundary(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let is_boundary = |&edge: &u32| self.twin(edge) == NONE && self.origin(edge) != NONE;
        (0..self.origins.len() as u32)
            .filter(is_boundary)
            .map(|edge| (self.origin(edge), self.end(edge)))
    }

    /// Adds a vertex that no triangle uses yet.
    fn add_vertex(&mut self) -> u32 {
        self.leaving.push(NONE);
        self.leaving.len() as u32 - 1
    }

    fn add_triangle(&mut self, corners: [u32; 3]) -> u32 {
        self.origins.extend(corners);
        self.twins.extend([NONE; 3]);
        self.origins.len() as u32 - 3
    }

    fn join(&mut self, edge: u32, twin: u32) {
        self.twins[edge as usize] = twin;
        if twin != NONE {
            self.twins[twin as usize] = edge;
        }
    }

    fn replace_leaving(&mut self, vertex: u32, removed: u32, edge: u32) {
        let leaving = &mut self.leaving[vertex as usize];
        if *leaving == removed {
            *leaving = edge;
        }
    }

    /// A new vertex inside a triangle.
    ///
    /// ```text
    ///        c                 c
    ///       ╱ ╲               ╱│╲
    ///      ╱   ╲      ▶      ╱ v ╲
    ///     ╱     ╲           ╱╱   ╲╲
    ///    a ───── b         a ───── b
    /// ```
    pub(crate) fn split_triangle(&mut self, triangle: u32) -> u32 {
        let vertex = self.add_vertex();
        let [ab, bc, ca] = [0, 1, 2].map(|corner| 3 * triangle + corner);
        let [a, b, c] = [ab, bc, ca].map(|edge| self.origin(edge));
        let (across_bc, across_ca) = (self.twin(bc), self.twin(ca));
        self.origins[ca as usize] = vertex;
        let right = self.add_triangle([b, c, vertex]);
        let left = self.add_triangle([c, a, vertex]);
        self.join(right, across_bc);
        self.join(left, across_ca);
        self.join(bc, right + 2);
        self.join(right + 1, left + 2);
        self.join(left + 1, ca);
        self.replace_leaving(b, bc, right);
        self.replace_leaving(c, ca, left);
        self.leaving[vertex as usize] = ca;
        vertex
    }

    /// A new vertex on an edge.
    ///
    /// ```text
    ///        c                 c
    ///       ╱ ╲               ╱│╲
    ///      ╱   ╲             ╱ │ ╲
    ///    a ─────▶ b   ▶    a ──v── b
    ///      ╲   ╱             ╲ │ ╱
    ///       ╲ ╱               ╲│╱
    ///        d                 d
    /// ```
    pub(crate) fn split_edge(&mut self, edge: u32) -> u32 {
        let vertex = self.add_vertex();
        let (bc, twin) = (next(edge), self.twin(edge));
        let (b, c) = (self.origin(bc), self.apex(edge));
        let across = self.twin(bc);
        self.origins[bc as usize] = vertex;
        let upper = self.add_triangle([vertex, b, c]);
        self.join(upper + 1, across);
        self.join(upper + 2, bc);
        self.replace_leaving(b, bc, upper + 1);
        self.leaving[vertex as usize] = upper;
        if twin != NONE {
            let db = previous(twin);
            let (d, across) = (self.origin(db), self.twin(db));
            self.origins[twin as usize] = vertex;
            let lower = self.add_triangle([b, vertex, d]);
            self.join(lower, upper);
            self.join(lower + 1, db);
            self.join(lower + 2, across);
            self.replace_leaving(b, twin, lower);
            self.replace_leaving(d, db, lower + 2);
        }
        vertex
    }

    /// Turns an edge inside its quadrilateral.
    ///
    /// ```text
    ///        c                 c
    ///       ╱ ╲               ╱│╲
    ///      ╱   ╲             ╱ │ ╲
    ///    a ─────▶ b   ▶    a   │   b
    ///      ╲   ╱             ╲ ▼ ╱
    ///       ╲ ╱               ╲│╱
    ///        d                 d
    /// ```
    /// The edge of that number is `d → b` afterwards, its twin `c → a`.
    pub(crate) fn flip(&mut self, edge: u32) {
        let twin = self.twin(edge);
        let (ca, db) = (previous(edge), previous(twin));
        let (a, b, c, d) = (self.origin(edge), self.origin(twin), self.origin(ca), self.origin(db));
        let (across_ca, across_db) = (self.twin(ca), self.twin(db));
        self.origins[edge as usize] = d;
        self.origins[twin as usize] = c;
        self.join(edge, across_db);
        self.join(twin, across_ca);
        self.join(ca, db);
        self.replace_leaving(a, edge, next(twin));
        self.replace_leaving(b, twin, next(edge));
        self.replace_leaving(c, ca, twin);
        self.replace_leaving(d, db, edge);
    }

    /// Collapses the edge between two neighbours: `blue` is removed, with the triangles on the edge. The link condition
    /// is the caller's to check.
    ///
    /// ```text
    ///          c                      c
    ///        ╱ │ ╲                  ╱ │
    ///      ╱   │   ╲              ╱   │
    ///    ─── blue ▶ red   ▶     ───── red
    ///      ╲   │   ╱              ╲   │
    ///        ╲ │ ╱                  ╲ │
    ///          d                      d
    /// ```
    pub(crate) fn collapse(&mut self, blue: u32, red: u32) {
        let (forth, back) = (self.edge_between(blue, red), self.edge_between(red, blue));
        let start = self.start_after(blue, red, forth, back);
        let mut edge = self.leaving[blue as usize];
        let first = edge;
        loop {
            self.origins[edge as usize] = red;
            edge = self.twin(previous(edge));
            if edge == NONE || edge == first {
                break;
            }
        }
        for removed in [forth, back].into_iter().flatten() {
            self.close(removed);
        }
        self.leaving[blue as usize] = NONE;
        self.leaving[red as usize] = start;
    }

    /// The third vertex of a hole that has three, of which `from` and `to` are two. The surface must pass each of them
    /// in one fan.
    ///
    /// ```text
    ///      ╲     ╱
    ///       third
    ///       ╱   ╲          half-edges from → to → third → from, or the other way round, with nothing to their right
    ///   ─ from ─ to ─
    ///     ╱       ╲
    /// ```
    pub(crate) fn third_of_hole(&self, from: u32, to: u32) -> Option<u32> {
        let after = |vertex: u32| {
            let edge = self.leaving[vertex as usize];
            (edge != NONE && self.twin(edge) == NONE).then(|| self.end(edge))
        };
        let [start, end] = if after(from)? == to { [from, to] } else { [to, from] };
        let third = after(end)?;
        (after(start)? == end && after(third)? == start).then_some(third)
    }

    /// Collapses the edge between two vertices of a hole that has three: what was on the other two sides of the hole meets.
    ///
    /// ```text
    ///        third                third
    ///        ╱   ╲                  │
    ///    ─ blue ─▶ red ─    ▶     ─ red ─
    ///        ╲   ╱                  │
    ///          p                    p
    /// ```
    pub(crate) fn close_hole(&mut self, blue: u32, red: u32, third: u32) {
        let [from_blue, from_red, from_third] = [blue, red, third].map(|vertex| self.leaving[vertex as usize]);
        let to_third = if self.end(from_blue) == third {
            from_blue
        } else {
            from_red
        };
        self.collapse(blue, red);
        self.join(to_third, from_third);
    }

    /// Where the walk around the red vertex begins after the collapse.
    fn start_after(&self, blue: u32, red: u32, forth: Option<u32>, back: Option<u32>) -> u32 {
        let beyond = |edge: u32| self.twin(previous(edge));
        let present = self.leaving[red as usize];
        match (forth, back) {
            (_, Some(back)) if self.is_boundary(blue) => {
                let start = self.leaving[blue as usize];
                if start == next(back) { beyond(back) } else { start }
            }
            (Some(forth), back) if present == next(forth) || Some(present) == back => beyond(forth),
            _ => present,
        }
    }

    /// Removes the triangle of a collapsed edge and joins what its other two edges met.
    fn close(&mut self, edge: u32) {
        let (second, third) = (next(edge), previous(edge));
        let (across_second, across_third) = (self.twin(second), self.twin(third));
        let apex = self.origin(third);
        if self.leaving[apex as usize] == third {
            self.leaving[apex as usize] = match (across_second, across_third) {
                (NONE, NONE) => NONE,
                (NONE, across) => next(across),
                (across, _) => across,
            };
        }
        for (outer, other) in [(across_second, across_third), (across_third, across_second)] {
            if outer != NONE {
                self.twins[outer as usize] = other;
            }
        }
        for removed in [edge, second, third] {
            self.origins[removed as usize] = NONE;
            self.twins[removed as usize] = NONE;
        }
    }
}

/// The place in `order` of each of `count` indices, or [`NONE`].
pub(crate) fn inverse(order: &[u32], count: usize) -> Vec<u32> {
    let mut places = vec![NONE; count];
    for (place, &index) in (0..).zip(order) {
        places[index as usize] = place;
    }
    places
}

/// Puts what was at `order[i]` at `i`, in place, and keeps the first `count`. The order is a whole permutation.
pub(crate) fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32], count: usize) {
    follow_cycles(values, order);
    values.truncate(count);
    values.shrink_to_fit();
}

/// The same for three values a triangle.
fn permute_triangles(values: &mut Vec<u32>, order: &[u32], count: usize) {
    follow_cycles(values.as_chunks_mut::<3>().0, order);
    values.truncate(3 * count);
    values.shrink_to_fit();
}

fn follow_cycles<T: Copy>(values: &mut [T], order: &[u32]) {
    let mut is_done = vec![false; values.len()];
    for start in 0..values.len() {
        let (first, mut place) = (values[start], start);
        while !std::mem::replace(&mut is_done[place], true) {
            let from = order[place] as usize;
            values[place] = if from == start { first } else { values[from] };
            place = from;
        }
    }
}

/// Walks around a vertex, counter-clockwise.
pub(crate) struct Leaving<'a> {
    connectivity: &'a HalfEdges,
    first: u32,
    next: u32,
}

impl Iterator for Leaving<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let edge = self.next;
        if edge == NONE {
            return None;
        }
        let following = self.connectivity.twin(previous(edge));
        self.next = if following == self.first { NONE } else { following };
        Some(edge)
    }
}

#[cfg(test)]
#[path = "half_edges_tests.rs"]
mod tests;
