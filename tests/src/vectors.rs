//! Answers test vectors: from a vector's inputs, what the product makes of them, under the keys of its `expected`.
//!
//! A vector is one JSON object with `kind`, inputs and `expected`. A few inputs stand inside `expected`; each module
//! below names those it reads, and reads nothing else there.

mod audit;
mod clustering;
mod collapse_validity;
mod counterexample;
mod curved;
mod dag;
mod forest;
mod input;
mod multilevel;
mod partition;

pub use multilevel::text_of_collapses;

use anyhow::{Context, Result, bail};
use serde_json::Value;

/// The vector with its `expected` made anew.
///
/// # Errors
/// Where the kind is not known, or the inputs are not what the kind asks for.
pub fn answer(vector: &Value) -> Result<Value> {
    let kind = vector["kind"].as_str().context("the file has no \"kind\"")?;
    let expected = match kind {
        "partition" => partition::expected(vector)?,
        "dag" => dag::expected(vector)?,
        "collapse_validity" => collapse_validity::expected(vector)?,
        "counterexample" => counterexample::expected(vector)?,
        "multilevel" => multilevel::expected(vector)?,
        "malformed" => multilevel::malformed(vector)?,
        "clustering" => clustering::expected(vector)?,
        "forest_split" => forest::split(vector)?,
        "forest_counts" => forest::all_counts(vector)?,
        "clod_star" => curved::star(vector)?,
        "clod_t" => curved::t(vector)?,
        "clod_swap" => curved::swap(vector)?,
        "clod_tensor" => curved::tensor(vector)?,
        "clod_fit" => curved::fit(vector)?,
        "clod_patterns" => curved::patterns(vector)?,
        _ => bail!("kind {kind:?} is not one that this program answers"),
    };
    let mut answered = vector.clone();
    answered["expected"] = expected;
    Ok(answered)
}
