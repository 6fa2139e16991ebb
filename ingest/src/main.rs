//! The command line `terrain-ingest`: parses, calls the library, prints, and turns failures into exit codes.

mod cli;
mod commands;
mod failure;
mod work;

use std::process::ExitCode;

use failure::Failure;

fn main() -> ExitCode {
    match commands::run(cli::Cli::of_arguments()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Violation) => ExitCode::from(1),
        Err(Failure::Input(error)) => fail(&error, 2),
        Err(Failure::Other(error)) => fail(&error, 1),
    }
}

/// One line, causes after colons.
fn fail(error: &anyhow::Error, code: u8) -> ExitCode {
    let message = format!("{error:#}");
    eprintln!("error: {}", message.split_whitespace().collect::<Vec<_>>().join(" "));
    ExitCode::from(code)
}
