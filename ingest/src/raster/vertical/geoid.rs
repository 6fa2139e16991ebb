//! Grids of the geoid's height above the ellipsoid.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex};

use gdal::Dataset;
use glam::DVec2;

use super::super::drivers::prepare_gdal;
use super::super::{ReadError, placement};
use super::datum::Datum;

/// Nodes of a grid, at most: the one of EGM2008 at 1′ has 233 million.
const MOST_NODES: usize = 1 << 28;
/// Where grids that PROJ knows are.
const NETWORK: &str = "https://cdn.proj.org";
/// Lines of a PGM file's header that are looked at.
const HEADER_LINES: usize = 40;
/// Share of a step within which a place beside the outermost nodes counts as on them.
const BESIDE: f64 = 0.51;

/// A grid, bilinear between its nodes, as PROJ takes it (operation `vgridshift`).
pub(super) struct Geoid {
    path: PathBuf,
    /// Longitude and latitude of the first node, degrees.
    first: DVec2,
    /// Degrees from column to column and from row to row; the latter is negative where the north comes first.
    step: DVec2,
    columns: usize,
    rows: usize,
    /// Metres, row by row; NaN where the grid tells nothing.
    metres: Vec<f32>,
}

/// Grids that were read: files of one product share theirs.
static READ: LazyLock<Mutex<Vec<Arc<Geoid>>>> = LazyLock::new(Mutex::default);

impl Geoid {
    /// The grid that a user names, or the one of a datum where PROJ keeps such.
    ///
    /// # Errors
    /// When there is none, or it cannot be read.
    pub(super) fn open(raster: &Path, datum: &Datum, named: Option<&str>) -> Result<Arc<Self>, ReadError> {
        let path = match named {
            Some(named) => PathBuf::from(named),
            None => find(raster, datum)?,
        };
        let mut read = READ.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(known) = read.iter().find(|geoid| geoid.path == path) {
            return Ok(Arc::clone(known));
        }
        let geoid = Arc::new(Self::read(&path)?);
        read.push(Arc::clone(&geoid));
        Ok(geoid)
    }

    fn read(path: &Path) -> Result<Self, ReadError> {
        prepare_gdal(false);
        let unreadable = |error| ReadError::gdal(path, error);
        std::fs::metadata(path).map_err(|error| ReadError::unreadable(path, error))?;
        let dataset = Dataset::open(path).map_err(unreadable)?;
        let (columns, rows) = dataset.raster_size();
        placement::check_size(path, columns, rows, MOST_NODES)?;
        let band = dataset.rasterband(1).map_err(unreadable)?;
        let window = band
            .read_as::<f32>((0, 0), (columns, rows), (columns, rows), None)
            .map_err(unreadable)?;
        let (_, mut metres) = window.into_shape_and_vec();
        let of_pgm = scale_of_pgm(path);
        let (scale, offset) = of_pgm.unwrap_or_else(|| (band.scale().unwrap_or(1.0), band.offset().unwrap_or(0.0)));
        let nodata = band.no_data_value();
        for metres in &mut metres {
            let is_void = nodata.is_some_and(|nodata| f64::from(*metres) == nodata);
            *metres = if is_void {
                f32::NAN
            } else {
                (f64::from(*metres) * scale + offset) as f32
            };
        }
        let (first, step) = match dataset.geo_transform() {
            Ok(transform) => {
                let to_degrees = placement::from_corner_based(transform);
                (to_degrees.translation, DVec2::new(transform[1], transform[5]))
            }
            // GeographicLib's files begin at 0° E, 90° N, and go around the whole Earth.
            Err(_) if of_pgm.is_some() => (
                DVec2::new(0.0, 90.0),
                DVec2::new(360.0 / columns as f64, -180.0 / (rows - 1) as f64),
            ),
            Err(_) => return Err(ReadError::unreadable(path, "it does not say where its nodes are")),
        };
        Ok(Self {
            path: path.to_owned(),
            first,
            step,
            columns,
            rows,
            metres,
        })
    }

    /// The file's name.
    pub(super) fn name(&self) -> &str {
        self.path.file_name().and_then(|name| name.to_str()).unwrap_or("a grid")
    }

    /// Metres of the geoid above the ellipsoid at a longitude and latitude in degrees; none where the grid does not reach.
    pub(super) fn undulation(&self, at: DVec2) -> Option<f64> {
        let around = (360.0 / self.step.x.abs()).round();
        let is_whole = self.columns as f64 >= around;
        let across = ((at.x - self.first.x) / self.step.x).rem_euclid(around);
        let down = (at.y - self.first.y) / self.step.y;
        let (column, right) = self.between(across, self.columns, is_whole.then_some(around as usize))?;
        let (row, below) = self.between(down, self.rows, None)?;
        let node = |[column, row]: [usize; 2]| f64::from(self.metres[row * self.columns + column]);
        let along = |row: usize| {
            let (left, next) = (node([column[0], row]), node([column[1], row]));
            left + (next - left) * right
        };
        let (upper, lower) = (along(row[0]), along(row[1]));
        let found = upper + (lower - upper) * below;
        (!found.is_nan()).then_some(found)
    }

    /// The nodes around a place along an axis, and the share of the second one. Where the axis goes around, the first follows
    /// the last.
    fn between(&self, place: f64, count: usize, around: Option<usize>) -> Option<([usize; 2], f64)> {
        if let Some(around) = around {
            let first = (place.floor() as usize).min(around - 1);
            return Some(([first, (first + 1) % around], place - place.floor()));
        }
        let last = (count - 1) as f64;
        if !(-BESIDE..=last + BESIDE).contains(&place) {
            return None;
        }
        let place = place.clamp(0.0, last);
        let first = (place as usize).min(count - 2);
        Some(([first, first + 1], place - first as f64))
    }
}

/// The grid of a datum in one of PROJ's folders.
fn find(raster: &Path, datum: &Datum) -> Result<PathBuf, ReadError> {
    let raster = raster.to_owned();
    let Datum::Model(model) = datum else {
        return Err(ReadError::NoGeoid {
            path: raster,
            datum: datum.to_string(),
            hint: "name the grid of its height above the ellipsoid by --geoid".to_owned(),
        });
    };
    let folders = folders();
    let found = model.grids.iter().find_map(|grid| {
        let path = |folder: &PathBuf| folder.join(grid);
        folders.iter().map(path).find(|path| path.is_file())
    });
    let get = model.grids[0];
    found.ok_or_else(|| ReadError::NoGeoid {
        path: raster,
        datum: datum.to_string(),
        hint: format!(
            "the grid {get} is not in PROJ's folders: get it by `projsync --file {get}` or from {NETWORK}/{get}, and name it by --geoid"
        ),
    })
}

/// Scale and offset from the comments of a PGM file by GeographicLib; none where it is no such file.
fn scale_of_pgm(path: &Path) -> Option<(f64, f64)> {
    let mut lines = BufReader::new(File::open(path).ok()?)
        .split(b'\n')
        .map_while(Result::ok);
    if lines.next()? != b"P5" {
        return None;
    }
    let (mut scale, mut offset) = (None, None);
    for line in lines.take(HEADER_LINES) {
        let line = String::from_utf8_lossy(&line).into_owned();
        let value = |name: &str| line.strip_prefix(name).and_then(|value| value.trim().parse().ok());
        scale = scale.or_else(|| value("# Scale "));
        offset = offset.or_else(|| value("# Offset "));
    }
    scale.zip(offset)
}

/// Where PROJ's grids may be.
fn folders() -> Vec<PathBuf> {
    let of_environment = ["PROJ_DATA", "PROJ_LIB"].into_iter().filter_map(std::env::var_os);
    let mut folders: Vec<PathBuf> = of_environment
        .flat_map(|folders| std::env::split_paths(&folders).collect::<Vec<_>>())
        .collect();
    if let Some(home) = std::env::home_dir() {
        folders.push(home.join(".local/share/proj"));
    }
    folders.extend(["/usr/local/share/proj", "/usr/share/proj"].map(PathBuf::from));
    folders
}
