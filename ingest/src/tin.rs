//! One mesh of a whole raster, in its own coordinate reference system: no tiles, no levels.
//!
//! ```text
//! outline ← where the raster's valid cells end, straight runs as one segment
//! surface ← constrained Delaunay of the outline, refined to the tolerance
//! surface ← collapses, swaps and moves inside the tolerance
//! measure, write
//! ```
//! The mesh is planar between its vertices in the raster's coordinates, so what the simplifier measures is exact.

use std::fmt;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use glam::{DVec2, DVec3};
use indicatif::HumanCount;
use serde::Serialize;
use terrain_core::Surface;
use terrain_core::height_field::reference::{Bound, Reference};
use terrain_core::height_field::refine::{Refinement, refine};
use terrain_core::height_field::simplify::{Allowance, Quality, Shape, Simplifier, VertexKind};
use terrain_core::mesh::Mesh;
use terrain_tiles::formats::{obj, ply};
use terrain_tiles::new_file::NewFile;

use crate::breaklines::steps_on_surface;
use crate::height_grid::HeightGrid;
use crate::progress::Progress;
use crate::whole_raster::{self, LEAST_ALTITUDE, SHARE};

/// Cells that a breakline may stray in plan, besides the rounding of its places: so that straight ones need few vertices.
const BREAKLINE_STRAYS: f64 = 1.0 / 64.0;

/// How to triangulate.
#[derive(Clone, Debug)]
pub struct Options {
    /// Largest error in metres.
    pub max_error: f64,
    /// Where it is to hold.
    pub bound: Bound,
    /// How much work goes into few triangles.
    pub quality: Quality,
    /// Lines that the mesh keeps as edges, in coordinates of the raster's reference system.
    pub breaklines: Vec<Vec<[f64; 2]>>,
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
    let curvature = vec![DVec2::ZERO; grid.rows];
    let reference = whole_raster::reference(grid, &curvature, options.bound);
    progress.open_stage("triangulating");
    let surface = refined(grid, &reference, options)?;
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
        certified_error: whole_raster::rounded_up(error),
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

fn refined<'a>(grid: &HeightGrid, reference: &'a Reference<'a>, options: &Options) -> Result<Surface<'a>> {
    let breaklines = steps_on_surface(&options.breaklines, &grid.georeference, reference.heights);
    let mut surface = whole_raster::triangulated(reference, &breaklines)?;
    let refinement = Refinement {
        tolerance: options.max_error * SHARE,
        height_step: 0.0,
        frame: None,
        most_vertices: None,
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
        breaklines: BREAKLINE_STRAYS,
    });
    simplifier.into_surface().in_memory_order()
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
