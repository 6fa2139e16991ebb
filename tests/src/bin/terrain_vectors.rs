//! `terrain-vectors FILE.json -o ACTUAL.json`: answers a test vector with the product's own code.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use terrain_tests::vectors;

/// Fills the `expected` keys of a test vector from its inputs.
#[derive(Parser)]
struct Arguments {
    /// The vector, a JSON file.
    file: PathBuf,
    /// Where the answer goes.
    #[arg(short, long)]
    output: PathBuf,
}

fn main() -> Result<()> {
    let Arguments { file, output } = Arguments::parse();
    let text = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let vector = serde_json::from_str(&text).with_context(|| file.display().to_string())?;
    let answer = vectors::answer(&vector).with_context(|| file.display().to_string())?;
    let text = serde_json::to_string(&answer).context("the answer cannot be written as JSON")?;
    std::fs::write(&output, text).with_context(|| output.display().to_string())
}
