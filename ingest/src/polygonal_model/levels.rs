//! A surface with its levels of detail, and what its vertices have besides positions.

use glam::DVec3;
use terrain_core::levels::attribute::Attribute;
use terrain_core::levels::level_view::LevelView;
use terrain_core::levels::replay::{Replay, Step};
use terrain_core::{Mesh, SurfacePartition};
use terrain_tiles::formats::polygons::{Column, Storage};

/// A Surface Partition and its columns.
#[derive(Clone, Debug)]
pub(super) struct LeveledModel {
    pub(super) partition: SurfacePartition,
    pub(super) columns: Vec<LeveledColumn>,
    /// Where the positions were rounded to, if they were.
    pub(super) lattice: Option<Lattice>,
}

/// Where the positions of a `.spm` file can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    pub(super) origin: DVec3,
    pub(super) step: DVec3,
}

/// A column of numbers that follow the vertices from level to level.
#[derive(Clone, Debug)]
pub(super) struct LeveledColumn {
    name: String,
    storage: Storage,
    values: Attribute<f64>,
}

impl LeveledModel {
    pub(super) fn level_count(&self) -> usize {
        self.partition.levels.len()
    }

    /// The triangles of the coarsest level.
    pub(super) fn fewest_triangles(&self) -> usize {
        self.partition.levels[0].triangle_end as usize
    }

    /// A level as a mesh with columns, 0 being the finest; none where there is no such level.
    pub(super) fn level(&self, level: usize) -> Option<(Mesh, Vec<Column>)> {
        let place = self.level_count().checked_sub(level + 1)?;
        let mut view = LevelView::new(&self.partition);
        let undone = view.set_level(place);
        let mesh = view.mesh();
        let columns = self.columns.iter().map(|column| {
            let mut values = column.values.clone();
            values.undo(&self.partition.representatives, undone.clone());
            values.red.truncate(mesh.positions.len());
            Column {
                name: column.name.clone(),
                storage: column.storage,
                values: values.red,
            }
        });
        let columns = columns.collect();
        Some((mesh, columns))
    }

    /// The smallest and the largest coordinates in any level.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let positions = self.partition.positions.iter().chain(&self.partition.blue_positions);
        let nowhere = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        positions.fold(nowhere, |(low, high), &at| (low.min(at), high.max(at)))
    }

    /// Whether every vertex is in one place in all levels.
    pub(super) fn keeps_vertices(&self) -> bool {
        let partition = &self.partition;
        let mut pairs = partition.representatives.iter().zip(&partition.blue_positions);
        pairs.all(|(&representative, &before)| before == partition.positions[representative as usize])
    }
}

impl LeveledColumn {
    /// A column whose representatives keep their values. `order` has the model's vertex for each of the partition.
    pub(super) fn kept(column: &Column, order: &[u32], representatives: &[u32]) -> Self {
        let red: Vec<f64> = order.iter().map(|&vertex| column.values[vertex as usize]).collect();
        let blue = representatives
            .iter()
            .map(|&representative| red[representative as usize])
            .collect();
        Self {
            name: column.name.clone(),
            storage: column.storage,
            values: Attribute { red, blue },
        }
    }
}

/// Carries columns through the collapses of a log: the red vertex gets what lies between both ends where it goes.
pub(super) struct Carrier<'a> {
    columns: &'a [Column],
    values: Vec<Attribute<f64>>,
    positions: Vec<DVec3>,
}

impl<'a> Carrier<'a> {
    pub(super) fn new(columns: &'a [Column], positions: &[DVec3]) -> Self {
        Self {
            columns,
            values: columns
                .iter()
                .map(|column| Attribute::new(column.values.clone()))
                .collect(),
            positions: positions.to_vec(),
        }
    }

    pub(super) fn carry(&mut self, step: &Step) {
        let collapse = step.collapse;
        let (blue, red) = (collapse.blue as usize, collapse.red as usize);
        let along = self.positions[blue] - collapse.red_before;
        let moved = (collapse.red_after - collapse.red_before).dot(along) / along.length_squared();
        let share = if moved.is_finite() { moved.clamp(0.0, 1.0) } else { 0.0 };
        for values in &mut self.values {
            let after = values.red[red] * (1.0 - share) + values.red[blue] * share;
            values.collapse(collapse.blue, collapse.red, after);
        }
        self.positions[red] = collapse.red_after;
    }

    /// The columns in the order of the partition that `replay` makes.
    pub(super) fn finish(self, replay: &Replay) -> Vec<LeveledColumn> {
        let order = replay.vertex_order();
        let columns = self.columns.iter().zip(self.values);
        let leveled = columns.map(|(column, values)| LeveledColumn {
            name: column.name.clone(),
            storage: column.storage,
            values: values.sorted(&order),
        });
        leveled.collect()
    }
}
