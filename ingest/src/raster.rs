//! Reads elevation rasters into one [`HeightGrid`]: metres, voids as NaN, several files as one mosaic.

mod crs;
mod error;
mod exr_file;
mod gdal_file;
mod layout;
mod mosaic;
mod units;

use std::path::{Path, PathBuf};

pub use error::ReadError;

use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::progress::Progress;
use gdal_file::GdalFile;
use layout::Layout;
use mosaic::Mosaic;

/// No terrain on any planet is higher or deeper; what is beyond is a void that the file does not declare.
const HIGHEST: f64 = 100_000.0;
/// Metres; the Challenger Deep is at −10,935 (Greenaway et al., 2021). Lower samples are kept, with a remark.
const DEEPEST: f32 = -11_000.0;

/// How to read.
#[derive(Clone, Default)]
pub struct ReadOptions {
    /// Coordinate reference system to use instead of the files' own: a code as `EPSG:2056`, WKT, a PROJ string.
    pub crs: Option<String>,
    /// West, south, east, north edges of the outermost pixels, in units of the coordinate reference system, to use
    /// instead of the files' own.
    pub bounds: Option<[f64; 4]>,
    /// What is too large.
    pub limits: Limits,
    /// Is told of the samples read.
    pub progress: Progress,
}

/// What a raster may ask for; anything larger is refused before it costs memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Samples of the whole grid.
    pub samples: usize,
    /// Bytes of one block (tile or strip) of a file, unpacked.
    pub block_bytes: usize,
}

impl Default for Limits {
    /// Two gigabytes of heights, a quarter of a gigabyte a block.
    fn default() -> Self {
        Self {
            samples: 1 << 29,
            block_bytes: 1 << 28,
        }
    }
}

/// Reads band 1 of `paths` as one grid. Files must share their coordinate reference system, cell size and alignment;
/// where they overlap, the first that is not void wins.
///
/// # Errors
/// A [`ReadError`] of one line that names the file.
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<HeightGrid, ReadError> {
    let files = paths
        .iter()
        .map(|path| Source::open(path, options))
        .collect::<Result<Vec<_>, _>>()?;
    let first = files.first().ok_or(ReadError::NoFile)?;
    let layouts: Vec<&Layout> = files.iter().map(Source::layout).collect();
    let mut mosaic = Mosaic::new(&layouts, options.limits)?;
    let georeference = georeference(first.layout(), &mosaic, options)?;

    let samples = layouts.iter().map(|layout| layout.columns * layout.rows).sum::<usize>();
    options.progress.stage("reading samples", samples as u64);
    for (index, file) in files.iter().enumerate() {
        let wild = file.read_into(&mut mosaic, index, options)?;
        note_wild(file.layout(), wild, options);
    }
    if mosaic.heights.iter().all(|height| height.is_nan()) {
        return Err(ReadError::AllVoid(first.layout().path.clone()));
    }
    options.progress.done();
    note_deep(&mosaic.heights, options);
    Ok(HeightGrid {
        columns: mosaic.columns,
        rows: mosaic.rows,
        heights: mosaic.heights,
        georeference,
        vertical_datum: first.layout().vertical_datum.clone(),
        files: paths.iter().map(|path| file_name(path)).collect(),
    })
}

fn georeference(first: &Layout, mosaic: &Mosaic, options: &ReadOptions) -> Result<GeoReference, ReadError> {
    let georeference = GeoReference::new(&first.crs, mosaic.to_crs, mosaic.columns, mosaic.rows)
        .map_err(|source| ReadError::Position(first.path.clone(), source))?;
    if georeference.is_ballpark() {
        let crs = georeference.crs_name();
        options.progress.note(&format!(
            "no datum shift from {crs} to WGS84 is known here; none is applied"
        ));
    }
    Ok(georeference)
}

fn note_wild(layout: &Layout, wild: usize, options: &ReadOptions) {
    if wild > 0 {
        let path = layout.path.display();
        let kilometres = HIGHEST / 1000.0;
        options.progress.note(&format!(
            "{path}: {wild} samples are infinite or beyond ±{kilometres} km and count as voids; is a nodata value missing?"
        ));
    }
}

fn note_deep(heights: &[f32], options: &ReadOptions) {
    let lowest = heights.iter().copied().fold(f32::INFINITY, f32::min);
    if lowest < DEEPEST {
        let note = format!("the lowest sample is {lowest} m, below every sea floor; is a nodata value missing?");
        options.progress.note(&note);
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// An open file.
enum Source {
    Gdal(GdalFile),
    Exr(exr_file::ExrFile),
}

impl Source {
    fn open(path: &Path, options: &ReadOptions) -> Result<Self, ReadError> {
        check_name(path)?;
        let is_exr = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        if is_exr {
            exr_file::ExrFile::open(path, options).map(Self::Exr)
        } else {
            GdalFile::open(path, options).map(Self::Gdal)
        }
    }

    fn layout(&self) -> &Layout {
        match self {
            Self::Gdal(file) => file.layout(),
            Self::Exr(file) => file.layout(),
        }
    }

    /// Returns how many samples were voided because they cannot be heights.
    fn read_into(&self, mosaic: &mut Mosaic, index: usize, options: &ReadOptions) -> Result<usize, ReadError> {
        match self {
            Self::Gdal(file) => file.read_into(mosaic, index, &options.progress),
            Self::Exr(file) => file.read_into(mosaic, index, &options.progress),
        }
    }
}

/// GDAL takes names for more than files: `/vsicurl/http://…` fetches, `<VRTDataset>…` reads other files. Only names of
/// plain files pass.
fn check_name(path: &Path) -> Result<(), ReadError> {
    let name = path.to_string_lossy();
    if name.contains("/vsi") || name.contains('<') {
        return Err(ReadError::Refused(path.to_owned()));
    }
    let metadata = std::fs::metadata(path).map_err(|error| ReadError::unreadable(path, error))?;
    if metadata.is_file() {
        Ok(())
    } else {
        Err(ReadError::unreadable(path, "it is not a file"))
    }
}

/// A height in metres as it is kept, and whether it had to be voided.
fn checked_height(metres: f64) -> (f32, bool) {
    if metres.is_nan() {
        (f32::NAN, false)
    } else if metres.abs() >= HIGHEST {
        (f32::NAN, true)
    } else {
        (metres as f32, false)
    }
}

#[cfg(test)]
#[path = "raster_tests.rs"]
mod tests;
