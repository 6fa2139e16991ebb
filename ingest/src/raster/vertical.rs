//! What heights are above, and how they become heights above the ellipsoid.
//!
//! ```text
//! datum  ← what the user says, or the coordinate reference system, or the file's tags, or the product by the file's name
//! height above the ellipsoid = height above the geoid + undulation, at every sample
//! ```
//! The undulation is added to samples when they are read, so that all that is made and measured of them is of one surface and costs
//! nothing of an error.

mod datum;
mod geoid;
mod product;

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::DVec2;
use terrain_tiles::metadata::{HeightsAbove, Vertical};

use datum::ELLIPSOID;
pub(crate) use datum::UNSPECIFIED;
use datum::{Datum, Frame};
use geoid::Geoid;

use super::ReadError;
use crate::georeference::GeoReference;

/// Samples along the side of a block in which the undulation is bilinear, if that is close enough.
const BLOCK: i64 = 16;
/// Metres by which it may differ from that.
const CLOSE: f64 = 1e-4;

/// What the heights of a file are above, and what makes them heights above the ellipsoid.
#[derive(Clone)]
pub(super) struct HeightReference {
    datum: Datum,
    geoid: Option<Arc<Geoid>>,
    /// What the person is told of it.
    remark: Option<String>,
}

impl HeightReference {
    /// By what the user says, the file's own `of_crs` and tags, and its name, in this order.
    ///
    /// # Errors
    /// When heights above the ellipsoid are wanted and the grid for it is not here.
    pub(super) fn of_file(
        path: &Path,
        of_crs: Option<String>,
        of_tags: Option<String>,
        asked: &Vertical,
    ) -> Result<Self, ReadError> {
        let (datum, why) = known_datum(path, of_crs, of_tags, asked)?;
        let mut reference = Self {
            datum,
            geoid: None,
            remark: None,
        };
        if asked.heights == HeightsAbove::Source {
            return Ok(reference);
        }
        reference.remark = Some(match (&reference.datum, &asked.geoid) {
            (Datum::Unspecified, None) => {
                "nothing says what heights are above; they are kept as they are. Say it by --vertical: egm96, \
                                           egm2008, ellipsoid …"
                    .to_owned()
            }
            (Datum::Ellipsoid, _) => format!("heights are above the ellipsoid ({why})"),
            (datum, grid) => {
                let geoid = reference.geoid.insert(Geoid::open(path, datum, grid.as_deref())?);
                let whose = datum.frame().map(Frame::remark).unwrap_or_default();
                format!(
                    "heights above {datum} ({why}) become heights above the ellipsoid{whose} by {}",
                    geoid.name()
                )
            }
        });
        Ok(reference)
    }

    /// Name of the vertical datum of the file, [`UNSPECIFIED`] where nothing says it.
    pub(super) fn datum(&self) -> String {
        self.datum.to_string()
    }

    /// Name of the grid that makes its heights heights above the ellipsoid.
    pub(super) fn geoid(&self) -> Option<&str> {
        self.geoid.as_ref().map(|geoid| geoid.name())
    }

    /// What the heights are above as they are read.
    pub(super) fn heights_above(&self) -> String {
        match (&self.geoid, self.datum.frame()) {
            (Some(_), Some(frame)) => format!("ellipsoid of {}", frame.name),
            (Some(_), None) => ELLIPSOID.to_owned(),
            (None, _) => self.datum(),
        }
    }

    /// What the person is told of it.
    pub(super) fn remark(&self) -> Option<&str> {
        self.remark.as_deref()
    }

    /// Makes metres of a rectangle of samples, row by row, metres above the ellipsoid. Columns and rows are those of
    /// `georeference`; `origin` is its first sample on a lattice that stays the same whatever is read.
    ///
    /// # Errors
    /// When the grid does not reach a sample.
    pub(super) fn to_ellipsoid(
        &self,
        path: &Path,
        georeference: &GeoReference,
        origin: [i64; 2],
        [columns, rows]: [&Range<usize>; 2],
        metres: &mut [f64],
    ) -> Result<(), ReadError> {
        let Some(geoid) = &self.geoid else { return Ok(()) };
        let undulation = |column: i64, row: i64| {
            let grid = DVec2::new((column - origin[0]) as f64, (row - origin[1]) as f64);
            geoid.undulation(georeference.geographic(grid))
        };
        let on_lattice = |range: &Range<usize>, axis: usize| {
            let first = origin[axis];
            first + range.start as i64..first + range.end as i64
        };
        let (across, down) = (on_lattice(columns, 0), on_lattice(rows, 1));
        for [columns, rows] in blocks(&across, &down) {
            let block = Block::new([columns.start, rows.start], undulation);
            for row in rows.clone() {
                let first = (row - down.start) as usize * columns_in(&across) + (columns.start - across.start) as usize;
                let samples = &mut metres[first..first + columns_in(&columns)];
                for (column, metres) in columns.clone().zip(samples).filter(|(_, metres)| !metres.is_nan()) {
                    let added = block.at(column, row).or_else(|| undulation(column, row));
                    *metres += added.ok_or_else(|| ReadError::BeyondGeoid {
                        path: path.to_owned(),
                        grid: geoid.name().to_owned(),
                    })?;
                }
            }
        }
        Ok(())
    }
}

/// Metres of a geoid above the ellipsoid by the grid in a file, at longitudes and latitudes in degrees; none where it does not reach.
///
/// # Errors
/// When the grid cannot be read.
pub fn undulations(grid: &Path, places: &[DVec2]) -> Result<Vec<Option<f64>>, ReadError> {
    let geoid = Geoid::open(grid, &Datum::Unspecified, Some(&grid.display().to_string()))?;
    Ok(places.iter().map(|&place| geoid.undulation(place)).collect())
}

/// Where the sea would be.
pub(crate) struct SeaLevel(Arc<Geoid>);

impl SeaLevel {
    /// By the grid that the person names, or else that of EGM96. `option` is what asks for it.
    ///
    /// # Errors
    /// When the grid cannot be read.
    pub(crate) fn new(option: &str, geoid: Option<&str>) -> Result<Self, ReadError> {
        Geoid::open(Path::new(option), &Datum::named("EGM96"), geoid).map(Self)
    }

    /// The grid's file.
    pub(crate) fn name(&self) -> &str {
        self.0.name()
    }

    /// Metres above the ellipsoid at degrees; none where the grid does not reach.
    pub(crate) fn height(&self, longitude: f64, latitude: f64) -> Option<f64> {
        self.0.undulation(DVec2::new(longitude, latitude))
    }
}

/// Whether heights are above an ellipsoid that are above what is called `name`.
pub(crate) fn is_ellipsoid(name: &str) -> bool {
    Datum::named(name) == Datum::Ellipsoid
}

fn columns_in(range: &Range<i64>) -> usize {
    (range.end - range.start) as usize
}

/// A rectangle cut where blocks begin.
fn blocks(columns: &Range<i64>, rows: &Range<i64>) -> Vec<[Range<i64>; 2]> {
    let cut = |range: &Range<i64>| {
        let (first, end) = (range.start, range.end);
        let starts = (first.div_euclid(BLOCK)..=(end - 1).div_euclid(BLOCK)).map(|block| block * BLOCK);
        starts
            .map(|start| start.max(first)..(start + BLOCK).min(end))
            .collect::<Vec<_>>()
    };
    let across = cut(columns);
    let with_columns = |rows: Range<i64>| across.iter().map(move |columns| [columns.clone(), rows.clone()]);
    cut(rows).into_iter().flat_map(with_columns).collect()
}

/// The undulation under a block of samples, bilinear between its corners; none where that is not close enough.
struct Block {
    first: [i64; 2],
    corners: Option<[f64; 4]>,
}

impl Block {
    /// Over the block with a sample.
    fn new(sample: [i64; 2], undulation: impl Fn(i64, i64) -> Option<f64>) -> Self {
        let first = sample.map(|place| place.div_euclid(BLOCK) * BLOCK);
        let at = |across: i64, down: i64| undulation(first[0] + across, first[1] + down);
        let corners = || Some([at(0, 0)?, at(BLOCK, 0)?, at(0, BLOCK)?, at(BLOCK, BLOCK)?]);
        let mut block = Self {
            first,
            corners: corners(),
        };
        let quarters = [1, 2, 3].map(|quarter| quarter * BLOCK / 4);
        let is_close = quarters.iter().all(|&down| {
            quarters.iter().all(|&across| {
                let both = block.at(first[0] + across, first[1] + down).zip(at(across, down));
                both.is_some_and(|(nearly, exactly)| (nearly - exactly).abs() <= CLOSE)
            })
        });
        if !is_close {
            block.corners = None;
        }
        block
    }

    fn at(&self, column: i64, row: i64) -> Option<f64> {
        let [a, b, c, d] = self.corners?;
        let share = |place: i64, axis: usize| (place - self.first[axis]) as f64 / BLOCK as f64;
        let (across, down) = (share(column, 0), share(row, 1));
        let (above, below) = (a + (b - a) * across, c + (d - c) * across);
        Some(above + (below - above) * down)
    }
}

fn known_datum(
    path: &Path,
    of_crs: Option<String>,
    of_tags: Option<String>,
    asked: &Vertical,
) -> Result<(Datum, String), ReadError> {
    if let Some(said) = &asked.datum {
        return Ok((Datum::said(said)?, "--vertical".to_owned()));
    }
    if let Some(name) = of_crs {
        return Ok((Datum::named(&name), "by its coordinate reference system".to_owned()));
    }
    if let Some(name) = of_tags {
        return Ok((Datum::named(&name), "by its tags".to_owned()));
    }
    Ok(match product::of(path) {
        Some(product) => (product.datum.clone(), format!("{}, by the file's name", product.name)),
        None if asked.geoid.is_some() => (Datum::Named("the geoid of --geoid".to_owned()), "--geoid".to_owned()),
        None => (Datum::Unspecified, String::new()),
    })
}

#[cfg(test)]
#[path = "vertical/vertical_tests.rs"]
mod tests;
