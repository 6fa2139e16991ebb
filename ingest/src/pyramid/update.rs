//! An archive whose rasters change: which files it is made of then, and what was made anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use serde::Serialize;
use terrain_codec::address::TileAddress;
use terrain_tiles::archive::Reader;

use super::finished::{Origin, TileRecord};
use super::plan::Plan;
use crate::raster::file_name;

/// Rasters of an archive that are others now.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// In the place of files of the same names.
    pub changed: Vec<PathBuf>,
    /// After all others.
    pub added: Vec<PathBuf>,
    /// Names, with or without a folder.
    pub removed: Vec<PathBuf>,
}

impl Changes {
    /// The files of an archive after the changes. Those that stay are where `locate` finds their names.
    ///
    /// # Errors
    /// When a name is not one of the archive's, or stands for two, or a file is not found.
    pub fn applied(&self, files: &[String], locate: impl Fn(&str) -> Option<PathBuf>) -> Result<Vec<PathBuf>> {
        let mut names = BTreeSet::new();
        for name in files {
            ensure!(
                names.insert(name),
                "two of the archive's files are called {name}: build it anew"
            );
        }
        let changed = self.named(&self.changed, &names)?;
        let removed = self.named(&self.removed, &names)?;
        if let Some(twice) = self.added.iter().find(|path| names.contains(&file_name(path))) {
            bail!(
                "{}: the archive has a file of that name; is it --changed?",
                twice.display()
            );
        }
        let mut paths = Vec::new();
        for name in files.iter().filter(|name| !removed.contains_key(*name)) {
            let found = changed.get(name).cloned().or_else(|| locate(name));
            match found {
                Some(path) => paths.push(path),
                None => bail!(
                    "{name}, which did not change, is needed, too, and was not found: say where it is with --from FOLDER"
                ),
            }
        }
        paths.extend(self.added.iter().cloned());
        ensure!(!paths.is_empty(), "no raster is left");
        Ok(paths)
    }

    /// Paths by their files' names, each of which must be among `names`.
    fn named(&self, paths: &[PathBuf], names: &BTreeSet<&String>) -> Result<BTreeMap<String, PathBuf>> {
        let mut found = BTreeMap::new();
        for path in paths {
            let name = file_name(path);
            ensure!(
                names.contains(&name),
                "{}: the archive is made of no file of that name, but of {}",
                path.display(),
                names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(", ")
            );
            if let Some(other) = found.insert(name, path.clone()) {
                bail!("{} and {} stand for the same file", other.display(), path.display());
            }
        }
        Ok(found)
    }
}

/// What an update came to, in tiles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Update {
    /// Taken as they were.
    pub kept: usize,
    /// Leaves made anew because samples under them or just beside them are others.
    pub changed_leaves: usize,
    /// Leaves where there were none.
    pub new_leaves: usize,
    /// Tiles above the leaves made anew because tiles below them are others.
    pub above: usize,
    /// Tiles above the leaves made anew because samples just beside them are others.
    pub beside: usize,
    /// Tiles of which no sample is left.
    pub removed: usize,
    /// All tiles had to be made anew: the lattice or an option is another, or the program makes other tiles by now.
    pub is_other_plan: bool,
}

impl Update {
    pub(super) fn new(earlier: &Reader, plan: &Plan, records: &[TileRecord]) -> Self {
        let before: BTreeSet<TileAddress> = earlier.addresses().collect();
        let now: BTreeSet<TileAddress> = records.iter().map(|record| record.square.address()).collect();
        let is_kept = |record: &TileRecord| record.origin == Origin::Archive;
        let others: BTreeSet<TileAddress> = records
            .iter()
            .filter(|record| !is_kept(record))
            .map(|record| record.square.address())
            .collect();
        let count = |is_of: &dyn Fn(&TileRecord) -> bool| records.iter().filter(|record| is_of(record)).count();
        let is_leaf = |record: &TileRecord| plan.depths.is_leaf(record.square);
        let is_new = |record: &TileRecord| !before.contains(&record.square.address());
        let is_above = |record: &TileRecord| {
            let below = record.square.children().map(|child| child.address());
            below
                .iter()
                .any(|child| others.contains(child) || (before.contains(child) && !now.contains(child)))
        };
        let is_other = |record: &TileRecord| !is_kept(record);
        Self {
            kept: count(&is_kept),
            changed_leaves: count(&|record| is_other(record) && is_leaf(record) && !is_new(record)),
            new_leaves: count(&|record| is_other(record) && is_leaf(record) && is_new(record)),
            above: count(&|record| is_other(record) && !is_leaf(record) && is_above(record)),
            beside: count(&|record| is_other(record) && !is_leaf(record) && !is_above(record)),
            removed: before.difference(&now).count(),
            is_other_plan: earlier.metadata().plan != plan.name.to_string(),
        }
    }
}

impl fmt::Display for Update {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rebuilt = self.changed_leaves + self.new_leaves + self.above + self.beside;
        write!(f, "rebuilt {rebuilt} of {} tiles", rebuilt + self.kept)?;
        if self.is_other_plan {
            write!(
                f,
                ": the lattice or the way tiles are made is another, so that none could be kept"
            )?;
        } else {
            let reasons = [
                (self.changed_leaves, "whose samples changed"),
                (self.new_leaves, "where there were none"),
                (self.above, "above those"),
                (self.beside, "beside changed samples"),
            ];
            let told: Vec<String> = reasons
                .into_iter()
                .filter(|&(count, _)| count > 0)
                .map(|(count, reason)| format!("{count} {reason}"))
                .collect();
            if !told.is_empty() {
                write!(f, ": {}", told.join(", "))?;
            }
        }
        if self.removed > 0 {
            write!(f, "; {} are gone", self.removed)?;
        }
        Ok(())
    }
}
