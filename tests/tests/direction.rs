//! Dependencies run one way: what `docs/architecture.md` calls invariants, held.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

/// Each crate and the crates of this workspace that it may use.
const ALLOWED: [(&str, &[&str]); 5] = [
    ("terrain-core", &[]),
    ("terrain-tiles", &["terrain-core"]),
    ("terrain-ingest", &["terrain-core", "terrain-tiles"]),
    ("terrain-server", &["terrain-core", "terrain-tiles"]),
    (
        "terrain-tests",
        &["terrain-core", "terrain-tiles", "terrain-ingest", "terrain-server"],
    ),
];

/// Libraries and the only crates that may use them, whatever for.
const HOMES: [(&str, &[&str]); 9] = [
    ("gdal", &["terrain-ingest"]),
    ("proj", &["terrain-ingest"]),
    ("exr", &["terrain-ingest"]),
    // The tests compare what one thread and several write.
    ("rayon", &["terrain-ingest", "terrain-tests"]),
    ("axum", &["terrain-server"]),
    ("pmtiles", &["terrain-tiles"]),
    // Verification reads meshes apart from what it verifies.
    ("ply-rs-bw", &["terrain-tiles", "terrain-ingest"]),
    ("tobj", &["terrain-tiles", "terrain-ingest"]),
    ("clap", &["terrain-ingest", "terrain-server", "terrain-tests"]),
];

/// Direct dependencies of each crate of the workspace, those of its tests and its build included.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(terrain_tests::workspace())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let name = |value: &Value| value["name"].as_str().unwrap().to_owned();
    let packages = metadata["packages"].as_array().unwrap();
    let uses = |package: &Value| package["dependencies"].as_array().unwrap().iter().map(name).collect();
    packages.iter().map(|package| (name(package), uses(package))).collect()
}

#[test]
fn crates_use_only_the_crates_below_them() {
    let dependencies = dependencies();
    assert_eq!(
        dependencies.len(),
        ALLOWED.len(),
        "a crate is missing from the table: {:?}",
        dependencies.keys()
    );
    for (name, allowed) in ALLOWED {
        for used in &dependencies[name] {
            let is_ours = dependencies.contains_key(used);
            assert!(
                !is_ours || allowed.contains(&used.as_str()),
                "{name} must not know {used}"
            );
        }
    }
}

#[test]
fn libraries_stay_in_their_crates() {
    for (name, used) in dependencies() {
        for (library, homes) in HOMES {
            assert!(
                !used.contains(library) || homes.contains(&name.as_str()),
                "{name} must not use {library}"
            );
        }
    }
}
