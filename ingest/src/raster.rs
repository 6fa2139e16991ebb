//! Elevation rasters: opened together as one lattice of samples, and read by rectangles, in metres, voids as NaN.

mod crs;
mod drivers;
mod error;
mod exr_file;
mod gdal_file;
mod layout;
mod mosaic;
mod options;
mod pieces;
mod placement;
mod raw_file;
mod reader;
mod record;
mod remark;
mod source;
mod tiff_file;
mod undeclared;
mod units;
mod vertical;
mod zip;

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use rayon::prelude::*;

pub use drivers::is_raster;
pub use error::ReadError;
pub use options::{RasterLimits, ReadOptions};
pub use record::{RasterRecord, RecordedRaster};
pub use units::metres_in;
pub(crate) use vertical::UNSPECIFIED;
pub use vertical::undulations;

use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::progress::Progress;
use crate::samples::{Extremes, Faults, Overrides, Provenance, Raster, Rectangle};
use layout::Layout;
use mosaic::Mosaic;
use pieces::{cut, part_size};
use remark::{HIGHEST, remark, tell};
use source::Source;
use vertical::HeightReference;

/// Metres by which files may differ where they overlap without a word.
const AGREEMENT: f32 = 0.01;

/// Rasters on one lattice of samples, opened but not read.
pub struct Rasters {
    files: Vec<Source>,
    mosaic: Mosaic,
    georeference: GeoReference,
    limits: RasterLimits,
    progress: Progress,
    overrides: Overrides,
}

/// A rectangle of one file's samples.
struct Part {
    file: usize,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Rasters {
    /// Opens band 1 of `paths`. Files must share their coordinate reference system, cell size and alignment; where they
    /// overlap, the first that is not void wins.
    ///
    /// # Errors
    /// A [`ReadError`] of one line that names the file.
    pub fn open(paths: &[PathBuf], options: &ReadOptions) -> Result<Self, ReadError> {
        let files = paths
            .iter()
            .map(|path| Source::open(path, options))
            .collect::<Result<Vec<_>, _>>()?;
        let first = files.first().ok_or(ReadError::NoFile)?;
        let layouts: Vec<&Layout> = files.iter().map(Source::layout).collect();
        let mosaic = Mosaic::new(&layouts, options.limits)?;
        let georeference = georeference(first.layout(), &mosaic, options)?;
        tell(&layouts, &options.progress);
        Ok(Self {
            files,
            mosaic,
            georeference,
            limits: options.limits,
            progress: options.progress.clone(),
            overrides: options.overrides.clone(),
        })
    }

    /// What files say of their heights, each different one once.
    fn of_heights(&self, of: impl Fn(&HeightReference) -> String) -> String {
        let names: BTreeSet<String> = self.files.iter().map(|file| of(&file.layout().heights)).collect();
        let names: Vec<String> = names.into_iter().filter(|name| !name.is_empty()).collect();
        names.join(", ")
    }

    /// Paths as they were given.
    fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| file.layout().path.as_path())
    }

    /// All that is known of the rasters but their samples.
    #[must_use]
    pub fn record(&self) -> RasterRecord {
        let first = self.files[0].layout();
        RasterRecord {
            paths: self.paths().map(absolute).collect(),
            crs: first.crs.clone(),
            to_crs: self.mosaic.to_crs.to_cols_array(),
            origin: self.mosaic.origin,
            size: self.size(),
            extents: self.extents(),
            block_rows: self.block_rows(),
            provenance: self.provenance(),
            stamps: self.stamps(),
        }
    }

    /// All samples as one grid in memory.
    ///
    /// # Errors
    /// A [`ReadError`] of one line that names the file.
    pub fn grid(self) -> Result<HeightGrid, ReadError> {
        let [columns, rows] = self.size();
        let path = &self.files[0].layout().path;
        placement::check_size(path, columns, rows, self.limits.samples_in_memory)?;
        self.progress.stage("reading samples", (columns * rows) as u64);
        let Rectangle { heights, faults } = self.read(0..columns, 0..rows)?;
        self.progress.done();
        self.remark(Extremes::of(&heights), &faults)?;
        Ok(HeightGrid {
            columns,
            rows,
            heights,
            georeference: self.georeference,
        })
    }

    /// The rectangle cut into parts of one file each, along its blocks, in the order of files.
    fn parts(&self, columns: &Range<usize>, rows: &Range<usize>) -> Vec<Part> {
        let mut parts = Vec::new();
        for (file, [across, down]) in self.extents().into_iter().enumerate() {
            let columns = intersection(columns, &across);
            let rows = intersection(rows, &down);
            if columns.is_empty() || rows.is_empty() {
                continue;
            }
            let [width, height] = part_size(self.files[file].block(), columns.len());
            for rows in cut(&rows, down.start, height) {
                for columns in cut(&columns, across.start, width) {
                    let rows = rows.clone();
                    parts.push(Part { file, columns, rows });
                }
            }
        }
        parts
    }

    fn read_part(&self, part: &Part) -> Result<Vec<f64>, ReadError> {
        let [left, top] = self.mosaic.offsets[part.file];
        let in_file = |range: &Range<usize>, first: usize| range.start - first..range.end - first;
        let file = &self.files[part.file];
        let mut metres = file.read(in_file(&part.columns, left), in_file(&part.rows, top))?;
        let Layout { path, heights, .. } = file.layout();
        heights.to_ellipsoid(
            path,
            &self.georeference,
            self.mosaic.origin,
            [&part.columns, &part.rows],
            &mut metres,
        )?;
        self.progress.advance(metres.len() as u64);
        Ok(metres)
    }
}

impl Raster for Rasters {
    fn size(&self) -> [usize; 2] {
        [self.mosaic.columns, self.mosaic.rows]
    }

    fn origin(&self) -> [i64; 2] {
        self.mosaic.origin
    }

    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        let extent = |(file, &[left, top]): (&Source, &[usize; 2])| {
            let layout = file.layout();
            [left..left + layout.columns, top..top + layout.rows]
        };
        self.files.iter().zip(&self.mosaic.offsets).map(extent).collect()
    }

    fn block_rows(&self) -> usize {
        self.files.iter().map(|file| file.block()[1]).max().unwrap_or(1)
    }

    /// By several readers at once, in whole blocks where the rectangle lies along them.
    fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Rectangle, ReadError> {
        let mut rectangle = Rectangle {
            heights: vec![f32::NAN; columns.len() * rows.len()],
            faults: vec![Faults::default(); self.files.len()],
        };
        let parts = self.parts(&columns, &rows);
        // Memory is that of the rectangle and of what is read at once.
        for parts in parts.chunks(rayon::current_num_threads()) {
            let read: Result<Vec<Vec<f64>>, ReadError> = parts.par_iter().map(|part| self.read_part(part)).collect();
            for (part, metres) in parts.iter().zip(read?) {
                let faults = put(part, &metres, &mut rectangle.heights, &columns, &rows);
                rectangle.faults[part.file] = rectangle.faults[part.file].with(faults);
            }
        }
        Ok(rectangle)
    }

    fn georeference(&self) -> &GeoReference {
        &self.georeference
    }

    fn provenance(&self) -> Provenance {
        Provenance {
            files: self.paths().map(file_name).collect(),
            vertical_datum: self.of_heights(HeightReference::datum),
            heights_above: self.of_heights(HeightReference::heights_above),
            geoid: Some(self.of_heights(|heights| heights.geoid().unwrap_or_default().to_owned()))
                .filter(|names| !names.is_empty()),
            overrides: self.overrides.clone(),
        }
    }

    fn remark(&self, extremes: Option<Extremes>, faults: &[Faults]) -> Result<(), ReadError> {
        let paths: Vec<&Path> = self.paths().collect();
        remark(&paths, extremes, faults, &self.progress)
    }

    /// Path, size and time of the last change of each file, and how they are read.
    fn stamps(&self) -> Vec<String> {
        let stamp = |path: &Path| format!("{} {:?}", stamp_of(path), self.overrides);
        self.paths().map(stamp).collect()
    }
}

fn stamp_of(path: &Path) -> String {
    let absolute = absolute(path);
    let changed = std::fs::metadata(path).map(|metadata| {
        let since = metadata
            .modified()
            .ok()
            .and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        (metadata.len(), since.map(|since| since.as_nanos()))
    });
    format!("{} {:?}", absolute.display(), changed.ok())
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Puts a part where nothing is yet; returns what cannot be right in it.
fn put(part: &Part, metres: &[f64], heights: &mut [f32], columns: &Range<usize>, rows: &Range<usize>) -> Faults {
    let mut faults = Faults::default();
    for (row, metres) in part.rows.clone().zip(metres.chunks_exact(part.columns.len())) {
        let start = (row - rows.start) * columns.len() + part.columns.start - columns.start;
        for (height, &metres) in heights[start..].iter_mut().zip(metres) {
            let (value, is_wild) = checked_height(metres);
            faults.wild += u64::from(is_wild);
            if height.is_nan() {
                *height = value;
                continue;
            }
            let apart = (*height - value).abs();
            if apart > AGREEMENT {
                faults.disagreeing += 1;
                faults.apart = faults.apart.max(apart);
            }
        }
    }
    faults
}

/// Reads band 1 of `paths` as one grid in memory.
///
/// # Errors
/// A [`ReadError`] of one line that names the file.
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<HeightGrid, ReadError> {
    Rasters::open(paths, options)?.grid()
}

fn intersection(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

fn georeference(first: &Layout, mosaic: &Mosaic, options: &ReadOptions) -> Result<GeoReference, ReadError> {
    if first.is_local {
        return Ok(GeoReference::local(
            mosaic.columns,
            mosaic.rows,
            mosaic.to_crs,
            mosaic.origin,
        ));
    }
    let georeference = GeoReference::on_lattice(&first.crs, mosaic.to_crs, mosaic.origin, mosaic.columns, mosaic.rows)
        .map_err(|source| ReadError::Position(first.path.clone(), source))?;
    if georeference.is_ballpark() {
        let crs = georeference.crs_name();
        options.progress.note(&format!(
            "no datum shift from {crs} to WGS84 is known here; none is applied"
        ));
    }
    Ok(georeference)
}

/// A file's name without its folder.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
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
