//! One mesh of a whole raster, in its own coordinate reference system: no tiles, no levels.
//!
//! ```text
//! outline ← where the raster's valid cells end, straight runs as one segment
//! surface ← constrained Delaunay of the outline, refined to the tolerance
//! surface ← collapses, swaps and moves inside the tolerance
//! measure, write
//! ```
//! The mesh is planar between its vertices in the raster's coordinates, so what the simplifier measures is exact.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use glam::{DVec2, DVec3};
use indicatif::HumanCount;
use serde::Serialize;
use terrain_core::Surface;
use terrain_core::height_field::ground::Ground;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::{Bound, Reference};
use terrain_core::height_field::refine::{Refinement, refine};
use terrain_core::height_field::simplify::{Allowance, Quality, Shape, Simplifier, VertexKind};
use terrain_core::height_field::triangulate::{Outline, triangulate};
use terrain_core::mesh::{self, Mesh};
use terrain_tiles::formats::{obj, ply};
use terrain_tiles::new_file::NewFile;

use crate::height_grid::HeightGrid;
use crate::progress::Progress;

/// Plan units in a cell: vertices that are no samples lie on this finer grid.
const UNITS_IN_A_CELL: f64 = 256.0;
/// No triangle is lower than this in plan, in units.
const LEAST_ALTITUDE: f64 = 4.0;
/// Share of the asked error that is used; the rest is for the rounding of whoever reads the coordinates back.
const SHARE: f64 = 1.0 - 1e-6;

/// How to triangulate.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Largest error in metres.
    pub max_error: f64,
    /// Where it is to hold.
    pub bound: Bound,
    /// How much work goes into few triangles.
    pub quality: Quality,
}

/// What was made.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// Largest deviation in metres, measured on the finished mesh.
    pub certified_error: f64,
    /// `surface` or `samples`.
    pub bound: &'static str,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            vertices,
            triangles,
            certified_error,
            bound,
        } = self;
        write!(
            f,
            "{triangles} triangles, {vertices} vertices, certified error {certified_error} m ({bound})"
        )
    }
}

/// Triangulates `grid` and writes a `.ply` or `.obj` to `output`, all at once or not at all.
///
/// # Errors
/// When the error asked for is none, the raster has no surface, or the file cannot be written.
pub fn run(grid: &HeightGrid, options: &Options, output: &Path, progress: &Progress) -> Result<Report> {
    if !(options.max_error.is_finite() && options.max_error > 0.0) {
        bail!("the largest error must be more than 0 m");
    }
    let is_flipped = grid.georeference.affine().matrix2.determinant() < 0.0;
    let curvature = vec![DVec2::ZERO; grid.rows];
    let reference = reference(grid, is_flipped, &curvature, options.bound);
    progress.open_stage("triangulating");
    let surface = refined(&reference, options)?;
    progress.open_stage(&format!(
        "simplifying {} triangles",
        HumanCount(surface.triangle_count() as u64)
    ));
    let surface = thinned(surface, options);
    progress.done();
    let error = surface.deviation().size;
    let (mesh, _) = surface.mesh();
    if mesh.triangles.is_empty() {
        bail!("the raster has no cell with four valid samples");
    }
    let report = Report {
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        certified_error: rounded_up(error),
        bound: bound_name(options.bound),
    };
    let in_crs = |position: DVec3| {
        let at = grid
            .georeference
            .crs_coordinates(reference.plan.grid(position.truncate()));
        at.extend(position.z)
    };
    write(output, &mesh, in_crs, &report).with_context(|| format!("{}", output.display()))?;
    Ok(report)
}

/// Name of a bound in files and reports.
#[must_use]
pub fn bound_name(bound: Bound) -> &'static str {
    match bound {
        Bound::Surface => "surface",
        Bound::Samples => "samples",
    }
}

fn reference<'a>(grid: &'a HeightGrid, is_flipped: bool, curvature: &'a [DVec2], bound: Bound) -> Reference<'a> {
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

fn refined<'a>(reference: &'a Reference<'a>, options: &Options) -> Result<Surface<'a>> {
    let is_inside = |plan: DVec2| {
        let cell = reference.plan.grid(plan).floor();
        reference.heights.cell_is_valid(cell.x as i64, cell.y as i64)
    };
    let mut mesh = triangulate(&outline(reference), is_inside)?;
    mesh::separate_fans(&mut mesh, |_| false);
    let mut surface = Surface::new(&mesh, reference);
    let refinement = Refinement {
        tolerance: options.max_error * SHARE,
        height_step: 0.0,
        frame: None,
    };
    refine(&mut surface, refinement);
    Ok(surface.in_memory_order())
}

fn thinned<'a>(surface: Surface<'a>, options: &Options) -> Surface<'a> {
    let shape = Shape {
        height_step: 0.0,
        least_altitude: LEAST_ALTITUDE,
    };
    let kinds = vec![VertexKind::Free; surface.vertex_count()];
    let mut simplifier = Simplifier::new(surface, kinds, shape, options.quality);
    simplifier.thin(Allowance {
        vertical: options.max_error * SHARE,
        outline: 0.0,
    });
    simplifier.into_surface().in_memory_order()
}

/// To micrometres, never down.
fn rounded_up(error: f64) -> f64 {
    (error * 1e6).ceil() / 1e6
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

fn write(output: &Path, mesh: &Mesh, in_crs: impl Fn(DVec3) -> DVec3, report: &Report) -> Result<()> {
    let note = format!(
        "terrain-ingest certified error {} bound {}",
        report.certified_error, report.bound
    );
    let positions: Vec<DVec3> = mesh.positions.iter().map(|&position| in_crs(position)).collect();
    let extension = output.extension().unwrap_or_default();
    let mut file = NewFile::create(output)?;
    let mut writer = BufWriter::new(file.file());
    if extension.eq_ignore_ascii_case("obj") {
        obj::write(&mut writer, &positions, &mesh.triangles, &note)?;
    } else {
        ply::write(&mut writer, &positions, &[], &mesh.triangles, Some(&note))?;
    }
    writer.flush()?;
    drop(writer);
    Ok(file.finish()?)
}
