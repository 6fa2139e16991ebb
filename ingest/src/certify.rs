//! The certified error of a finished surface: measured on the Earth, not in the simplifier's model of it.
//!
//! Triangles are flat in Earth-centred coordinates between vertices of the lattice, as a client draws them; the
//! deviation at a sample P with the ellipsoid's normal n is N·(P − V) / (N·n) for a triangle through V with normal N.
//!
//! ```text
//! for each triangle: each valid sample whose normal line crosses it
//! for each edge:     each place where it crosses a grid line, and the summit of the difference in between
//! bound ← the largest of these + what curvature can add inside a cell: (column² + row²) / 8R
//! ```
//! The difference from a bilinear cell is, but for the curvature, a bilinear function without summits of its own.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use terrain_core::Mesh;
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::scan;
use terrain_tiles::ellipsoid::{self, Geodetic};


/// Third-order terms of the curvature inside a cell, as a share of the second-order one.
const HIGHER_ORDER: f64 = 1.1;
/// Metres by which a sample may lie beside a triangle and still be taken as covered by it.
const BESIDE: f64 = 1e-3;
/// Share of the way to the middle of a piece from an end that is outside the piece's cell by rounding.
const INWARDS: f64 = 1e-6;
/// Cells by which a straight edge in space may leave the straight line on the grid before it is cut into stretches. What a
/// parabola leaves out of a stretch is smaller by another factor of its length over the Earth's radius.
const STRAIGHT: f64 = 1e-4;

/// A vertex on the Earth and on the raster.
#[derive(Clone, Copy)]
struct Place {
    space: DVec3,
    longitude: f64,
    height: f64,
    grid: DVec2,
}

impl Place {
    /// Column, row and height.
    fn seen(self) -> DVec3 {
        self.grid.extend(self.height)
    }
}

/// Measures surfaces against one raster.
pub(crate) struct Certifier<'a> {
    grid: &'a HeightGrid,
    bound: Bound,
    /// Where longitude depends on the column alone and latitude on the row alone: sine and cosine of each.
    separable: Option<[Vec<DVec2>; 2]>,
}

impl<'a> Certifier<'a> {
    pub(crate) fn new(grid: &'a HeightGrid, bound: Bound) -> Self {
        let place = |column, row| grid.georeference.geographic(DVec2::new(column as f64, row as f64));
        let last = place(grid.columns - 1, grid.rows - 1);
        let is_upright = place(grid.columns - 1, 0).y == place(0, 0).y && place(grid.columns - 1, 0).x == last.x;
        let sine_and_cosine = |degrees: f64| DVec2::from(degrees.to_radians().sin_cos());
        let separable = (grid.georeference.is_geographic() && is_upright).then(|| {
            let columns = (0..grid.columns)
                .map(|column| sine_and_cosine(place(column, 0).x))
                .collect();
            [
                columns,
                (0..grid.rows).map(|row| sine_and_cosine(place(0, row).y)).collect(),
            ]
        });
        Self { grid, bound, separable }
    }

    /// The ellipsoid's normal at a sample.
    fn up(&self, column: usize, row: usize) -> DVec3 {
        match &self.separable {
            Some([longitudes, latitudes]) => {
                let (longitude, latitude) = (longitudes[column], latitudes[row]);
                DVec3::new(latitude.y * longitude.y, latitude.y * longitude.x, latitude.x)
            }
            None => {
                let at = self.grid.georeference.geographic(DVec2::new(column as f64, row as f64));
                ellipsoid::normal(at.x, at.y)
            }
        }
    }

    /// An upper bound of the vertical deviation between `surface` and the raster's surface, in metres. `geodetic` gives
    /// the longitude (in the range of the raster's), latitude and height of a vertex.
    pub(crate) fn vertical_error(&self, surface: &Mesh, geodetic: impl Fn(DVec3) -> Geodetic) -> f64 {
        let grid = self.grid;
        let places: Vec<Place> = surface
            .positions
            .iter()
            .map(|&position| place(grid, geodetic(position)))
            .collect();
        let largest = |a: f64, b: f64| a.max(b);
        let corners = surface
            .triangles
            .par_iter()
            .map(|corners| corners.map(|corner| places[corner as usize]));
        let worst = corners.map(|corners| self.at_samples(corners)).reduce(|| 0.0, largest);
        if self.bound == Bound::Samples {
            return worst;
        }
        let ordered = |a: u32, b: u32| (a.min(b), a.max(b));
        let edges: BTreeSet<(u32, u32)> = surface
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [ordered(a, b), ordered(b, c), ordered(c, a)])
            .collect();
        let along = edges
            .into_par_iter()
            .map(|(a, b)| along_edge(grid, places[a as usize], places[b as usize]));
        along.reduce(|| worst, largest) + curvature_in_a_cell(grid)
    }

    fn at_samples(&self, corners: [Place; 3]) -> f64 {
        let grid = self.grid;
        let [a, b, c] = corners.map(|corner| corner.space);
        let normal = (b - a).cross(c - a);
        let margin = 0.02 + corners_bulge(grid, &corners);
        let low = corners.iter().map(|corner| corner.grid.y).fold(f64::INFINITY, f64::min) - margin;
        let high = corners
            .iter()
            .map(|corner| corner.grid.y)
            .fold(f64::NEG_INFINITY, f64::max)
            + margin;
        let mut worst: f64 = 0.0;
        for row in whole_numbers(low, high, grid.rows) {
            let (from, to) = span(row as f64, margin, corners.map(|corner| corner.grid));
            for column in whole_numbers(from, to, grid.columns) {
                let height = grid.height(column, row);
                let up = self.up(column, row);
                let sample = ellipsoid::above(up, f64::from(height));
                let covers =
                    |(p, q): (DVec3, DVec3)| up.dot((p - sample).cross(q - sample)) >= -BESIDE * (q - p).length();
                if !height.is_nan() && [(a, b), (b, c), (c, a)].into_iter().all(covers) {
                    worst = worst.max((normal.dot(sample - a) / normal.dot(up)).abs());
                }
            }
        }
        worst
    }
}

/// The whole numbers from `low` to `high` that are indices below `end`.
fn whole_numbers(low: f64, high: f64, end: usize) -> std::ops::Range<usize> {
    low.ceil().max(0.0) as usize..((high.floor() + 1.0).max(0.0) as usize).min(end)
}

/// What the ellipsoid's curvature can add to the extremes of a bilinear function inside one cell, metres.
fn curvature_in_a_cell(grid: &HeightGrid) -> f64 {
    let rows = [0.0, 0.5, 1.0].map(|share| (grid.rows - 1) as f64 * share);
    let squared = rows.map(|row| {
        let cell = grid
            .georeference
            .cell_metres(DVec2::new((grid.columns - 1) as f64 / 2.0, row));
        cell.length_squared()
    });
    HIGHER_ORDER * squared.into_iter().fold(0.0, f64::max) / (8.0 * ellipsoid::LEAST_CURVATURE_RADIUS)
}

fn place(grid: &HeightGrid, geodetic: Geodetic) -> Place {
    Place {
        space: ellipsoid::to_earth_centred(geodetic),
        longitude: geodetic.longitude,
        height: geodetic.height,
        grid: grid
            .georeference
            .grid(DVec2::new(geodetic.longitude, geodetic.latitude)),
    }
}

/// The largest deviation along a straight edge in space.
fn along_edge(grid: &HeightGrid, a: Place, b: Place) -> f64 {
    let count = (corners_bulge(grid, &[a, b]) / STRAIGHT).sqrt().ceil().max(1.0);
    let mut worst: f64 = 0.0;
    let mut from = a.seen();
    for number in 1..=count as usize {
        let middle = on_edge(grid, a, b, (number as f64 - 0.5) / count);
        let to = match number as f64 / count {
            end if end < 1.0 => on_edge(grid, a, b, end),
            _ => b.seen(),
        };
        worst = worst.max(Stretch::through([from, middle, to]).deviation(grid));
        from = to;
    }
    worst
}

/// Column, row and height of a place on a straight edge in space.
fn on_edge(grid: &HeightGrid, a: Place, b: Place, t: f64) -> DVec3 {
    let mut geodetic = ellipsoid::to_geodetic(a.space.lerp(b.space, t));
    geodetic.longitude += ((a.longitude - geodetic.longitude) / 360.0).round() * 360.0;
    let at = DVec2::new(geodetic.longitude, geodetic.latitude);
    grid.georeference.grid(at).extend(geodetic.height)
}

/// Part of a straight edge in space, so short that it is a parabola over the grid: column, row and height are
/// `from + t (slope + t bend)`, with t from 0 to 1.
struct Stretch {
    from: DVec3,
    slope: DVec3,
    bend: DVec3,
}

impl Stretch {
    /// The parabola through its two ends and, between these, its middle.
    fn through([from, middle, to]: [DVec3; 3]) -> Self {
        let bend = 2.0 * (from - 2.0 * middle + to);
        let slope = to - from - bend;
        Self { from, slope, bend }
    }

    fn at(&self, t: f64) -> DVec3 {
        self.from + t * (self.slope + t * self.bend)
    }

    /// Height above the raster; none beside it.
    fn difference(&self, grid: &HeightGrid, t: f64) -> Option<f64> {
        let at = self.at(t);
        grid.bilinear(at.truncate()).map(|height| at.z - height)
    }

    /// The largest difference.
    fn deviation(&self, grid: &HeightGrid) -> f64 {
        let mut worst: f64 = 0.0;
        let [from, to] = [0.0, 1.0].map(|t| self.at(t).truncate());
        scan::visit_cells(from, to, |start, end| {
            worst = worst.max(self.deviation_between(grid, start, end))
        });
        worst
    }

    /// The largest difference between two parameters, inside one cell.
    fn deviation_between(&self, grid: &HeightGrid, first: f64, last: f64) -> f64 {
        let middle = (first + last) / 2.0;
        // Where the surface ends, rounding may put the end of a piece beside the cell that the piece is in.
        let inwards = |t: f64| self.difference(grid, t + (middle - t) * INWARDS);
        let ends = [first, middle, last].map(|t| self.difference(grid, t).or_else(|| inwards(t)));
        let worst = ends.into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
        let [Some(at_first), Some(at_middle), Some(at_last)] = ends else {
            return worst;
        };
        let bend = at_first - 2.0 * at_middle + at_last;
        let summit = (at_first - at_last) / (4.0 * bend);
        if bend == 0.0 || summit.abs() >= 0.5 {
            return worst;
        }
        let at_summit = self.difference(grid, middle + summit * (last - first));
        worst.max(at_summit.unwrap_or(0.0).abs())
    }
}

/// How far, in cells, a straight line in space between the places can leave the straight line on the grid.
fn corners_bulge(grid: &HeightGrid, corners: &[Place]) -> f64 {
    let Some((first, rest)) = corners.split_first() else {
        return 0.0;
    };
    let longest = rest
        .iter()
        .map(|corner| corner.space.distance_squared(first.space))
        .fold(0.0, f64::max);
    let cell = grid.georeference.cell_metres(first.grid).min_element();
    let up = first.space.normalize();
    let steepness = 1.0 + (up.z / up.truncate().length().max(1e-3)).abs();
    // Twice the distance from the first corner bounds the third side, so four times its square.
    4.0 * longest * steepness / (8.0 * ellipsoid::LEAST_CURVATURE_RADIUS) / cell
}

/// First and last column of the triangle between `row − margin` and `row + margin`, each moved out by the margin.
fn span(row: f64, margin: f64, corners: [DVec2; 3]) -> (f64, f64) {
    let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
    for (p, q) in [
        (corners[0], corners[1]),
        (corners[1], corners[2]),
        (corners[2], corners[0]),
    ] {
        let (low, high) = if p.y <= q.y { (p, q) } else { (q, p) };
        let (bottom, top) = (low.y.max(row - margin), high.y.min(row + margin));
        if bottom > top {
            continue;
        }
        let at = |y: f64| low.lerp(high, (y - low.y) / (high.y - low.y)).x;
        let ends = if high.y > low.y {
            [at(bottom), at(top)]
        } else {
            [low.x, high.x]
        };
        from = from.min(ends[0]).min(ends[1]);
        to = to.max(ends[0]).max(ends[1]);
    }
    (from - margin, to + margin)
}

#[cfg(test)]
#[path = "certify_tests.rs"]
mod tests;
