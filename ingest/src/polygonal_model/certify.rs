//! Measures how far levels of detail are from the model, both ways, on all threads.

use glam::DVec3;
use rayon::prelude::*;
use terrain_core::SurfacePartition;
use terrain_core::space::hausdorff::{PRECISION, SurfaceTree};

use super::levels::LeveledModel;
use crate::progress::Progress;

/// Triangles that one thread measures in one go; the result depends on it, but not on the number of threads.
const RUN: usize = 256;

/// Measures each level; the finest one is the model, unless it is rounded. Errors never shrink towards the coarsest.
pub(super) fn certify_levels(leveled: &mut LeveledModel, tree: &SurfaceTree, progress: &Progress) {
    let count = leveled.level_count();
    progress.stage("measuring levels", count as u64);
    let mut error = 0.0;
    for level in (0..count).rev() {
        if level + 1 < count || leveled.lattice.is_some() {
            error = distance(&leveled.partition, level, tree).max(error);
        }
        leveled.partition.levels[level].error = error;
        progress.advance(1);
    }
    progress.done();
}

/// How far a level, 0 being the coarsest, is from the model.
pub(super) fn distance(partition: &SurfacePartition, level: usize, model: &SurfaceTree) -> f64 {
    distance_between(&SurfaceTree::new(&partition.lod(level)), model)
}

/// Whether all levels from one on, 0 being the coarsest, are within an error of the model; the finest is not measured.
pub(super) fn keeps(partition: &SurfacePartition, first: usize, error: f64, model: &SurfaceTree) -> bool {
    let mut coarser = first..partition.levels.len() - 1;
    coarser.all(|level| distance(partition, level, model) <= error)
}

/// A bound of the distance between two surfaces, the larger one of the two ways, in their units.
fn distance_between(one: &SurfaceTree, other: &SurfaceTree) -> f64 {
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
