//! Measures how far levels of detail are from the model, both ways, on all threads.

use glam::DVec3;
use rayon::prelude::*;
use terrain_core::Mesh;
use terrain_core::hausdorff::SurfaceTree;

/// By how much a bound may exceed the largest distance found, as a share of it.
const PRECISION: f64 = 1.0 / 128.0;

/// A bound of the distance between two surfaces, each way, in their units.
pub(super) fn distance(one: (&Mesh, &SurfaceTree), other: (&Mesh, &SurfaceTree)) -> f64 {
    let enough = found(one.0, other.1).max(found(other.0, one.1)) * (1.0 + PRECISION);
    one_sided(one.0, other.1, enough).max(one_sided(other.0, one.1, enough))
}

/// The largest distance at the middles of triangles: no bound is below it.
fn found(from: &Mesh, to: &SurfaceTree) -> f64 {
    largest(from, |[a, b, c]| to.distance((a + b + c) / 3.0).max(to.distance(a)))
}

fn one_sided(from: &Mesh, to: &SurfaceTree, enough: f64) -> f64 {
    largest(from, |corners| to.bound(corners, enough))
}

/// The largest of what `measure` finds for the triangles; the same on any number of threads.
fn largest(mesh: &Mesh, measure: impl Fn([DVec3; 3]) -> f64 + Send + Sync) -> f64 {
    let triangles = mesh.triangles.par_iter();
    let corners = triangles.map(|corners| corners.map(|corner| mesh.positions[corner as usize]));
    corners.map(measure).reduce(|| 0.0, f64::max)
}
