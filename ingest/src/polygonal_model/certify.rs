//! Measures how far levels of detail are from the model, both ways, on all threads.

use glam::DVec3;
use rayon::prelude::*;
use terrain_core::space::hausdorff::{PRECISION, SurfaceTree};

/// Triangles that one thread measures in one go; the result depends on it, but not on the number of threads.
const RUN: usize = 256;

/// A bound of the distance between two surfaces, the larger one of the two ways, in their units.
pub(super) fn distance(one: &SurfaceTree, other: &SurfaceTree) -> f64 {
    let there_and_back = |measure: Measure| one_sided(one, other, measure).max(one_sided(other, one, measure));
    let found = there_and_back(&|to, triangles| to.farthest(triangles));
    there_and_back(&|to, triangles| to.bound(triangles, found * (1.0 + PRECISION)))
}

/// How far triangles are from a surface.
type Measure<'a> = &'a (dyn Fn(&SurfaceTree, &[[DVec3; 3]]) -> f64 + Sync);

fn one_sided(from: &SurfaceTree, to: &SurfaceTree, measure: Measure) -> f64 {
    let runs = from.facets().par_chunks(RUN);
    runs.map(|run| measure(to, run)).reduce(|| 0.0, f64::max)
}
