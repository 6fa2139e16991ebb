//! Polygonal models: surfaces in space of any topology, read from files of polygons, made into levels of detail of certified
//! error, and written as one level or as all of them.
//!
//! ```text
//! .ply, .obj, .stl, .off,
//! .gltf, .glb ──read, weld──▶ Model ──collapse, or cluster──▶ LeveledModel ──▶ .lod, .spm, .x3d, .wrl: all levels
//!                                                  .lod, .spm ──────▲       └─▶ .ply: one level
//! ```
//!
//! An oriented 2-manifold is simplified by edge collapses (`terrain_core::space::simplify`), after surfaces that touch in vertices or
//! along edges are parted there (`terrain_core::topology::parting`). What is no manifold even then goes through vertex clustering
//! (`terrain_core::streaming::clustering`), whose levels can be drawn but may pinch or lose small parts.
//!
//! **What is certified, for either:** every point of the model is within a level's error of the level's surface, and every
//! point of the level's surface is within it of the model, in the model's units (the Hausdorff distance). It is measured on the
//! levels as they are written, by `terrain_core::space::hausdorff`, after all else is done.

mod certify;
mod clustered;
mod error;
mod levels;
mod lod_file;
mod model;
mod order;
mod simplified;
mod spm_file;
mod weld;
mod world_file;

use std::fmt;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Component, Path};

use anyhow::{Context, Result};
use glam::DVec3;
use serde::Serialize;
use terrain_core::Mesh;
use terrain_core::space::simplify::Placement;
use terrain_core::streaming::multilevel::MultilevelLimits;
use terrain_tiles::formats::polygons::{Column, PolygonLimits, Polygons};
use terrain_tiles::formats::x3d::Encoding;
use terrain_tiles::formats::{gltf, obj, off, ply, stl};
use terrain_tiles::new_file::NewFile;

pub use self::error::ModelError;
use self::levels::LeveledModel;
pub use self::model::Model;
use self::order::Order;
pub use self::order::Target;
use self::simplified::Way;
use self::weld::{Welded, welded};
use crate::progress::Progress;

/// What to make of a model.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// When to stop simplifying.
    pub target: Target,
    /// Whether every vertex keeps its position, as it must in a `.lod` file and in a world.
    pub keep_vertices: bool,
    /// The level to extract, 0 being the finest; the coarsest if none is given.
    pub lod: Option<usize>,
}

/// One level of what was made.
#[derive(Clone, Debug, Serialize)]
pub struct LevelReport {
    /// 0 is the finest.
    pub level: usize,
    /// Its vertices.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// Largest distance from the model, both ways, in the model's units; none for levels read from a file without errors.
    pub certified_error: Option<f64>,
}

/// What was made.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// `collapses`, `clustering`, or `file` where the levels were read.
    pub method: &'static str,
    /// Why it is not `collapses`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The level that was extracted, if one was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extracted: Option<usize>,
    /// All levels, the finest first.
    pub levels: Vec<LevelReport>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.reason {
            Some(reason) => writeln!(f, "levels by {}: {reason}", self.method)?,
            None => writeln!(f, "levels by {}", self.method)?,
        }
        write!(f, "level  vertices  triangles  certified error")?;
        for level in &self.levels {
            let error = level
                .certified_error
                .map_or("not known".to_owned(), |error| format!("{error:.6e}"));
            write!(
                f,
                "\n{:>5} {:>9} {:>10}  {error:>15}",
                level.level, level.vertices, level.triangles
            )?;
            if self.extracted == Some(level.level) {
                write!(f, "  ◀ written")?;
            }
        }
        Ok(())
    }
}

/// What is written, by the name of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// All levels, compressed.
    Spm,
    /// All levels, as text.
    Lod,
    /// The same and a world that streams it.
    World(Encoding),
    /// One level.
    Ply,
}

impl Form {
    fn of_file(path: &Path) -> Result<Self, ModelError> {
        match extension(path).as_str() {
            "spm" => Ok(Self::Spm),
            "lod" => Ok(Self::Lod),
            "ply" => Ok(Self::Ply),
            _ => Encoding::of_file(path)
                .map(Self::World)
                .ok_or(ModelError::UnknownOutput),
        }
    }

    /// Whether a vertex can only have one position in all levels.
    fn keeps_vertices(self) -> bool {
        matches!(self, Self::Lod | Self::World(_))
    }
}

/// Reads a model or its levels from `input`, makes levels where there are none, and writes `output`, all at once or not at
/// all: every level where that is a `.spm` or a `.lod` file; the latter and a world that streams it where it is an `.x3d` or
/// `.wrl` file; one of them where it is a `.ply` file.
///
/// # Errors
/// A [`ModelError`] inside where the input is at fault, or the output's format cannot hold the levels; otherwise where the file
/// cannot be written.
pub fn run(input: &Path, options: &Options, output: &Path, progress: &Progress) -> Result<Report> {
    let named = || output.display().to_string();
    let form = Form::of_file(output).with_context(named)?;
    let (leveled, way) = leveled(input, options, form, progress)?;
    let mut report = report(&leveled, way);
    progress.stage(&format!("writing {}", output.display()), 1);
    match form {
        Form::Ply => report.extracted = Some(write_level(input, options.lod, &leveled, output)?),
        Form::Spm => spm_file::write(output, &leveled).with_context(named)?,
        Form::Lod => lod_file::write(output, &leveled).with_context(named)?,
        Form::World(encoding) => world_file::write(output, encoding, &leveled, input).with_context(named)?,
    }
    progress.advance(1);
    progress.done();
    Ok(report)
}

/// What a `.spm` or a `.lod` file says of its levels.
///
/// # Errors
/// Where it is neither, or cannot be read.
pub fn info(input: &Path) -> Result<Report> {
    let leveled = read_levels(input).unwrap_or(Err(ModelError::Unknown));
    Ok(report(&leveled.with_context(|| input.display().to_string())?, None))
}

/// Writes one level, the coarsest if none is named, and tells which.
fn write_level(input: &Path, level: Option<usize>, leveled: &LeveledModel, output: &Path) -> Result<usize> {
    let last = leveled.level_count() - 1;
    let level = level.unwrap_or(last);
    let (mesh, columns) = leveled
        .level(level)
        .ok_or(ModelError::NoSuchLevel { level, last })
        .with_context(|| input.display().to_string())?;
    let error = leveled.partition.levels[last - level].error;
    let known = error.is_finite().then_some(error);
    write_ply(output, &mesh, &columns, known).with_context(|| output.display().to_string())?;
    Ok(level)
}

/// Writes one level, all at once or not at all. `error`, if it is known, goes into a comment.
fn write_ply(output: &Path, mesh: &Mesh, columns: &[Column], error: Option<f64>) -> io::Result<()> {
    let note = error.map(|error| format!("terrain-ingest distance from the model at most {error}"));
    let mut file = NewFile::create(output)?;
    let mut out = BufWriter::new(file.file());
    ply::write(&mut out, &mesh.positions, columns, &mesh.triangles, note.as_deref())?;
    out.flush()?;
    drop(out);
    file.finish()
}

fn leveled(input: &Path, options: &Options, form: Form, progress: &Progress) -> Result<(LeveledModel, Option<Way>)> {
    let named = || input.display().to_string();
    progress.stage("reading", 1);
    if let Some(levels) = read_levels(input) {
        return Ok((levels.with_context(named)?, None));
    }
    let model = read(input, PolygonLimits::default()).with_context(named)?;
    progress.advance(1);
    note_columns(&model, form, progress);
    let order = Order {
        target: options.target,
        placement: match options.keep_vertices || form.keeps_vertices() {
            true => Placement::Stay,
            false => Placement::Best,
        },
        is_rounded: form == Form::Spm,
    };
    let (leveled, way) = simplified::leveled(&model, order, progress).with_context(named)?;
    Ok((leveled, Some(way)))
}

/// The levels of a `.spm` or a `.lod` file; none of any other.
fn read_levels(input: &Path) -> Option<Result<LeveledModel, ModelError>> {
    match extension(input).as_str() {
        "spm" => Some(spm_file::read(input)),
        "lod" => Some(lod_file::read(input, MultilevelLimits::default())),
        _ => None,
    }
}

/// Names the columns that will be missing.
fn note_columns(model: &Model, form: Form, progress: &Progress) {
    for seam in &model.seams {
        progress.note(&format!(
            "`{seam}` is left out: it differs between triangles that share a vertex"
        ));
    }
    if form != Form::Ply {
        for column in &model.columns {
            progress.note(&format!("`{}` is left out: only .ply files have it", column.name));
        }
    }
}

/// Reads a file of polygons, of a format that its name tells. Polygons become fans of triangles, positions that are one become
/// one vertex, and what has no area left in that, or is not used, is dropped.
///
/// # Errors
/// What is wrong with the file.
pub fn read(path: &Path, limits: PolygonLimits) -> Result<Model, ModelError> {
    Ok(welded(polygons(path, limits)?)?.model)
}

/// A normal for each corner of each triangle.
pub(crate) type CornerNormals = Vec<[DVec3; 3]>;

/// A model as an oriented manifold, surfaces that touch being parted, and the normals at the corners of its triangles where the
/// file has some.
pub(crate) fn read_manifold(path: &Path) -> Result<(Mesh, Option<CornerNormals>), ModelError> {
    let Welded { model, normals } = welded(polygons(path, PolygonLimits::default())?)?;
    Ok((model.parted().map_err(ModelError::NotManifold)?.mesh, normals))
}

fn polygons(path: &Path, limits: PolygonLimits) -> Result<Polygons, ModelError> {
    let file = || File::open(path).map(BufReader::new);
    Ok(match extension(path).as_str() {
        "ply" => ply::read(file()?, limits)?,
        "obj" => obj::read(file()?, limits)?,
        "stl" => stl::read(file()?, limits)?,
        "off" => off::read(file()?, limits)?,
        "gltf" | "glb" => gltf::read(&fs::read(path)?, &|name| read_beside(path, name), limits)?,
        _ => return Err(ModelError::Unknown),
    })
}

/// Reads a file that another names, by a path that leads down from where that is.
fn read_beside(path: &Path, name: &str) -> io::Result<Vec<u8>> {
    let leads_down = Path::new(name)
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    match leads_down && !name.contains(':') {
        true => fs::read(path.with_file_name(name)),
        false => Err(io::Error::other("only files beside it or below are read")),
    }
}

/// A file's extension in lower case; empty where it has none.
pub(crate) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_lowercase()
}

fn report(leveled: &LeveledModel, way: Option<Way>) -> Report {
    let (method, reason) = match way {
        None => ("file", None),
        Some(Way::Collapses) => ("collapses", None),
        Some(Way::Clustering(cause)) => ("clustering", Some(cause.to_string())),
    };
    let levels = leveled.partition.levels.iter().rev().enumerate();
    let level = |(level, extent): (usize, &terrain_core::levels::partition::Level)| LevelReport {
        level,
        vertices: extent.vertex_end as usize,
        triangles: extent.triangle_end as usize,
        certified_error: extent.error.is_finite().then_some(extent.error),
    };
    Report {
        method,
        reason,
        extracted: None,
        levels: levels.map(level).collect(),
    }
}

#[cfg(test)]
#[path = "polygonal_model_tests.rs"]
mod tests;
