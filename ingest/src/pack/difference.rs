//! What a pack has that an older one has not, and the pack that both of them make.
//!
//! ```text
//! old pack, new pack ─▶ each file's hash ─▶ a list of all files, and those that changed     write
//! old pack, difference ─▶ each file of the list, from the one or the other, hashed again ─▶ new pack     apply
//! ```
//! Packs that are one file are compared by [`pieces`]; databases as their rows in order, since their pages say where other pages are.

mod pieces;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Component, Path, PathBuf};

use anyhow::Context;
use serde::{Deserialize, Serialize};

use super::folder::{Sum, sums};
use super::mbtiles;
use super::unusable::Unusable;
use super::whole::write_whole;

/// Name of the list, beside the files that changed.
const LIST: &str = "difference.json";
/// Folder of the files that changed.
const FILES: &str = "files";
const FORMAT: &str = "terrain-pack-difference";
const VERSION: u32 = 1;

/// `difference.json`.
#[derive(Serialize, Deserialize)]
struct List {
    format: String,
    version: u32,
    /// Paths of files that are in the difference: they are new, or others than in the old pack.
    changed: BTreeSet<String>,
    /// Paths of files of the old pack that are not in the new one.
    gone: BTreeSet<String>,
    /// All files of the new pack by their paths.
    files: BTreeMap<String, Sum>,
}

/// `difference.json` of a pack that is one file.
#[derive(Serialize, Deserialize)]
struct OneFile {
    format: String,
    version: u32,
    /// Whether the pieces are those of a database's rows.
    rows: bool,
    /// The new pack.
    file: Sum,
}

const FORMAT_OF_FILE: &str = "terrain-pack-file-difference";

/// How two packs differ, in numbers of files; of packs that are one file, in numbers of pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// In both, and the same.
    pub kept: usize,
    /// In the old one alone.
    pub gone: usize,
}

/// Makes of the pack in the folder `new` the difference from the one in the folder `old`, as the folder `output`.
pub(super) fn write(old: &Path, new: &Path, output: &Path) -> anyhow::Result<Difference> {
    let (before, files) = (sums(old)?, sums(new)?);
    let is_changed = |path: &&String| before.get(*path) != files.get(*path);
    let list = List {
        format: FORMAT.to_owned(),
        version: VERSION,
        changed: files.keys().filter(is_changed).cloned().collect(),
        gone: before
            .keys()
            .filter(|path| !files.contains_key(*path))
            .cloned()
            .collect(),
        files,
    };
    fs::create_dir_all(output.join(FILES))?;
    for path in &list.changed {
        let target = output.join(FILES).join(path);
        fs::create_dir_all(target.parent().unwrap_or(output))?;
        fs::rename(new.join(path), target).with_context(|| path.clone())?;
    }
    fs::write(output.join(LIST), serde_json::to_vec_pretty(&list)?)?;
    Ok(Difference {
        kept: list.files.len() - list.changed.len(),
        gone: list.gone.len(),
    })
}

/// Makes of the pack that is the file `new` the difference from the one that is the file `old`, as the folder `output`.
pub(super) fn write_of_file(old: &Path, new: &Path, output: &Path) -> anyhow::Result<Difference> {
    fs::create_dir_all(output)?;
    let rows = mbtiles::is_database(new)?;
    if rows != mbtiles::is_database(old)? {
        return Err(Unusable(format!("{}: is no pack of this format", old.display())).into());
    }
    let work = tempfile::tempdir_in(output)?;
    let flat = |path: &Path, name: &str| -> anyhow::Result<PathBuf> {
        if !rows {
            return Ok(path.to_owned());
        }
        let flat = work.path().join(name);
        mbtiles::flatten(path, &flat)?;
        Ok(flat)
    };
    let [kept, gone] = pieces::write(&flat(old, "old")?, &flat(new, "new")?, output)?;
    let list = OneFile {
        format: FORMAT_OF_FILE.to_owned(),
        version: VERSION,
        rows,
        file: Sum::of_file(new)?,
    };
    fs::write(output.join(LIST), serde_json::to_vec_pretty(&list)?)?;
    work.close()?;
    Ok(Difference { kept, gone })
}

/// Makes the file of the old one and the difference.
fn apply_to_file(list: &OneFile, old: &Path, difference: &Path, output: &Path) -> anyhow::Result<(usize, u64)> {
    write_whole(output, |part| {
        let whole = part.join("whole");
        if list.rows {
            let [before, after] = ["before", "after"].map(|name| part.join(name));
            mbtiles::flatten(old, &before)?;
            pieces::join(&before, difference, &after)?;
            mbtiles::unflatten(&after, &whole)?;
        } else {
            pieces::join(old, difference, &whole)?;
        }
        let made = Sum::of_file(&whole)?;
        if made != list.file {
            let reason = format!("{}: is not the pack that the difference was made with", old.display());
            return Err(Unusable(reason).into());
        }
        Ok((whole, (1, made.bytes)))
    })
}

/// Makes the pack `output`, which must not be there yet, of an `old` one and the `difference` of a newer one from that. Gives how many
/// files it has, and their bytes.
///
/// # Errors
/// [`Unusable`] where the difference is not one from this old pack; where files cannot be read or written.
pub fn apply(old: &Path, difference: &Path, output: &Path) -> anyhow::Result<(usize, u64)> {
    let path = difference.join(LIST);
    if let Some(list) = read_of_file(&path)? {
        if !old.is_file() {
            return Err(Unusable(format!("{}: is no file", old.display())).into());
        }
        return apply_to_file(&list, old, difference, output);
    }
    let list = read(&path)?;
    write_whole(output, |part| {
        let whole = part.join("whole");
        for path in list.files.keys() {
            let changed = difference.join(FILES);
            let from = if list.changed.contains(path) { &changed } else { old };
            let target = whole.join(path);
            fs::create_dir_all(target.parent().unwrap_or(&whole))?;
            let source = from.join(path);
            fs::copy(&source, target).map_err(|error| Unusable(format!("{}: {error}", source.display())))?;
        }
        let made = sums(&whole)?;
        let wrong = list.files.iter().find(|(path, sum)| made.get(*path) != Some(*sum));
        if let Some((path, _)) = wrong {
            let reason = format!("{path}: is not the file that the difference was made with");
            return Err(Unusable(reason).into());
        }
        let bytes = made.values().map(|sum| sum.bytes).sum();
        Ok((whole, (made.len(), bytes)))
    })
}

/// None where it is a difference of folders, or anything else.
fn read_of_file(path: &Path) -> Result<Option<OneFile>, Unusable> {
    let bytes = fs::read(path).map_err(|error| Unusable(format!("{}: {error}", path.display())))?;
    let list = serde_json::from_slice::<OneFile>(&bytes).ok();
    Ok(list.filter(|list| list.format == FORMAT_OF_FILE && list.version == VERSION))
}

fn read(path: &Path) -> Result<List, Unusable> {
    let unreadable = |reason: String| Unusable(format!("{}: {reason}", path.display()));
    let file = File::open(path).map_err(|error| unreadable(error.to_string()))?;
    let list: List = serde_json::from_reader(BufReader::new(file)).map_err(|error| unreadable(error.to_string()))?;
    if list.format != FORMAT || list.version != VERSION {
        return Err(unreadable(format!("is not {FORMAT} version {VERSION}")));
    }
    match list.files.keys().find(|path| !stays_inside(path)) {
        Some(outside) => Err(unreadable(format!("{outside} is no path inside a pack"))),
        None => Ok(list),
    }
}

fn stays_inside(path: &str) -> bool {
    let mut parts = Path::new(path).components();
    !path.is_empty() && parts.all(|part| matches!(part, Component::Normal(_)))
}
