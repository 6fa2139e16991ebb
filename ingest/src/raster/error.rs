//! Why a raster cannot be used: one line each, by whose fault it is.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use gdal::errors::GdalError;
use thiserror::Error;

use crate::georeference::GeoReferenceError;

/// Why rasters cannot be read into a grid. All of them are faults of the input.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The list of files is empty.
    #[error("no raster to read")]
    NoFile,
    /// A name that GDAL would take for something else than a file.
    #[error("{}: names with `/vsi` or `<` are refused, only plain files are read", .0.display())]
    Refused(PathBuf),
    /// Not there, damaged, or no raster.
    #[error("{}: cannot be read: {reason}", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the reader said.
        reason: String,
    },
    /// Fewer than two columns or rows have no surface between them.
    #[error("{}: has {columns} × {rows} samples, a surface needs 2 × 2", .path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// Samples in a row.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// The file does not say what its coordinates mean.
    #[error("{}: has no coordinate reference system; pass --crs EPSG:…, or --local if it is nowhere on the Earth", .0.display())]
    NoCrs(PathBuf),
    /// The file does not say where its samples are.
    #[error("{}: has no position; pass --bounds WEST,SOUTH,EAST,NORTH in units of the CRS, or --pixel-size METRES if it is nowhere on the Earth", .0.display())]
    NoPosition(PathBuf),
    /// The coordinate reference system given by the caller means nothing.
    #[error("`{0}` is no coordinate reference system that PROJ knows")]
    UnknownCrs(String),
    /// The bounds given by the caller are not west < east, south < north.
    #[error("bounds {0:?} are not west < east and south < north")]
    BadBounds([f64; 4]),
    /// The samples have no longitude and latitude.
    #[error("{}: {}", .0.display(), .1)]
    Position(PathBuf, GeoReferenceError),
    /// Not one sample has a height.
    #[error("{}: every sample is void", .0.display())]
    AllVoid(PathBuf),
    /// More memory than the limits allow.
    #[error("{}: {what}, the limit is {limit}", .path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large, and how large.
        what: String,
        /// The limit that it exceeds.
        limit: usize,
    },
    /// The vertical datum given by the caller means nothing.
    #[error(
        "`{0}` is no vertical datum that is known here: egm96, egm2008, egm84, navd88, ellipsoid or their EPSG codes; for another, \
             name the grid of its height above the ellipsoid by --geoid"
    )]
    UnknownDatum(String),
    /// Heights above the ellipsoid need a grid that is not here.
    #[error("{}: its heights are above {datum}; {hint}, or keep them by --heights source", .path.display())]
    NoGeoid {
        /// The file.
        path: PathBuf,
        /// What its heights are above.
        datum: String,
        /// Where the grid is had.
        hint: String,
    },
    /// A sample beside the grid that would make its height one above the ellipsoid.
    #[error("{}: reaches beyond the grid {grid}; keep its heights by --heights source", .path.display())]
    BeyondGeoid {
        /// The file.
        path: PathBuf,
        /// Name of the grid.
        grid: String,
    },
    /// Files that do not fit on one grid.
    #[error("{}: does not fit {}: {reason}", .path.display(), .first.display())]
    Mixed {
        /// The file that does not fit.
        path: PathBuf,
        /// The first file.
        first: PathBuf,
        /// In what they differ.
        reason: String,
    },
}

impl ReadError {
    pub(super) fn unreadable(path: &Path, reason: impl Display) -> Self {
        Self::Unreadable {
            path: path.to_owned(),
            reason: one_line(path, &reason.to_string()),
        }
    }

    /// What GDAL said, without the name of the function that said it.
    pub(super) fn gdal(path: &Path, error: GdalError) -> Self {
        match error {
            GdalError::NullPointer { msg, .. } | GdalError::CplError { msg, .. } if msg.is_empty() => {
                match std::fs::metadata(path) {
                    Ok(_) => Self::unreadable(path, "it is of no format that is read here"),
                    Err(gone) => Self::unreadable(path, gone),
                }
            }
            GdalError::NullPointer { msg, .. } | GdalError::CplError { msg, .. } => Self::unreadable(path, msg),
            other => Self::unreadable(path, other),
        }
    }
}

/// Libraries answer in several lines at times, and name the file themselves.
fn one_line(path: &Path, text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let name = path.display().to_string();
    line.trim_start_matches(&name)
        .trim_start_matches([':', ',', ' '])
        .to_owned()
}
