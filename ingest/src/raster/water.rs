//! Lakes, and other polygons within which the surface is level.
//!
//! ```text
//! polygons of a vector file ─▶ the lattice's coordinates ─▶ level: the median of the samples inside ─▶ all samples inside
//! ```

use std::ops::Range;
use std::path::Path;

use glam::{DAffine2, DVec2};
use terrain_tiles::water;

use super::ReadError;
use super::composition::common;
use super::vectors::{polygons, rings_in, wgs84};
use crate::georeference::{Crs, nearest_turn};

/// Places in a degree that are told of water: a centimetre on the ground.
const PLACES_IN_A_DEGREE: f64 = 1e7;
/// Rows that are read at once to find a level.
const ROWS_AT_ONCE: i64 = 64;
/// Samples that a level is found from, at most.
const MOST_SAMPLES: usize = 1 << 20;

/// A polygon that is level.
pub(super) struct Lake {
    /// Its rings in degrees of longitude and latitude, if it is water.
    pub(super) on_earth: Vec<Vec<[f64; 2]>>,
    /// Rings in coordinates of the lattice of samples: what is inside of an odd number of them is inside.
    rings: Vec<Vec<DVec2>>,
    /// Columns and rows of the lattice that it reaches into.
    extent: [Range<i64>; 2],
    /// Metres, once it is known.
    pub(super) level: Option<f32>,
}

/// The polygons of a vector file on the lattice that `to_crs` leads from.
///
/// Polygons for ground that is nowhere on the Earth are in metres of its plane, whatever the file says.
///
/// # Errors
/// When the file cannot be read, or has no place on the lattice's plane.
pub(super) fn lakes(path: &Path, is_water: bool, lattice: &Crs, to_crs: DAffine2) -> Result<Vec<Lake>, ReadError> {
    let laid = lattice.is_laid_plane().then_some(lattice);
    let position = |source| ReadError::Position(path.to_owned(), source);
    let (to_lattice, wgs84) = (to_crs.inverse(), wgs84());
    let mut found = Vec::new();
    for layer in polygons(path, laid)? {
        for of_feature in layer.features {
            let rings = of_feature.concat();
            let on_earth = if is_water {
                rings_in(&rings, &layer.crs, &wgs84).map_err(position)?
            } else {
                Vec::new()
            };
            let mut on_lattice = rings_in(&rings, &layer.crs, lattice).map_err(position)?;
            let points = on_lattice.iter_mut().flatten();
            points.for_each(|at| *at = to_lattice.transform_point2(*at));
            found.push(Lake {
                on_earth: on_earth.iter().map(|ring| degrees(ring)).collect(),
                ..Lake::new(on_lattice)
            });
        }
    }
    Ok(found)
}

/// A ring of longitudes and latitudes, to a centimetre on the ground; longitudes go on past the antimeridian.
fn degrees(ring: &[DVec2]) -> Vec<[f64; 2]> {
    let mut before = ring.first().map_or(0.0, |first| first.x);
    let place = |&at: &DVec2| {
        let at = nearest_turn(at, before);
        before = at.x;
        ((at * PLACES_IN_A_DEGREE).round() / PLACES_IN_A_DEGREE).to_array()
    };
    ring.iter().map(place).collect()
}

impl Lake {
    /// Of rings in coordinates of the lattice.
    fn new(rings: Vec<Vec<DVec2>>) -> Self {
        let nowhere = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let points = rings.iter().flatten();
        let (low, high) = points.fold(nowhere, |(low, high), &at| (low.min(at), high.max(at)));
        Self {
            extent: [0, 1].map(|axis| low[axis].ceil() as i64..high[axis].floor() as i64 + 1),
            rings,
            on_earth: Vec::new(),
            level: None,
        }
    }

    /// Columns and rows of the lattice around it.
    pub(super) fn extent(&self) -> &[Range<i64>; 2] {
        &self.extent
    }

    /// What it has of columns and rows of the lattice.
    fn within(&self, [columns, rows]: [&Range<i64>; 2]) -> [Range<i64>; 2] {
        [common(&self.extent[0], columns), common(&self.extent[1], rows)]
    }

    /// Columns of the lattice that are inside, for each of some rows.
    fn runs(&self, rows: Range<i64>) -> Vec<Vec<Range<i64>>> {
        water::runs(&self.rings, rows)
    }

    /// Makes a rectangle of samples level where it is inside.
    pub(super) fn level_in(&self, [columns, rows]: [&Range<i64>; 2], heights: &mut [f32]) {
        let (Some(level), width) = (self.level, (columns.end - columns.start) as usize) else {
            return;
        };
        let [across, down] = self.within([columns, rows]);
        if across.is_empty() {
            return;
        }
        for (row, runs) in down.clone().zip(self.runs(down)) {
            let first = (row - rows.start) as usize * width;
            for run in runs {
                for column in common(&run, columns) {
                    heights[first + (column - columns.start) as usize] = level;
                }
            }
        }
    }
}

/// The level of the samples that `read` gives by columns and rows: their median; none where all are void.
pub(super) fn level(
    lake: &Lake,
    within: [&Range<i64>; 2],
    read: impl Fn([&Range<i64>; 2]) -> Result<Vec<f32>, ReadError>,
) -> Result<Option<f32>, ReadError> {
    let [columns, rows] = lake.within(within);
    let mut heights = Vec::new();
    let mut row = rows.start;
    while row < rows.end && !columns.is_empty() && heights.len() < MOST_SAMPLES {
        let strip = row..(row + ROWS_AT_ONCE).min(rows.end);
        let read = read([&columns, &strip])?;
        let width = (columns.end - columns.start) as usize;
        for (line, runs) in read.chunks_exact(width).zip(lake.runs(strip.clone())) {
            let inside = runs.into_iter().flat_map(|run| common(&run, &columns));
            let there = inside.map(|column| line[(column - columns.start) as usize]);
            heights.extend(there.filter(|height| !height.is_nan()));
        }
        row = strip.end;
    }
    let middle = heights.len() / 2;
    Ok((!heights.is_empty()).then(|| *heights.select_nth_unstable_by(middle, f32::total_cmp).1))
}

#[cfg(test)]
#[path = "water_tests.rs"]
mod tests;
