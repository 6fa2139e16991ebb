//! Dependencies run one way: what `docs/architecture.md` calls invariants, held, for crates and for the files of each.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use serde_json::Value;
use terrain_tests::source::{Crate, Edge, Target, Use, edges_on_circles};
use terrain_tests::workspace;

/// Each crate and the crates of this workspace that it may use.
const ALLOWED: [(&str, &[&str]); 12] = [
    ("terrain-core", &[]),
    ("terrain-codec", &["terrain-core"]),
    ("terrain-tiles", &["terrain-codec", "terrain-core"]),
    ("terrain-ingest", &["terrain-codec", "terrain-core", "terrain-tiles"]),
    ("terrain-server", &["terrain-codec", "terrain-core", "terrain-tiles"]),
    ("terrain-bindings", &[]),
    ("terrain-decoder", &["terrain-codec", "terrain-core"]),
    ("terrain-model-decoder", &["terrain-codec", "terrain-core"]),
    ("terrain-heights", &["terrain-codec", "terrain-core", "terrain-tiles"]),
    ("terrain-heights-python", &["terrain-heights"]),
    ("terrain-fuzz", &["terrain-codec", "terrain-core"]),
    (
        "terrain-tests",
        &[
            "terrain-codec",
            "terrain-core",
            "terrain-tiles",
            "terrain-ingest",
            "terrain-server",
            "terrain-heights",
        ],
    ),
];

/// Libraries and the files or folders that wrap them: no other file names them.
const HOMES: [(&str, &[&str]); 25] = [
    ("gdal", &["ingest/src/raster"]),
    (
        "exr",
        &["ingest/src/raster/exr_file.rs", "ingest/src/pack/simulator/images.rs"],
    ),
    (
        "tiff",
        &[
            "ingest/src/raster/tiff_file.rs",
            "ingest/src/raster/tiff_file",
            "ingest/src/pack/simulator/images.rs",
            "tests",
        ],
    ),
    ("proj", &["ingest/src/georeference/projection.rs"]),
    (
        "proj_sys",
        &[
            "ingest/src/georeference/operations.rs",
            "ingest/src/georeference/projection.rs",
        ],
    ),
    ("geo", &["ingest/src/pack/area.rs", "tests"]),
    ("pmtiles", &["tiles/src/archive.rs", "tiles/src/tile_file.rs"]),
    (
        "ply_rs_bw",
        &["tiles/src/formats/ply.rs", "ingest/src/verify/mesh_file.rs"],
    ),
    ("tobj", &["tiles/src/formats/obj.rs", "ingest/src/verify/mesh_file.rs"]),
    ("stl_io", &["tiles/src/formats/stl.rs"]),
    ("gltf_json", &["tiles/src/formats/gltf.rs", "tiles/src/formats/gltf"]),
    ("libwebp_sys", &["tiles/src/raster_dem/webp.rs"]),
    (
        "meshopt",
        &[
            "tiles/src/formats/three_d_tiles/compressed.rs",
            "tiles/src/formats/three_d_tiles_tests.rs",
        ],
    ),
    ("base64", &["tiles/src/archive.rs", "tiles/src/formats/gltf/buffers.rs"]),
    ("axum", &["server"]),
    ("wasm_bindgen", &["server/web/decoder", "server/web/model_decoder"]),
    ("wasm_bindgen_cli_support", &["server/web/bindings"]),
    ("numpy", &["heights/python"]),
    ("pyo3", &["heights/python"]),
    ("tokio", &["server", "ingest/src/store.rs"]),
    ("object_store", &["ingest/src/store.rs", "server/src/remote.rs"]),
    // Threads; the tests compare what one and several write.
    ("rayon", &["ingest", "tests"]),
    (
        "spade",
        &[
            "core/src/height_field/triangulate.rs",
            "tiles/src/formats/quantized_mesh/square.rs",
        ],
    ),
    // Programs: their errors and their command lines.
    (
        "anyhow",
        &[
            "ingest",
            "server/src/main.rs",
            "server/src/settings.rs",
            "server/src/models.rs",
            "server/web/bindings",
            "tests",
        ],
    ),
    (
        "clap",
        &[
            "ingest",
            "server/src/main.rs",
            "server/src/settings.rs",
            "tests/src/bin",
        ],
    ),
];

/// All that `core` may use from outside: arithmetic on arrays, maps, what words its errors, and text to JSON values.
const ARITHMETIC: [&str; 20] = [
    "glam",
    "robust",
    "rustc_hash",
    "serde_json",
    "smallvec",
    "spade",
    "std::array",
    "std::cmp",
    "std::collections",
    "std::cell",
    "std::f64",
    "std::fmt",
    "std::hash::Hash",
    "std::iter",
    "std::mem",
    "std::ops",
    "std::slice",
    "std::sync::Arc",
    "std::sync::OnceLock",
    "thiserror",
];

/// What `codec` may use besides: whatever it runs in, a browser too, has to have it.
const OF_CODEC: [&str; 5] = ["flate2", "integer_encoding", "std::io", "std::num", "terrain_core"];

/// The wings of `core` and what each may use besides itself, as `core/src/lib.rs` draws it.
const WINGS: [(&str, &[&str]); 8] = [
    ("mesh", &[]),
    ("selection", &[]),
    ("topology", &["mesh"]),
    ("levels", &["topology", "mesh", "selection"]),
    ("height_field", &["levels", "topology", "mesh"]),
    ("space", &["levels", "topology", "mesh"]),
    ("streaming", &["levels", "topology", "mesh"]),
    ("curved", &["topology", "mesh"]),
];

/// What verification may use of the rest of `ingest`: how a raster is read and where its samples are, and progress.
const BESIDE_VERIFICATION: [&str; 4] = [
    "ingest/src/georeference.rs",
    "ingest/src/height_grid.rs",
    "ingest/src/samples.rs",
    "ingest/src/progress.rs",
];

/// What verification may use of the crates below: data, their own checks, decoders, the ellipsoid, and the selection, of
/// which it draws what is selected; nothing that makes a surface.
const BELOW_VERIFICATION: [&str; 12] = [
    "terrain_core::Mesh",
    "terrain_core::mesh",
    "terrain_core::levels::partition",
    "terrain_core::selection",
    "terrain_codec::address",
    "terrain_tiles::archive::Reader",
    "terrain_codec::LevelLimits",
    "terrain_codec::spt",
    "terrain_codec::ellipsoid",
    "terrain_tiles::metadata",
    "terrain_tiles::pyramid",
    "terrain_codec::tile",
];

/// A crate of the workspace.
struct Package {
    name: String,
    /// From the top folder.
    folder: String,
    /// Direct dependencies, those of its tests and its build included.
    dependencies: BTreeSet<String>,
    /// Everything that the files of its library and programs use.
    uses: BTreeSet<Use>,
}

static PACKAGES: LazyLock<Vec<Package>> = LazyLock::new(|| {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(workspace())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let top = Path::new(metadata["workspace_root"].as_str().unwrap());
    metadata["packages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|package| read(top, package))
        .collect()
});

fn read(top: &Path, package: &Value) -> Package {
    let from_top = |value: &Value| {
        let path = Path::new(value.as_str().unwrap());
        path.strip_prefix(top).unwrap().to_str().unwrap().to_owned()
    };
    let name = |value: &Value| value["name"].as_str().unwrap().to_owned();
    let dependencies: BTreeSet<String> = package["dependencies"].as_array().unwrap().iter().map(name).collect();
    // A program names the library beside it like any other.
    let libraries = dependencies.iter().cloned().chain([name(package)]).collect();
    let is_shipped = |target: &&Value| ["lib", "cdylib", "bin"].contains(&target["kind"][0].as_str().unwrap());
    let roots = package["targets"].as_array().unwrap().iter().filter(is_shipped);
    let uses = roots.flat_map(|target| Crate::read(top, &from_top(&target["src_path"]), &libraries).uses());
    Package {
        name: name(package),
        folder: from_top(&package["manifest_path"]).replace("/Cargo.toml", ""),
        uses: uses.collect(),
        dependencies,
    }
}

fn package(name: &str) -> &'static Package {
    PACKAGES.iter().find(|package| package.name == name).unwrap()
}

/// Every file and path of a library that it names.
fn libraries_named() -> impl Iterator<Item = (&'static str, &'static str)> {
    PACKAGES
        .iter()
        .flat_map(|package| &package.uses)
        .filter_map(|used| match &used.target {
            Target::Library(path) => Some((used.file.as_str(), path.as_str())),
            Target::File(_) => None,
        })
}

/// Every file and another of its crate that it uses.
fn files_used() -> impl Iterator<Item = (&'static str, &'static str)> {
    PACKAGES
        .iter()
        .flat_map(|package| &package.uses)
        .filter_map(|used| match &used.target {
            Target::File(file) => Some((used.file.as_str(), file.as_str())),
            Target::Library(_) => None,
        })
}

/// Whether a path is `top` or below it, of files or of modules.
fn is_below(path: &str, top: &str) -> bool {
    path.strip_prefix(top)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', ':']) || rest == ".rs")
}

fn is_below_any(path: &str, tops: &[&str]) -> bool {
    tops.iter().any(|top| is_below(path, top))
}

#[test]
fn crates_use_only_the_crates_below_them() {
    let names: BTreeSet<&str> = PACKAGES.iter().map(|package| package.name.as_str()).collect();
    assert_eq!(
        names,
        ALLOWED.iter().map(|(name, _)| *name).collect(),
        "the table is not the workspace"
    );
    for (name, allowed) in ALLOWED {
        for used in &package(name).dependencies {
            let is_ours = names.contains(used.as_str());
            assert!(
                !is_ours || allowed.contains(&used.as_str()),
                "{name} must not know {used}"
            );
        }
    }
}

#[test]
fn libraries_stay_in_the_modules_that_wrap_them() {
    for (library, homes) in HOMES {
        let mut found = libraries_named().filter(|(_, path)| is_below(path, library)).peekable();
        assert!(
            found.peek().is_some(),
            "nobody uses {library}, or its name is wrong here"
        );
        for (file, path) in found {
            assert!(is_below_any(file, homes), "{file} must not use {path}");
        }
    }
}

#[test]
fn libraries_stay_in_their_crates_for_tests_too() {
    for package in PACKAGES.iter() {
        for (library, homes) in HOMES {
            let is_home = homes.iter().any(|home| is_below(home, &package.folder));
            assert!(
                is_home || !package.dependencies.contains(&library.replace('_', "-")),
                "{} must not use {library}",
                package.name
            );
        }
    }
}

#[test]
fn core_is_arithmetic_on_arrays() {
    let in_core = libraries_named().filter(|(file, _)| file.starts_with("core/"));
    let outside: Vec<_> = in_core.filter(|(_, path)| !is_below_any(path, &ARITHMETIC)).collect();
    assert_eq!(outside, [], "no file, clock, thread, socket or stream");
}

#[test]
fn codec_needs_nothing_that_a_browser_lacks() {
    let in_codec = libraries_named().filter(|(file, _)| file.starts_with("codec/"));
    let allowed = [ARITHMETIC.as_slice(), &OF_CODEC].concat();
    let outside: Vec<_> = in_codec.filter(|(_, path)| !is_below_any(path, &allowed)).collect();
    assert_eq!(outside, [], "no file, clock, thread or socket");
}

#[test]
fn wings_of_core_use_only_the_wings_below_them() {
    let wing = |file: &str| {
        let inside = file.strip_prefix("core/src/")?;
        Some(inside.split(['/', '.']).next()?.to_owned())
    };
    let wings: BTreeSet<String> = files_used().filter_map(|(_, used)| wing(used)).collect();
    assert_eq!(
        wings,
        WINGS.iter().map(|(name, _)| (*name).to_owned()).collect(),
        "the table is not the crate"
    );
    let table = BTreeMap::from(WINGS);
    let is_upwards = |(file, used): &(&str, &str)| {
        let (Some(from), Some(to)) = (wing(file), wing(used)) else {
            return false;
        };
        from != "lib" && from != to && !table[from.as_str()].contains(&to.as_str())
    };
    let upwards: BTreeSet<_> = files_used().filter(is_upwards).collect();
    assert_eq!(upwards, BTreeSet::new());
}

#[test]
fn no_circles_between_files() {
    for package in PACKAGES.iter() {
        let circles: Vec<Edge> = edges_on_circles(&package.uses);
        assert_eq!(circles, [], "files of {} use each other", package.name);
    }
}

#[test]
fn verification_shares_no_code_with_what_it_verifies() {
    let is_verification = |file: &str| is_below(file, "ingest/src/verify");
    for (file, used) in files_used().filter(|(file, _)| is_verification(file)) {
        let is_allowed = is_verification(used) || BESIDE_VERIFICATION.contains(&used);
        assert!(is_allowed, "{file} must not use {used}");
    }
    for (file, path) in libraries_named().filter(|(file, _)| is_verification(file)) {
        let is_allowed = !path.starts_with("terrain_") || is_below_any(path, &BELOW_VERIFICATION);
        assert!(is_allowed, "{file} must not use {path}");
    }
}
