//! What commands have in common: arguments become options, rasters are opened, reports printed.

use std::fmt::{self, Display};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, anyhow};
use serde::Serialize;
use terrain_core::height_field::{reference, simplify};
use terrain_ingest::raster::Rasters;
use terrain_ingest::samples::Overrides;
use terrain_ingest::{
    HeightGrid, Progress, ReadOptions, curved_model, peak_memory, polygonal_model, quarter_of_memory, raster,
};
use terrain_tiles::metadata::{ColourEncoding, Fill, HeightsAbove, RasterReader, Reading, Vertical};

use crate::cli::{Bound, ByteOrder, Priority, Quality, RasterArgs, RunArgs, Values, VoidPolicy};
use crate::failure::Failure;

/// A fault of a model is one of the input.
pub(super) fn blamed(error: anyhow::Error) -> Failure {
    let is_models = error.is::<polygonal_model::ModelError>() || error.is::<curved_model::CurvedModelError>();
    if is_models {
        Failure::Input(error)
    } else {
        Failure::Other(error)
    }
}

/// Sets the number of threads and says where progress goes.
pub(super) fn prepare(run: &RunArgs) -> Result<Progress, Failure> {
    if let Some(jobs) = run.jobs {
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(jobs))
            .build_global()
            .map_err(|error| Failure::Other(error.into()))?;
    }
    Ok(if run.quiet {
        Progress::silent()
    } else if run.json {
        Progress::as_events()
    } else {
        Progress::on_standard_error()
    })
}

/// `heights` is what they are above where the person does not say it.
pub(super) fn overrides(raster: RasterArgs, breaklines: Option<PathBuf>, heights: HeightsAbove) -> Overrides {
    Overrides {
        crs: raster.crs,
        bounds: raster.bounds,
        vertical: Vertical {
            heights: raster.heights.map_or(heights, HeightsAbove::from),
            datum: raster.vertical,
            geoid: raster.geoid.map(|path| path.display().to_string()),
        },
        reading: Reading {
            unit: raster.unit,
            nodata: raster.nodata.map(|Values(values)| values),
            encoding: raster.encoding.map(ColourEncoding::from),
            height_range: raster.height_range.map(|range| [range[0], range[1]]),
            local: raster.local || raster.pixel_size.is_some(),
            pixel_size: raster.pixel_size,
            reader: raster.reader.map(RasterReader::from),
            big_endian: matches!(raster.byte_order, ByteOrder::Big),
            allow_vrt: raster.allow_vrt,
            underlay: raster.underlay.iter().map(|path| path.display().to_string()).collect(),
            around: raster.around,
            blend: raster.blend,
            by_order: matches!(raster.priority, Priority::Order),
            water: raster.water.map(|path| path.display().to_string()),
            flatten: raster.flatten.map(|path| path.display().to_string()),
            breaklines: breaklines.map(|path| path.display().to_string()),
            fill: matches!(raster.voids, VoidPolicy::Fill).then_some(Fill {
                widest: raster.fill_width,
            }),
        },
    }
}

/// Folders become the rasters in them, by their names, in order.
fn files(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for path in named {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let unreadable = |error: io::Error| Failure::Input(anyhow!("{}: cannot be read: {error}", path.display()));
        let entries = fs::read_dir(path)
            .and_then(Iterator::collect::<io::Result<Vec<_>>>)
            .map_err(unreadable)?;
        let inside = entries.into_iter().map(|entry| entry.path());
        let mut rasters: Vec<PathBuf> = inside
            .filter(|path| path.is_file() && raster::is_raster(path))
            .collect();
        if rasters.is_empty() {
            return Err(Failure::Input(anyhow!(
                "{}: no file in this folder is a raster by its name",
                path.display()
            )));
        }
        rasters.sort();
        files.extend(rasters);
    }
    Ok(files)
}

pub(super) fn read_options(overrides: Overrides, progress: &Progress) -> ReadOptions {
    ReadOptions {
        overrides,
        progress: progress.clone(),
        ..ReadOptions::default()
    }
}

/// Bytes of memory to stay below, roughly.
pub(super) fn memory(run: &RunArgs) -> u64 {
    run.memory.unwrap_or_else(quarter_of_memory)
}

pub(super) fn open(dems: &[PathBuf], overrides: Overrides, progress: &Progress) -> Result<Rasters, Failure> {
    Rasters::open(&files(dems)?, &read_options(overrides, progress)).map_err(|error| Failure::Input(error.into()))
}

pub(super) fn read(dems: &[PathBuf], overrides: Overrides, progress: &Progress) -> Result<HeightGrid, Failure> {
    grid(dems, open(dems, overrides, progress)?)
}

/// All samples of opened rasters, which are to have a surface.
pub(super) fn grid(dems: &[PathBuf], rasters: Rasters) -> Result<HeightGrid, Failure> {
    let grid = rasters.grid().map_err(|error| Failure::Input(error.into()))?;
    if !grid.has_surface() {
        let first = dems[0].display();
        return Err(Failure::Input(anyhow!(
            "{first}: no four neighbouring samples are all valid, so there is no surface"
        )));
    }
    Ok(grid)
}

/// Finds out before the work whether the result has a place.
pub(super) fn check_output(output: &Path) -> Result<(), Failure> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let problem = match folder {
        _ if output.is_dir() => "is a folder",
        _ if output.exists() && !output.is_file() => "is a device or a pipe, and no file that can be replaced",
        Some(folder) if !folder.is_dir() => "its folder does not exist",
        _ => return Ok(()),
    };
    Err(Failure::Input(anyhow!("{}: {problem}", output.display())))
}

pub(super) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension()
        .is_some_and(|extension| extensions.iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

pub(super) fn bound_name(bound: Bound) -> &'static str {
    match bound {
        Bound::Surface => "surface",
        Bound::Samples => "samples",
    }
}

impl From<Quality> for simplify::Quality {
    fn from(quality: Quality) -> Self {
        match quality {
            Quality::Fast => Self::Fast,
            Quality::Default => Self::Default,
            Quality::Best => Self::Best,
        }
    }
}

impl From<Bound> for reference::Bound {
    fn from(bound: Bound) -> Self {
        match bound {
            Bound::Surface => Self::Surface,
            Bound::Samples => Self::Samples,
        }
    }
}

/// A report with what the job cost.
#[derive(Serialize)]
pub(super) struct Finished<R> {
    output: PathBuf,
    #[serde(flatten)]
    report: R,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_memory_bytes: Option<u64>,
}

impl<R: Display> Display for Finished<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.report)?;
        write!(f, "{}: {:.1} s", self.output.display(), self.seconds)?;
        match self.peak_memory_bytes {
            Some(bytes) => write!(f, ", peak memory {} MB", bytes / 1_000_000),
            None => Ok(()),
        }
    }
}

pub(super) fn print_finished<R: Serialize + Display>(
    report: R,
    output: &Path,
    started: Instant,
    json: bool,
) -> Result<(), Failure> {
    let finished = Finished {
        output: output.to_owned(),
        report,
        seconds: started.elapsed().as_secs_f64(),
        peak_memory_bytes: peak_memory(),
    };
    print(&finished, json)
}

pub(super) fn print(report: &(impl Serialize + Display), json: bool) -> Result<(), Failure> {
    let text = if json {
        serde_json::to_string_pretty(report).map_err(|error| Failure::Other(error.into()))?
    } else {
        report.to_string()
    };
    match writeln!(io::stdout(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(error).context("standard output").map_err(Failure::Other)
        }
        _ => Ok(()),
    }
}
