//! The command that writes packs.

use std::fmt::{self, Display};
use std::time::Instant;

use anyhow::anyhow;
use serde::Serialize;
use terrain_ingest::pack::{self, Choice, Report, Unusable};
use terrain_tiles::archive::Reader;

use super::shared::{prepare, print_finished};
use crate::cli::PackArgs;
use crate::failure::Failure;

pub(super) fn write_pack(arguments: &PackArgs) -> Result<(), Failure> {
    let started = Instant::now();
    prepare(&arguments.run)?;
    let archive = Reader::open(&arguments.archive).map_err(|error| Failure::Input(error.into()))?;
    if arguments.output.exists() {
        return Err(Failure::Input(anyhow!(
            "{}: it is there already",
            arguments.output.display()
        )));
    }
    let choice = Choice {
        bbox: arguments.bbox,
        max_zoom: arguments.max_zoom,
        max_error: arguments.max_error,
    };
    let report = pack::write(&archive, arguments.format(), &choice, &arguments.output).map_err(|error| {
        if error.is::<Unusable>() {
            Failure::Input(error)
        } else {
            Failure::Other(error)
        }
    })?;
    print_finished(Written(report), &arguments.output, started, arguments.run.json)
}

/// A report in words.
#[derive(Serialize)]
struct Written(Report);

impl Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Report { tiles, files, bytes } = self.0;
        write!(f, "{tiles} tiles in {files} files, {bytes} bytes")
    }
}
