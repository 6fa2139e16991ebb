//! A single mesh of a whole raster, in the raster's own reference system and metres of height: planes are planes in
//! that system, heights differ along its third axis.

use std::path::Path;

use anyhow::Context;
use glam::DVec2;
use terrain_core::mesh::validate;

use super::deviation::{Worst, along_edges, visit_posts};
use super::mesh_file::{self, Claim};
use super::reference::{Post, Reference};
use super::report::{MeshReport, ROUNDING, Violation};
use super::space::{Foot, Raster};
use super::surface::Surface;
use crate::height_grid::HeightGrid;

/// Measures the mesh at `path`, a `.ply` or `.obj` file, against the raster that it was made from. What it claims is
/// taken from its comments, or from `claim` where it says nothing.
///
/// # Errors
/// When the file is no readable triangle mesh, or there is no claim to hold it to.
pub fn mesh(path: &Path, grid: &HeightGrid, claim: Option<Claim>) -> anyhow::Result<MeshReport> {
    let claim = mesh_file::read_claim(path)?.or(claim);
    let claim = claim.with_context(|| format!("{}: claims no error; pass --max-error", path.display()))?;
    Ok(check(&mesh_file::read(path)?, grid, &claim))
}

fn check(mesh: &terrain_core::Mesh, grid: &HeightGrid, claim: &Claim) -> MeshReport {
    let mut report = MeshReport {
        bound: claim.bound.clone(),
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        claimed: claim.error,
        measured_at_samples: 0.0,
        measured_between_samples: 0.0,
        violation_count: 0,
        violations: Vec::new(),
    };
    let mut violations = Vec::new();
    if !["surface", "samples"].contains(&claim.bound.as_str()) {
        violations.push(Violation::new(format!("bound “{}” is unknown", claim.bound)));
    }
    match validate(mesh) {
        Err(error) => violations.push(Violation::new(format!("is no surface: {error}"))),
        Ok(()) => violations.extend(measure(mesh, &Reference::new(grid), claim, &mut report)),
    }
    report.set_violations(violations);
    report
}

fn measure(mesh: &terrain_core::Mesh, reference: &Reference, claim: &Claim, report: &mut MeshReport) -> Vec<Violation> {
    let surface = in_grid(mesh, reference);
    let mut covered = vec![false; reference.grid.heights.len()];
    let mut at_samples = Worst::default();
    visit_posts(&Raster, reference, &surface, |column, row, deviation| {
        covered[row * reference.grid.columns + column] = true;
        if reference.post(column, row) == Post::Surface {
            at_samples.meet(deviation, DVec2::new(column as f64, row as f64));
        }
    });
    let anywhere = at_samples.max(along_edges(&Raster, reference, &surface));
    report.measured_at_samples = at_samples.figure;
    report.measured_between_samples = anywhere.figure;
    let mut violations = coverage(reference, &covered);
    let promised = if claim.bound == "samples" { at_samples } else { anywhere };
    if promised.figure > claim.error + ROUNDING || claim.error.is_nan() {
        let place = reference.grid.georeference.crs_coordinates(promised.place);
        violations.push(
            Violation::new("vertical error")
                .at(place)
                .figures(claim.error, promised.figure),
        );
    }
    violations
}

fn in_grid(mesh: &terrain_core::Mesh, reference: &Reference) -> Surface {
    let to_grid = reference.grid.georeference.affine().inverse();
    let positions = mesh
        .positions
        .iter()
        .map(|p| to_grid.transform_point2(p.truncate()).extend(p.z));
    let positions: Vec<_> = positions.collect();
    let feet = positions
        .iter()
        .map(|p| Foot {
            grid: p.truncate(),
            height: p.z,
        })
        .collect();
    Surface {
        positions,
        feet,
        triangles: mesh.triangles.clone(),
    }
}

/// Samples of the surface that are not covered, and voids that are.
fn coverage(reference: &Reference, covered: &[bool]) -> Vec<Violation> {
    let posts = || {
        let columns = reference.grid.columns;
        covered
            .iter()
            .enumerate()
            .map(move |(index, &covered)| ((index % columns, index / columns), covered))
    };
    let wrong = |post: Post, should_be: bool, what: &str| {
        let found: Vec<_> = posts()
            .filter(|&((column, row), covered)| reference.post(column, row) == post && covered != should_be)
            .map(|((column, row), _)| DVec2::new(column as f64, row as f64))
            .collect();
        let first = found.first()?;
        let place = reference.grid.georeference.crs_coordinates(*first);
        Some(Violation::new(format!("{} {what}, the first", found.len())).at(place))
    };
    let left_out = wrong(Post::Surface, true, "samples that no triangle covers");
    let invented = wrong(Post::Void, false, "voids that a triangle covers");
    left_out.into_iter().chain(invented).collect()
}

#[cfg(test)]
#[path = "plain_mesh_tests.rs"]
mod tests;
