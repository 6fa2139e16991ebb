//! Files become models of patches.

use std::fs::File;
use std::path::Path;

use glam::DVec3;
use terrain_core::Mesh;
use terrain_core::curved::corner_normals;
use terrain_core::curved::model::CurvedModel;
use terrain_core::curved::tensor::Bicubic;
use terrain_tiles::formats::bezier::{self, BezierLimits};

use super::CurvedModelError;
use crate::polygonal_model::{extension, read_manifold};
use crate::progress::Progress;

/// An edge between triangles that meet at more than this is a crease where nobody says otherwise: 60°.
const CREASE_ANGLE: f64 = std::f64::consts::FRAC_PI_3;
/// Normals of a file that differ by less are one: half a degree.
const SAME_NORMAL: f64 = 0.009;
/// How often patches of a degree above three are halved each way.
const HALVINGS: u32 = 2;

const PATCHES: [&str; 3] = ["bez", "bpt", "txt"];
const POLYGONS: [&str; 6] = ["ply", "obj", "stl", "off", "gltf", "glb"];

/// Whether a file is a model, by its name.
pub(super) fn is_read(path: &Path) -> bool {
    let extension = extension(path);
    PATCHES.iter().chain(&POLYGONS).any(|known| extension == *known)
}

/// Reads a model, by its file's name.
pub(super) fn read(
    path: &Path,
    crease_angle: Option<f64>,
    progress: &Progress,
) -> Result<CurvedModel, CurvedModelError> {
    match extension(path).as_str() {
        patches if PATCHES.contains(&patches) => read_patches(path, progress),
        polygons if POLYGONS.contains(&polygons) => {
            let (mesh, normals) = read_manifold(path)?;
            let normals = corner_normals(&mesh, normals, crease_angle);
            Ok(CurvedModel::from_mesh(&mesh, &normals)?)
        }
        _ => Err(CurvedModelError::Unknown),
    }
}

fn read_patches(path: &Path, progress: &Progress) -> Result<CurvedModel, CurvedModelError> {
    let patches = bezier::read(File::open(path)?, BezierLimits::default())?;
    let high = patches
        .iter()
        .filter(|patch| patch.degrees().into_iter().max() > Some(3))
        .count();
    if high > 0 {
        progress.note(&format!(
            "{high} patches of a degree above 3 are approximated by 16 of degree 3 each"
        ));
    }
    let bicubics: Vec<Bicubic> = patches.iter().flat_map(|patch| patch.bicubics(HALVINGS)).collect();
    Ok(CurvedModel::from_bicubics(&bicubics))
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
