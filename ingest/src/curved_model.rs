//! Curved models: surfaces of Bézier patches, fitted to polygonal models or read from files of patches, with their levels of
//! detail, which are written all at once, or one of them as triangles.
//!
//! ```text
//! .ply, .obj, .stl, .off, .gltf, .glb ──normals, fit──┐
//! .bez, .bpt, .txt ──two triangles a patch────────────┴─▶ CurvedModel ──simplify──▶ CurvedLevels ──▶ .clod, .json: all levels
//!                                                                       .clod ───────────▲    └─▶ .obj, .ply, .glb: one level,
//!                                                                                                  tessellated
//! ```
//!
//! **What is certified:** every point of the triangles or patches that were read is within a level's error of the level, and the
//! other way round, in the model's units. Level 0 of a polygonal model passes through its vertices, and bends between them as its
//! normals say, by half an error that is asked for at most; tensor-product patches are cut until triangles are near to the pieces.

mod drawn;
mod error;
mod source;

use std::fmt;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result};
use glam::DVec3;
use serde::Serialize;
use serde_json::json;
use terrain_codec::clod::{self, CurvedLimits};
use terrain_core::curved::levels::CurvedLevels;
use terrain_core::curved::simplify::{self, simplify};
use terrain_core::curved::tessellation::Tessellation;
use terrain_tiles::new_file::NewFile;

pub use self::error::CurvedModelError;
use self::source::longest_side;
use crate::polygonal_model::extension;
use crate::progress::Progress;

/// What to make of a model.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The largest error of a patch, in the model's units; any where it is not given.
    pub max_error: Option<f64>,
    /// When to stop simplifying; and of levels that were made before the first that has so few is written.
    pub patches: Option<usize>,
    /// The level to tessellate, 0 being the finest; the coarsest if none is given.
    pub level: Option<usize>,
    /// How far triangles may be from their patches, in the model's units; a thousandth of its longest side if not given.
    pub tolerance: Option<f64>,
    /// The angle in radians from which on an edge between triangles is a crease. If it is given, a file's normals are not used.
    pub crease_angle: Option<f64>,
}

/// One level of what was made.
#[derive(Clone, Debug, Serialize)]
pub struct LevelReport {
    /// 0 is the finest.
    pub level: usize,
    /// Its patches.
    pub patches: usize,
    /// Largest distance from what was read, both ways, in the model's units.
    pub certified_error: f64,
}

/// The triangles that one level became.
#[derive(Clone, Debug, Serialize)]
pub struct TessellationReport {
    /// Which level.
    pub level: usize,
    /// How far they are from its patches at most, in the model's units.
    pub tolerance: f64,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
}

/// What was made.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// All levels, the finest first.
    pub levels: Vec<LevelReport>,
    /// The triangles, where one level was written as such.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tessellation: Option<TessellationReport>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "level   patches  certified error")?;
        for level in &self.levels {
            let (number, error) = (level.level, level.certified_error);
            write!(f, "\n{number:>5} {:>9}  {error:>15.6e}", level.patches)?;
            if self.tessellation.as_ref().is_some_and(|made| made.level == number) {
                write!(f, "  ◀ written")?;
            }
        }
        match &self.tessellation {
            Some(made) => write!(
                f,
                "\n{} triangles, {} vertices, within {:.3e} of level {}",
                made.triangles, made.vertices, made.tolerance, made.level
            ),
            None => Ok(()),
        }
    }
}

/// What is written, by the name of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// All levels, on a lattice.
    Clod,
    /// All levels, as text.
    Json,
    /// One level as triangles.
    Triangles(drawn::Form),
}

impl Form {
    fn of_file(path: &Path) -> Result<Self, CurvedModelError> {
        Ok(match extension(path).as_str() {
            "clod" => Self::Clod,
            "json" => Self::Json,
            "obj" => Self::Triangles(drawn::Form::Obj),
            "ply" => Self::Triangles(drawn::Form::Ply),
            "glb" => Self::Triangles(drawn::Form::Glb),
            _ => return Err(CurvedModelError::UnknownOutput),
        })
    }
}

/// Reads a model, or levels made before, simplifies where it is a model, and writes `output`, all at once or not at all.
///
/// # Errors
/// A [`CurvedModelError`] inside where the input is at fault or the options do not fit it; otherwise where the file cannot be
/// written.
pub fn run(input: &Path, options: &Options, output: &Path, progress: &Progress) -> Result<Report> {
    Form::of_file(output).with_context(|| output.display().to_string())?;
    let levels = leveled(input, options, progress).with_context(|| input.display().to_string())?;
    write(&levels, options, output, progress).with_context(|| input.display().to_string())
}

/// Whether a file is read as a model or as levels, by its name.
#[must_use]
pub fn is_read(input: &Path) -> bool {
    extension(input) == "clod" || source::is_read(input)
}

/// Writes levels, or one of them, to `output`, all at once or not at all.
///
/// # Errors
/// A [`CurvedModelError`] inside where the options do not fit; otherwise where the file cannot be written.
pub fn write(levels: &CurvedLevels, options: &Options, output: &Path, progress: &Progress) -> Result<Report> {
    let form = Form::of_file(output).with_context(|| output.display().to_string())?;
    progress.stage(&format!("writing {}", output.display()), 1);
    let mut report = report(levels);
    let mut file = NewFile::create(output).with_context(|| output.display().to_string())?;
    let mut out = BufWriter::new(file.file());
    match form {
        Form::Clod => out.write_all(&clod::encode(levels, bits(levels, options)).map_err(CurvedModelError::from)?)?,
        Form::Json => write_json(&mut out, levels)?,
        Form::Triangles(form) => {
            let level = chosen(levels, options)?;
            let tolerance = options
                .tolerance
                .unwrap_or_else(|| longest_side(points(levels)) / 1000.0);
            let made = Tessellation::within(&levels.model(level), tolerance).map_err(CurvedModelError::from)?;
            let note = format!(
                "terrain-ingest distance from the model at most {:e}",
                levels.error(level) + tolerance
            );
            drawn::write(&mut out, form, &made, &note)?;
            report.tessellation = Some(TessellationReport {
                level,
                tolerance,
                vertices: made.mesh.positions.len(),
                triangles: made.mesh.triangles.len(),
            });
        }
    }
    out.flush()?;
    drop(out);
    file.finish().with_context(|| output.display().to_string())?;
    progress.advance(1);
    progress.done();
    Ok(report)
}

/// What a `.clod` file says of its levels.
///
/// # Errors
/// Where it is none, or cannot be read.
pub fn info(input: &Path) -> Result<Report> {
    Ok(report(
        &read_levels(input).with_context(|| input.display().to_string())?,
    ))
}

fn read_levels(input: &Path) -> Result<CurvedLevels, CurvedModelError> {
    Ok(clod::decode(&fs::read(input)?, &CurvedLimits::default())?)
}

fn leveled(input: &Path, options: &Options, progress: &Progress) -> Result<CurvedLevels, CurvedModelError> {
    progress.stage("reading", 1);
    if extension(input) == "clod" {
        return read_levels(input);
    }
    let model = source::read(input, options.max_error, options.crease_angle)?;
    progress.advance(1);
    let count = model.patches().len();
    let goal = simplify::Options {
        max_error: options.max_error.unwrap_or(f64::INFINITY) * (1.0 - LATTICE_SHARE),
        patches: options.patches.unwrap_or(0),
        ..simplify::Options::default()
    };
    progress.stage("merging patches", count as u64);
    let mut left = count;
    let levels = simplify(model, &goal, |patches| {
        progress.advance(left.saturating_sub(patches) as u64);
        left = patches;
    });
    Ok(levels)
}

/// Which level becomes triangles.
fn chosen(levels: &CurvedLevels, options: &Options) -> Result<usize, CurvedModelError> {
    let last = levels.len() - 1;
    if let Some(level) = options.level {
        return if level <= last {
            Ok(level)
        } else {
            Err(CurvedModelError::NoSuchLevel { level, last })
        };
    }
    let is_few = |&level: &usize| {
        options
            .patches
            .is_none_or(|patches| levels.patch_count(level) <= patches)
    };
    let is_near = |&level: &usize| options.max_error.is_none_or(|error| levels.error(level) <= error);
    let few = match options.patches {
        Some(_) => (0..=last).find(is_few).unwrap_or(last),
        None => last,
    };
    (0..=few)
        .rev()
        .find(is_near)
        .ok_or(CurvedModelError::NoLevelWithin(options.max_error.unwrap_or_default()))
}

/// The longest side of the model is divided by two to this, or more where an error asks for it.
const FEWEST_BITS: u32 = 20;
/// Share of an error that rounding to the lattice may take, so that what was asked for holds of a file, too.
pub const LATTICE_SHARE: f64 = 1.0 / 64.0;

/// Bits of a lattice that takes a small share of the error that was asked for.
fn bits(levels: &CurvedLevels, options: &Options) -> u32 {
    let side = longest_side(points(levels));
    let is_enough = |bits: &u32| {
        options
            .max_error
            .is_none_or(|error| side / f64::from(*bits).exp2() <= error * LATTICE_SHARE)
    };
    (FEWEST_BITS..clod::MOST_BITS)
        .find(is_enough)
        .unwrap_or(clod::MOST_BITS)
}

fn points(levels: &CurvedLevels) -> impl Iterator<Item = DVec3> {
    levels.level(0).flat_map(|patch| patch.patch.points)
}

fn report(levels: &CurvedLevels) -> Report {
    let level = |level: usize| LevelReport {
        level,
        patches: levels.patch_count(level),
        certified_error: levels.error(level),
    };
    Report {
        levels: (0..levels.len()).map(level).collect(),
        tessellation: None,
    }
}

/// A list of levels and one of patches, each of which says which levels show it.
fn write_json(out: &mut impl Write, levels: &CurvedLevels) -> io::Result<()> {
    let patches = levels.patches().iter().map(|patch| {
        json!({
            "levels": [patch.levels().start, patch.levels().end],
            "corners": patch.corners,
            "creases": patch.creases,
            "error": patch.error,
            "points": patch.patch.points.map(|point| point.to_array()),
        })
    });
    let all = json!({
        "format": "curved levels of detail",
        "order": "300 210 201 120 111 102 030 021 012 003",
        "levels": report(levels).levels,
        "patches": patches.collect::<Vec<_>>(),
    });
    serde_json::to_writer(out, &all).map_err(io::Error::from)
}

#[cfg(test)]
#[path = "curved_model_tests.rs"]
mod tests;
