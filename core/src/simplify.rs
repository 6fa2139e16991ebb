//! Edge collapses inside a tolerance volume, in rounds of an independent set, recorded in a [`CollapseLog`].
//!
//! The volume is that of A. Guéziec, *Surface simplification inside a tolerance volume*, IBM RC 20440, 1996, made exact
//! for height fields: instead of error spheres the reference surface itself bounds every triangle. A collapse may give
//! the red vertex a new height, the one of least squares among those that the reference allows.
//!
//! ```text
//! for each band, by growing tolerance:
//!     all vertices are worth a try
//!     repeat until a round finds nothing:
//!         for each vertex worth a try, in memory order, whose star no collapse of this round has touched:
//!             for each neighbour, nearest first:
//!                 check kinds, link, orientation, outline, tolerance
//!                 perform the first collapse that passes all; the star around it is worth a try again
//!     close the band in the log
//! ```
//! The stars of a round do not meet, so a round is one level of the Surface Partition.

use glam::{DVec2, DVec3};

use crate::collapse_log::{Band, Collapse, CollapseLog};
use crate::filters::{self, Candidate};
use crate::mesh::Mesh;
use crate::outline::OutlineChains;
use crate::reference::{GridPoint, Reference};
use crate::triangulate::stepped;

/// What a vertex may do in a collapse.
///
/// | kind | as blue, into | as red | reason |
/// | --- | --- | --- | --- |
/// | `Free` | any but `Border` | yes, height free | |
/// | `OnColumn`, `OnRow` | same line | yes, height free | the strip along a tile's side stays straight |
/// | `Outline` | along the outline | yes, height free | the hole keeps its shape within the tolerance |
/// | `Fixed` | no | yes | corners |
/// | `Border` | only by [`Simplifier::collapse_border`] | no | shared with other tiles |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// Inside the surface.
    Free,
    /// On a line of constant x.
    OnColumn,
    /// On a line of constant y.
    OnRow,
    /// On the edge of the surface.
    Outline,
    /// Stays where it is.
    Fixed,
    /// On a tile's side.
    Border,
}

/// What a band allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// Metres that the surface may stray vertically.
    pub vertical: f64,
    /// Metres that the outline may stray from that of the mesh the simplifier began with, in plan view.
    pub outline: f64,
}

/// What holds for all bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Heights are multiples of this, metres; 0 leaves them free.
    pub height_step: f64,
    /// No collapse makes a triangle of a smaller altitude than this, in plan units.
    pub least_altitude: f64,
}

/// A mesh while it is simplified.
pub struct Simplifier<'a> {
    pub(crate) reference: &'a Reference<'a>,
    shape: Shape,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) grid: Vec<DVec2>,
    pub(crate) kinds: Vec<VertexKind>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) triangles_of: Vec<Vec<u32>>,
    outline: OutlineChains,
    outline_strayed: f64,
    log: CollapseLog,
    /// The round in which each vertex was last a red one.
    touched: Vec<u32>,
    round: u32,
}

impl<'a> Simplifier<'a> {
    /// Begins with `mesh`, whose positions are plan coordinates of `reference` and heights in metres. `kinds` tells
    /// what each vertex may do; vertices of the outline that are [`VertexKind::Free`] become [`VertexKind::Outline`],
    /// and [`VertexKind::Border`] where the outline touches itself.
    #[must_use]
    pub fn new(mesh: &Mesh, kinds: Vec<VertexKind>, reference: &'a Reference<'a>, shape: Shape) -> Self {
        let grid: Vec<DVec2> = mesh
            .positions
            .iter()
            .map(|p| reference.plan.grid(p.truncate()))
            .collect();
        let mut triangles_of = vec![Vec::new(); mesh.positions.len()];
        for (triangle, corners) in (0_u32..).zip(&mesh.triangles) {
            corners
                .iter()
                .for_each(|&corner| triangles_of[corner as usize].push(triangle));
        }
        let metres = grid.iter().map(|&point| point * reference.ground).collect();
        let outline = OutlineChains::new(&mesh.triangles, metres);
        let mut simplifier = Self {
            reference,
            shape,
            positions: mesh.positions.clone(),
            grid,
            kinds,
            triangles: mesh.triangles.clone(),
            triangles_of,
            outline,
            outline_strayed: 0.0,
            log: CollapseLog::default(),
            touched: vec![0; mesh.positions.len()],
            round: 0,
        };
        for vertex in 0..simplifier.kinds.len() {
            let kind = &mut simplifier.kinds[vertex];
            match simplifier.outline.visits(vertex as u32) {
                0 => {}
                1 if *kind == VertexKind::Free => *kind = VertexKind::Outline,
                1 => {}
                _ => *kind = VertexKind::Border,
            }
        }
        simplifier
    }

    /// Collapses what a band allows and closes the band.
    pub fn simplify(&mut self, allowance: Allowance) {
        let mut worth_a_try: Vec<bool> = self.kinds.iter().map(|kind| *kind != VertexKind::Border).collect();
        loop {
            self.round += 1;
            let before = self.log.collapses.len();
            for vertex in 0..self.positions.len() as u32 {
                if worth_a_try[vertex as usize] && !self.star_is_touched(vertex) {
                    self.try_vertex(vertex, allowance, &mut worth_a_try);
                }
            }
            if self.log.collapses.len() == before {
                break;
            }
        }
        self.close_band(allowance.vertical);
    }

    /// Ends a band after the collapses so far; `error` is what its surface is good for.
    pub fn close_band(&mut self, error: f64) {
        self.log.bands.push(Band {
            end: self.log.collapses.len(),
            error,
        });
    }

    /// Collapses a vertex of a tile's side into another one next to it on the side, if the surface stays within
    /// `tolerance` metres. Infinity allows what topology does: the side as a curve was simplified before. Tells
    /// whether it could.
    pub fn collapse_border(&mut self, blue: u32, red: u32, tolerance: f64) -> bool {
        let (around_blue, around_red) = (&self.neighbours(blue), &self.neighbours(red));
        let candidate = Candidate {
            blue,
            red,
            around_blue,
            around_red,
        };
        let possible = filters::link_allows(self, &candidate)
            && filters::stays_upright(self, blue, red, 0.0)
            && filters::allowed_height(self, &candidate, tolerance).is_some();
        if possible {
            let height = self.positions[red as usize].z;
            self.perform(blue, red, height);
        }
        possible
    }

    /// How far, in metres, the outline strays by now from that of the mesh the simplifier began with.
    #[must_use]
    pub fn outline_strayed(&self) -> f64 {
        self.outline_strayed
    }

    /// Position of a vertex.
    #[must_use]
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    /// The log of all collapses so far.
    #[must_use]
    pub fn log(&self) -> &CollapseLog {
        &self.log
    }

    /// The mesh as it is now, vertices renumbered in order; `kinds` go along.
    #[must_use]
    pub fn mesh(&self) -> (Mesh, Vec<VertexKind>) {
        let mut numbers = vec![u32::MAX; self.positions.len()];
        let (mut mesh, mut kinds) = (Mesh::default(), Vec::new());
        for (vertex, triangles) in self.triangles_of.iter().enumerate() {
            if !triangles.is_empty() {
                numbers[vertex] = mesh.positions.len() as u32;
                mesh.positions.push(self.positions[vertex]);
                kinds.push(self.kinds[vertex]);
            }
        }
        let live = (0_u32..)
            .zip(&self.triangles)
            .filter(|(index, corners)| self.is_live(*index, corners));
        mesh.triangles = live
            .map(|(_, corners)| corners.map(|corner| numbers[corner as usize]))
            .collect();
        (mesh, kinds)
    }

    fn is_live(&self, triangle: u32, corners: &[u32; 3]) -> bool {
        self.triangles_of[corners[0] as usize].contains(&triangle)
    }

    fn try_vertex(&mut self, blue: u32, allowance: Allowance, worth_a_try: &mut [bool]) {
        worth_a_try[blue as usize] = false;
        let around_blue = self.neighbours_nearest_first(blue);
        for &red in &around_blue {
            if !filters::kinds_allow(self, blue, red) {
                continue;
            }
            let candidate = Candidate {
                blue,
                red,
                around_blue: &around_blue,
                around_red: &self.neighbours(red),
            };
            if !filters::link_allows(self, &candidate) {
                continue;
            }
            if candidate
                .around_red
                .iter()
                .any(|&vertex| self.touched[vertex as usize] == self.round)
            {
                worth_a_try[blue as usize] = true;
                continue;
            }
            let strays = self.outline_strays(blue, red);
            if strays > allowance.outline || !filters::stays_upright(self, blue, red, self.shape.least_altitude) {
                continue;
            }
            if let Some(height) = filters::allowed_height(self, &candidate, allowance.vertical) {
                self.perform(blue, red, height);
                self.outline_strayed = self.outline_strayed.max(strays);
                self.touched[red as usize] = self.round;
                for vertex in self.neighbours(red).into_iter().chain([red]) {
                    worth_a_try[vertex as usize] = self.kinds[vertex as usize] != VertexKind::Border;
                }
                return;
            }
        }
    }

    fn outline_strays(&self, blue: u32, red: u32) -> f64 {
        if self.kinds[blue as usize] == VertexKind::Outline {
            self.outline.strays(blue, red)
        } else {
            0.0
        }
    }

    fn perform(&mut self, blue: u32, red: u32, height: f64) {
        let red_before = self.positions[red as usize];
        let red_after = red_before.truncate().extend(height);
        self.log.collapses.push(Collapse {
            blue,
            red,
            red_before,
            red_after,
        });
        self.positions[red as usize] = red_after;
        self.outline.remove(blue);
        for triangle in std::mem::take(&mut self.triangles_of[blue as usize]) {
            let corners = self.triangles[triangle as usize];
            if corners.contains(&red) {
                for corner in corners {
                    self.triangles_of[corner as usize].retain(|&other| other != triangle);
                }
            } else {
                self.triangles[triangle as usize] = corners.map(|corner| if corner == blue { red } else { corner });
                self.triangles_of[red as usize].push(triangle);
            }
        }
    }

    pub(crate) fn star(&self, vertex: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles_of[vertex as usize]
            .iter()
            .map(|&triangle| self.triangles[triangle as usize])
    }

    pub(crate) fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let mut found = Vec::with_capacity(8);
        for corner in self.star(vertex).flatten() {
            if corner != vertex && !found.contains(&corner) {
                found.push(corner);
            }
        }
        found
    }

    pub(crate) fn grid_point(&self, vertex: u32) -> GridPoint {
        GridPoint {
            grid: self.grid[vertex as usize],
            height: self.positions[vertex as usize].z,
        }
    }

    pub(crate) fn stepped(&self, height: f64) -> f64 {
        stepped(height, self.shape.height_step)
    }

    pub(crate) fn height_step(&self) -> f64 {
        self.shape.height_step
    }

    fn neighbours_nearest_first(&self, vertex: u32) -> Vec<u32> {
        let at = self.positions[vertex as usize].truncate();
        let distance = |v: u32| self.positions[v as usize].truncate().distance_squared(at);
        let mut neighbours = self.neighbours(vertex);
        neighbours.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
        neighbours
    }

    fn star_is_touched(&self, vertex: u32) -> bool {
        self.star(vertex)
            .flatten()
            .any(|corner| self.touched[corner as usize] == self.round)
    }
}

#[cfg(test)]
#[path = "simplify_tests.rs"]
mod tests;
