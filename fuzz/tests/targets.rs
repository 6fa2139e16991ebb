//! Every fuzz target over its seeds and over damaged copies of them, the same each time.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

use terrain_fuzz::TARGETS;

/// Damaged copies of each seed.
const COPIES: usize = 2000;

/// What is in a folder of this crate, in the order of the names.
fn listed(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    paths
}

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let paths = listed(&format!("corpus/{target}"));
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// Up to four bytes changed, and a piece cut out of one copy in eight or doubled in another.
fn damaged(seed: &[u8], random: &mut fastrand::Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..random.usize(1..5) {
        let at = random.usize(..bytes.len());
        bytes[at] = random.u8(..);
    }
    let from = random.usize(..bytes.len());
    let piece = from..random.usize(from..=bytes.len());
    match random.u8(..8) {
        0 => drop(bytes.drain(piece)),
        1 => bytes.extend_from_within(piece),
        _ => {}
    }
    bytes
}

#[test]
fn each_target_has_a_program_and_seeds() {
    let names = TARGETS.map(|(name, _)| name);
    for folder in ["fuzz_targets", "corpus"] {
        let listed = listed(folder);
        let stems: Vec<_> = listed
            .iter()
            .map(|path| path.file_stem().unwrap().to_str().unwrap())
            .collect();
        assert_eq!(stems, names, "in {folder}");
    }
}

#[test]
fn seeds_are_decoded() {
    for (name, run) in TARGETS {
        for (index, seed) in seeds(name).iter().enumerate() {
            assert!(run(seed), "seed {index} of {name}");
        }
    }
}

#[test]
fn damaged_seeds_are_decoded_to_what_stands_its_checks_or_refused() {
    for (name, run) in TARGETS {
        let mut random = fastrand::Rng::with_seed(1);
        let copies = seeds(name);
        let damaged = copies
            .iter()
            .flat_map(|seed| std::iter::repeat_n(seed, COPIES))
            .map(|seed| damaged(seed, &mut random));
        let decoded = damaged.filter(|bytes| run(bytes)).count();
        let all = copies.len() * COPIES;
        assert!(
            decoded < all * 7 / 10,
            "{name}: {decoded} of {all} damaged seeds were decoded"
        );
    }
}
