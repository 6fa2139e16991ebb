//! From a model to its levels of detail.
//!
//! ```text
//! collapse, band by band, until the target; where it is an error, again with a smaller tolerance until it holds
//! or, where the model is no manifold: cluster by grids, cells half as wide from level to level
//! certify each level
//! ```
//! A level ends where half of the triangles of the one before are left.

use anyhow::{Result, bail};
use terrain_core::clustering::{Clustering, clustered_mesh, grid_clusterings};
use terrain_core::connectivity::Connectivity;
use terrain_core::hausdorff::SurfaceTree;
use terrain_core::manifold::{self, ManifoldError};
use terrain_core::model::{Goal, ModelSimplifier, Placement};
use terrain_core::replay::{Demand, Replay};
use terrain_core::{CollapseLog, Mesh, SurfacePartition};

use super::levels::{Carrier, LeveledColumn, LeveledModel};
use super::{Model, certify};
use crate::progress::Progress;

/// When to stop simplifying.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// As far as topology allows.
    Coarsest,
    /// With at most so many triangles.
    Triangles(usize),
    /// With as few triangles as an error allows, in the model's units.
    Error(f64),
}

/// How levels were made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    /// By edge collapses.
    Collapses,
    /// By vertex clustering, because the model is no manifold.
    Clustering(ManifoldError),
}

/// Tolerances tried for one error, each smaller than the one before.
const ATTEMPTS: usize = 8;
/// Share that is tried next of the tolerance that should hold.
const CAUTION: f64 = 0.98;
/// Steps from the size of one grid's cells to the next smaller one that is looked at.
const CELL_STEP: f64 = 0.84;
/// Sizes of cells that are looked at: down to a 16,000th of the model.
const CELL_STEPS: usize = 56;
/// Share of the vertices that a grid must leave to be too fine for a level of its own.
const TOO_FINE: f64 = 0.75;

/// Makes and certifies the levels of a model.
pub(super) fn leveled(
    model: &Model,
    target: Target,
    keeps_vertices: bool,
    progress: &Progress,
) -> Result<(LeveledModel, Way)> {
    let tree = SurfaceTree::new(&model.mesh);
    let placement = if keeps_vertices {
        Placement::Stay
    } else {
        Placement::Best
    };
    let (mut leveled, way) = match manifold::check_stars(&Connectivity::new(&model.mesh)) {
        Ok(()) => (collapsed(model, &tree, target, placement, progress)?, Way::Collapses),
        Err(fault) => (clustered(model, &tree, target, progress)?, Way::Clustering(fault)),
    };
    certify_levels(&mut leveled.partition, &tree, progress);
    Ok((leveled, way))
}

/// Measures each level; the finest one is the model. Errors never shrink towards the coarsest.
fn certify_levels(partition: &mut SurfacePartition, tree: &SurfaceTree, progress: &Progress) {
    let finest = partition.levels.len() - 1;
    progress.stage("measuring levels", finest as u64);
    partition.levels[finest].error = 0.0;
    for level in (0..finest).rev() {
        let finer = partition.levels[level + 1].error;
        partition.levels[level].error = distance(partition, level, tree).max(finer);
        progress.advance(1);
    }
    progress.done();
}

fn distance(partition: &SurfacePartition, level: usize, model: &SurfaceTree) -> f64 {
    certify::distance(&SurfaceTree::new(&partition.lod(level)), model)
}

fn collapsed(
    model: &Model,
    tree: &SurfaceTree,
    target: Target,
    placement: Placement,
    progress: &Progress,
) -> Result<LeveledModel> {
    let Target::Error(error) = target else {
        let triangles = if let Target::Triangles(triangles) = target {
            triangles
        } else {
            0
        };
        let tolerance = f64::INFINITY;
        let log = collapse(&model.mesh, placement, Goal { tolerance, triangles }, progress)?;
        return from_log(model, &log);
    };
    let mut tolerance = error;
    for _ in 0..ATTEMPTS {
        let log = collapse(
            &model.mesh,
            placement,
            Goal {
                tolerance,
                triangles: 0,
            },
            progress,
        )?;
        let leveled = from_log(model, &log)?;
        let reached = distance(&leveled.partition, 0, tree);
        if reached <= error {
            return Ok(leveled);
        }
        tolerance *= error / reached * CAUTION;
    }
    bail!("no tolerance was found that keeps the error {error}; ask for a larger one")
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

fn from_log(model: &Model, log: &CollapseLog) -> Result<LeveledModel> {
    let mut carrier = Carrier::new(&model.columns, &model.mesh.positions);
    let replay = Replay::run(&model.mesh, log, Demand::Drawable, |step| carrier.carry(step))?;
    let batches = replay.band_batches(log, f64::INFINITY);
    Ok(LeveledModel {
        partition: SurfacePartition::from_replay(&model.mesh, &replay, &batches)?,
        columns: carrier.finish(&replay),
    })
}

/// The positions of the model and its triangles, for clusterings.
struct Clustered<'a> {
    model: &'a Model,
    positions: Vec<[f64; 3]>,
}

fn clustered(model: &Model, tree: &SurfaceTree, target: Target, progress: &Progress) -> Result<LeveledModel> {
    progress.stage("clustering", 1);
    let clustered = Clustered {
        model,
        positions: model
            .mesh
            .positions
            .iter()
            .map(|position| position.to_array())
            .collect(),
    };
    let (low, high) = model.mesh.bounds();
    let cells = || std::iter::successors(Some(low.distance(high)), |cell| Some(cell * CELL_STEP)).take(CELL_STEPS);
    let is_drawn = |cell: &f64| clustered.triangles_left(*cell).is_some_and(|count| count > 0);
    let is_small = |cell: &f64, most: usize| clustered.triangles_left(*cell).is_some_and(|count| count <= most);
    let keeps = |cell: &f64, error: f64| {
        let leveled = clustered.down_to(Some(*cell));
        leveled.is_ok_and(|leveled| distance(&leveled.partition, 0, tree) <= error)
    };
    let coarsest = match target {
        Target::Coarsest => cells().find(is_drawn),
        Target::Triangles(count) => cells().take_while(|cell| is_small(cell, count)).last().filter(is_drawn),
        Target::Error(error) => cells().find(|cell| is_drawn(cell) && keeps(cell, error)),
    };
    let leveled = clustered.down_to(coarsest);
    progress.advance(1);
    progress.done();
    leveled
}

impl Clustered<'_> {
    /// Levels of which the coarsest has cells of a size; the model alone where there is none.
    fn down_to(&self, coarsest: Option<f64>) -> Result<LeveledModel> {
        let Some(coarsest) = coarsest else { return self.by(&[]) };
        let mut count = 1;
        let mut finest = coarsest;
        while self.is_worth_a_level(finest / 2.0) {
            finest /= 2.0;
            count += 1;
        }
        self.by(&grid_clusterings(&self.positions, finest, count)?)
    }

    /// Whether cells of a size bring vertices together, not just a few.
    fn is_worth_a_level(&self, cell: f64) -> bool {
        let clusterings = grid_clusterings(&self.positions, cell, 1).unwrap_or_default();
        let left = |clustering: &Clustering| clustering.positions.len() as f64;
        clusterings
            .first()
            .is_some_and(|clustering| left(clustering) < TOO_FINE * self.positions.len() as f64)
    }

    /// Triangles with corners in three different cells; none where cells of that size cannot be numbered.
    fn triangles_left(&self, cell: f64) -> Option<usize> {
        let clusterings = grid_clusterings(&self.positions, cell, 1).ok()?;
        let mapping = &clusterings.first()?.mapping;
        let corners = self
            .model
            .mesh
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| mapping[corner as usize]));
        Some(corners.filter(|&[a, b, c]| a != b && b != c && c != a).count())
    }

    fn by(&self, clusterings: &[Clustering]) -> Result<LeveledModel> {
        let clustered = clustered_mesh(&self.positions, &self.model.mesh.triangles, clusterings)?;
        let partition = clustered.mesh.to_partition()?;
        let column = |column| LeveledColumn::kept(column, &clustered.vertex_order, &partition.representatives);
        Ok(LeveledModel {
            columns: self.model.columns.iter().map(column).collect(),
            partition,
        })
    }
}
