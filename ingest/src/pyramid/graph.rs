//! A build as jobs for many machines that share a store: stages one after the other, the jobs of a stage in any order and at
//! the same time. Each may run twice, or be killed and run again.
//!
//! ```text
//! samples/i   a band of the rasters → chunks                  needs the files; all others need the store only
//! relief/i    a part of the blocks above the samples
//! survey/0    the blocks above those: how steep and how high it is
//! tiles/i     a subtree of tiles
//! top/0       the tiles above the subtrees
//! ```
//! The archive is written when all are done ([`Graph::merge`]). Which jobs there are follows from the rasters' sizes and places
//! alone, so that no sample is read before the first job runs.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;

use super::plan::{self, Options};
use super::recipe::Recipe;
use super::{Build, BuildError, Report};
use crate::chunk_grid::ChunkId;
use crate::globe::Seen;
use crate::intake::{Intake, chunks_over_files};
use crate::lattice::Square;
use crate::progress::Progress;
use crate::raster::{Rasters, ReadOptions, RecordedRaster};
use crate::samples::Raster;
use crate::store::Store;
use crate::stored_raster::StoredRaster;

/// Level of the chunks of relief that a job makes with all below them: 8192 × 8192 samples.
const RELIEF_LEVEL: u8 = 5;

/// Jobs that may run at the same time, once those of the stages before are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Samples are read.
    Samples,
    /// Blocks of samples get their bounds.
    Relief,
    /// The uppermost blocks, from which the lattice follows.
    Survey,
    /// Subtrees of tiles.
    Tiles,
    /// The tiles above the subtrees.
    Top,
}

impl Stage {
    /// In the order in which they run.
    pub const ALL: [Self; 5] = [Self::Samples, Self::Relief, Self::Survey, Self::Tiles, Self::Top];

    fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Relief => "relief",
            Self::Survey => "survey",
            Self::Tiles => "tiles",
            Self::Top => "top",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// One job: `tiles/12`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Job {
    /// Its stage.
    pub stage: Stage,
    /// Its number in the stage, from 0 on.
    pub number: usize,
}

impl fmt::Display for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.stage, self.number)
    }
}

impl FromStr for Job {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = text.split_once('/').and_then(|(stage, number)| {
            let stage = Stage::ALL.into_iter().find(|known| known.name() == stage)?;
            let number = number.parse().ok()?;
            Some(Self { stage, number })
        });
        parsed.ok_or_else(|| "is a stage and a number, as tiles/12".to_owned())
    }
}

/// How many jobs a stage has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StageSize {
    /// Which stage.
    pub stage: Stage,
    /// Jobs 0 to `jobs` − 1.
    pub jobs: usize,
}

/// A build that many machines work at.
pub struct Graph<'a> {
    recipe: Recipe,
    raster: RecordedRaster,
    options: Options,
    store: Store,
    progress: &'a Progress,
    /// Chunks of relief, one a job.
    relief: Vec<ChunkId>,
    subtrees: Vec<Square>,
    bands: usize,
}

impl<'a> Graph<'a> {
    /// Writes a recipe into the store.
    ///
    /// # Errors
    /// When the store cannot be written.
    pub fn plan(recipe: Recipe, store: Store, memory: u64, progress: &'a Progress) -> Result<Self> {
        recipe.keep(&store)?;
        Self::new(recipe, store, memory, progress)
    }

    /// The build whose recipe is in the store at a folder or an address. `memory` is bytes that a job is to stay below, roughly.
    ///
    /// # Errors
    /// When there is none.
    pub fn open(location: &str, memory: u64, progress: &'a Progress) -> Result<Self> {
        let nothing = || format!("{location}: nothing is planned here: begin with `plan`");
        let store = Store::find(location)?.with_context(nothing)?;
        let recipe = Recipe::find(&store)?.with_context(nothing)?;
        Self::new(recipe, store, memory, progress)
    }

    fn new(recipe: Recipe, store: Store, memory: u64, progress: &'a Progress) -> Result<Self> {
        let options = recipe.options(memory)?;
        let raster = RecordedRaster::new(recipe.raster.clone(), progress.clone())?;
        let seen = Seen::new(&raster);
        let seen = seen.raster();
        let relief = chunks_over_files(seen, RELIEF_LEVEL);
        let subtrees = plan::subtrees(seen, &options);
        let bands = Intake::new(seen, &store).bands().len();
        Ok(Self {
            relief,
            subtrees,
            bands,
            recipe,
            raster,
            options,
            store,
            progress,
        })
    }

    /// The stages in order, and how many jobs each has.
    #[must_use]
    pub fn stages(&self) -> Vec<StageSize> {
        let size = |stage: Stage| StageSize {
            stage,
            jobs: self.jobs(stage),
        };
        Stage::ALL.map(size).to_vec()
    }

    fn jobs(&self, stage: Stage) -> usize {
        match stage {
            Stage::Samples => self.bands,
            Stage::Relief => self.relief.len(),
            Stage::Tiles => self.subtrees.len(),
            Stage::Survey | Stage::Top => 1,
        }
    }

    /// Runs one job.
    ///
    /// # Errors
    /// When there is no such job, one of the stages before is not done, or the store cannot be read or written.
    pub fn run(&self, job: Job) -> Result<(), BuildError> {
        let count = self.jobs(job.stage);
        if job.number >= count {
            return Err(anyhow!("there is no job {job}: {} has {count}", job.stage).into());
        }
        match job.stage {
            Stage::Samples => self.read_band(job.number),
            Stage::Relief => self.make_relief(self.relief[job.number]),
            Stage::Survey => self.survey(),
            Stage::Tiles => self.make_tiles(Some(self.subtrees[job.number])),
            Stage::Top => self.make_tiles(None),
        }
    }

    fn build(&self) -> Build<'_> {
        Build {
            raster: &self.raster,
            options: &self.options,
            store: &self.store,
            earlier: None,
            progress: self.progress,
        }
    }

    fn read_band(&self, number: usize) -> Result<(), BuildError> {
        let options = ReadOptions {
            overrides: self.raster.provenance().overrides,
            progress: self.progress.clone(),
            ..ReadOptions::default()
        };
        let rasters = Rasters::open(&self.recipe.raster.paths, &options)?;
        if rasters.stamps() != self.raster.stamps() {
            return Err(anyhow!("a raster has changed since the build was planned: plan it again").into());
        }
        let seen = Seen::new(&rasters);
        let intake = Intake::new(seen.raster(), &self.store);
        intake.take(&intake.bands()[number..=number], self.progress)?;
        Ok(())
    }

    fn make_relief(&self, chunk: ChunkId) -> Result<(), BuildError> {
        self.samples()?.chunks.make_chunk(chunk, self.progress)?;
        Ok(())
    }

    fn survey(&self) -> Result<(), BuildError> {
        let stored = self.samples()?;
        self.build().check_pole(&stored)?;
        stored.chunks.make_relief(self.progress)?;
        Ok(())
    }

    /// A subtree, or the tiles above them all.
    fn make_tiles(&self, subtree: Option<Square>) -> Result<(), BuildError> {
        let build = self.build();
        let stored = self.surveyed()?;
        let scheduler = build.scheduler(&stored, true)?;
        let roots = match subtree {
            Some(square) => vec![square],
            None => {
                self.expect(Stage::Tiles, |number| scheduler.has_subtree(self.subtrees[number]))?;
                scheduler.jobs.plan.roots()
            }
        };
        for root in roots {
            scheduler.tiles(root)?;
        }
        Ok(())
    }

    /// Writes the archive when all jobs are done.
    ///
    /// # Errors
    /// When a job is not done, the rasters have no surface, or the store cannot be read or the archive written.
    pub fn merge(&self, output: &Path) -> Result<Report, BuildError> {
        let build = self.build();
        let stored = self.surveyed()?;
        let scheduler = build.scheduler(&stored, false)?;
        self.expect(Stage::Tiles, |number| scheduler.has_subtree(self.subtrees[number]))?;
        let mut records = Vec::new();
        for root in scheduler.jobs.plan.roots() {
            records.extend(scheduler.tiles(root).context("job top/0 has not been done")?);
        }
        build.write(&stored, &scheduler, records, output)
    }

    /// The samples, which all jobs of their stage have brought into the store.
    fn samples(&self) -> Result<StoredRaster, BuildError> {
        let seen = Seen::new(&self.raster);
        let intake = Intake::new(seen.raster(), &self.store);
        let bands = intake.bands();
        self.expect(Stage::Samples, |number| intake.has(&bands[number]))?;
        Ok(self.build().take_samples(seen.raster())?)
    }

    /// The samples with all blocks above them.
    fn surveyed(&self) -> Result<StoredRaster, BuildError> {
        let stored = self.samples()?;
        for chunk in stored.chunks.chunks_of(stored.chunks.top()) {
            if !stored.chunks.is_made(chunk)? {
                return Err(anyhow!("job survey/0 has not been done").into());
            }
        }
        Ok(stored)
    }

    /// Holds that all jobs of a stage are done.
    fn expect(&self, stage: Stage, is_done: impl Fn(usize) -> Result<bool>) -> Result<()> {
        let mut missing = Vec::new();
        for number in 0..self.jobs(stage) {
            if !is_done(number)? {
                missing.push(Job { stage, number }.to_string());
            }
        }
        match missing.as_slice() {
            [] => Ok(()),
            [one] => bail!("job {one} has not been done"),
            [first, .., last] => bail!(
                "{} of the {} jobs of the stage {stage} have not been done: {first} to {last}",
                missing.len(),
                self.jobs(stage)
            ),
        }
    }
}
