//! What the documents say of the source tree is so.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use terrain_tests::{files_below, workspace};

/// Words between back-quotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.lines().flat_map(|line| line.split('`').skip(1).step_by(2))
}

/// Source files of all crates, from the top folder.
fn sources() -> BTreeSet<String> {
    let crates = ["core", "codec", "tiles", "ingest", "server", "fuzz", "tests"].map(|name| workspace().join(name));
    let folders = crates
        .iter()
        .flat_map(|name| ["src", "tests"].map(|inside| name.join(inside)));
    let files = folders
        .filter(|folder| folder.exists())
        .flat_map(|folder| files_below(&folder));
    let from_top = |path: &Path| path.strip_prefix(workspace()).unwrap().to_str().unwrap().to_owned();
    let sources = files.filter(|path| path.extension().is_some_and(|extension| extension == "rs"));
    sources.map(|path| from_top(&path)).collect()
}

/// The section of `docs/architecture.md` under a heading.
fn section(heading: &str) -> String {
    let text = fs::read_to_string(workspace().join("docs/architecture.md")).unwrap();
    let (_, after) = text.split_once(&format!("\n## {heading}\n")).unwrap();
    after.split("\n## ").next().unwrap().to_owned()
}

#[test]
fn files_that_documents_name_are_there() {
    let sources = sources();
    let documents = ["README.md", "docs/architecture.md", "docs/performance.md"];
    let mut count = 0;
    for document in documents {
        let text = fs::read_to_string(workspace().join(document)).unwrap();
        for name in quoted(&text).filter(|word| word.ends_with(".rs")) {
            let is_there = sources
                .iter()
                .any(|file| file == name || file.ends_with(&format!("/{name}")));
            assert!(is_there, "{document} names {name}");
            count += 1;
        }
    }
    assert!(count > 10, "{count} names of files were found");
}

#[test]
fn the_module_map_has_every_module_and_no_other() {
    let map = section("Crates and modules");
    let is_word = |word: &&str| {
        !word.is_empty()
            && word
                .chars()
                .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    let rows: String = map
        .lines()
        .filter(|line| line.starts_with("| `"))
        .collect::<Vec<_>>()
        .join("\n");
    let named: BTreeSet<&str> = quoted(&map).filter(is_word).collect();
    let sources = sources();
    let modules: BTreeSet<&str> = sources.iter().filter_map(|file| module(file)).collect();
    let missing: Vec<_> = modules.difference(&named).collect();
    assert!(missing.is_empty(), "the map lacks {missing:?}");
    let strange: Vec<_> = quoted(&rows).filter(|word| !modules.contains(word)).collect();
    assert!(strange.is_empty(), "the map has {strange:?}, which are no modules");
}

/// The module of a file that belongs in the map: those at the top of a crate, and in `core` those of its wings.
fn module(file: &str) -> Option<&str> {
    let (name, inside) = file.split_once("/src/")?;
    let depth = if name == "core" { 2 } else { 1 };
    let stem = inside.strip_suffix(".rs")?;
    let is_in_map = ["core", "codec", "tiles", "ingest", "server"].contains(&name)
        && stem.split('/').count() <= depth
        && !stem.ends_with("_tests")
        && !["lib", "main"].contains(&stem);
    is_in_map.then(|| stem.rsplit('/').next())?
}
