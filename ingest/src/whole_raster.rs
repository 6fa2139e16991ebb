//! A whole raster as one surface, in its own coordinate reference system: planar between places in its coordinates, so
//! that what is measured on the grid is exact.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use glam::DVec2;
use terrain_core::Surface;
use terrain_core::height_field::ground::Ground;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::{Bound, Reference};
use terrain_core::height_field::snapping::{Place, snapped};
use terrain_core::height_field::triangulate::{Outline, Triangulated, triangulate};
use terrain_core::mesh;

use crate::breaklines::GridStep;
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

/// The raster's cells with four samples, in as few triangles as their outline and `breaklines` have, which are steps on the grid.
///
/// # Errors
/// When the outline cannot be triangulated.
pub(crate) fn triangulated<'a>(reference: &'a Reference<'a>, breaklines: &[GridStep]) -> Result<Surface<'a>> {
    let is_inside = |plan: DVec2| {
        let cell = reference.plan.grid(plan).floor();
        reference.heights.cell_is_valid(cell.x as i64, cell.y as i64)
    };
    let mut outline = outline(reference);
    if !breaklines.is_empty() {
        outline = with_breaklines(outline, reference, breaklines);
    }
    let Triangulated { mut mesh, breaklines } = triangulate(&outline, is_inside)?;
    mesh::separate_fans(&mut mesh, |_| false);
    Ok(Surface::new(&mesh, reference).with_breaklines(&breaklines))
}

/// An outline with lines, all of which meet at vertices only.
fn with_breaklines(outline: Outline, reference: &Reference, steps: &[GridStep]) -> Outline {
    let place = |plan: DVec2| plan.round().as_i64vec2().to_array();
    let of_outline = |segment: &[u32; 2]| segment.map(|end| place(outline.vertices[end as usize].truncate()));
    let of_line = |step: &GridStep| step.map(|at| place(reference.plan.plan(at)));
    let segments: Vec<[Place; 2]> = outline
        .segments
        .iter()
        .map(of_outline)
        .chain(steps.iter().map(of_line))
        .collect();
    let mut joined = Outline {
        has_outside: outline.has_outside,
        ..Outline::default()
    };
    let mut numbers: BTreeMap<Place, u32> = BTreeMap::new();
    for &at in &outline.vertices {
        numbers.insert(place(at.truncate()), joined.vertices.len() as u32);
        joined.vertices.push(at);
    }
    let mut number = |at: Place| {
        *numbers.entry(at).or_insert_with(|| {
            let plan = DVec2::new(at[0] as f64, at[1] as f64);
            let height = reference.heights.height_near(reference.plan.grid(plan));
            joined.vertices.push(plan.extend(height.unwrap_or(0.0)));
            joined.vertices.len() as u32 - 1
        })
    };
    let ways = snapped(&segments);
    let (bounds, lines) = ways.split_at(outline.segments.len());
    let mut edges = |ways: &[Vec<Place>]| -> BTreeSet<[u32; 2]> {
        let pairs = ways.iter().flat_map(|way| way.windows(2));
        pairs
            .map(|pair| [pair[0].min(pair[1]), pair[0].max(pair[1])].map(&mut number))
            .collect()
    };
    let (bounds, lines) = (edges(bounds), edges(lines));
    joined.breaklines = lines.difference(&bounds).copied().collect();
    joined.segments = bounds.into_iter().collect();
    joined
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
