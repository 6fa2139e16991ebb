//! The commands that write packs.

use std::fmt::{self, Display};
use std::path::Path;
use std::time::Instant;

use anyhow::anyhow;
use serde::Serialize;
use terrain_ingest::pack::{self, Area, Choice, Difference, Report, Unusable};
use terrain_tiles::archive::Reader;

use super::shared::{prepare, print_finished};
use crate::cli::{ApplyArgs, PackArgs};
use crate::failure::Failure;

pub(super) fn write_pack(arguments: &PackArgs) -> Result<(), Failure> {
    let started = Instant::now();
    prepare(&arguments.run)?;
    let archive = Reader::open(&arguments.archive).map_err(|error| Failure::Input(error.into()))?;
    check_new(&arguments.output)?;
    let area = arguments.polygon.as_deref().map(Area::read).transpose();
    let choice = Choice {
        bbox: arguments.bbox,
        area: area.map_err(|error| Failure::Input(error.into()))?,
        max_zoom: arguments.max_zoom,
        max_error: arguments.max_error,
    };
    let (since, output) = (arguments.since.as_deref(), &arguments.output);
    let report = pack::write(&archive, &arguments.format(), &choice, since, output).map_err(blamed)?;
    print_finished(Written(report), output, started, arguments.run.json)
}

pub(super) fn apply_difference(arguments: &ApplyArgs) -> Result<(), Failure> {
    let started = Instant::now();
    prepare(&arguments.run)?;
    check_new(&arguments.output)?;
    let made = pack::apply(&arguments.old, &arguments.difference, &arguments.output);
    let (files, bytes) = made.map_err(blamed)?;
    print_finished(Applied { files, bytes }, &arguments.output, started, arguments.run.json)
}

fn check_new(output: &Path) -> Result<(), Failure> {
    if output.exists() {
        return Err(Failure::Input(anyhow!("{}: it is there already", output.display())));
    }
    Ok(())
}

fn blamed(error: anyhow::Error) -> Failure {
    if error.is::<Unusable>() {
        Failure::Input(error)
    } else {
        Failure::Other(error)
    }
}

/// A report in words.
#[derive(Serialize)]
struct Written(Report);

impl Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Report {
            tiles,
            files,
            bytes,
            difference,
            remark,
        } = &self.0;
        match difference {
            None => write!(f, "{tiles} tiles in {files} files, {bytes} bytes"),
            Some(Difference { kept, gone }) => write!(
                f,
                "{files} files with what changed, {bytes} bytes; {kept} parts of the old pack stay, {gone} are gone"
            ),
        }?;
        remark.iter().try_for_each(|remark| write!(f, "\nnote: {remark}"))
    }
}

/// A pack made of an old one and a difference.
#[derive(Serialize)]
struct Applied {
    files: usize,
    bytes: u64,
}

impl Display for Applied {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} files, {} bytes", self.files, self.bytes)
    }
}
