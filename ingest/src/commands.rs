//! What the commands do: read, call the library, print a report.

use std::fmt::{self, Display};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, anyhow};
use serde::Serialize;
use terrain_core::height_field::{reference, simplify};
use terrain_ingest::pyramid::{Build, BuildError, Changes, Graph, Recipe, Report, StageSize};
use terrain_ingest::raster::{RasterRecord, Rasters};
use terrain_ingest::samples::Overrides;
use terrain_ingest::store::Store;
use terrain_ingest::stored_raster::{StoredRaster, TakeError};
use terrain_ingest::{
    HeightGrid, Progress, ReadOptions, curved_model, curved_terrain, peak_memory, polygonal_model, pyramid,
    quarter_of_memory, raster, tin, verify,
};
use terrain_tiles::archive::Reader;
use terrain_tiles::metadata::{HeightsAbove, Metadata, Vertical};

use crate::cli::{
    Bound, BuildArgs, Cli, ClodArgs, Command, InfoArgs, JobArgs, MergeArgs, MeshArgs, PlanArgs, Quality, RasterArgs,
    RunArgs, TileArgs, TinArgs, UpdateArgs, VerifyArgs,
};
use crate::failure::Failure;
use crate::work::Work;

pub(crate) fn run(cli: Cli) -> Result<(), Failure> {
    match cli.command {
        None => build(cli.build),
        Some(Command::Update(arguments)) => update(arguments),
        Some(Command::Plan(arguments)) => plan(arguments),
        Some(Command::Build(arguments)) => run_job(&arguments),
        Some(Command::Merge(arguments)) => merge(&arguments),
        Some(Command::Tin(arguments)) => triangulate(arguments),
        Some(Command::Mesh(arguments)) => simplify_model(arguments),
        Some(Command::Clod(arguments)) => curve(arguments),
        Some(Command::Verify(arguments)) => check(arguments),
        Some(Command::Info(arguments)) => info(&arguments),
    }
}

fn build(arguments: BuildArgs) -> Result<(), Failure> {
    let started = Instant::now();
    let output = arguments.output.unwrap_or_else(|| default_output(&arguments.dems[0]));
    check_output(&output)?;
    let progress = prepare(&arguments.run)?;
    let rasters = open(
        &arguments.dems,
        overrides(arguments.raster, HeightsAbove::Ellipsoid),
        &progress,
    )?;
    let options = options(&arguments.tiles, &arguments.run);
    let work = Work::begin(arguments.work.work, &output)?;
    let build = Build {
        raster: &rasters,
        options: &options,
        store: work.store(),
        earlier: None,
        progress: &progress,
    };
    let built = run_build(build, rasters.record(), &output);
    let report = work.end(built, arguments.work.keep_work)?;
    print_finished(report, &output, started, arguments.run.json)
}

/// Builds, the recipe first: what is kept then tells what it is made of.
fn run_build(build: Build, record: RasterRecord, output: &Path) -> Result<Report, BuildError> {
    Recipe::new(record, build.options).keep(build.store)?;
    build.run(output)
}

fn update(arguments: UpdateArgs) -> Result<(), Failure> {
    let started = Instant::now();
    let UpdateArgs {
        archive,
        changed,
        added,
        removed,
        from,
        work,
        run,
    } = arguments;
    let progress = prepare(&run)?;
    let earlier = Reader::open(&archive).map_err(|error| Failure::Input(error.into()))?;
    let of_archive = earlier.metadata();
    let options = pyramid::Options {
        memory: memory(&run),
        ..pyramid::options_of(&of_archive.asked, &of_archive.bound).map_err(Failure::Input)?
    };
    let keep_work = work.keep_work;
    let work = Work::begin(work.work, &archive)?;
    let places = Places::new(from, [&changed, &added], &archive, work.store()).map_err(Failure::Other)?;
    let changes = Changes {
        changed,
        added,
        removed,
    };
    let applied = changes.applied(&of_archive.source.files, |name| places.find(name));
    let overrides = Overrides {
        crs: of_archive.asked.crs.clone(),
        bounds: of_archive.asked.bounds,
        vertical: of_archive.asked.vertical.clone(),
    };
    let opened = applied
        .map_err(Failure::Input)
        .and_then(|paths| open(&paths, overrides, &progress));
    let rasters = match opened {
        Ok(rasters) => rasters,
        Err(failure) => return Err(work.abandon(failure)),
    };
    let build = Build {
        raster: &rasters,
        options: &options,
        store: work.store(),
        earlier: Some(&earlier),
        progress: &progress,
    };
    let built = run_build(build, rasters.record(), &archive);
    let report = work.end(built, keep_work)?;
    print_finished(report, &archive, started, run.json)
}

/// Where rasters may be of which only the names are known.
struct Places {
    /// Of files, from work that was kept.
    paths: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl Places {
    fn new(from: Vec<PathBuf>, named: [&[PathBuf]; 2], archive: &Path, store: &Store) -> anyhow::Result<Self> {
        let beside = |path: &PathBuf| path.parent().map(Path::to_path_buf);
        let mut folders = from;
        folders.extend(beside(&archive.to_owned()));
        folders.extend(named.into_iter().flatten().filter_map(beside));
        folders.push(PathBuf::new());
        let recipe = Recipe::find(store)?;
        Ok(Self {
            paths: recipe.map(|recipe| recipe.raster.paths).unwrap_or_default(),
            folders,
        })
    }

    fn find(&self, name: &str) -> Option<PathBuf> {
        let in_folders = self.folders.iter().map(|folder| folder.join(name));
        let of_that_name = self
            .paths
            .iter()
            .filter(|path| path.file_name().is_some_and(|known| known == name));
        in_folders.chain(of_that_name.cloned()).find(|path| path.is_file())
    }
}

fn plan(arguments: PlanArgs) -> Result<(), Failure> {
    let progress = prepare(&arguments.run)?;
    let rasters = open(
        &arguments.dems,
        overrides(arguments.raster, HeightsAbove::Ellipsoid),
        &progress,
    )?;
    let options = pyramid::Options {
        leaves_of_subtree: arguments.leaves,
        ..options(&arguments.tiles, &arguments.run)
    };
    let store = Store::open(&arguments.work).map_err(Failure::Other)?;
    let recipe = Recipe::new(rasters.record(), &options);
    let graph = Graph::plan(recipe, store, options.memory, &progress).map_err(Failure::Other)?;
    let planned = Planned {
        work: arguments.work,
        stages: graph.stages(),
    };
    print(&planned, arguments.run.json)
}

fn run_job(arguments: &JobArgs) -> Result<(), Failure> {
    let started = Instant::now();
    let progress = prepare(&arguments.run)?;
    let graph = Graph::open(&arguments.work, memory(&arguments.run), &progress).map_err(Failure::Input)?;
    graph.run(arguments.job).map_err(of_build)?;
    let done = JobDone {
        job: arguments.job.to_string(),
        seconds: started.elapsed().as_secs_f64(),
        peak_memory_bytes: peak_memory(),
    };
    print(&done, arguments.run.json)
}

fn merge(arguments: &MergeArgs) -> Result<(), Failure> {
    let started = Instant::now();
    check_output(&arguments.output)?;
    let progress = prepare(&arguments.run)?;
    let graph = Graph::open(&arguments.work, memory(&arguments.run), &progress).map_err(Failure::Input)?;
    let report = graph.merge(&arguments.output).map_err(of_build)?;
    print_finished(report, &arguments.output, started, arguments.run.json)
}

/// What is wrong with the input is the caller's.
fn of_build(error: BuildError) -> Failure {
    match error {
        BuildError::Other(error) => Failure::Other(error),
        error => Failure::Input(error.into()),
    }
}

/// The jobs of a build.
#[derive(Serialize)]
struct Planned {
    work: String,
    stages: Vec<StageSize>,
}

impl Display for Planned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "stage    jobs")?;
        for StageSize { stage, jobs } in &self.stages {
            writeln!(f, "{stage:<7} {jobs:>5}")?;
        }
        let work = &self.work;
        writeln!(f, "Stage by stage, all jobs of one at the same time where you can:")?;
        writeln!(f, "  terrain-ingest build --work {work} --job samples/0")?;
        write!(f, "and at the end\n  terrain-ingest merge --work {work} -o OUT.pmtiles")
    }
}

/// What a job cost.
#[derive(Serialize)]
struct JobDone {
    job: String,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_memory_bytes: Option<u64>,
}

impl Display for JobDone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is done: {:.1} s", self.job, self.seconds)
    }
}

fn triangulate(arguments: TinArgs) -> Result<(), Failure> {
    let started = Instant::now();
    check_output(&arguments.output)?;
    if !has_extension(&arguments.output, &["ply", "obj"]) {
        let output = arguments.output.display();
        return Err(Failure::Input(anyhow!("{output}: meshes are written as .ply or .obj")));
    }
    let progress = prepare(&arguments.run)?;
    let grid = read(&arguments.dems, arguments.raster, &progress)?;
    let options = tin::Options {
        max_error: arguments.max_error,
        bound: arguments.surface.bound.into(),
        quality: arguments.surface.quality.into(),
    };
    let report = tin::run(&grid, &options, &arguments.output, &progress).map_err(Failure::Other)?;
    print_finished(report, &arguments.output, started, arguments.run.json)
}

fn simplify_model(arguments: MeshArgs) -> Result<(), Failure> {
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

fn curve(arguments: ClodArgs) -> Result<(), Failure> {
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
    let grid = read(&[arguments.input], arguments.raster, &progress)?;
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
struct CurvedSurface {
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

fn check(arguments: VerifyArgs) -> Result<(), Failure> {
    let progress = prepare(&arguments.run)?;
    if let Err(error) = std::fs::metadata(&arguments.subject) {
        return Err(Failure::Input(anyhow!("{}: {error}", arguments.subject.display())));
    }
    let memory = memory(&arguments.run);
    let overrides = overrides_of(&arguments.subject, arguments.raster)?;
    let rasters = open(&arguments.dems, overrides, &progress)?;
    let work = tempfile::tempdir()
        .context("a folder for samples")
        .map_err(Failure::Other)?;
    let store = Store::open(&work.path().display().to_string()).map_err(Failure::Other)?;
    let stored = StoredRaster::take(&rasters, &store, memory, &progress).map_err(|error| match error {
        TakeError::Read(error) => Failure::Input(error.into()),
        TakeError::Store(error) => Failure::Other(error),
    })?;
    let (json, subject) = (arguments.run.json, &arguments.subject);
    let holds = if has_extension(subject, &["ply", "obj"]) {
        let claim = arguments.max_error.map(|error| verify::Claim {
            error,
            bound: bound_name(arguments.bound).to_owned(),
        });
        let report = verify::mesh(subject, stored.source(), claim, memory).map_err(Failure::Input)?;
        print(&report, json)?;
        report.holds()
    } else {
        let report = verify::archive(subject, stored.source(), memory, &progress).map_err(Failure::Input)?;
        print(&report, json)?;
        report.holds()
    };
    if holds { Ok(()) } else { Err(Failure::Violation) }
}

/// A fault of a model is one of the input.
fn blamed(error: anyhow::Error) -> Failure {
    let is_models = error.is::<polygonal_model::ModelError>() || error.is::<curved_model::CurvedModelError>();
    if is_models {
        Failure::Input(error)
    } else {
        Failure::Other(error)
    }
}

fn info(arguments: &InfoArgs) -> Result<(), Failure> {
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

/// Sets the number of threads and says where progress goes.
fn prepare(run: &RunArgs) -> Result<Progress, Failure> {
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

fn options(tiles: &TileArgs, run: &RunArgs) -> pyramid::Options {
    pyramid::Options {
        max_error: tiles.max_error,
        bound: tiles.surface.bound.into(),
        quality: tiles.surface.quality.into(),
        memory: memory(run),
        ..pyramid::Options::default()
    }
}

/// `heights` is what they are above where the person does not say it.
fn overrides(raster: RasterArgs, heights: HeightsAbove) -> Overrides {
    Overrides {
        crs: raster.crs,
        bounds: raster.bounds,
        vertical: Vertical {
            heights: raster.heights.map_or(heights, HeightsAbove::from),
            datum: raster.vertical,
            geoid: raster.geoid.map(|path| path.display().to_string()),
        },
    }
}

/// The same for an archive to verify, which says what its heights are above.
fn overrides_of(subject: &Path, raster: RasterArgs) -> Result<Overrides, Failure> {
    if has_extension(subject, &["ply", "obj"]) {
        return Ok(overrides(raster, HeightsAbove::Source));
    }
    let archive = Reader::open(subject).map_err(|error| Failure::Input(error.into()))?;
    let asked = archive.metadata().asked.vertical.clone();
    let mut overrides = overrides(raster, asked.heights);
    let Vertical { datum, geoid, .. } = &mut overrides.vertical;
    *datum = datum.take().or(asked.datum);
    *geoid = geoid.take().or(asked.geoid);
    Ok(overrides)
}

fn read_options(overrides: Overrides, progress: &Progress) -> ReadOptions {
    ReadOptions {
        overrides,
        progress: progress.clone(),
        ..ReadOptions::default()
    }
}

/// Bytes of memory to stay below, roughly.
fn memory(run: &RunArgs) -> u64 {
    run.memory.unwrap_or_else(quarter_of_memory)
}

fn open(dems: &[PathBuf], overrides: Overrides, progress: &Progress) -> Result<Rasters, Failure> {
    Rasters::open(dems, &read_options(overrides, progress)).map_err(|error| Failure::Input(error.into()))
}

fn read(dems: &[PathBuf], raster: RasterArgs, progress: &Progress) -> Result<HeightGrid, Failure> {
    let grid = raster::read(dems, &read_options(overrides(raster, HeightsAbove::Source), progress))
        .map_err(|error| Failure::Input(error.into()))?;
    if !grid.has_surface() {
        let first = dems[0].display();
        return Err(Failure::Input(anyhow!(
            "{first}: no four neighbouring samples are all valid, so there is no surface"
        )));
    }
    Ok(grid)
}

/// The raster's name with `.pmtiles`, in the current folder; `N48W125.hgt.zip` becomes `N48W125.pmtiles`.
fn default_output(dem: &Path) -> PathBuf {
    let name = PathBuf::from(dem.file_name().unwrap_or_default());
    let is_zip = has_extension(&name, &["zip"]);
    let name = if is_zip { name.with_extension("") } else { name };
    name.with_extension("pmtiles")
}

/// Finds out before the work whether the result has a place.
fn check_output(output: &Path) -> Result<(), Failure> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    let problem = match folder {
        _ if output.is_dir() => "is a folder",
        Some(folder) if !folder.is_dir() => "its folder does not exist",
        _ => return Ok(()),
    };
    Err(Failure::Input(anyhow!("{}: {problem}", output.display())))
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension()
        .is_some_and(|extension| extensions.iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

fn bound_name(bound: Bound) -> &'static str {
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
struct Finished<R> {
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

fn print_finished<R: Serialize + Display>(
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

/// An archive's own description, as a table.
#[derive(Serialize)]
struct Info<'a>(&'a Metadata);

impl Display for Info<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(metadata) = self;
        let [west, south, east, north] = metadata.bounds;
        let [lowest, highest] = metadata.heights;
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
        if let Some(geoid) = &source.geoid {
            writeln!(f, "tiles above     {}, by {geoid}", source.heights_above)?;
        }
        writeln!(f, "scheme          {}", metadata.scheme)?;
        writeln!(
            f,
            "bounds          {west:.6}, {south:.6}, {east:.6}, {north:.6} (west, south, east, north)"
        )?;
        writeln!(f, "heights         {lowest} … {highest} m")?;
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

fn print(report: &(impl Serialize + Display), json: bool) -> Result<(), Failure> {
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
