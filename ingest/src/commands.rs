//! What the commands do: read, call the library, print a report.

mod checks;
mod models;
mod packs;
mod shared;

use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;
use terrain_ingest::pyramid::{Build, BuildError, Changes, Graph, Recipe, Report, StageSize};
use terrain_ingest::raster::RasterRecord;
use terrain_ingest::samples::Overrides;
use terrain_ingest::store::Store;
use terrain_ingest::{peak_memory, pyramid};
use terrain_tiles::archive::Reader;
use terrain_tiles::metadata::HeightsAbove;

use self::checks::{check, info};
use self::models::{curve, simplify_model, triangulate};
use self::packs::{apply_difference, write_pack};
use self::shared::{check_output, has_extension, memory, open, overrides, prepare, print, print_finished};
use crate::cli::{BuildArgs, Cli, Command, JobArgs, MergeArgs, PlanArgs, RunArgs, TileArgs, UpdateArgs};
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
        Some(Command::Pack(arguments)) => write_pack(&arguments),
        Some(Command::Apply(arguments)) => apply_difference(&arguments),
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
        overrides(
            arguments.raster,
            arguments.tiles.surface.breaklines.clone(),
            HeightsAbove::Ellipsoid,
        ),
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
        reading: of_archive.asked.reading.clone(),
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
        overrides(
            arguments.raster,
            arguments.tiles.surface.breaklines.clone(),
            HeightsAbove::Ellipsoid,
        ),
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

fn options(tiles: &TileArgs, run: &RunArgs) -> pyramid::Options {
    pyramid::Options {
        max_error: tiles.max_error,
        bound: tiles.surface.bound.into(),
        quality: tiles.surface.quality.into(),
        outside: tiles.outside.into(),
        memory: memory(run),
        ..pyramid::Options::default()
    }
}

/// The raster's name with `.pmtiles`, in the current folder; `N48W125.hgt.zip` becomes `N48W125.pmtiles`.
fn default_output(dem: &Path) -> PathBuf {
    let name = PathBuf::from(dem.file_name().unwrap_or_default());
    let is_zip = has_extension(&name, &["zip"]);
    let name = if is_zip { name.with_extension("") } else { name };
    name.with_extension("pmtiles")
}
