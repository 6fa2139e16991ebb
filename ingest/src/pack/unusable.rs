//! What a person asked for that cannot be had.

/// Options that do not go with an archive, and why.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Unusable(pub(super) String);
