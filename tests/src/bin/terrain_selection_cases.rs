//! `terrain-selection-cases`: records the cases that Rust and TypeScript select for alike, in `tests/selection/cases.json`.

use anyhow::{Context, Result};
use terrain_tests::selection::{Cases, random};

const PYRAMIDS: usize = 12;
const CASES_EACH: usize = 30;
const SEED: u64 = 15;

fn main() -> Result<()> {
    let cases = random::cases(PYRAMIDS, CASES_EACH, SEED);
    let text = serde_json::to_string(&cases).context("the cases cannot be written as JSON")?;
    let lines = text
        .replace("},{\"pyramid\"", "},\n{\"pyramid\"")
        .replace("},{\"tile\"", "},\n{\"tile\"");
    let path = Cases::path();
    std::fs::write(&path, lines + "\n").with_context(|| path.display().to_string())
}
