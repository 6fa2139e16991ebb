//! Files become models of patches.

use std::fs::File;
use std::path::Path;

use glam::DVec3;
use terrain_core::Mesh;
use terrain_core::curved::corner_normals;
use terrain_core::curved::model::CurvedModel;
use terrain_core::curved::tensor::TensorPatch;
use terrain_tiles::formats::bezier::{self, BezierLimits};

use super::error::CurvedModelError;
use crate::polygonal_model::{extension, read_manifold};

/// An edge between triangles that meet at more than this is a crease where nobody says otherwise: 60°.
const CREASE_ANGLE: f64 = std::f64::consts::FRAC_PI_3;
/// Normals of a file that differ by less are one: half a degree.
const SAME_NORMAL: f64 = 0.009;
/// Share of an error that is asked for that patches may bend away from their triangles.
const MOST_BENT: f64 = 0.5;

const PATCHES: [&str; 3] = ["bez", "bpt", "txt"];
const POLYGONS: [&str; 6] = ["ply", "obj", "stl", "off", "gltf", "glb"];

/// Whether a file is a model, by its name.
pub(super) fn is_read(path: &Path) -> bool {
    let extension = extension(path);
    PATCHES.iter().chain(&POLYGONS).any(|known| extension == *known)
}

/// Reads a model, by its file's name. Its patches bend, and are cut, as `max_error` asks for; from `crease_angle`, in radians, on an edge
/// is a crease.
pub(super) fn read(
    path: &Path,
    max_error: Option<f64>,
    crease_angle: Option<f64>,
) -> Result<CurvedModel, CurvedModelError> {
    match extension(path).as_str() {
        patches if PATCHES.contains(&patches) => read_patches(path, max_error),
        polygons if POLYGONS.contains(&polygons) => {
            let (mesh, normals) = read_manifold(path)?;
            let normals = corner_normals(&mesh, normals, crease_angle);
            let mut model = CurvedModel::from_mesh(&mesh, &normals)?;
            model.bend_at_most(max_error.map_or(f64::INFINITY, |error| error * MOST_BENT));
            Ok(model)
        }
        _ => Err(CurvedModelError::Unknown),
    }
}

/// Patches are cut until triangles are so near to them: this share of an error that is asked for.
const NEAR: f64 = 1.0 / 8.0;
/// Where none is asked for, this share of the longest side.
const NEAR_BY_SIDE: f64 = 1.0 / 1000.0;

fn read_patches(path: &Path, max_error: Option<f64>) -> Result<CurvedModel, CurvedModelError> {
    let patches = bezier::read(File::open(path)?, BezierLimits::default())?;
    let is_point = |patch: &TensorPatch| patch.points().all(|point| Some(point) == patch.points().next());
    if let Some(index) = patches.iter().position(is_point) {
        return Err(CurvedModelError::Point(index));
    }
    let points = patches.iter().flat_map(TensorPatch::points);
    let near = match max_error {
        Some(error) => error * NEAR,
        None => longest_side(points) * NEAR_BY_SIDE,
    };
    Ok(CurvedModel::from_tensors(&patches, near))
}

/// The file's normals, or those of the triangles where it has none at some corner, or where an angle for creases is given.
fn corner_normals(mesh: &Mesh, given: Option<Vec<[DVec3; 3]>>, crease_angle: Option<f64>) -> Vec<[DVec3; 3]> {
    let has_direction = |normal: &DVec3| normal.is_finite() && *normal != DVec3::ZERO;
    let given = given.filter(|normals| crease_angle.is_none() && normals.as_flattened().iter().all(has_direction));
    match given {
        Some(normals) => corner_normals::from_corners(mesh, &normals, SAME_NORMAL),
        None => corner_normals::from_triangles(mesh, crease_angle.unwrap_or(CREASE_ANGLE)),
    }
}

/// The longest side of the box around some points.
pub(super) fn longest_side(points: impl Iterator<Item = DVec3>) -> f64 {
    let both = points
        .map(|at| (at, at))
        .reduce(|(low, high), (a, b)| (low.min(a), high.max(b)));
    both.map_or(0.0, |(low, high)| (high - low).max_element())
}
