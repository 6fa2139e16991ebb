//! Levels of models that are no manifolds: vertices cluster in the cells of grids, half as wide from level to level.

use anyhow::Result;
use terrain_core::space::hausdorff::SurfaceTree;
use terrain_core::streaming::clustering::{Clustering, clustered_mesh, grid_clusterings};

use super::Model;
use super::certify::keeps;
use super::levels::{LeveledColumn, LeveledModel};
use super::order::Target;
use crate::progress::Progress;

/// Steps from the size of one grid's cells to the next smaller one that is looked at.
const CELL_STEP: f64 = 0.96;
/// Sizes of cells that are looked at: down to a 16,000th of the model.
const CELL_STEPS: usize = 238;
/// Of so many sizes one is measured where the target is an error, which takes far longer than to count triangles.
const MEASURED_STEPS: usize = 2;
/// Share of the vertices that a grid must leave to be too fine for a level of its own.
const TOO_FINE: f64 = 0.75;

/// The positions of the model and its triangles, for clusterings.
struct Clustered<'a> {
    model: &'a Model,
    positions: Vec<[f64; 3]>,
}

/// Levels by grids, down to the target.
pub(super) fn leveled(model: &Model, tree: &SurfaceTree, target: Target, progress: &Progress) -> Result<LeveledModel> {
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
    let coarsest = match target {
        Target::Coarsest => cells().find(|&cell| clustered.level(cell).is_some()),
        Target::Triangles(most) if model.mesh.triangles.len() <= most => None,
        Target::Triangles(most) => nearest_below(most, cells().filter_map(|cell| clustered.level(cell))),
        Target::Error(error) => cells()
            .step_by(MEASURED_STEPS)
            .find(|&cell| clustered.level(cell).is_some() && clustered.keeps(cell, error, tree)),
    };
    let leveled = clustered.down_to(coarsest);
    progress.advance(1);
    progress.done();
    leveled
}

/// Of pairs of a size and the triangles that are left, the size with the most up to `most`, or with the fewest at all.
fn nearest_below(most: usize, levels: impl Iterator<Item = (f64, usize)>) -> Option<f64> {
    let rank = |&(_, left): &(f64, usize)| (left > most, left.abs_diff(most));
    levels.min_by_key(rank).map(|(cell, _)| cell)
}

impl Clustered<'_> {
    /// The triangles that cells of a size leave, with the size; none where that is all of them or none.
    fn level(&self, cell: f64) -> Option<(f64, usize)> {
        let left = self.triangles_left(cell)?;
        (0 < left && left < self.model.mesh.triangles.len()).then_some((cell, left))
    }

    /// Whether the levels down to cells of a size are within an error.
    fn keeps(&self, cell: f64, error: f64, tree: &SurfaceTree) -> bool {
        let leveled = self.down_to(Some(cell));
        leveled.is_ok_and(|leveled| keeps(&leveled.partition, 0, error, tree))
    }

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
            lattice: None,
        })
    }
}
