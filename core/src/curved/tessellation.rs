//! Triangles for drawing: a curved model within a tolerance of itself, or as a view needs it, without gaps.
//!
//! ```text
//! for each edge:   a factor from its own curve (and the view) alone ──▶ its cuts
//! for each patch:  the largest of its edges' factors and its own ──▶ a lattice; along its sides the edges' cuts
//! ```
//! Where switching is gradual, factors are any numbers, and the surface is continuous in them: cuts of edges slide along their
//! curves, and new points inside a patch start in the middle of the edge that they cut in two. A lattice has then a power of
//! two steps, so that the points of one are those of the next, too.

use std::collections::BTreeSet;

use glam::DVec3;
use thiserror::Error;

use crate::curved::edge_cuts::{EdgeCuts, Steps, canonical};
use crate::curved::flatness::{self, View};
use crate::curved::model::CurvedModel;
use crate::curved::patch::CubicPatch;
use crate::curved::patch_lattice::{PatchLattice, Place, sides_of};
use crate::curved::tessellated_numbers::Numbering;
use crate::mesh::Mesh;
use crate::topology::half_edges::{NONE, edges_of};

/// Most steps of a patch's lattice where a tolerance asks for them.
pub const MOST_STEPS: u32 = 1024;
/// Most steps of a patch's lattice where a view asks for them, as with graphics hardware.
pub const MOST_STEPS_IN_VIEW: f64 = 64.0;
/// Most triangles of a tessellation.
pub const MOST_TRIANGLES: u64 = 1 << 28;
/// The share of a tolerance that chords of edges may use, so that finer lattices inside can keep the rest.
const SHARE_OF_EDGES: f64 = 0.8;

/// A curved model as triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// The surface. Patches that meet share the vertices of their edge.
    pub mesh: Mesh,
    /// Unit normals from the patches: one for each vertex, but several where a crease passes. Zero where a patch has no area.
    pub normals: Vec<DVec3>,
    /// The normals of each triangle's corners.
    pub triangle_normals: Vec<[u32; 3]>,
}

/// Into how many steps edges and patches are cut, by the edges' curves and by the patches.
pub struct Factors<'a> {
    /// From an edge's curve in its canonical direction; 1 at least.
    pub edge: &'a dyn Fn([DVec3; 4]) -> f64,
    /// From a patch, for its inside; 1 at least.
    pub patch: &'a dyn Fn(&CubicPatch) -> f64,
    /// Whether the surface is continuous in the factors. If not, they are rounded up.
    pub is_gradual: bool,
}

/// Why there is no tessellation.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum TessellationError {
    /// A tolerance that would never be kept.
    #[error("patch {0} needs more than {MOST_STEPS} steps for this tolerance")]
    TooFine(usize),
    /// More than memory holds.
    #[error("more than {MOST_TRIANGLES} triangles")]
    TooMany,
}

impl Tessellation {
    /// Triangles within `tolerance` of the patches, in the model's units: each point of either within it of the other. Along
    /// edges that is known before ([`flatness::chord_error`]); then every triangle is measured ([`flatness::part_error`]), and
    /// edges are cut finer where those that touch them are too coarse, lattices where others are.
    ///
    /// # Errors
    /// Where the tolerance is too small for the model.
    pub fn within(model: &CurvedModel, tolerance: f64) -> Result<Self, TessellationError> {
        let edge = |curve| flatness::factor(flatness::chord_error(curve), SHARE_OF_EDGES * tolerance);
        let mut cut = CutModel::new(
            model,
            &Factors {
                edge: &edge,
                patch: &|_| 1.0,
                is_gradual: false,
            },
        )?;
        cut.refine(tolerance)?;
        cut.triangles()
    }

    /// Triangles that are off by the view's tolerance at most, in pixels, along edges and in lattices; no patch has more than
    /// [`MOST_STEPS_IN_VIEW`] steps. Continuous in the eye's position.
    ///
    /// # Errors
    /// Where there would be more triangles than memory holds.
    pub fn in_view(model: &CurvedModel, view: &View) -> Result<Self, TessellationError> {
        let edge = |curve| view.curve_factor(curve).min(MOST_STEPS_IN_VIEW);
        let patch = |patch: &CubicPatch| view.patch_factor(patch).min(MOST_STEPS_IN_VIEW);
        Self::by_factors(
            model,
            &Factors {
                edge: &edge,
                patch: &patch,
                is_gradual: true,
            },
        )
    }

    /// Triangles by any factors.
    ///
    /// # Errors
    /// Where there would be more triangles than memory holds, or more steps than a lattice has.
    pub fn by_factors(model: &CurvedModel, factors: &Factors) -> Result<Self, TessellationError> {
        CutModel::new(model, factors)?.triangles()
    }
}

/// A model whose edges are cut and whose patches know their lattices.
struct CutModel<'a> {
    model: &'a CurvedModel,
    /// Cuts of each half-edge; those of both sides are equal.
    cuts: Vec<EdgeCuts>,
    is_reversed: Vec<bool>,
    steps: Vec<Steps>,
}

impl<'a> CutModel<'a> {
    fn new(model: &'a CurvedModel, factors: &Factors) -> Result<Self, TessellationError> {
        let curves = || {
            model
                .patches()
                .iter()
                .flat_map(|patch| [0, 1, 2].map(|curve| canonical(patch.curve(curve))))
        };
        let edge_factors: Vec<f64> = curves().map(|(curve, _)| (factors.edge)(curve)).collect();
        let steps = model.patches().iter().zip(edge_factors.as_chunks::<3>().0).enumerate();
        let steps = steps.map(|(index, (patch, edges))| {
            let factor = edges
                .iter()
                .fold((factors.patch)(patch), |most, &factor| most.max(factor));
            steps_for(factor, factors.is_gradual).ok_or(TessellationError::TooFine(index))
        });
        let steps: Vec<Steps> = steps.collect::<Result<_, _>>()?;
        let cuts = edge_factors.into_iter().map(|factor| match factors.is_gradual {
            true => EdgeCuts::gradual(factor),
            false => EdgeCuts::even(factor.ceil() as u32),
        });
        Ok(Self {
            model,
            cuts: cuts.collect(),
            is_reversed: curves().map(|(_, is_reversed)| is_reversed).collect(),
            steps,
        })
    }

    fn lattice(&self, patch: usize) -> PatchLattice<'_> {
        PatchLattice {
            steps: self.steps[patch].count,
            sides: edges_of(patch as u32).map(|edge| (&self.cuts[edge as usize], self.is_reversed[edge as usize])),
        }
    }

    /// Makes lattices and edges finer until each triangle is within the tolerance.
    fn refine(&mut self, tolerance: f64) -> Result<(), TessellationError> {
        let mut unmeasured: BTreeSet<usize> = (0..self.steps.len()).collect();
        while let Some(index) = unmeasured.pop_first() {
            let errors = self.errors(index);
            if errors.largest <= tolerance {
                continue;
            }
            unmeasured.insert(index);
            let uneven = self.uneven_edges(index, |side| errors.along[side] > tolerance);
            if uneven.is_empty() {
                self.refine_lattice(index, errors.largest / tolerance)?;
            }
            for (side, edge) in uneven {
                let pieces = finer(self.cuts[edge as usize].pieces(), errors.along[side] / tolerance);
                unmeasured.extend(self.refine_edge(edge, pieces.min(self.steps[index].count)));
            }
        }
        Ok(())
    }

    /// How far triangles of a patch are off.
    fn errors(&self, index: usize) -> TriangleErrors {
        let patch = &self.model.patches()[index];
        let lattice = self.lattice(index);
        let mut errors = TriangleErrors::default();
        for (at, places) in lattice.triangles_at() {
            let error = flatness::part_error(patch, places.map(|place| lattice.domain(place)));
            errors.largest = errors.largest.max(error);
            for side in sides_of(at) {
                errors.along[side] = errors.along[side].max(error);
            }
        }
        errors
    }

    /// Those edges of a patch that have fewer pieces than its lattice.
    fn uneven_edges(&self, index: usize, is_meant: impl Fn(usize) -> bool) -> Vec<(usize, u32)> {
        let is_uneven = |&(side, edge): &(usize, u32)| {
            is_meant(side) && self.cuts[edge as usize].pieces() < self.steps[index].count
        };
        (0..3).zip(edges_of(index as u32)).filter(is_uneven).collect()
    }

    fn refine_lattice(&mut self, index: usize, excess: f64) -> Result<(), TessellationError> {
        let steps = &mut self.steps[index].count;
        *steps = finer(*steps, excess);
        if *steps > MOST_STEPS {
            return Err(TessellationError::TooFine(index));
        }
        Ok(())
    }

    /// Cuts an edge for both of its patches, and makes the other's lattice as fine at least; which one that is.
    fn refine_edge(&mut self, edge: u32, pieces: u32) -> Option<usize> {
        self.cuts[edge as usize] = EdgeCuts::even(pieces);
        let twin = self.model.topology.twin(edge);
        if twin == NONE {
            return None;
        }
        self.cuts[twin as usize] = EdgeCuts::even(pieces);
        let across = twin as usize / 3;
        let steps = &mut self.steps[across].count;
        *steps = pieces.max(*steps);
        Some(across)
    }

    fn triangles(&self) -> Result<Tessellation, TessellationError> {
        let most: u64 = self.steps.iter().map(|steps| u64::from(steps.count).pow(2)).sum();
        if most > MOST_TRIANGLES {
            return Err(TessellationError::TooMany);
        }
        let pieces: Vec<u32> = self.cuts.iter().map(EdgeCuts::pieces).collect();
        let inside = (0..self.steps.len())
            .map(|patch| self.lattice(patch).count_inside())
            .collect::<Vec<_>>();
        let vertices = Numbering::of_vertices(self.model, &pieces, &inside);
        let normals = Numbering::of_normals(self.model, &pieces, &inside);
        let mut made = Tessellation {
            mesh: Mesh {
                positions: vec![DVec3::ZERO; vertices.count()],
                triangles: Vec::new(),
            },
            normals: vec![DVec3::ZERO; normals.count()],
            triangle_normals: Vec::new(),
        };
        self.place_edges(&vertices, &mut made.mesh.positions);
        for index in 0..self.steps.len() {
            let lattice = self.lattice(index);
            self.place_inside(index, &lattice, &vertices, &mut made.mesh.positions);
            self.add_normals(index, &lattice, &normals, &mut made.normals);
            for places in lattice.triangles() {
                let corners = places.map(|place| vertices.number(index, place, &lattice));
                let [a, b, c] = corners.map(|corner| made.mesh.positions[corner as usize]);
                let is_at_a_pole = a == b || b == c || c == a;
                if is_at_a_pole {
                    continue;
                }
                made.mesh.triangles.push(corners);
                made.triangle_normals
                    .push(places.map(|place| normals.number(index, place, &lattice)));
            }
        }
        made.normals
            .iter_mut()
            .for_each(|normal| *normal = normal.normalize_or_zero());
        Ok(made)
    }

    /// Corners and cuts, each once.
    fn place_edges(&self, numbers: &Numbering, positions: &mut [DVec3]) {
        for (edge, cuts) in self.cuts.iter().enumerate() {
            let curve = self.model.patches()[edge / 3].curve(edge % 3);
            positions[numbers.corners[edge] as usize] = curve[0];
            let twin = self.model.topology.twin(edge as u32);
            if twin == NONE || (edge as u32) < twin {
                let first = numbers.edges[edge] as usize;
                let places = &mut positions[first..first + cuts.parameters.len() - 2];
                places
                    .iter_mut()
                    .zip(cuts.points(curve))
                    .for_each(|(place, point)| *place = point);
            }
        }
    }

    /// Points inside a patch, on their way from where they were in the coarser lattice.
    fn place_inside(&self, index: usize, lattice: &PatchLattice, numbers: &Numbering, positions: &mut [DVec3]) {
        let patch = &self.model.patches()[index];
        let moved = self.steps[index].moved;
        for at in lattice.inside() {
            let place = Place::Inside(at);
            let point = patch.point(lattice.domain(place));
            let from = lattice.parents(at).filter(|_| moved < 1.0).map(|parents| {
                let [one, other] = parents.map(|parent| match parent {
                    Place::Inside(_) => patch.point(lattice.domain(parent)),
                    shared => positions[numbers.number(index, shared, lattice) as usize],
                });
                one.midpoint(other)
            });
            let position = from.map_or(point, |from| from.lerp(point, moved));
            positions[numbers.number(index, place, lattice) as usize] = position;
        }
    }

    fn add_normals(&self, index: usize, lattice: &PatchLattice, numbers: &Numbering, normals: &mut [DVec3]) {
        let patch = &self.model.patches()[index];
        let moved = self.steps[index].moved;
        let normal_at = |place: Place| unit_normal(patch, lattice.domain(place));
        for place in lattice.places() {
            let own = normal_at(place);
            let parents = match place {
                Place::Inside(at) if moved < 1.0 => lattice.parents(at),
                _ => None,
            };
            let from = parents.map(|parents| parents.map(normal_at).into_iter().sum::<DVec3>().normalize_or(own));
            normals[numbers.number(index, place, lattice) as usize] += from.map_or(own, |from| from.lerp(own, moved));
        }
    }
}

/// How far the triangles of a patch are off, and those of them that touch each side.
#[derive(Default)]
struct TriangleErrors {
    largest: f64,
    along: [f64; 3],
}

/// A number of steps after which an error that is so many times too large is not, if it falls with the square of it; twice as
/// many at most, since along sides it need not.
fn finer(steps: u32, excess: f64) -> u32 {
    let wanted = (f64::from(steps) * excess.sqrt().min(2.0)).ceil() as u32;
    wanted.max(steps + 1)
}

/// Steps of a lattice; none where there would be too many.
fn steps_for(factor: f64, is_gradual: bool) -> Option<Steps> {
    if factor.is_nan() || factor > f64::from(MOST_STEPS) {
        return None;
    }
    Some(match is_gradual {
        true => Steps::gradual(factor),
        false => Steps {
            count: factor.ceil() as u32,
            moved: 1.0,
        },
    })
}

/// The unit normal of a patch. Where its derivatives are parallel, as at a corner where two are one point, it is that of a
/// place nearer to the middle; zero where that finds none.
fn unit_normal(patch: &CubicPatch, at: DVec3) -> DVec3 {
    let size = patch
        .points
        .iter()
        .map(|point| point.distance_squared(patch.points[0]))
        .fold(0.0, f64::max);
    let places = [0.0, 1e-3, 1e-2, 0.1, 0.5].map(|way| at.lerp(DVec3::splat(1.0 / 3.0), way));
    let normals = places.map(|at| patch.normal(at));
    let normal = normals.into_iter().find(|normal| normal.length() > LEAST_AREA * size);
    normal.map_or(DVec3::ZERO, DVec3::normalize_or_zero)
}

/// Normals that are shorter, as a share of the patch's size squared, are rounding.
const LEAST_AREA: f64 = 1e-9;

#[cfg(test)]
#[path = "tessellation_tests.rs"]
mod tests;
