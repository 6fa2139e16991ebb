//! Files whose samples lie between those of the lattice: their heights on it are bilinear in their own cells.

use std::ops::Range;

use glam::{DAffine2, DVec2};

use super::ReadError;
use super::layout::{Frame, Layout};
use crate::georeference::{Crs, GeoReference, GeoReferenceError, converted, nearest_turn};

/// A sample of the lattice that is so near to one of the file, in the file's cells, is that one.
const SAME: f64 = 1e-6;
/// A sample stands for half a cell on each side of it, beyond the outermost ones, too.
const HALF: f64 = 0.5 + SAME;
/// No index of a sample comes near it.
pub(super) const FARTHEST: f64 = 1e9;
/// Points along each side of a file by which it is found where it lies on the lattice.
const PROBES: usize = 64;

/// From the lattice of samples to columns and rows of a file.
pub(super) struct Between {
    way: Way,
    /// Columns in 360°, where these are longitudes.
    around: Option<f64>,
    /// Where the file's samples are on the Earth.
    pub(super) own: GeoReference,
}

enum Way {
    /// In the reference system that both share: from the lattice's coordinates.
    Affine(DAffine2),
    /// Over the Earth, by longitudes within half a turn of the file's middle.
    Geographic { middle: f64 },
}

impl Between {
    /// From a lattice, which has a transform to a reference system, to a file; `own` is where the file's samples are on the Earth, which
    /// tells where both have no reference system in common.
    pub(super) fn new((crs, to_crs): (&Crs, DAffine2), file: Frame, own: GeoReference) -> Self {
        let way = if file.crs == crs {
            Way::Affine(file.to_crs.inverse() * to_crs)
        } else {
            let [west, _, east, _] = own.geographic_bounds();
            Way::Geographic {
                middle: f64::midpoint(west, east),
            }
        };
        let around = file.columns_around();
        Self { way, around, own }
    }

    /// Columns and rows in the file of a rectangle of samples of `georeference`, row by row.
    pub(super) fn places(&self, georeference: &GeoReference, [columns, rows]: [&Range<usize>; 2]) -> Vec<DVec2> {
        let samples = rows
            .clone()
            .flat_map(|row| columns.clone().map(move |column| DVec2::new(column as f64, row as f64)));
        samples.map(|sample| self.place(georeference, sample)).collect()
    }

    /// Column and row in the file of a sample of `georeference`.
    pub(super) fn place(&self, georeference: &GeoReference, sample: DVec2) -> DVec2 {
        let place = match self.way {
            Way::Affine(affine) => {
                let [left, top] = georeference.origin();
                affine.transform_point2(sample + DVec2::new(left as f64, top as f64))
            }
            Way::Geographic { middle } => self.own.grid(nearest_turn(georeference.geographic(sample), middle)),
        };
        match self.around {
            Some(around) if place.x < -HALF || place.x > around - 0.5 => {
                DVec2::new((place.x + 0.5).rem_euclid(around) - 0.5, place.y)
            }
            _ => place,
        }
    }
}

/// Whether a file goes around the whole Earth.
pub(super) fn is_around(file: &Layout) -> bool {
    let around = file.frame().columns_around();
    around.is_some_and(|around| file.columns as f64 > around - HALF)
}

/// The rectangle of the lattice of `lattice` that a file reaches into: first and end column, first and end row.
///
/// # Errors
/// When the file is not on the plane of the lattice's reference system, or hardly so.
pub(super) fn reach(lattice: &Layout, file: &Layout) -> Result<[Range<i64>; 2], ReadError> {
    let edge = edge(file);
    let position = |source| ReadError::Position(file.path.clone(), source);
    let points = to_plane(&lattice.crs, &file.crs, &edge).map_err(position)?;
    let middle = lattice
        .to_crs
        .transform_point2(DVec2::new(lattice.columns as f64, lattice.rows as f64) / 2.0);
    let near = |point: DVec2| match lattice.is_in_degrees {
        true => nearest_turn(point, middle.x),
        false => point,
    };
    let to_lattice = lattice.to_crs.inverse();
    let on_lattice = points.into_iter().map(|point| to_lattice.transform_point2(near(point)));
    let (low, high) = on_lattice.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
        (low.min(point), high.max(point))
    });
    // Not a number where PROJ has no place, too.
    let is_there = low.abs().max(high.abs()).cmplt(DVec2::splat(FARTHEST)).all();
    if !is_there {
        return Err(ReadError::Mixed {
            path: file.path.clone(),
            first: lattice.path.clone(),
            reason: "it reaches to where that one's coordinate system has no place for it".into(),
        });
    }
    Ok([0, 1].map(|axis| (low[axis] - SAME).floor() as i64..(high[axis] + SAME).ceil() as i64 + 1))
}

fn to_plane(lattice: &Crs, file: &Crs, points: &[DVec2]) -> Result<Vec<DVec2>, GeoReferenceError> {
    if lattice == file {
        return Ok(points.to_vec());
    }
    converted(file, lattice, points)
}

/// Points along the outer edge of a file's pixels, in its reference system.
fn edge(file: &Layout) -> Vec<DVec2> {
    let size = DVec2::new(file.columns as f64, file.rows as f64);
    let along = (0..=PROBES).map(|index| index as f64 / PROBES as f64);
    let sides = along.flat_map(|t| {
        [
            DVec2::new(t, 0.0),
            DVec2::new(t, 1.0),
            DVec2::new(0.0, t),
            DVec2::new(1.0, t),
        ]
    });
    sides
        .map(|share| file.to_crs.transform_point2(share * size - 0.5))
        .collect()
}

/// Columns and rows of a file that heights at `places` are made from; none where all are beside it.
pub(super) fn needed(places: &[DVec2], [columns, rows]: [usize; 2]) -> Option<[Range<usize>; 2]> {
    let size = [columns, rows];
    let inside = places.iter().filter_map(|&place| within(place, size));
    let (low, high) = inside.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), place| {
        (low.min(place), high.max(place))
    });
    (low.x <= high.x).then(|| {
        [0, 1].map(|axis| {
            let first = low[axis].floor() as usize;
            first..(high[axis].floor() as usize + 2).min(size[axis])
        })
    })
}

/// Heights at `places`, from a rectangle of a file's samples: bilinear, NaN where a sample that counts is void or there is none.
pub(super) fn bilinear(
    places: &[DVec2],
    size: [usize; 2],
    [columns, rows]: [&Range<usize>; 2],
    stored: &[f64],
) -> Vec<f64> {
    let at = |column: usize, row: usize| stored[(row - rows.start) * columns.len() + column - columns.start];
    let height = |&place: &DVec2| {
        let Some(place) = within(place, size) else {
            return f64::NAN;
        };
        let first = place.floor();
        let share = place - first;
        let [column, row] = [first.x as usize, first.y as usize];
        // Beside a void, a sample that has no share in the height does not make it void.
        let along = |row: usize| mix(at(column, row), share.x, || at(column + 1, row));
        mix(along(row), share.y, || along(row + 1))
    };
    places.iter().map(height).collect()
}

fn mix(a: f64, share: f64, b: impl Fn() -> f64) -> f64 {
    if share == 0.0 { a } else { a + (b() - a) * share }
}

/// A place on the samples of a file, if it belongs to one of them.
fn within(place: DVec2, [columns, rows]: [usize; 2]) -> Option<DVec2> {
    let last = DVec2::new((columns - 1) as f64, (rows - 1) as f64);
    let is_inside = place.cmpge(DVec2::splat(-HALF)).all() && place.cmple(last + HALF).all();
    let nearest = place.round();
    let snap = |axis: usize| {
        if (place[axis] - nearest[axis]).abs() < SAME {
            nearest[axis]
        } else {
            place[axis]
        }
    };
    is_inside.then(|| DVec2::new(snap(0), snap(1)).clamp(DVec2::ZERO, last))
}

#[cfg(test)]
#[path = "between_tests.rs"]
mod tests;
