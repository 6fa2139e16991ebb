//! The vertices of the model as it was given and the middles of its edges, each in the list of the triangle that it lies next
//! to by now: a collapse looks at those under its star and at no others.

use glam::DVec3;

use crate::topology::half_edges::{self, HalfEdges};

/// End of a list.
const END: u32 = u32::MAX;

/// A vertex of the model as it was given, or the middle of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    index: u32,
    pub(crate) at: DVec3,
    /// Whether it was on the boundary. It is then measured from the boundary, not from the surface.
    pub(crate) is_on_boundary: bool,
}

/// All samples, by triangle.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleLists {
    samples: Vec<Sample>,
    /// The first sample of each triangle.
    heads: Vec<u32>,
    /// What follows each sample in its list.
    following: Vec<u32>,
}

impl SampleLists {
    /// Each in the list of a triangle around it; on the boundary, of one with an edge of the boundary.
    pub(crate) fn new(positions: &[DVec3], connectivity: &HalfEdges) -> Self {
        let mut lists = Self {
            heads: vec![END; connectivity.triangle_slots() as usize],
            ..Self::default()
        };
        for (vertex, &at) in (0..).zip(positions) {
            if let Some(edge) = connectivity.leaving(vertex).next() {
                lists.add(edge / 3, at, connectivity.is_boundary(vertex));
            }
        }
        for edge in (0..connectivity.triangle_slots()).flat_map(half_edges::edges_of) {
            let (twin, ends) = (
                connectivity.twin(edge),
                [connectivity.origin(edge), connectivity.end(edge)],
            );
            // Of two half-edges the first stands for the edge; one without a twin is the first.
            if edge < twin {
                let [from, to] = ends.map(|vertex| positions[vertex as usize]);
                lists.add(edge / 3, from.midpoint(to), twin == half_edges::NONE);
            }
        }
        lists
    }

    fn add(&mut self, triangle: u32, at: DVec3, is_on_boundary: bool) {
        let index = self.samples.len() as u32;
        self.samples.push(Sample {
            index,
            at,
            is_on_boundary,
        });
        self.following.push(END);
        self.put(triangle, self.samples[index as usize]);
    }

    /// Adds a sample that is in no list to a triangle's.
    pub(crate) fn put(&mut self, triangle: u32, sample: Sample) {
        let before = std::mem::replace(&mut self.heads[triangle as usize], sample.index);
        self.following[sample.index as usize] = before;
    }

    /// Empties a triangle's list.
    pub(crate) fn clear(&mut self, triangle: u32) {
        self.heads[triangle as usize] = END;
    }

    /// Appends a triangle's samples to `found`.
    pub(crate) fn gather(&self, triangle: u32, found: &mut Vec<Sample>) {
        let mut index = self.heads[triangle as usize];
        while index != END {
            found.push(self.samples[index as usize]);
            index = self.following[index as usize];
        }
    }
}
