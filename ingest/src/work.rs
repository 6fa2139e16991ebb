//! The folder in which a build keeps its finished work: one build at a time, gone when the archive is whole.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use terrain_ingest::pyramid::{BuildError, Report};
use terrain_ingest::store::Store;

use crate::failure::Failure;

/// The work of one build.
pub(crate) struct Work {
    store: Store,
    /// Nothing was there before.
    is_new: bool,
    /// Held as long as the build goes on.
    _lock: Option<File>,
}

impl Work {
    /// Opens the store at `location`, or beside the output.
    pub(crate) fn begin(location: Option<String>, output: &Path) -> Result<Self, Failure> {
        let location = location.unwrap_or_else(|| format!("{}.work", output.display()));
        let is_new = !Path::new(&location).exists();
        let store = Store::open(&location).map_err(Failure::Other)?;
        let lock = store.folder().map(lock).transpose()?;
        tell_on_interrupt(&store);
        Ok(Self {
            store,
            is_new,
            _lock: lock,
        })
    }

    pub(crate) fn store(&self) -> &Store {
        &self.store
    }

    /// Removes the work where there was none before, for a failure before any of it was done.
    pub(crate) fn abandon(self, failure: Failure) -> Failure {
        match self.is_new.then(|| self.remove()) {
            Some(Err(error)) => error,
            _ => failure,
        }
    }

    fn remove(&self) -> Result<(), Failure> {
        let Some(folder) = self.store.folder() else {
            return Ok(());
        };
        let gone = fs::remove_dir_all(folder).with_context(|| folder.display().to_string());
        gone.map_err(Failure::Other)
    }

    /// Removes the work where it is of no more use, and says how to go on where it is.
    pub(crate) fn end(self, built: Result<Report, BuildError>, keep: bool) -> Result<Report, Failure> {
        let is_of_use = match &built {
            Ok(_) => keep,
            Err(BuildError::Other(_)) => true,
            Err(BuildError::Read(_) | BuildError::NoSurface(_) | BuildError::EndsAtPole(_)) => !self.is_new,
        };
        if !is_of_use {
            self.remove()?;
        }
        let location = self.store.location();
        built.map_err(|error| match error {
            BuildError::Other(error) => Failure::Other(anyhow!(
                "{error:#}; finished work is kept in {location}: the same command goes on from there"
            )),
            error => Failure::Input(error.into()),
        })
    }
}

/// Two builds that write the same work would be in each other's way.
fn lock(folder: &Path) -> Result<File, Failure> {
    let path: PathBuf = folder.join("lock");
    let file = File::create(&path).with_context(|| path.display().to_string());
    let file = file.map_err(Failure::Other)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(_) => Err(Failure::Input(anyhow!(
            "{}: another build is at work here",
            folder.display()
        ))),
    }
}

/// Ctrl-C ends the program at once: what is in the store is whole.
fn tell_on_interrupt(store: &Store) {
    let location = store.location().to_owned();
    let told = ctrlc::set_handler(move || {
        eprintln!("\nstopped; finished work is kept in {location}: the same command goes on from there");
        std::process::exit(130);
    });
    // Without a handler, Ctrl-C ends the program as well; it only says less.
    drop(told);
}
