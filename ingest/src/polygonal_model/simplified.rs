//! From a model to its levels of detail.
//!
//! ```text
//! part surfaces that touch
//! collapse, band by band, until the target; round; where the target is an error, again with a smaller tolerance until it holds
//! or, where the model is no manifold even then, or its parts apart need more triangles: cluster by grids, cells half as wide
//! from level to level
//! certify each level
//! ```
//! A level ends where half of the triangles of the one before are left.

use std::borrow::Cow;

use anyhow::Result;
use terrain_core::levels::replay::{Demand, Replay};
use terrain_core::space::hausdorff::SurfaceTree;
use terrain_core::space::simplify::{Goal, ModelSimplifier, Placement};
use terrain_core::topology::connectivity::Connectivity;
use terrain_core::topology::manifold::{self, ManifoldError};
use terrain_core::{CollapseLog, Mesh, SurfacePartition};
use thiserror::Error;

use super::certify::{certify_levels, distance, keeps};
use super::levels::{Carrier, LeveledModel};
use super::order::{Order, Target};
use super::{Model, ModelError, clustered, spm_file};
use crate::progress::Progress;

/// How levels were made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    /// By edge collapses.
    Collapses,
    /// By vertex clustering.
    Clustering(Cause),
}

/// Why edge collapses will not do.
#[derive(Clone, Copy, Debug, Error)]
pub(super) enum Cause {
    #[error("the model is not a manifold: {0}")]
    NoManifold(ManifoldError),
    #[error("collapses, which keep surfaces that touch apart, leave {0} triangles")]
    Apart(usize),
}

/// Tolerances tried for one error, each smaller than the one before.
const ATTEMPTS: usize = 8;
/// Share that is tried next of the tolerance that should hold; its square the time after that, and so on.
const CAUTION: f64 = 0.98;

/// Makes and certifies the levels of a model.
pub(super) fn leveled(model: &Model, order: Order, progress: &Progress) -> Result<(LeveledModel, Way)> {
    let tree = SurfaceTree::new(&model.mesh);
    let (mut leveled, way) = match as_manifold(model, progress) {
        Ok(manifold) => by_collapses(model, manifold, &tree, order, progress)?,
        Err(fault) if order.is_rounded => return Err(ModelError::NoManifold(fault).into()),
        Err(fault) => {
            let leveled = clustered::leveled(model, &tree, order.target, progress)?;
            (leveled, Way::Clustering(Cause::NoManifold(fault)))
        }
    };
    certify_levels(&mut leveled, &tree, progress);
    let left = leveled.fewest_triangles();
    match order.target {
        Target::Error(error) if leveled.partition.levels[0].error > error => {
            return Err(ModelError::TooExact(error).into());
        }
        Target::Triangles(most) if left > most => {
            progress.note(&format!("{most} triangles cannot be reached, {left} can"));
        }
        _ => {}
    }
    Ok((leveled, way))
}

/// Collapses, unless surfaces were parted, more triangles are left than need be, and clustering, which brings the surfaces
/// together again, leaves fewer.
fn by_collapses(
    model: &Model,
    manifold: Cow<Model>,
    tree: &SurfaceTree,
    order: Order,
    progress: &Progress,
) -> Result<(LeveledModel, Way)> {
    let leveled = collapsed(&manifold, tree, order, progress)?;
    let left = leveled.fewest_triangles();
    let is_enough = match order.target {
        Target::Coarsest => true,
        Target::Triangles(most) => left <= most,
        Target::Error(_) => false,
    };
    if matches!(manifold, Cow::Owned(_)) && !order.is_rounded && !is_enough {
        let clustered = clustered::leveled(model, tree, order.target, progress)?;
        if clustered.fewest_triangles() < left {
            return Ok((clustered, Way::Clustering(Cause::Apart(left))));
        }
    }
    Ok((leveled, Way::Collapses))
}

/// The model, if it is a manifold, or the same with its surfaces parted where they touch.
///
/// # Errors
/// What keeps it from being a manifold even then.
fn as_manifold<'a>(model: &'a Model, progress: &Progress) -> Result<Cow<'a, Model>, ManifoldError> {
    let check = |model: &Model| manifold::check_stars(&Connectivity::new(&model.mesh));
    if check(model).is_ok() {
        return Ok(Cow::Borrowed(model));
    }
    let parted = model.parted()?;
    check(&parted)?;
    let count = parted.mesh.positions.len() - model.mesh.positions.len();
    progress.note(&format!(
        "surfaces that touch in vertices or along edges are parted there: {count} vertices more"
    ));
    Ok(Cow::Owned(parted))
}

fn collapsed(model: &Model, tree: &SurfaceTree, order: Order, progress: &Progress) -> Result<LeveledModel> {
    match order.target {
        Target::Error(error) => within(error, model, tree, order, progress),
        Target::Triangles(triangles) => down_to(triangles, model, order, progress),
        Target::Coarsest => down_to(0, model, order, progress),
    }
}

fn down_to(triangles: usize, model: &Model, order: Order, progress: &Progress) -> Result<LeveledModel> {
    let tolerance = f64::INFINITY;
    let log = collapse(&model.mesh, order.placement, Goal { tolerance, triangles }, progress)?;
    from_log(model, &log, order)
}

/// With a tolerance that turns out to keep the error. If there is none, the model alone does.
fn within(error: f64, model: &Model, tree: &SurfaceTree, order: Order, progress: &Progress) -> Result<LeveledModel> {
    let (mut tolerance, mut caution) = (error, 1.0);
    for _ in 0..ATTEMPTS {
        let goal = Goal {
            tolerance,
            triangles: 0,
        };
        let leveled = from_log(model, &collapse(&model.mesh, order.placement, goal, progress)?, order)?;
        let reached = distance(&leveled.partition, 0, tree);
        if reached <= error && keeps(&leveled.partition, 1, error, tree) {
            return Ok(leveled);
        }
        caution *= CAUTION;
        tolerance *= (error / reached).min(1.0) * caution;
    }
    from_log(model, &CollapseLog::default(), order)
}

fn collapse(mesh: &Mesh, placement: Placement, goal: Goal, progress: &Progress) -> Result<CollapseLog> {
    let before = mesh.triangles.len();
    progress.stage(&format!("collapsing {before} triangles"), before as u64);
    let mut simplifier = ModelSimplifier::new(mesh, placement)?;
    let mut count = before;
    let mut goes_on = count > goal.triangles;
    while goes_on {
        goes_on = simplifier.next_band(goal);
        progress.advance((count - simplifier.triangle_count()) as u64);
        count = simplifier.triangle_count();
    }
    progress.done();
    Ok(simplifier.log().clone())
}

fn from_log(model: &Model, log: &CollapseLog, order: Order) -> Result<LeveledModel> {
    let mut carrier = Carrier::new(&model.columns, &model.mesh.positions);
    let replay = Replay::run(&model.mesh, log, Demand::Drawable, |step| carrier.carry(step))?;
    let batches = replay.band_batches(log, f64::INFINITY);
    let leveled = LeveledModel {
        partition: SurfacePartition::from_replay(&model.mesh, &replay, &batches)?,
        columns: carrier.finish(&replay),
        lattice: None,
    };
    if !order.is_rounded {
        return Ok(leveled);
    }
    let error = match order.target {
        Target::Error(error) => Some(error),
        Target::Triangles(_) | Target::Coarsest => None,
    };
    Ok(spm_file::rounded(&leveled, error)?)
}

#[cfg(test)]
#[path = "simplified_tests.rs"]
mod tests;
