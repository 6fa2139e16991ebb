//! A surface that is fine here and coarse there: any closed set of a log's collapses, performed (Surface Partitions §3).
//!
//! A collapse and its opposite, the split, cost what stands in their own rows, however large the mesh is:
//!
//! ```text
//! split c (nothing performed rests on it):     collapse c (all it needs is performed):
//!     the corners that c moved: red → blue         the corners that c moved: blue → red
//!     the triangles that c removed are back        the triangles that c removed are gone
//!     the red vertex ↔ what the blue one saved     the red vertex ↔ what the blue one saved
//!     one constraint less for what c needs         …
//! ```
//!
//! Removed triangles keep their corners, for these cannot change before the split: a collapse of one of them has the
//! red vertex in its star and so rests on `c`.

use std::cmp::Reverse;
use std::collections::HashSet;
use std::sync::Arc;

use glam::DVec3;

use crate::levels::attribute::Attribute;
use crate::levels::collapse_log::{Collapse, CollapseLog, LogError};
use crate::levels::dag::{CollapseDag, DagBuilder};
use crate::levels::replay::{Demand, Replay};
use crate::mesh::Mesh;
use crate::topology::compressed_rows::CompressedRows;
use crate::topology::index_set::IndexSet;

/// A mesh with the collapses of a log, each performed or split. Collapses are numbered as in the log.
#[derive(Clone, Debug)]
pub struct AdaptiveSurface {
    dag: Arc<CollapseDag>,
    edges: Vec<[u32; 2]>,
    /// For each collapse the corners (`3 × triangle + k`) that go from the blue vertex to the red one.
    moved: CompressedRows,
    /// For each collapse the triangles that it removes.
    removed: CompressedRows,
    positions: Attribute<DVec3>,
    corners: Vec<[u32; 3]>,
    drawn: Drawn,
    front: Front,
    /// Vertices that moved since [`Self::take_undrawn`].
    moved_vertices: IndexSet,
}

/// The triangles that are drawn, and the places among them that changed since [`AdaptiveSurface::take_undrawn`].
#[derive(Clone, Debug)]
struct Drawn {
    triangles: IndexSet,
    changed: IndexSet,
}

impl Drawn {
    /// One triangle more, in the last place.
    fn add(&mut self, triangle: u32) {
        self.changed.insert(self.triangles.members().len() as u32);
        self.triangles.insert(triangle);
    }

    /// One triangle less; the last one takes its place.
    fn remove(&mut self, triangle: u32) {
        self.change(triangle);
        self.triangles.remove(triangle);
    }

    /// A triangle, if it is drawn, has other corners.
    fn change(&mut self, triangle: u32) {
        if let Some(place) = self.triangles.place(triangle) {
            self.changed.insert(place);
        }
    }
}

impl AdaptiveSurface {
    /// Replays `log` on `mesh`. At first all collapses are performed.
    ///
    /// # Errors
    /// Where the mesh is no 2-manifold or a collapse fails the link condition ([`Demand::Consistent`]).
    pub fn new(mesh: &Mesh, log: &CollapseLog) -> Result<Self, LogError> {
        let mut dag = DagBuilder::new(mesh.positions.len());
        let (mut moved, mut removed) = (CompressedRows::default(), CompressedRows::default());
        let mut corners = mesh.triangles.clone();
        let replay = Replay::run(mesh, log, Demand::Consistent, |step| {
            dag.add(step);
            moved.push(step.moved.iter().copied());
            removed.push(step.star.removed().iter().copied());
            for &corner in step.moved {
                corners.as_flattened_mut()[corner as usize] = step.collapse.red;
            }
        })?;
        let dag = Arc::new(dag.finish());
        let mut surface = Self {
            edges: log
                .collapses
                .iter()
                .map(|&Collapse { blue, red, .. }| [blue, red])
                .collect(),
            moved,
            removed,
            positions: replay.positions,
            corners,
            drawn: Drawn {
                triangles: IndexSet::empty(mesh.triangles.len()),
                changed: IndexSet::empty(mesh.triangles.len()),
            },
            front: Front::all_performed(&dag),
            moved_vertices: IndexSet::empty(mesh.positions.len()),
            dag,
        };
        for (triangle, &level) in (0..).zip(&replay.triangle_levels) {
            if level == replay.top_level {
                surface.drawn.add(triangle);
            }
        }
        (0..mesh.positions.len() as u32).for_each(|vertex| surface.moved_vertices.insert(vertex));
        Ok(surface)
    }

    /// What the collapses need.
    #[must_use]
    pub fn dag(&self) -> &Arc<CollapseDag> {
        &self.dag
    }

    /// Whether a collapse is performed; else it is split.
    #[must_use]
    pub fn is_performed(&self, collapse: u32) -> bool {
        self.front.status[collapse as usize].is_performed
    }

    /// The performed collapses that nothing performed rests on, in no particular order.
    #[must_use]
    pub fn splittable(&self) -> &[u32] {
        self.front.splittable.members()
    }

    /// Whether a collapse is one of [`Self::splittable`].
    #[must_use]
    pub fn can_split(&self, collapse: u32) -> bool {
        self.front.status[collapse as usize].can_split()
    }

    /// The split collapses of which all that they need is performed, in no particular order.
    #[must_use]
    pub fn collapsible(&self) -> &[u32] {
        self.front.collapsible.members()
    }

    /// Whether a collapse is one of [`Self::collapsible`].
    #[must_use]
    pub fn can_collapse(&self, collapse: u32) -> bool {
        self.front.status[collapse as usize].can_collapse()
    }

    /// Undoes a collapse. Where it is not [`Self::splittable`], nothing happens and false is returned.
    pub fn split(&mut self, collapse: u32) -> bool {
        let can = self.can_split(collapse);
        if can {
            let [blue, _] = self.edges[collapse as usize];
            for &triangle in self.removed.row(collapse) {
                self.drawn.add(triangle);
            }
            self.change(collapse, blue, false);
        }
        can
    }

    /// Performs a collapse. Where it is not [`Self::collapsible`], nothing happens and false is returned.
    pub fn collapse(&mut self, collapse: u32) -> bool {
        let can = self.can_collapse(collapse);
        if can {
            let [_, red] = self.edges[collapse as usize];
            for &triangle in self.removed.row(collapse) {
                self.drawn.remove(triangle);
            }
            self.change(collapse, red, true);
        }
        can
    }

    /// Undoes a collapse and first all that rests on it. Returns what was split, in that order.
    pub fn force_split(&mut self, collapse: u32) -> Vec<u32> {
        let mut to_split = self.resting_on(collapse);
        to_split.sort_unstable_by_key(|&found| Reverse(found));
        for &found in &to_split {
            self.split(found);
        }
        to_split
    }

    /// The triangles that are drawn, by their index in the mesh, in no particular order: the rows of an index buffer.
    #[must_use]
    pub fn triangles(&self) -> &[u32] {
        self.drawn.triangles.members()
    }

    /// The vertices of a drawn triangle.
    #[must_use]
    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        self.corners[triangle as usize]
    }

    /// Where a vertex of the surface is now.
    #[must_use]
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.positions.red[vertex as usize]
    }

    /// What there is to draw anew since this was last asked for: places among [`Self::triangles`] whose triangle or corners changed, and
    /// vertices that moved, both growing. The first time that is everything.
    pub fn take_undrawn(&mut self) -> [Vec<u32>; 2] {
        let mut places = self.drawn.changed.take();
        places.truncate(places.partition_point(|&place| (place as usize) < self.triangles().len()));
        [places, self.moved_vertices.take()]
    }

    /// The surface as a mesh with all vertices of the original, those that are not drawn unused.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        let mut drawn = self.triangles().to_vec();
        drawn.sort_unstable();
        Mesh {
            positions: self.positions.red.clone(),
            triangles: drawn.into_iter().map(|triangle| self.corners(triangle)).collect(),
        }
    }

    /// Collapses and triangles that a split or collapse of `collapse` looks at: its cost.
    #[must_use]
    pub fn cost(&self, collapse: u32) -> usize {
        let rows = self.dag.constraints(collapse).len() + self.dag.split_constraints(collapse).len();
        rows + self.moved.row(collapse).len() + self.removed.row(collapse).len()
    }

    /// Performed collapses among `collapse` and all that rests on it, directly or not.
    fn resting_on(&self, collapse: u32) -> Vec<u32> {
        let mut found: Vec<u32> = Some(collapse).filter(|&c| self.is_performed(c)).into_iter().collect();
        let mut seen: HashSet<u32> = found.iter().copied().collect();
        let mut next = 0;
        while let Some(&below) = found.get(next) {
            for &above in self.dag.split_constraints(below) {
                if self.is_performed(above) && seen.insert(above) {
                    found.push(above);
                }
            }
            next += 1;
        }
        found
    }

    /// Gives the moved corners to `vertex`, exchanges what the red vertex has, and moves the front.
    fn change(&mut self, collapse: u32, vertex: u32, is_performed: bool) {
        for &corner in self.moved.row(collapse) {
            self.corners.as_flattened_mut()[corner as usize] = vertex;
            self.drawn.change(corner / 3);
        }
        let [blue, red] = self.edges[collapse as usize];
        self.positions.exchange(blue, red);
        self.moved_vertices.insert(red);
        self.front.change(&self.dag, collapse, is_performed);
    }
}

/// Where a collapse stands.
#[derive(Clone, Copy, Debug)]
struct Status {
    is_performed: bool,
    /// How many of the collapses that it needs are split.
    missing: u32,
    /// How many performed collapses need it.
    resting: u32,
}

impl Status {
    fn can_split(self) -> bool {
        self.is_performed && self.resting == 0
    }

    fn can_collapse(self) -> bool {
        !self.is_performed && self.missing == 0
    }
}

/// The status of all collapses, and which of them can change.
#[derive(Clone, Debug)]
struct Front {
    status: Vec<Status>,
    splittable: IndexSet,
    collapsible: IndexSet,
}

impl Front {
    fn all_performed(dag: &CollapseDag) -> Self {
        let status = |collapse| Status {
            is_performed: true,
            missing: 0,
            resting: dag.split_constraints(collapse).len() as u32,
        };
        let mut front = Self {
            status: (0..dag.len() as u32).map(status).collect(),
            splittable: IndexSet::empty(dag.len()),
            collapsible: IndexSet::empty(dag.len()),
        };
        (0..dag.len() as u32).for_each(|collapse| front.sort_in(collapse));
        front
    }

    /// Counts of one and less are where a collapse becomes possible or impossible.
    fn change(&mut self, dag: &CollapseDag, collapse: u32, is_performed: bool) {
        self.status[collapse as usize].is_performed = is_performed;
        self.sort_in(collapse);
        for &below in dag.constraints(collapse) {
            let resting = &mut self.status[below as usize].resting;
            *resting = if is_performed { *resting + 1 } else { *resting - 1 };
            if *resting <= 1 {
                self.sort_in(below);
            }
        }
        for &above in dag.split_constraints(collapse) {
            let missing = &mut self.status[above as usize].missing;
            *missing = if is_performed { *missing - 1 } else { *missing + 1 };
            if *missing <= 1 {
                self.sort_in(above);
            }
        }
    }

    /// Puts a collapse among those that can be split or performed, or takes it out.
    fn sort_in(&mut self, collapse: u32) {
        let status = self.status[collapse as usize];
        self.splittable.set(collapse, status.can_split());
        self.collapsible.set(collapse, status.can_collapse());
    }
}

#[cfg(test)]
#[path = "adaptive_surface_tests.rs"]
mod tests;
