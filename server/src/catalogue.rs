//! The archives that are served now: files and folders looked at again and again, each archive a generation.
//!
//! ```text
//! files and folders ──look──▶ which file is where ──open what is new──▶ tilesets, put in the others' place at once
//! ```
//! A request keeps the tileset that it began with. A file that was replaced is so read to the end from where it was; bytes of a
//! file that was overwritten do not have their checksums, and the request is begun again with the new generation.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use arc_swap::ArcSwap;
use terrain_tiles::archive::ArchiveError;
use terrain_tiles::shading::Shading;

use crate::remote::{Address, Remote, is_address};
use crate::tileset::Tileset;

/// Shaded surfaces of tiles kept in memory, bytes.
const SHADING_BYTES: u64 = 128 << 20;

/// What ends the name of an archive in a folder.
const ENDING: &str = "pmtiles";

/// All tilesets of one moment, in the order of their names.
pub(crate) type Tilesets = BTreeMap<String, Arc<Tileset>>;

/// The archives that are served now.
pub struct Catalogue {
    sources: Vec<PathBuf>,
    /// Of the sources that are elsewhere.
    addresses: BTreeMap<PathBuf, Address>,
    known: Mutex<BTreeMap<PathBuf, Known>>,
    tilesets: ArcSwap<Tilesets>,
    /// How often these were replaced.
    epoch: AtomicU64,
    /// For all archives.
    shading: Arc<Shading>,
}

/// A file that was looked at.
struct Known {
    identity: Identity,
    /// What it held when it last could be opened.
    tileset: Option<Arc<Tileset>>,
}

/// Changes when what is at a path or an address is replaced or written to.
#[derive(Clone, PartialEq, Eq)]
enum Identity {
    /// Device, inode, length, seconds and nanoseconds of the last change.
    File([u64; 3], [i64; 2]),
    /// Length, seconds of the last change, entity tag.
    Object((u64, i64, Option<String>)),
}

impl Catalogue {
    /// Opens the archives `sources`, which are files, addresses, and folders whose files that end in `.pmtiles` are archives. Blocks:
    /// where there are addresses, on a thread of a runtime where that is no harm.
    ///
    /// # Errors
    /// The first source that cannot be read. In a folder, archives that cannot are passed over, and the log says so.
    pub fn open(sources: Vec<PathBuf>) -> Result<Self, ArchiveError> {
        let addresses = sources.iter().filter(|source| is_address(source)).map(|source| {
            let address = Address::parse(source).map_err(|error| ArchiveError::Io(source.clone(), error))?;
            Ok((source.clone(), address))
        });
        let catalogue = Self {
            addresses: addresses.collect::<Result<_, ArchiveError>>()?,
            sources,
            known: Mutex::default(),
            tilesets: ArcSwap::default(),
            epoch: AtomicU64::default(),
            shading: Arc::new(Shading::new(SHADING_BYTES)),
        };
        for source in &catalogue.sources {
            if !source.is_dir() {
                let found = catalogue.look(source);
                let (identity, remote) = found.map_err(|error| ArchiveError::Io(source.clone(), error))?;
                let tileset = Some(Arc::new(Tileset::open(source, remote, Arc::clone(&catalogue.shading))?));
                catalogue.lock().insert(source.clone(), Known { identity, tileset });
            }
        }
        catalogue.tilesets.store(Arc::new(by_name(&catalogue.lock())));
        catalogue.refresh();
        Ok(catalogue)
    }

    /// Two sources of one name, of which only the first is served.
    #[must_use]
    pub fn twin(&self) -> Option<String> {
        let mut names = BTreeSet::new();
        let known = self.lock();
        let tilesets = known.values().filter_map(|known| known.tileset.as_ref());
        let mut twins = tilesets.filter(|tileset| !names.insert(&tileset.name));
        twins.next().map(|tileset| tileset.name.clone())
    }

    /// Names of all tilesets, sorted.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.tilesets.load().keys().cloned().collect()
    }

    /// Looks at all sources again and opens what is new. What cannot be opened leaves in place what was there; what is gone
    /// is no longer served. Blocks while it reads.
    pub fn refresh(&self) {
        let mut known = self.lock();
        let files = self.files();
        let count = known.len();
        known.retain(|path, _| files.contains(path));
        let mut has_changed = known.len() != count;
        for path in files {
            let (identity, remote) = match self.look(&path) {
                Ok(found) => found,
                Err(error) if self.addresses.contains_key(&path) && error.kind() == io::ErrorKind::NotFound => {
                    has_changed |= known.remove(&path).is_some();
                    continue;
                }
                // A file may have gone since: then the next look tells. What cannot be reached may be there still.
                Err(_) => continue,
            };
            if known.get(&path).is_none_or(|before| before.identity != identity) {
                let before = known.remove(&path).and_then(|before| before.tileset);
                let tileset = self.opened(&path, remote).or(before);
                known.insert(path, Known { identity, tileset });
                has_changed = true;
            }
        }
        if has_changed {
            self.tilesets.store(Arc::new(by_name(&known)));
            // What is found for the number that was read before is at most newer than it says.
            self.epoch.fetch_add(1, Ordering::SeqCst);
            tracing::info!("serving {} archives", self.tilesets.load().len());
        }
    }

    pub(crate) fn tilesets(&self) -> Arc<Tilesets> {
        self.tilesets.load_full()
    }

    /// Changes after the tilesets have.
    pub(crate) fn epoch(&self) -> u64 {
        self.epoch.load(Ordering::SeqCst)
    }

    pub(crate) fn find(&self, name: &str) -> Option<Arc<Tileset>> {
        self.tilesets.load().get(name).cloned()
    }

    fn opened(&self, path: &Path, remote: Option<Remote>) -> Option<Arc<Tileset>> {
        match Tileset::open(path, remote, Arc::clone(&self.shading)) {
            Ok(tileset) => {
                tracing::info!("{}: version {}", path.display(), tileset.version);
                Some(Arc::new(tileset))
            }
            Err(error) => {
                tracing::warn!("{error}");
                None
            }
        }
    }

    /// What is at a path or an address now, by which it is known again, and the object itself where it is elsewhere.
    fn look(&self, path: &Path) -> io::Result<(Identity, Option<Remote>)> {
        if let Some(address) = self.addresses.get(path) {
            let remote = address.look()?;
            return Ok((Identity::Object(remote.identity()), Some(remote)));
        }
        let file = fs::metadata(path)?;
        let identity = Identity::File([file.dev(), file.ino(), file.len()], [file.ctime(), file.ctime_nsec()]);
        Ok((identity, None))
    }

    /// Sources, and files in those that are folders.
    fn files(&self) -> BTreeSet<PathBuf> {
        let mut files = BTreeSet::new();
        for source in &self.sources {
            match fs::read_dir(source) {
                Ok(folder) => files.extend(
                    folder
                        .flatten()
                        .map(|entry| entry.path())
                        .filter(|path| path.extension().is_some_and(|ending| ending == ENDING)),
                ),
                Err(_) if self.addresses.contains_key(source) || source.exists() => drop(files.insert(source.clone())),
                Err(_) => {}
            }
        }
        files
    }

    /// Nothing panics while it is held, and even then what is known of files stays right.
    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<PathBuf, Known>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Of two files of one name the first path has it.
fn by_name(known: &BTreeMap<PathBuf, Known>) -> Tilesets {
    let mut tilesets = Tilesets::new();
    for tileset in known.values().filter_map(|known| known.tileset.as_ref()) {
        if tilesets.contains_key(&tileset.name) {
            tracing::warn!("another archive is called “{}” already", tileset.name);
        } else {
            tilesets.insert(tileset.name.clone(), Arc::clone(tileset));
        }
    }
    tilesets
}

#[cfg(test)]
#[path = "catalogue_tests.rs"]
mod tests;
