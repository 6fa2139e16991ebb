//! Rasters around the whole Earth, closed at the antimeridian and at the poles.
//!
//! Whatever longitude such a raster begins at, its columns are counted from −180° on, so that the same samples in another
//! writing give the same tiles. Some columns are there twice, beyond −180° and beyond 180°, so that the surface goes on through the
//! antimeridian; tiles end there.
//!
//! ```text
//! columns  …, N−2, N−1 | 0, 1, …, N−1 | 0, 1, …              N of them are 360°
//! rows     a row at a pole has one height, the mean of its samples;
//!          where the row next to a pole ends up to a cell before it, a row beyond is added, so that the surface between the two
//!          comes to that height at the pole
//! ```

use std::ops::Range;

use glam::DVec2;

use crate::georeference::GeoReference;
use crate::raster::{OwnGrid, ReadError};
use crate::samples::{Extremes, Faults, Provenance, Raster, Rectangle};
use crate::store::Name;

/// Columns that are there twice, at either end: more than a tile looks beyond its sides.
const BESIDE: usize = 16;
/// Cells by which columns may miss 360°, or the first one a place that is meant: half a cell from the antimeridian, say.
const NEARLY: f64 = 0.01;

/// A raster as pyramids see it: closed if it goes around the Earth.
pub enum Seen<'a> {
    /// It goes around the Earth.
    Around(Box<Globe<'a>>),
    /// It has sides where it ends.
    Open(&'a dyn Raster),
}

impl<'a> Seen<'a> {
    /// Of any raster.
    #[must_use]
    pub fn new(raster: &'a dyn Raster) -> Self {
        Globe::around(raster).map_or(Self::Open(raster), |globe| Self::Around(Box::new(globe)))
    }

    /// What it is.
    #[must_use]
    pub fn raster(&self) -> &dyn Raster {
        match self {
            Self::Around(globe) => globe.as_ref(),
            Self::Open(raster) => *raster,
        }
    }
}

/// A raster around the whole Earth.
pub struct Globe<'a> {
    raster: &'a dyn Raster,
    georeference: GeoReference,
    /// Columns in 360°.
    around: usize,
    /// Column of the raster, not yet wrapped, at the first one that is not there twice.
    first: i64,
    /// The rows at or beyond the poles, northern or not: first and last.
    poles: [Option<Pole>; 2],
    /// Where each file is, each time that it is there.
    copies: Vec<Copy>,
}

/// A row at a pole, or just beyond it.
#[derive(Clone, Copy)]
struct Pole {
    /// The raster's row at the pole or next to it.
    nearest: usize,
    /// Rows from that one to the pole, 0 or up to 1.
    share: f64,
}

struct Copy {
    file: usize,
    extent: [Range<usize>; 2],
}

impl<'a> Globe<'a> {
    /// None where the raster does not go around the Earth, by columns along parallels.
    fn around(raster: &'a dyn Raster) -> Option<Self> {
        let of_lattice = raster.georeference().of_lattice();
        let at = |column: f64, row: f64| of_lattice.geographic(DVec2::new(column, row));
        let [place, beside, below] = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        let step = DVec2::new(beside.x - place.x, below.y - place.y);
        let is_along_parallels =
            of_lattice.is_geographic() && beside.y == place.y && below.x == place.x && step.x > 0.0;
        let around = (360.0 / step.x).round();
        let [columns, rows] = raster.size();
        let is_around = is_along_parallels && (around - 360.0 / step.x).abs() < NEARLY && columns as f64 >= around;
        if !is_around || around < 2.0 {
            return None;
        }
        let to_first = ((-180.0 - place.x) / step.x - NEARLY).ceil();
        let beyond = snapped((place.x + 180.0) / step.x + to_first);
        let [left, top] = raster.origin();
        let poles = [(top, 0), (top + rows as i64 - 1, rows - 1)]
            .map(|(row, nearest)| pole(at(0.0, row as f64).y, step.y, nearest));
        let added = poles.map(|pole| usize::from(pole.is_some_and(|pole| pole.share > 0.0)));
        let around = around as usize;
        let georeference = of_lattice
            .around(-180.0 + beyond * 360.0 / around as f64, around)
            .window(
                [-(BESIDE as i64), top - added[0] as i64],
                around + 2 * BESIDE,
                rows + added[0] + added[1],
            );
        let mut globe = Self {
            raster,
            georeference,
            around,
            first: to_first as i64 - left,
            poles,
            copies: Vec::new(),
        };
        globe.copies = globe.all_copies();
        Some(globe)
    }

    /// Rows before the raster's first one.
    fn rows_before(&self) -> usize {
        usize::from(self.has_row_beyond(0))
    }

    fn has_row_beyond(&self, end: usize) -> bool {
        self.poles[end].is_some_and(|pole| pole.share > 0.0)
    }

    /// Where files are, as often as they are there, with the rows beyond the poles.
    fn all_copies(&self) -> Vec<Copy> {
        let [width, height] = Raster::size(self);
        let last = self.raster.size()[1];
        let mut copies = Vec::new();
        for (file, [columns, rows]) in self.raster.extents().into_iter().enumerate() {
            let first = if rows.start == 0 {
                0
            } else {
                rows.start + self.rows_before()
            };
            let end = if rows.end == last {
                height
            } else {
                rows.end + self.rows_before()
            };
            let once = columns.start as i64 - self.first + BESIDE as i64;
            for turn in -2..=2 {
                let start = once + turn * self.around as i64;
                let within = |column: i64| column.clamp(0, width as i64) as usize;
                let columns = within(start)..within(start + columns.len() as i64);
                if !columns.is_empty() {
                    let extent = [columns, first..end];
                    copies.push(Copy { file, extent });
                }
            }
        }
        copies
    }

    /// Columns of the raster that hold a run of columns, by pieces, and whether each is there elsewhere, too.
    fn pieces(&self, columns: &Range<usize>) -> Vec<(Range<usize>, bool)> {
        let once = BESIDE..BESIDE + self.around;
        let mut pieces = Vec::new();
        let mut from = columns.start;
        while from < columns.end {
            let column = (from as i64 - BESIDE as i64 + self.first).rem_euclid(self.around as i64) as usize;
            let stops = [columns.end, once.start, once.end, from + self.around - column];
            let to = stops
                .into_iter()
                .filter(|&stop| stop > from)
                .min()
                .unwrap_or(columns.end);
            pieces.push((column..column + to - from, !once.contains(&from)));
            from = to;
        }
        pieces
    }

    /// A rectangle of the raster's own rows.
    fn read_rows(&self, columns: &Range<usize>, rows: &Range<usize>) -> Result<Rectangle, ReadError> {
        let mut whole = Rectangle {
            heights: vec![f32::NAN; columns.len() * rows.len()],
            filled: Vec::new(),
            faults: vec![Faults::default(); self.raster.extents().len()],
        };
        let mut from = 0;
        for (piece, is_twice) in self.pieces(columns) {
            for again in [0, self.around] {
                let there = piece.start + again..(piece.end + again).min(self.raster.size()[0]);
                if there.is_empty() {
                    continue;
                }
                let part = self.raster.read(there.clone(), rows.clone())?;
                for (row, heights) in part.heights.chunks_exact(there.len()).enumerate() {
                    fill(&mut whole.heights[row * columns.len() + from..], heights);
                }
                let in_whole = |index: usize| index / there.len() * columns.len() + from + index % there.len();
                whole.filled.extend(part.filled.into_iter().map(in_whole));
                if !is_twice {
                    whole
                        .faults
                        .iter_mut()
                        .zip(part.faults)
                        .for_each(|(sum, faults)| *sum = sum.with(faults));
                }
            }
            from += piece.len();
        }
        whole.filled.sort_unstable();
        Ok(whole)
    }

    /// The row at a pole, or beyond it.
    fn read_pole(&self, pole: Pole, columns: &Range<usize>) -> Result<Vec<f32>, ReadError> {
        let row = pole.nearest..pole.nearest + 1;
        let all = self.read_rows(&(BESIDE..BESIDE + self.around), &row)?.heights;
        let there: Vec<f64> = all
            .iter()
            .filter(|height| !height.is_nan())
            .map(|&height| height.into())
            .collect();
        let mean = there.iter().sum::<f64>() / there.len() as f64;
        let beyond = |height: f32| match pole.share {
            0.0 => mean as f32,
            share => (f64::from(height) + (mean - f64::from(height)) / share) as f32,
        };
        let around = self.around as i64;
        let height = |column: usize| all[(column as i64 - BESIDE as i64).rem_euclid(around) as usize];
        Ok(columns.clone().map(|column| beyond(height(column))).collect())
    }
}

impl Raster for Globe<'_> {
    fn size(&self) -> [usize; 2] {
        let added = [0, 1].map(|end| usize::from(self.has_row_beyond(end)));
        [self.around + 2 * BESIDE, self.raster.size()[1] + added[0] + added[1]]
    }

    fn origin(&self) -> [i64; 2] {
        self.georeference.origin()
    }

    fn extents(&self) -> Vec<[Range<usize>; 2]> {
        self.copies.iter().map(|copy| copy.extent.clone()).collect()
    }

    fn coarseness(&self) -> Vec<f64> {
        let of_files = self.raster.coarseness();
        self.copies.iter().map(|copy| of_files[copy.file]).collect()
    }

    fn block_rows(&self) -> usize {
        self.raster.block_rows()
    }

    fn read(&self, columns: Range<usize>, rows: Range<usize>) -> Result<Rectangle, ReadError> {
        let (height, before) = (Raster::size(self)[1], self.rows_before());
        let own = rows.start.max(before)..rows.end.min(before + self.raster.size()[1]);
        let read = self.read_rows(&columns, &(own.start - before..own.end.max(own.start) - before))?;
        let mut heights = vec![f32::NAN; columns.len() * rows.len()];
        let from = (own.start - rows.start) * columns.len();
        heights[from..from + read.heights.len()].copy_from_slice(&read.heights);
        for (pole, row) in self.poles.iter().zip([0, height - 1]) {
            if let Some(pole) = pole.filter(|_| rows.contains(&row)) {
                let from = (row - rows.start) * columns.len();
                heights[from..from + columns.len()].copy_from_slice(&self.read_pole(pole, &columns)?);
            }
        }
        let mut faults = vec![Faults::default(); self.copies.len()];
        let found = read.faults.into_iter().enumerate();
        for (file, of_file) in found.filter(|(_, of_file)| *of_file != Faults::default()) {
            let reaches = |copy: &Copy| {
                copy.file == file && copy.extent[0].start < columns.end && columns.start < copy.extent[0].end
            };
            if let Some(copy) = self.copies.iter().position(reaches) {
                faults[copy] = faults[copy].with(of_file);
            }
        }
        Ok(Rectangle {
            heights,
            filled: read.filled.into_iter().map(|index| index + from).collect(),
            faults,
        })
    }

    fn read_own(&self, own: &OwnGrid, columns: Range<usize>, rows: Range<usize>) -> Result<Vec<f32>, ReadError> {
        self.raster.read_own(own, columns, rows)
    }

    fn georeference(&self) -> &GeoReference {
        &self.georeference
    }

    fn provenance(&self) -> Provenance {
        self.raster.provenance()
    }

    fn remark(&self, extremes: Option<Extremes>, faults: &[Faults]) -> Result<(), ReadError> {
        let mut of_files = vec![Faults::default(); self.raster.extents().len()];
        for (copy, &faults) in self.copies.iter().zip(faults) {
            of_files[copy.file] = of_files[copy.file].with(faults);
        }
        self.raster.remark(extremes, &of_files)
    }

    /// A row at a pole depends on all files.
    fn stamps(&self) -> Vec<String> {
        let stamps = self.raster.stamps();
        let all = Name::of(stamps.iter().map(|stamp| stamp.as_bytes())).to_string();
        let has_pole = self.poles.iter().any(Option::is_some);
        let of_copy = |copy: &Copy| match has_pole {
            true => format!("{} {all}", stamps[copy.file]),
            false => stamps[copy.file].clone(),
        };
        self.copies.iter().map(of_copy).collect()
    }
}

/// Puts heights where there are none yet.
fn fill(to: &mut [f32], heights: &[f32]) {
    for (to, &height) in to.iter_mut().zip(heights) {
        if to.is_nan() {
            *to = height;
        }
    }
}

/// The pole that a first or last row at a latitude, of rows so many degrees apart, comes to.
fn pole(latitude: f64, step: f64, nearest: usize) -> Option<Pole> {
    let share = snapped((90.0 - latitude.abs()) / step.abs());
    (0.0..=1.0).contains(&share).then_some(Pole { nearest, share })
}

/// A number of cells that is nearly whole or half is meant to be.
fn snapped(cells: f64) -> f64 {
    let halves = (2.0 * cells).round() / 2.0;
    if (cells - halves).abs() < NEARLY { halves } else { cells }
}

#[cfg(test)]
#[path = "globe_tests.rs"]
mod tests;
