//! The few representatives that the levels of a multilevel mesh are drawn with ("Vertex clustering" of the paper): those of
//! corners that are missing at a level, and their chains.

use std::collections::HashSet;

use super::MultilevelMesh;

impl<const DIMENSION: usize> MultilevelMesh<DIMENSION> {
    /// Forgets the representatives that no level of detail draws with. Those that are left, [`to_ascii`](super::to_ascii) writes; with
    /// all of them, geomorphs move more vertices.
    pub fn keep_needed_representatives(&mut self) {
        let mut needed = Vec::new();
        let mut links = NeededLinks::new(self);
        for level in (0..self.level_count()).rev() {
            for triangle in self.level_range(level).1 {
                links.visit(level, triangle, |vertex, own| needed.push((vertex, own)));
            }
        }
        self.representatives = (0..).take(self.positions.len()).collect();
        self.awaited.clear();
        needed
            .into_iter()
            .for_each(|(vertex, own)| self.set_representative(vertex, own));
    }
}

/// Finds the representatives that a reader needs, each at the first triangle that it cannot draw without it.
pub(super) struct NeededLinks<'a, const DIMENSION: usize> {
    mesh: &'a MultilevelMesh<DIMENSION>,
    given: HashSet<u32>,
}

impl<'a, const DIMENSION: usize> NeededLinks<'a, DIMENSION> {
    pub(super) fn new(mesh: &'a MultilevelMesh<DIMENSION>) -> Self {
        let given = HashSet::new();
        Self { mesh, given }
    }

    /// Hands every vertex and representative to `give` that triangle `triangle` of level `level` is the first to need.
    pub(super) fn visit(&mut self, level: usize, triangle: usize, mut give: impl FnMut(u32, u32)) {
        let present = self.mesh.end(level).unwrap_or_default().vertices;
        for mut vertex in self.mesh.triangles[triangle] {
            while vertex >= present && self.given.insert(vertex) {
                let Some(own) = self.mesh.representative(vertex) else {
                    break;
                };
                give(vertex, own);
                vertex = own;
            }
        }
    }
}
