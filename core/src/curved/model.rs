//! The C-Model (§5): a surface of cubic triangular patches, and which patch meets which.
//!
//! Half-edge `3p + i` is the boundary curve of patch `p` that [`CURVES`](crate::curved::patch::CURVES) counts as `i`. Patches
//! across an edge have the same control points on it, bit for bit, so that the surface has no gaps.

use glam::DVec3;
use thiserror::Error;

use crate::curved::curve_twins;
use crate::curved::fit::{self, Refined, SAME_NORMAL, Tangent};
use crate::curved::orientation;
use crate::curved::patch::{CENTRE, CubicPatch};
use crate::curved::strips;
use crate::curved::tensor::{Bicubic, TensorPatch};
use crate::curved::tensor_triangles::{self, NearTriangle};
use crate::mesh::Mesh;
use crate::topology::connectivity::Connectivity;
use crate::topology::half_edges::{HalfEdges, NONE, edges_of, next, previous};
use crate::topology::manifold::{self, ManifoldError};

/// A surface of cubic triangular patches with full adjacency.
#[derive(Clone, Debug)]
pub struct CurvedModel {
    pub(crate) patches: Vec<CubicPatch>,
    pub(crate) topology: HalfEdges,
    /// For each half-edge whether the surface has no common tangent plane along it.
    pub(crate) is_crease: Vec<bool>,
    pub(crate) input: Input,
}

/// What the patches are held against.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Input {
    /// The flat triangles between their corners.
    Triangles,
    /// Surfaces that each of them is so near to.
    Near(Vec<f64>),
}

/// Why something is no model.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModelError {
    /// The triangles are no oriented manifold.
    #[error(transparent)]
    NotManifold(#[from] ManifoldError),
    /// There is not one value for each triangle.
    #[error("there are {given} for {triangles} triangles")]
    Count {
        /// How many there are.
        given: usize,
        /// How many triangles there are.
        triangles: usize,
    },
    /// A corner's normal has no direction, or a position is not finite.
    #[error("triangle {0} has a corner without a position or a normal")]
    NoNormal(usize),
}

/// Tangent planes of tensor-product patches that meet at a larger angle are a crease: cosine of 30°.
const CREASE_COSINE: f64 = 0.866_025_403_784_438_6;

impl CurvedModel {
    /// One patch for each triangle (§5.1), both passes, but no centre is moved farther than the curves bend. `normals` has one for each corner of each triangle, of any length;
    /// along an edge whose two triangles have different normals the surface keeps its crease.
    ///
    /// # Errors
    /// Where the triangles are no oriented manifold, or a normal is missing.
    pub fn from_mesh(mesh: &Mesh, normals: &[[DVec3; 3]]) -> Result<Self, ModelError> {
        let mut model = Self::first_pass(mesh, normals)?;
        let first = model.patches.clone();
        model.refine_centres();
        for (patch, first) in model.patches.iter_mut().zip(&first) {
            patch.points[CENTRE] = held_centre(patch.points[CENTRE], first);
        }
        Ok(model)
    }

    /// The first pass alone.
    ///
    /// # Errors
    /// As [`CurvedModel::from_mesh`].
    pub fn first_pass(mesh: &Mesh, normals: &[[DVec3; 3]]) -> Result<Self, ModelError> {
        let normals = unit_normals(mesh, normals)?;
        manifold::check_corners(mesh)?;
        manifold::check_stars(&Connectivity::new(mesh))?;
        let topology = HalfEdges::new(mesh.positions.len(), mesh.triangles.clone());
        let is_crease = creases(&topology, &normals);
        let tangents = tangents(&topology, &normals);
        let patches = mesh.triangles.iter().zip(tangents);
        let patches = patches.map(|(corners, tangents)| {
            fit::first_pass(corners.map(|corner| mesh.positions[corner as usize]), tangents)
        });
        Ok(Self {
            patches: patches.collect(),
            topology,
            is_crease,
            input: Input::Triangles,
        })
    }

    /// Bends patches of triangles back towards these where their control points are farther than `most` from where they would be
    /// in flat ones.
    pub fn bend_at_most(&mut self, most: f64) {
        for patch in &mut self.patches {
            let flat = patch.flat();
            for (point, flat) in patch.points.iter_mut().zip(flat.points) {
                *point = flat + (*point - flat).clamp_length_max(most);
            }
        }
    }

    /// Patches that are there already, and the vertices of each one's corners.
    ///
    /// # Errors
    /// Where the triangles of the corners are no oriented manifold, or not as many.
    pub fn from_patches(corners: Vec<[u32; 3]>, patches: Vec<CubicPatch>) -> Result<Self, ModelError> {
        if corners.len() != patches.len() {
            return Err(ModelError::Count {
                given: patches.len(),
                triangles: corners.len(),
            });
        }
        let count = corners.iter().flatten().max().map_or(0, |&last| last as usize + 1);
        let mesh = Mesh {
            positions: vec![DVec3::ZERO; count],
            triangles: corners,
        };
        manifold::check_corners(&mesh)?;
        manifold::check_stars(&Connectivity::new(&mesh))?;
        Ok(Self {
            is_crease: vec![false; 3 * patches.len()],
            input: Input::Near(vec![0.0; patches.len()]),
            topology: HalfEdges::new(count, mesh.triangles),
            patches,
        })
    }

    /// Two patches for each piece of a tensor-product one (§5.2), or one where a side is a point: pieces of halves and quarters,
    /// so small that patches are within `tolerance` of them, or as near as limits allow; patches know how near. Tensor-product
    /// patches that are the other way round than their neighbours are turned, and all of them where a closed surface is inside
    /// out. Patches meet where they have a whole boundary curve in common, exactly; more than two that have do not.
    #[must_use]
    pub fn from_tensors(tensors: &[TensorPatch], tolerance: f64) -> Self {
        let bicubics: Vec<Bicubic> = tensors.iter().map(|tensor| tensor.near_bicubic().0).collect();
        let halvings = strips::halvings(tensors, &bicubics, tolerance);
        let is_turned = orientation::to_turn(&bicubics);
        let mut near: Vec<NearTriangle> = Vec::new();
        let mut diagonals = Vec::new();
        for ((tensor, halvings), is_turned) in tensors.iter().zip(halvings).zip(is_turned) {
            for piece in tensor.halved(halvings) {
                let piece = if is_turned { piece.transposed() } else { piece };
                let (bicubic, deviation) = piece.near_bicubic();
                let mut triangles = tensor_triangles::near_triangles(&bicubic);
                triangles.iter_mut().for_each(|near| near.deviation += deviation);
                if triangles.len() == 2 {
                    let first = 3 * near.len() as u32;
                    diagonals.push([first + 2, first + 3]);
                }
                near.extend(triangles);
            }
        }
        Self::from_near_triangles(&near, &diagonals)
    }

    /// Bicubic patches as they are, none of them cut.
    #[must_use]
    pub fn from_bicubics(bicubics: &[Bicubic]) -> Self {
        let tensors: Vec<TensorPatch> = bicubics.iter().map(TensorPatch::of_bicubic).collect();
        Self::from_tensors(&tensors, f64::INFINITY)
    }

    /// `diagonals` are the half-edges on both sides of each diagonal. The two triangles there are as smooth as their patch is,
    /// however far their diagonal is from it.
    fn from_near_triangles(near: &[NearTriangle], diagonals: &[[u32; 2]]) -> Self {
        let patches: Vec<CubicPatch> = near.iter().map(|near| near.patch).collect();
        let twins = twins_by_curve(&patches, diagonals);
        let (vertex_count, corners) = vertices_of_fans(&twins);
        let mut model = Self {
            is_crease: Vec::new(),
            topology: HalfEdges::with_twins(vertex_count, corners, twins),
            patches,
            input: Input::Near(near.iter().map(|near| near.deviation).collect()),
        };
        model.is_crease = (0..3 * near.len() as u32).map(|edge| model.is_sharp(edge)).collect();
        for &edge in diagonals.as_flattened() {
            model.is_crease[edge as usize] = false;
        }
        model
    }

    /// The patches.
    #[must_use]
    pub fn patches(&self) -> &[CubicPatch] {
        &self.patches
    }

    /// The vertices of each patch's corners.
    #[must_use]
    pub fn corners(&self) -> &[[u32; 3]] {
        self.topology.triangles()
    }

    /// The patch across each of a patch's curves AB, BC and CA.
    #[must_use]
    pub fn neighbours(&self, patch: u32) -> [Option<u32>; 3] {
        edges_of(patch).map(|edge| match self.topology.twin(edge) {
            NONE => None,
            twin => Some(twin / 3),
        })
    }

    /// Whether each of a patch's curves AB, BC and CA is a crease.
    #[must_use]
    pub fn creases(&self, patch: u32) -> [bool; 3] {
        edges_of(patch).map(|edge| self.is_crease[edge as usize])
    }

    /// The second pass of §5.1 for all centres at once; what happened to each.
    pub fn refine_centres(&mut self) -> Vec<Refined> {
        let refined = (0..).zip(&self.patches).map(|(index, patch)| {
            let across = edges_of(index).map(|edge| self.centre_across(edge));
            fit::refined_centre(patch, across)
        });
        let refined: Vec<_> = refined.collect();
        for (patch, (centre, _)) in self.patches.iter_mut().zip(&refined) {
            patch.points[CENTRE] = *centre;
        }
        refined.into_iter().map(|(_, how)| how).collect()
    }

    fn centre_across(&self, edge: u32) -> Option<DVec3> {
        let twin = self.topology.twin(edge);
        let is_smooth = twin != NONE && !self.is_crease[edge as usize];
        is_smooth.then(|| self.patches[twin as usize / 3].points[CENTRE])
    }

    /// Whether the tangent planes of both patches differ in the middle of an edge.
    fn is_sharp(&self, edge: u32) -> bool {
        let twin = self.topology.twin(edge);
        if twin == NONE {
            return false;
        }
        let normal = |edge: u32| {
            let middle = [
                DVec3::new(0.5, 0.5, 0.0),
                DVec3::new(0.0, 0.5, 0.5),
                DVec3::new(0.5, 0.0, 0.5),
            ];
            let patch = &self.patches[edge as usize / 3];
            patch.normal(middle[edge as usize % 3]).normalize_or_zero()
        };
        normal(edge).dot(normal(twin)) < CREASE_COSINE
    }
}

/// A centre, no farther from that of the first pass than curves are from straight ones: planes that nearly agree may meet anywhere.
fn held_centre(centre: DVec3, first: &CubicPatch) -> DVec3 {
    let first_centre = first.points[CENTRE];
    let bend = first.deviation(&first.flat());
    first_centre + (centre - first_centre).clamp_length_max(bend)
}

fn unit_normals(mesh: &Mesh, normals: &[[DVec3; 3]]) -> Result<Vec<[DVec3; 3]>, ModelError> {
    if normals.len() != mesh.triangles.len() {
        return Err(ModelError::Count {
            given: normals.len(),
            triangles: mesh.triangles.len(),
        });
    }
    let units: Vec<[DVec3; 3]> = normals
        .iter()
        .map(|three| three.map(DVec3::normalize_or_zero))
        .collect();
    let is_bad = |(normals, corners): (&[DVec3; 3], &[u32; 3])| {
        let is_finite = |&corner: &u32| mesh.positions.get(corner as usize).is_none_or(|at| at.is_finite());
        normals.contains(&DVec3::ZERO) || !corners.iter().all(is_finite)
    };
    match units.iter().zip(&mesh.triangles).position(is_bad) {
        Some(triangle) => Err(ModelError::NoNormal(triangle)),
        None => Ok(units),
    }
}

/// The normal that the triangle of a half-edge has at its beginning.
fn normal_at(normals: &[[DVec3; 3]], edge: u32) -> DVec3 {
    normals[edge as usize / 3][edge as usize % 3]
}

fn creases(topology: &HalfEdges, normals: &[[DVec3; 3]]) -> Vec<bool> {
    let differ = |a: u32, b: u32| normal_at(normals, a).distance(normal_at(normals, b)) > SAME_NORMAL;
    let is_crease = |edge: u32| {
        let twin = topology.twin(edge);
        twin != NONE && (differ(edge, next(twin)) || differ(next(edge), twin))
    };
    (0..3 * normals.len() as u32).map(is_crease).collect()
}

/// For each corner of each triangle what its outgoing and its incoming edge may do there. Both triangles of an edge ask in the
/// same order, so that they are told the same.
fn tangents(topology: &HalfEdges, normals: &[[DVec3; 3]]) -> Vec<[[Tangent; 2]; 3]> {
    let between = |own: u32, across: Option<u32>| match across {
        None => Tangent::Plane(normal_at(normals, own)),
        Some(across) => {
            let (first, second) = (own.min(across), own.max(across));
            Tangent::between(normal_at(normals, first), normal_at(normals, second))
        }
    };
    let at_corner = |edge: u32| {
        let (twin, before) = (topology.twin(edge), topology.twin(previous(edge)));
        [
            between(edge, (twin != NONE).then(|| next(twin))),
            between(edge, (before != NONE).then_some(before)),
        ]
    };
    (0..normals.len() as u32)
        .map(|triangle| edges_of(triangle).map(at_corner))
        .collect()
}

/// Patches meet where they have a whole curve in common, whichever vertices it joins. The diagonal inside a tensor-product patch
/// joins its two triangles whatever else runs there.
fn twins_by_curve(patches: &[CubicPatch], diagonals: &[[u32; 2]]) -> Vec<u32> {
    let mut twins = curve_twins::twins(&vec![[0; 3]; patches.len()], patches);
    for &[edge, across] in diagonals {
        let curve = patches[edge as usize / 3].curve(edge as usize % 3);
        let is_point = curve.iter().all(|point| *point == curve[0]);
        if twins[edge as usize] == NONE && !is_point {
            twins[edge as usize] = across;
            twins[across as usize] = edge;
        }
    }
    twins
}

/// A vertex for each fan of triangles around a corner.
fn vertices_of_fans(twins: &[u32]) -> (usize, Vec<[u32; 3]>) {
    let mut corners = vec![NONE; twins.len()];
    let mut count = 0;
    for start in 0..twins.len() as u32 {
        if corners[start as usize] != NONE {
            continue;
        }
        let onwards = [
            |twins: &[u32], edge: u32| twins[previous(edge) as usize],
            |twins: &[u32], edge: u32| match twins[edge as usize] {
                NONE => NONE,
                twin => next(twin),
            },
        ];
        for step in onwards {
            let mut edge = start;
            while edge != NONE && (edge == start || corners[edge as usize] == NONE) {
                corners[edge as usize] = count;
                edge = step(twins, edge);
                if edge == start {
                    break;
                }
            }
        }
        count += 1;
    }
    (count as usize, corners.as_chunks::<3>().0.to_vec())
}

#[cfg(test)]
#[path = "model_tests.rs"]
mod tests;
