//! Damaged bytes for decoders: bits flipped one by one, and seeds of the fuzz targets, damaged by chance but the same way each time.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_core::SurfacePartition;
use terrain_core::levels::partition;

/// The files of one target's corpus, in the order of their names.
pub(crate) fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = format!("{}/../fuzz/corpus/{target}", env!("CARGO_MANIFEST_DIR"));
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// Asserts that `decode` finds a Surface Partition or nothing in `bytes` with any one bit flipped.
pub(crate) fn hold_with_flipped_bits(bytes: &[u8], decode: impl Fn(&[u8]) -> Option<SurfacePartition>) {
    for bit in 0..bytes.len() * 8 {
        let mut damaged = bytes.to_vec();
        damaged[bit / 8] ^= 1 << (bit % 8);
        finds_partition(&damaged, &decode);
    }
}

/// Asserts the same of 1000 damaged copies of each seed, and that in most of the 1000 nothing is found.
pub(crate) fn hold_with_damaged_seeds(seeds: &[Vec<u8>], decode: impl Fn(&[u8]) -> Option<SurfacePartition>) {
    for seed in seeds {
        let mut random = fastrand::Rng::with_seed(1);
        let damaged = (0..1000).map(|_| damaged(seed, &mut random));
        let accepted = damaged.filter(|bytes| finds_partition(bytes, &decode)).count();
        assert!(accepted < 700, "{accepted} of 1000 damaged seeds were accepted");
    }
}

/// Whether something is found, which is then a Surface Partition.
fn finds_partition(bytes: &[u8], decode: impl Fn(&[u8]) -> Option<SurfacePartition>) -> bool {
    let found = decode(bytes);
    found
        .iter()
        .for_each(|partition| partition::validate(partition).unwrap());
    found.is_some()
}

/// `seed` with up to four bytes changed, or cut off by chance.
fn damaged(seed: &[u8], random: &mut fastrand::Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..random.usize(1..5) {
        let at = random.usize(..bytes.len());
        bytes[at] = random.u8(..);
    }
    if random.u8(..) < 32 {
        bytes.truncate(random.usize(..bytes.len()));
    }
    bytes
}
