//! What a tile above the leaves is simplified over: every 2^k-th sample of the raster, k zooms up, with the relief between them.

use std::ops::Range;

use glam::DVec2;
use terrain_core::height_field::blocks::Relief;
use terrain_core::height_field::chunks::Chunks;
use terrain_core::height_field::finer::Finer;
use terrain_core::height_field::ground::Ground;
use terrain_core::height_field::heights::Heights;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::{Bound, Reference};

/// Some of the samples of a rectangle of a raster.
pub(crate) struct CoarseWindow<'a> {
    level: u8,
    /// Columns and rows, in steps of 2^level samples.
    columns: Range<usize>,
    rows: Range<usize>,
    heights: Vec<f32>,
    curvature: Vec<DVec2>,
    relief: Relief<'a>,
}

impl<'a> CoarseWindow<'a> {
    /// Each 2^`level`-th of the samples in these columns and rows; `curvature` as in [`Reference`], of a row of the raster.
    pub(crate) fn new(
        chunks: &'a dyn Chunks,
        level: u8,
        [columns, rows]: [Range<usize>; 2],
        curvature: impl Fn(usize) -> DVec2,
    ) -> Self {
        let relief = Relief::new(chunks, columns.clone(), rows.clone());
        let level = level.min(relief.top());
        let [columns, rows] = [columns, rows].map(|range| range.start >> level..((range.end - 1) >> level) + 2);
        let last_row = chunks.size()[1] - 1;
        let scale = f64::from(1_u32 << level);
        Self {
            heights: relief.samples(level, columns.clone(), rows.clone()),
            curvature: rows
                .clone()
                .map(|row| curvature((row << level).min(last_row)) * scale * scale)
                .collect(),
            level,
            columns,
            rows,
            relief,
        }
    }

    /// `to_grid` and `to_plan` map between plan coordinates and the raster's grid, over the rectangle `low … high` in plan.
    pub(crate) fn reference<'b>(
        &'b self,
        [low, high]: [DVec2; 2],
        to_grid: impl Fn(DVec2) -> DVec2 + Send + Sync + 'b,
        to_plan: impl Fn(DVec2) -> DVec2 + Send + Sync + 'b,
        ground: Ground<'b>,
        bound: Bound,
    ) -> Reference<'b> {
        let scale = f64::from(1_u32 << self.level);
        let origin = [self.columns.start, self.rows.start];
        let first = DVec2::new(origin[0] as f64, origin[1] as f64);
        Reference {
            heights: Heights {
                columns: self.columns.len(),
                rows: self.rows.len(),
                samples: &self.heights,
            },
            plan: PlanMap::fit(
                low,
                high,
                move |plan| to_grid(plan) / scale - first,
                move |at| to_plan((at + first) * scale),
            ),
            curvature: &self.curvature,
            ground,
            bound,
            finer: Some(Finer {
                relief: &self.relief,
                level: self.level,
                origin,
            }),
        }
    }
}
