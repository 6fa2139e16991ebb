//! All that a build needs to know, written down in the store: so others can work at it, and it can be made again with other files.

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::Quality;
use terrain_tiles::metadata::Asked;

use super::plan::Options;
use crate::raster::RasterRecord;
use crate::samples::Overrides;
use crate::store::Store;
use crate::tin::bound_name;

/// Where the recipe is in the store.
const KEY: &str = "recipe.json";
/// Counts up when a recipe means another thing than before.
const VERSION: u32 = 1;

/// What is built, and of what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    version: u32,
    asked: Asked,
    bound: String,
    leaves_of_subtree: u32,
    /// The rasters.
    pub raster: RasterRecord,
}

impl Recipe {
    /// A build of some rasters.
    #[must_use]
    pub fn new(raster: RasterRecord, options: &Options) -> Self {
        Self {
            version: VERSION,
            asked: asked(options, &raster.provenance.overrides),
            bound: bound_name(options.bound).to_owned(),
            leaves_of_subtree: options.leaves_of_subtree,
            raster,
        }
    }

    /// What is asked for. `memory` is bytes to stay below, roughly.
    ///
    /// # Errors
    /// When the recipe is one of a newer program.
    pub fn options(&self, memory: u64) -> Result<Options> {
        let options = options_of(&self.asked, &self.bound)?;
        Ok(Options {
            leaves_of_subtree: self.leaves_of_subtree,
            memory,
            ..options
        })
    }

    /// Puts the recipe into a store, over one that is there.
    ///
    /// # Errors
    /// When the store cannot be written.
    pub fn keep(&self, store: &Store) -> Result<()> {
        store.put(KEY, serde_json::to_vec(self)?)
    }

    /// The recipe in a store, if there is one.
    ///
    /// # Errors
    /// When the store cannot be read, or has a recipe of a newer program.
    pub fn find(store: &Store) -> Result<Option<Self>> {
        let Some(bytes) = store.get(KEY)? else { return Ok(None) };
        let place = || format!("{}/{KEY} cannot be read", store.location());
        let recipe: Self = serde_json::from_slice(&bytes).with_context(place)?;
        if recipe.version != VERSION {
            bail!(
                "{}/{KEY} has version {}; this program reads {VERSION}",
                store.location(),
                recipe.version
            );
        }
        Ok(Some(recipe))
    }
}

/// What an archive says it was asked for, as options.
///
/// # Errors
/// When it names what this program does not know.
pub fn options_of(asked: &Asked, bound: &str) -> Result<Options> {
    let bounds = [Bound::Surface, Bound::Samples];
    let qualities = [Quality::Fast, Quality::Default, Quality::Best];
    let known = |what: &str, name: &str| format!("`{name}` is no {what} that this program knows");
    Ok(Options {
        max_error: asked.max_error,
        bound: bounds
            .into_iter()
            .find(|&known| bound_name(known) == bound)
            .with_context(|| known("bound", bound))?,
        quality: qualities
            .into_iter()
            .find(|&known| quality_name(known) == asked.quality)
            .with_context(|| known("quality", &asked.quality))?,
        outside: asked.outside,
        ..Options::default()
    })
}

/// What is asked for, as an archive says it.
pub(crate) fn asked(options: &Options, overrides: &Overrides) -> Asked {
    Asked {
        max_error: options.max_error,
        quality: quality_name(options.quality).to_owned(),
        crs: overrides.crs.clone(),
        bounds: overrides.bounds,
        vertical: overrides.vertical.clone(),
        reading: overrides.reading.clone(),
        outside: options.outside,
    }
}

fn quality_name(quality: Quality) -> &'static str {
    match quality {
        Quality::Fast => "fast",
        Quality::Default => "default",
        Quality::Best => "best",
    }
}
