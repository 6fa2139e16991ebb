//! The main job: a raster becomes a nested pyramid of certified tiles in one archive.
//!
//! ```text
//! samples ← the rasters, read once, chunk by chunk           chunks.rs
//! relief  ← blocks of samples with bounds, level by level
//! plan    ← lattice and errors                               plan.rs
//! for each tile, depth first, whatever the store lacks:      scheduler.rs
//!     leaf   ← samples, sides                                jobs.rs
//!     parent ← its children, relief, sides
//! archive ← all tiles in order                               finished.rs
//! ```
//! Many machines can share the work (graph.rs), and an archive of which rasters change is updated (update.rs).
//! Every job is a pure function of named inputs, and what it makes is kept in a [`Store`]: a build that was killed goes on where
//! it was.

mod depths;
mod family;
mod finished;
mod graph;
mod jobs;
mod plan;
mod recipe;
mod scheduler;
mod update;

use std::fmt;
use std::path::Path;

use anyhow::{Result, ensure};
use serde::Serialize;
use terrain_tiles::archive::Reader;
use terrain_tiles::metadata::{FORMAT, Metadata, OutsidePolicy, Source, VERSION, Zoom};
use terrain_tiles::outside::Outside;

use self::finished::{FinishedTiles, Origin, Summary, TileRecord};
pub use self::graph::{Graph, Job, Stage, StageSize};
use self::jobs::Jobs;
pub use self::plan::Options;
use self::plan::{Plan, Relief};
pub use self::recipe::{Recipe, options_of};
use self::scheduler::Scheduler;
pub use self::update::{Changes, Update};
use crate::globe::Seen;
use crate::outside;
use crate::progress::Progress;
use crate::raster::{ReadError, SeaLevel};
use crate::samples::{Raster, Samples, Window};
use crate::store::Store;
use crate::stored_raster::{StoredRaster, TakeError};
use crate::tin::bound_name;

/// The stages of a build and their shares of the work, as measured on an SRTM tile.
const SHARES: [(&str, f64); 3] = [("reading samples", 0.04), ("bounding blocks", 0.04), ("tiles", 0.92)];
/// Cells around a pole in which all samples have to be there, if it is among them.
const CLEAR_OF_POLE: usize = 3;
/// How many of the slowest tiles a report names.
const SLOWEST: usize = 5;

/// What was built.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The archive's own description.
    pub metadata: Metadata,
    /// Bytes of all tiles.
    pub tile_bytes: usize,
    /// The leaves that could not be made as good as was asked.
    pub beyond: Option<Beyond>,
    /// What was made anew, where an archive was updated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub update: Option<Update>,
    /// The tiles that took longest of those made by this run, and for how many seconds.
    pub slowest: Vec<(String, f64)>,
}

/// Leaves that claim more than the largest error that was asked for.
#[derive(Clone, Debug, Serialize)]
pub struct Beyond {
    /// How many.
    pub tiles: usize,
    /// The worst of them, `zoom/x/y`.
    pub worst: String,
    /// What it claims, metres.
    pub error: f64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "zoom  tiles  triangles  error, finest … coarsest level")?;
        for zoom in self.metadata.zooms.iter().rev() {
            let Zoom {
                zoom,
                tiles,
                triangles,
                finest_error,
                coarsest_error,
                ..
            } = zoom;
            writeln!(
                f,
                "{zoom:>4}  {tiles:>5}  {triangles:>9}  {finest_error:.2} … {coarsest_error:.2} m"
            )?;
        }
        let slowest: Vec<String> = self
            .slowest
            .iter()
            .map(|(tile, seconds)| format!("{tile} ({seconds:.1} s)"))
            .collect();
        if !slowest.is_empty() {
            writeln!(f, "slowest tiles: {}", slowest.join(", "))?;
        }
        if let Some(update) = &self.update {
            writeln!(f, "{update}")?;
        }
        write!(f, "{:.1} MB of tiles", self.tile_bytes as f64 / 1e6)?;
        if let Some(Beyond { tiles, worst, error }) = &self.beyond {
            let asked = self.metadata.max_error;
            let are = if *tiles == 1 { "tile" } else { "tiles" };
            write!(
                f,
                "\n{tiles} {are} could not keep {asked} m; the worst, {worst}, claims {error:.3} m"
            )?;
        }
        Ok(())
    }
}

/// Why nothing was built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The rasters cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// There is nothing to build from.
    #[error("{0}: no four neighbouring samples are all valid, so there is no surface")]
    NoSurface(String),
    /// An outline would go around a pole so closely that it is bent beyond recognition on the map.
    #[error("{0}: the raster ends, or has a void, within {CLEAR_OF_POLE} cells of the pole, where no surface may end")]
    EndsAtPole(String),
    /// Anything else, like a full disk.
    #[error(transparent)]
    Other(#[from] anyhow::Error),
}

impl From<TakeError> for BuildError {
    fn from(error: TakeError) -> Self {
        match error {
            TakeError::Read(error) => Self::Read(error),
            TakeError::Store(error) => Self::Other(error),
        }
    }
}

/// What an archive is built of, and with.
#[derive(Clone, Copy)]
pub struct Build<'a> {
    /// The rasters.
    pub raster: &'a dyn Raster,
    /// What is asked for.
    pub options: &'a Options,
    /// Where finished work is kept; what is there already is not made again.
    pub store: &'a Store,
    /// An archive of other rasters or of the same, of which tiles are taken that are good still.
    pub earlier: Option<&'a Reader>,
    /// Is told how far it is.
    pub progress: &'a Progress,
}

impl<'a> Build<'a> {
    /// Builds the archive at `output`, all at once or not at all.
    ///
    /// # Errors
    /// When rasters cannot be read or have no surface, or the store or the archive cannot be written.
    pub fn run(self, output: &Path) -> Result<Report, BuildError> {
        self.check()?;
        self.progress.job(&SHARES);
        let seen = Seen::new(self.raster);
        let stored = self.take_samples(seen.raster())?;
        self.check_pole(&stored)?;
        stored.chunks.make_relief(self.progress)?;
        let scheduler = self.scheduler(&stored, true)?;
        let roots = scheduler.jobs.plan.roots();
        let leaves = roots.iter().map(|&root| scheduler.count_leaves(root)).sum();
        self.progress.stage("tiles", leaves);
        let mut records = Vec::new();
        for root in roots {
            records.extend(scheduler.tiles(root)?);
        }
        self.progress.done();
        self.write(&stored, &scheduler, records, output)
    }

    fn check(&self) -> Result<()> {
        let is_sound = |error: f64| error.is_finite() && error > 0.0;
        ensure!(
            self.options.max_error.is_none_or(is_sound),
            "the largest error must be more than 0 m"
        );
        Ok(())
    }

    /// Holds that no outline is close to a pole that is among the samples.
    fn check_pole(&self, stored: &StoredRaster) -> Result<(), BuildError> {
        let Some(pole) = stored.georeference.pole_among_samples() else {
            return Ok(());
        };
        let side = 2 * CLEAR_OF_POLE + 1;
        let first = pole.round().as_i64vec2() - CLEAR_OF_POLE as i64;
        let window = if first.min_element() < 0 {
            None
        } else {
            let [column, row] = first.to_array().map(|first| first as usize);
            Some(stored.chunks.window(column..column + side, row..row + side)?)
        };
        let is_there = |window: Window| {
            window.heights.len() == side * side && !window.heights.iter().any(|height| height.is_nan())
        };
        if window.is_some_and(is_there) {
            return Ok(());
        }
        let first = self.raster.provenance().files.into_iter().next();
        Err(BuildError::EndsAtPole(first.unwrap_or_default()))
    }

    fn take_samples(&self, raster: &dyn Raster) -> Result<StoredRaster, TakeError> {
        StoredRaster::take(raster, self.store, self.options.memory, self.progress)
    }

    fn scheduler<'b>(&self, stored: &'b StoredRaster, makes_tiles: bool) -> Result<Scheduler<'b>>
    where
        'a: 'b,
    {
        let [lowest, highest] = stored.heights;
        let relief = Relief {
            steepest_step: stored.chunks.steepest()?.into(),
            farthest_height: lowest.abs().max(highest.abs()).into(),
        };
        let (georeference, size) = stored.of_samples();
        let seen = Seen::new(self.raster);
        let plan = Plan::new(seen.raster(), &georeference, size, relief, self.options);
        Ok(Scheduler {
            jobs: Jobs::new(plan, stored, &self.raster.provenance().breaklines),
            tiles: FinishedTiles {
                store: self.store,
                archive: self.earlier,
            },
            progress: self.progress,
            makes_tiles,
        })
    }

    fn write(
        &self,
        stored: &StoredRaster,
        scheduler: &Scheduler,
        mut records: Vec<TileRecord>,
        output: &Path,
    ) -> Result<Report, BuildError> {
        if records.is_empty() {
            let first = self.raster.provenance().files.into_iter().next();
            return Err(BuildError::NoSurface(first.unwrap_or_default()));
        }
        let plan = &scheduler.jobs.plan;
        let outside = self.outside(scheduler, &records)?;
        let describe = |summary: &Summary| self.metadata(stored, plan, summary, outside);
        let (metadata, summary) = scheduler.tiles.write_archive(&mut records, output, describe)?;
        Ok(Report {
            metadata,
            tile_bytes: summary.tile_bytes,
            beyond: beyond(plan, &summary),
            update: self.earlier.map(|earlier| Update::new(earlier, plan, &records)),
            slowest: slowest(records),
        })
    }

    /// What is drawn where nothing was measured.
    fn outside(&self, scheduler: &Scheduler, records: &[TileRecord]) -> Result<Outside, BuildError> {
        let provenance = self.raster.provenance();
        Ok(match self.options.outside {
            OutsidePolicy::Ellipsoid => Outside::Ellipsoid,
            OutsidePolicy::Extend => Outside::Extend {
                field: outside::extended(&scheduler.tiles.outline(records)?, scheduler.jobs.plan.bounds),
            },
            OutsidePolicy::Geoid if provenance.heights_above.contains("ellipsoid") => {
                let geoid = SeaLevel::new("--outside geoid", provenance.overrides.vertical.geoid.as_deref())?;
                Outside::Geoid {
                    field: outside::sea_level(|longitude, latitude| geoid.height(longitude, latitude)),
                }
            }
            // Heights that are above the sea are 0 there.
            OutsidePolicy::Geoid => Outside::Ellipsoid,
        })
    }

    fn metadata(&self, stored: &StoredRaster, plan: &Plan, summary: &Summary, outside: Outside) -> Metadata {
        let provenance = self.raster.provenance();
        let [lowest, highest] = summary.heights;
        let [lowest_sample, highest_sample] = stored.heights.map(f64::from);
        Metadata {
            format: FORMAT.into(),
            version: VERSION,
            scheme: "geographic-tms".into(),
            bounds: plan.bounds,
            heights: [lowest.min(lowest_sample), highest.max(highest_sample)],
            min_zoom: 0,
            max_zoom: plan.lattice.leaf_zoom,
            bound: bound_name(plan.bound).into(),
            max_error: plan.max_error,
            asked: recipe::asked(self.options, &provenance.overrides),
            plan: plan.name.to_string(),
            source: Source {
                files: provenance.files,
                crs: self.raster.georeference().crs_name().into(),
                vertical_datum: provenance.vertical_datum,
                heights_above: provenance.heights_above,
                geoid: provenance.geoid,
                samples: self.raster.size(),
                heights: Some([lowest_sample, highest_sample]),
            },
            generator: concat!("terrain-ingest ", env!("CARGO_PKG_VERSION")).into(),
            zooms: summary.zooms(),
            outside,
            water: provenance.water,
        }
    }
}

fn beyond(plan: &Plan, summary: &Summary) -> Option<Beyond> {
    let leaves = summary.leaves().into_iter();
    let beyond = leaves.filter(|(tile, error)| !plan.keeps_the_error(tile.zoom, *error));
    let (worst, error) = beyond.clone().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Beyond {
        tiles: beyond.count(),
        worst: worst.to_string(),
        error,
    })
}

fn slowest(records: Vec<TileRecord>) -> Vec<(String, f64)> {
    let timed = records.into_iter().filter_map(|record| match record.origin {
        Origin::Made(seconds) => Some((record.square.address().to_string(), seconds)),
        Origin::Store | Origin::Archive => None,
    });
    let mut timed: Vec<(String, f64)> = timed.collect();
    timed.sort_by(|a, b| b.1.total_cmp(&a.1));
    timed.truncate(SLOWEST);
    timed
}
