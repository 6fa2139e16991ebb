//! Seeds of the fuzz targets, damaged by chance but the same way each time.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

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

/// In how many of 1000 damaged copies of `seed` a decoder finds something.
pub(crate) fn accepted(seed: &[u8], decode: impl Fn(&[u8]) -> Option<()>) -> usize {
    let mut random = fastrand::Rng::with_seed(1);
    (0..1000).filter_map(|_| decode(&damaged(seed, &mut random))).count()
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
