//! Lakes: polygons within which the surface is level.
//!
//! ```text
//! polygons of a vector file ─▶ the lattice's coordinates ─▶ level: the median of the samples inside ─▶ all samples inside
//! ```

use std::ops::Range;
use std::path::Path;

use gdal::vector::{GeometryRef, LayerAccess, OGRwkbGeometryType};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};
use glam::{DAffine2, DVec2};

use super::composition::common;
use super::drivers::{VECTOR_DRIVERS, prepare_gdal};
use super::{ReadError, crs};
use crate::georeference::{Crs, converted};

/// Vertices of all polygons of a file, at most.
const MOST_VERTICES: usize = 1 << 24;
/// Rows that are read at once to find a level.
const ROWS_AT_ONCE: i64 = 64;
/// Samples that a level is found from, at most.
const MOST_SAMPLES: usize = 1 << 20;

/// A polygon that is level.
pub(super) struct Lake {
    /// Rings in coordinates of the lattice of samples: what is inside of an odd number of them is inside.
    rings: Vec<Vec<DVec2>>,
    /// Columns and rows of the lattice that it reaches into.
    extent: [Range<i64>; 2],
    /// Metres, once it is known.
    pub(super) level: Option<f32>,
}

/// The polygons of a vector file on the lattice that `to_crs` leads from.
///
/// # Errors
/// When the file cannot be read, or has no place on the lattice's plane.
pub(super) fn lakes(path: &Path, lattice: &Crs, to_crs: DAffine2) -> Result<Vec<Lake>, ReadError> {
    prepare_gdal(false);
    std::fs::metadata(path).map_err(|error| ReadError::unreadable(path, error))?;
    let options = DatasetOptions {
        open_flags: GdalOpenFlags::GDAL_OF_VECTOR | GdalOpenFlags::GDAL_OF_READONLY,
        allowed_drivers: Some(&VECTOR_DRIVERS),
        ..DatasetOptions::default()
    };
    let dataset = Dataset::open_ex(path, options).map_err(|error| ReadError::gdal(path, error))?;
    let to_lattice = to_crs.inverse();
    let mut found = Vec::new();
    let mut vertices = 0;
    for mut layer in dataset.layers() {
        let reference = layer.spatial_ref().ok_or_else(|| ReadError::NoCrs(path.to_owned()))?;
        let own = crs::describe(&reference).ok_or_else(|| ReadError::NoCrs(path.to_owned()))?;
        for feature in layer.features() {
            let Some(geometry) = feature.geometry() else { continue };
            let mut rings = Vec::new();
            collect_rings(geometry, &mut rings);
            vertices += rings.iter().map(Vec::len).sum::<usize>();
            if vertices > MOST_VERTICES {
                return Err(ReadError::TooLarge {
                    path: path.to_owned(),
                    what: format!("{vertices} vertices of polygons"),
                    limit: MOST_VERTICES,
                });
            }
            let on_lattice = |ring: Vec<DVec2>| {
                let points = if own == *lattice {
                    Ok(ring)
                } else {
                    converted(&own, lattice, &ring)
                };
                points.map(|points| points.into_iter().map(|at| to_lattice.transform_point2(at)).collect())
            };
            let rings: Result<Vec<Vec<DVec2>>, _> = rings.into_iter().map(on_lattice).collect();
            let rings = rings.map_err(|source| ReadError::Position(path.to_owned(), source))?;
            found.push(Lake::new(rings));
        }
    }
    if found.iter().all(|lake| lake.rings.is_empty()) {
        return Err(ReadError::unreadable(path, "it has no polygon"));
    }
    Ok(found)
}

/// The rings of a polygon, or of all polygons of a collection.
fn collect_rings(geometry: &gdal::vector::Geometry, rings: &mut Vec<Vec<DVec2>>) {
    let is_polygon = |kind| matches!(kind, OGRwkbGeometryType::wkbPolygon | OGRwkbGeometryType::wkbPolygon25D);
    for index in 0..geometry.geometry_count() {
        let part: GeometryRef<'_> = geometry.get_geometry(index);
        if is_polygon(geometry.geometry_type()) {
            let mut points = Vec::new();
            part.get_points(&mut points);
            rings.push(points.into_iter().map(|(x, y, _)| DVec2::new(x, y)).collect());
        } else {
            collect_rings(&part, rings);
        }
    }
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
            level: None,
        }
    }

    /// What it has of columns and rows of the lattice.
    fn within(&self, [columns, rows]: [&Range<i64>; 2]) -> [Range<i64>; 2] {
        [common(&self.extent[0], columns), common(&self.extent[1], rows)]
    }

    /// Columns of a row of the lattice that are inside.
    pub(super) fn runs(&self, row: i64) -> Vec<Range<i64>> {
        let y = row as f64;
        let mut crossings: Vec<f64> = self.rings.iter().flat_map(|ring| crossings(ring, y)).collect();
        crossings.sort_by(f64::total_cmp);
        let pairs = crossings.chunks_exact(2);
        pairs.map(|pair| pair[0].ceil() as i64..pair[1].ceil() as i64).collect()
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
        for row in down {
            let first = (row - rows.start) as usize * width;
            for run in self.runs(row) {
                for column in common(&run, columns) {
                    heights[first + (column - columns.start) as usize] = level;
                }
            }
        }
    }
}

/// Where a closed ring crosses a row.
fn crossings(ring: &[DVec2], y: f64) -> impl Iterator<Item = f64> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).filter_map(move |(a, b)| {
        let is_across = (a.y <= y) != (b.y <= y);
        is_across.then(|| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
    })
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
        for (line, row) in read.chunks_exact(width).zip(strip.clone()) {
            let runs = lake.runs(row).into_iter();
            let inside = runs.flat_map(|run| common(&run, &columns));
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
