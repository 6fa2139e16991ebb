//! How a job runs.

use clap::Args;

use super::values::size;

#[derive(Args)]
pub(crate) struct RunArgs {
    /// Threads to use; all cores if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Memory to stay below, roughly, as 800M or 2G; a quarter of the machine's if not given.
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub(crate) memory: Option<u64>,
    /// Show no progress.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Report as JSON on standard output; progress, unless it is quiet, as an event a line on standard error.
    #[arg(long)]
    pub(crate) json: bool,
}
