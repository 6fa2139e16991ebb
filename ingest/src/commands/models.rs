//! Commands that make one mesh, or levels of detail of a model.

use std::fmt::{self, Display};
use std::time::Instant;

use anyhow::anyhow;
use serde::Serialize;
use terrain_ingest::samples::Raster;
use terrain_ingest::{curved_model, curved_terrain, polygonal_model, tin};
use terrain_tiles::metadata::HeightsAbove;

use super::shared::{blamed, check_output, grid, has_extension, open, overrides, prepare, print_finished, read};
use crate::cli::{ClodArgs, MeshArgs, TinArgs};
use crate::failure::Failure;

pub(super) fn triangulate(arguments: TinArgs) -> Result<(), Failure> {
    let started = Instant::now();
    check_output(&arguments.output)?;
    if !has_extension(&arguments.output, &["ply", "obj"]) {
        let output = arguments.output.display();
        return Err(Failure::Input(anyhow!("{output}: meshes are written as .ply or .obj")));
    }
    let progress = prepare(&arguments.run)?;
    let surface = arguments.surface;
    let overrides = overrides(arguments.raster, surface.breaklines, HeightsAbove::Source);
    let rasters = open(&arguments.dems, overrides, &progress)?;
    let options = tin::Options {
        max_error: arguments.max_error,
        bound: surface.bound.into(),
        quality: surface.quality.into(),
        breaklines: rasters.provenance().breaklines,
    };
    let grid = grid(&arguments.dems, rasters)?;
    let report = tin::run(&grid, &options, &arguments.output, &progress).map_err(Failure::Other)?;
    print_finished(report, &arguments.output, started, arguments.run.json)
}

pub(super) fn simplify_model(arguments: MeshArgs) -> Result<(), Failure> {
    let started = Instant::now();
    check_output(&arguments.output)?;
    let progress = prepare(&arguments.run)?;
    let target = match (arguments.target_triangles, arguments.max_error) {
        (Some(count), _) => polygonal_model::Target::Triangles(count as usize),
        (None, Some(error)) => polygonal_model::Target::Error(error),
        (None, None) => polygonal_model::Target::Coarsest,
    };
    let options = polygonal_model::Options {
        target,
        keep_vertices: arguments.keep_vertices,
        lod: arguments.lod,
    };
    let report = polygonal_model::run(&arguments.input, &options, &arguments.output, &progress).map_err(blamed)?;
    print_finished(report, &arguments.output, started, arguments.run.json)
}

/// Triangles of a raster's surface are as near to it as this part of its error where nobody says otherwise.
const TRIANGLES_IN_AN_ERROR: f64 = 4.0;

pub(super) fn curve(arguments: ClodArgs) -> Result<(), Failure> {
    let started = Instant::now();
    let (output, json) = (arguments.output, arguments.run.json);
    check_output(&output)?;
    let progress = prepare(&arguments.run)?;
    let options = curved_model::Options {
        max_error: arguments.max_error,
        patches: arguments.patches.map(|patches| patches as usize),
        level: arguments.level,
        tolerance: arguments.tessellate,
        crease_angle: arguments.crease_angle.map(f64::to_radians),
    };
    if curved_model::is_read(&arguments.input) {
        let report = curved_model::run(&arguments.input, &options, &output, &progress).map_err(blamed)?;
        return print_finished(report, &output, started, json);
    }
    let max_error = options.max_error.ok_or_else(|| {
        let name = arguments.input.display();
        Failure::Input(anyhow!("{name}: a surface of a raster needs --max-error METRES"))
    })?;
    let overrides = overrides(arguments.raster, None, HeightsAbove::Source);
    let grid = read(&[arguments.input], overrides, &progress)?;
    let on_lattice = max_error * (1.0 - curved_model::LATTICE_SHARE);
    let (levels, report) = curved_terrain::run(&grid, on_lattice, &progress).map_err(Failure::Other)?;
    let options = curved_model::Options {
        tolerance: options.tolerance.or(Some(max_error / TRIANGLES_IN_AN_ERROR)),
        ..options
    };
    let made = curved_model::write(&levels, &options, &output, &progress).map_err(blamed)?;
    let surface = CurvedSurface {
        surface: report,
        tessellation: made.tessellation,
    };
    print_finished(surface, &output, started, json)
}

/// A curved surface of a raster, and the triangles that it became, if it did.
#[derive(Serialize)]
pub(super) struct CurvedSurface {
    #[serde(flatten)]
    surface: curved_terrain::Report,
    #[serde(skip_serializing_if = "Option::is_none")]
    tessellation: Option<curved_model::TessellationReport>,
}

impl Display for CurvedSurface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.surface)?;
        match &self.tessellation {
            Some(made) => write!(
                f,
                "\n{} triangles, {} vertices, within {:.3e} of the surface",
                made.triangles, made.vertices, made.tolerance
            ),
            None => Ok(()),
        }
    }
}
