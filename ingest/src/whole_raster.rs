//! A whole raster as one surface, in its own coordinate reference system: planar between places in its coordinates, so
//! that what is measured on the grid is exact.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use glam::DVec2;
use terrain_core::Surface;
use terrain_core::height_field::ground::Ground;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::{Bound, Reference};
use terrain_core::height_field::triangulate::{Outline, triangulate};
use terrain_core::mesh;

use crate::height_grid::HeightGrid;

/// Plan units in a cell: vertices that are no samples lie on this finer grid.
const UNITS_IN_A_CELL: f64 = 256.0;
/// No triangle is lower than this in plan, in units.
pub(crate) const LEAST_ALTITUDE: f64 = 4.0;
/// Share of the asked error that is used; the rest is for the rounding of whoever reads the coordinates back.
pub(crate) const SHARE: f64 = 1.0 - 1e-6;

/// The raster as what a mesh is measured against; `curvature` is nothing for each row.
pub(crate) fn reference<'a>(grid: &'a HeightGrid, curvature: &'a [DVec2], bound: Bound) -> Reference<'a> {
    let is_flipped = grid.georeference.affine().matrix2.determinant() < 0.0;
    let last_row = (grid.rows - 1) as f64;
    let turned = move |grid: DVec2| DVec2::new(grid.x, if is_flipped { last_row - grid.y } else { grid.y });
    let high = DVec2::new((grid.columns - 1) as f64, last_row) * UNITS_IN_A_CELL;
    let plan = PlanMap::fit(
        DVec2::ZERO,
        high,
        move |plan| turned(plan / UNITS_IN_A_CELL),
        move |grid| turned(grid) * UNITS_IN_A_CELL,
    );
    Reference {
        heights: grid.whole(),
        plan,
        curvature,
        ground: Ground::Plane(DVec2::ONE / UNITS_IN_A_CELL),
        bound,
        finer: None,
    }
}

/// The raster's cells with four samples, in as few triangles as their outline has.
///
/// # Errors
/// When the outline cannot be triangulated.
pub(crate) fn triangulated<'a>(reference: &'a Reference<'a>) -> Result<Surface<'a>> {
    let is_inside = |plan: DVec2| {
        let cell = reference.plan.grid(plan).floor();
        reference.heights.cell_is_valid(cell.x as i64, cell.y as i64)
    };
    let mut mesh = triangulate(&outline(reference), is_inside)?;
    mesh::separate_fans(&mut mesh, |_| false);
    Ok(Surface::new(&mesh, reference))
}

/// The edge of the raster's valid cells: a vertex wherever it turns, a segment between.
fn outline(reference: &Reference) -> Outline {
    let valid = |c: usize, r: usize| reference.heights.cell_is_valid(c as i64 - 1, r as i64 - 1);
    let (mut across, mut down) = (BTreeSet::new(), BTreeSet::new());
    // Cells are counted from one here, so that the ring of cells around the raster has numbers, too.
    for row in 1..=reference.heights.rows {
        for column in 1..=reference.heights.columns {
            if valid(column, row) != valid(column, row - 1) {
                across.insert((row - 1, column - 1));
            }
            if valid(column, row) != valid(column - 1, row) {
                down.insert((column - 1, row - 1));
            }
        }
    }
    let has_outside = reference.heights.samples.iter().any(|height| height.is_nan());
    let mut outline = Outline {
        has_outside,
        ..Outline::default()
    };
    let mut numbers = BTreeMap::new();
    let is_turn = |lines: &BTreeSet<(usize, usize)>, at: (usize, usize)| {
        lines.contains(&at)
            || at
                .1
                .checked_sub(1)
                .is_some_and(|before| lines.contains(&(at.0, before)))
    };
    for (steps, others, is_across) in [(&across, &down, true), (&down, &across, false)] {
        for run in straight_runs(steps, |line, along| is_turn(others, (along, line))) {
            let (line, [from, to]) = run;
            let ends = [from, to].map(|along| {
                let (column, row) = if is_across { (along, line) } else { (line, along) };
                *numbers.entry((column, row)).or_insert_with(|| {
                    let plan = reference.plan.plan(DVec2::new(column as f64, row as f64)).round();
                    outline
                        .vertices
                        .push(plan.extend(reference.heights.sample(column, row)));
                    outline.vertices.len() as u32 - 1
                })
            });
            outline.segments.push(ends);
        }
    }
    outline
}

/// Joins unit steps (line, start) on one line as long as they follow each other and nothing turns in between.
fn straight_runs(steps: &BTreeSet<(usize, usize)>, is_turn: impl Fn(usize, usize) -> bool) -> Vec<(usize, [usize; 2])> {
    let mut runs: Vec<(usize, [usize; 2])> = Vec::new();
    for &(line, start) in steps {
        match runs.last_mut() {
            Some((last, [_, end])) if *last == line && *end == start && !is_turn(line, start) => *end += 1,
            _ => runs.push((line, [start, start + 1])),
        }
    }
    runs
}

/// To micrometres, never down.
pub(crate) fn rounded_up(error: f64) -> f64 {
    (error * 1e6).ceil() / 1e6
}
