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
//! Every job is a pure function of named inputs, and what it makes is kept in a [`Store`]: a build that was killed goes on where
//! it was.

mod finished;
mod jobs;
mod plan;
mod scheduler;

use std::fmt;
use std::path::Path;
use std::sync::Mutex;

use anyhow::Result;
use serde::Serialize;
use terrain_tiles::metadata::{FORMAT, Metadata, Source, VERSION, Zoom};

use self::finished::TileRecord;
use self::jobs::Jobs;
pub use self::plan::Options;
use self::plan::{Plan, Relief};
use self::scheduler::Scheduler;
use crate::progress::Progress;
use crate::raster::ReadError;
use crate::samples::Raster;
use crate::store::Store;
use crate::stored_raster::{StoredRaster, TakeError};
use crate::tin::bound_name;

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
    /// The tiles that took longest, and for how many seconds.
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
        writeln!(f, "slowest tiles: {}", slowest.join(", "))?;
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

/// Builds the archive at `output`, all at once or not at all. What is made on the way is kept in `store`; what is there already
/// is not made again.
///
/// # Errors
/// When rasters cannot be read or have no surface, or the store or the archive cannot be written.
pub fn build(
    raster: &dyn Raster,
    options: &Options,
    store: &Store,
    output: &Path,
    progress: &Progress,
) -> Result<Report, BuildError> {
    if options
        .max_error
        .is_some_and(|error| !(error.is_finite() && error > 0.0))
    {
        return Err(anyhow::anyhow!("the largest error must be more than 0 m").into());
    }
    let stored = StoredRaster::take(raster, store, options.memory, progress)?;
    stored.chunks.make_relief()?;
    let [lowest, highest] = stored.heights;
    let relief = Relief {
        steepest_step: stored.chunks.steepest()?.into(),
        farthest_height: lowest.abs().max(highest.abs()).into(),
    };
    let plan = Plan::new(raster.georeference(), raster.size(), relief, options);
    let scheduler = Scheduler {
        jobs: Jobs::new(plan, &stored),
        store,
        progress,
        finished: Mutex::default(),
    };
    let roots = scheduler.jobs.plan.roots();
    progress.stage("tiles", roots.iter().map(|&root| scheduler.count_leaves(root)).sum());
    for root in roots {
        scheduler.tile(root)?;
    }
    progress.done();
    let Scheduler { jobs, finished, .. } = scheduler;
    let mut records = finished.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    if records.is_empty() {
        let first = raster.provenance().files.into_iter().next();
        return Err(BuildError::NoSurface(first.unwrap_or_default()));
    }
    records.sort_by_key(|record| record.square);
    let metadata = metadata(raster, &stored, &jobs.plan, &records);
    let tile_bytes = finished::write_archive(store, &records, &metadata, output)?;
    Ok(Report {
        metadata,
        tile_bytes,
        beyond: beyond(&jobs.plan, &records),
        slowest: slowest(records),
    })
}

fn beyond(plan: &Plan, records: &[TileRecord]) -> Option<Beyond> {
    let leaves = records.iter().filter(|record| plan.height(record.square) == 0);
    let beyond = leaves.filter(|leaf| !plan.keeps_the_error(leaf.claims.finest_error));
    let error = |record: &&TileRecord| record.claims.finest_error;
    let worst = beyond.clone().max_by(|a, b| error(a).total_cmp(&error(b)))?;
    Some(Beyond {
        tiles: beyond.count(),
        worst: worst.square.address().to_string(),
        error: error(&worst),
    })
}

fn slowest(mut records: Vec<TileRecord>) -> Vec<(String, f64)> {
    records.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let told = |record: &TileRecord| (record.square.address().to_string(), record.seconds);
    records.iter().take(SLOWEST).map(told).collect()
}

fn metadata(raster: &dyn Raster, stored: &StoredRaster, plan: &Plan, records: &[TileRecord]) -> Metadata {
    let provenance = raster.provenance();
    let [lowest, highest] = finished::heights(records);
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
        source: Source {
            files: provenance.files,
            crs: raster.georeference().crs_name().into(),
            vertical_datum: provenance.vertical_datum,
            samples: raster.size(),
        },
        generator: concat!("terrain-ingest ", env!("CARGO_PKG_VERSION")).into(),
        zooms: finished::zooms(records),
    }
}
