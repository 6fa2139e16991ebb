//! How the program fails.

/// Why the program ends without success.
pub(crate) enum Failure {
    /// A file or an option that cannot be used: exit code 2.
    Input(anyhow::Error),
    /// A claim that does not hold, already told on standard output: exit code 1.
    Violation,
    /// Anything else, like a full disk: exit code 1.
    Other(anyhow::Error),
}
