//! Commands that measure what was made, or tell what it says of itself.

use std::fmt::{self, Display};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use serde::Serialize;
use terrain_ingest::globe::Seen;
use terrain_ingest::samples::{Overrides, Raster};
use terrain_ingest::store::Store;
use terrain_ingest::stored_raster::{StoredRaster, TakeError};
use terrain_ingest::verify::Source;
use terrain_ingest::{curved_model, polygonal_model, verify};
use terrain_tiles::archive::Reader;
use terrain_tiles::metadata::{HeightsAbove, Metadata, Vertical};

use super::shared::{blamed, bound_name, has_extension, memory, open, overrides, prepare, print};
use crate::cli::{InfoArgs, RasterArgs, VerifyArgs};
use crate::failure::Failure;

pub(super) fn check(arguments: VerifyArgs) -> Result<(), Failure> {
    let progress = prepare(&arguments.run)?;
    if let Err(error) = std::fs::metadata(&arguments.subject) {
        return Err(Failure::Input(anyhow!("{}: {error}", arguments.subject.display())));
    }
    let memory = memory(&arguments.run);
    let overrides = overrides_of(&arguments.subject, arguments.raster, arguments.breaklines)?;
    let rasters = open(&arguments.dems, overrides, &progress)?;
    let work = tempfile::tempdir()
        .context("a folder for samples")
        .map_err(Failure::Other)?;
    let store = Store::open(&work.path().display().to_string()).map_err(Failure::Other)?;
    let is_mesh = has_extension(&arguments.subject, &["ply", "obj"]);
    let seen = if is_mesh {
        Seen::Open(&rasters)
    } else {
        Seen::new(&rasters)
    };
    let stored = StoredRaster::take(seen.raster(), &store, memory, &progress).map_err(|error| match error {
        TakeError::Read(error) => Failure::Input(error.into()),
        TakeError::Store(error) => Failure::Other(error),
    })?;
    let (json, subject) = (arguments.run.json, &arguments.subject);
    let breaklines = rasters.provenance().breaklines;
    let source = Source {
        breaklines: &breaklines,
        ..stored.source()
    };
    let holds = if is_mesh {
        let claim = arguments.max_error.map(|error| verify::Claim {
            error,
            bound: bound_name(arguments.bound).to_owned(),
        });
        let report = verify::mesh(subject, source, claim, memory).map_err(Failure::Input)?;
        print(&report, json)?;
        report.holds()
    } else {
        let report = verify::archive(subject, source, memory, &progress).map_err(Failure::Input)?;
        print(&report, json)?;
        report.holds()
    };
    if holds { Ok(()) } else { Err(Failure::Violation) }
}

/// The same for an archive to verify, which says how its rasters were read.
fn overrides_of(subject: &Path, raster: RasterArgs, breaklines: Option<PathBuf>) -> Result<Overrides, Failure> {
    if has_extension(subject, &["ply", "obj"]) {
        return Ok(overrides(raster, breaklines, HeightsAbove::Source));
    }
    let archive = Reader::open(subject).map_err(|error| Failure::Input(error.into()))?;
    let asked = archive.metadata().asked.clone();
    let said = overrides(raster, breaklines, asked.vertical.heights);
    Ok(Overrides {
        crs: said.crs.or(asked.crs),
        bounds: said.bounds.or(asked.bounds),
        vertical: Vertical {
            heights: said.vertical.heights,
            datum: said.vertical.datum.or(asked.vertical.datum),
            geoid: said.vertical.geoid.or(asked.vertical.geoid),
        },
        reading: said.reading.or(asked.reading),
    })
}

pub(super) fn info(arguments: &InfoArgs) -> Result<(), Failure> {
    if has_extension(&arguments.archive, &["spm", "lod"]) {
        let report = polygonal_model::info(&arguments.archive).map_err(blamed)?;
        return print(&report, arguments.json);
    }
    if has_extension(&arguments.archive, &["clod"]) {
        let report = curved_model::info(&arguments.archive).map_err(blamed)?;
        return print(&report, arguments.json);
    }
    let reader = Reader::open(&arguments.archive).map_err(|error| Failure::Input(error.into()))?;
    print(&Info(reader.metadata()), arguments.json)
}

/// An archive's own description, as a table.
#[derive(Serialize)]
struct Info<'a>(&'a Metadata);

impl Display for Info<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(metadata) = self;
        let [west, south, east, north] = metadata.bounds;
        let source = &metadata.source;
        writeln!(f, "format          {} version {}", metadata.format, metadata.version)?;
        writeln!(f, "written by      {}", metadata.generator)?;
        writeln!(f, "source          {}", source.files.join(", "))?;
        writeln!(
            f,
            "samples         {} × {}, {}",
            source.samples[0], source.samples[1], source.crs
        )?;
        writeln!(f, "vertical datum  {}", source.vertical_datum)?;
        writeln!(f, "tiles above     {}", source.tiles_above())?;
        writeln!(f, "transformation  {}", source.vertical_transformation())?;
        writeln!(f, "scheme          {}", metadata.scheme)?;
        writeln!(
            f,
            "bounds          {west:.6}, {south:.6}, {east:.6}, {north:.6} (west, south, east, north)"
        )?;
        let range = |heights: [f64; 2]| {
            let [lowest, highest] = heights.map(|metres| (metres * 1e3).round() / 1e3);
            format!("{lowest} … {highest} m")
        };
        let of_samples = source
            .heights
            .map_or_else(String::new, |heights| format!("{} of samples, ", range(heights)));
        writeln!(
            f,
            "heights         {of_samples}{} of all surfaces",
            range(metadata.heights)
        )?;
        writeln!(
            f,
            "error           {} m at the leaves, bounded at the {}",
            metadata.max_error, metadata.bound
        )?;
        writeln!(
            f,
            "zoom  tiles  triangles  finest error, m  coarsest error, m  outline error, m"
        )?;
        let lines = metadata.zooms.iter().map(|zoom| {
            let (tiles, triangles) = (zoom.tiles, zoom.triangles);
            let (finest, coarsest, outline) = (zoom.finest_error, zoom.coarsest_error, zoom.outline_error);
            format!(
                "{:>4} {tiles:>6} {triangles:>10} {finest:>16.3} {coarsest:>18.3} {outline:>17.3}",
                zoom.zoom
            )
        });
        write!(f, "{}", lines.collect::<Vec<_>>().join("\n"))
    }
}
