//! Heights of several files become one: which counts, how others are bent to meet it, and how voids are filled.
//!
//! ```text
//! lay      the file that counts first; below it the next, bent near the joint by as much as both differ there
//! fill     voids that are no wider than so many metres, smoothly from their rims
//! ```
//! What is made at a sample depends on the samples within [`Rules::reach`] of it, not on what rectangle is read.

use std::ops::Range;

use crate::distances::distances;
use crate::samples::Faults;
use crate::spread::Values;

/// Metres by which files may differ where they overlap without being bent.
pub(super) const AGREEMENT: f32 = 0.01;
/// How often filled samples become the mean of those around them.
const SMOOTHINGS: usize = 16;

/// What is asked of a composition, in metres.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    /// From column to column and from row to row.
    pub(super) cell: [f64; 2],
    /// For each file, how far from a joint it is bent to meet one that counts before it.
    pub(super) blends: Vec<f64>,
    /// The widest void that is filled.
    pub(super) fill: Option<f64>,
}

impl Rules {
    /// Samples around a rectangle that its heights depend on.
    pub(super) fn reach(&self) -> usize {
        let blend = self.blends.iter().copied().fold(0.0, f64::max);
        let is_alone = self.blends.len() < 2 || blend == 0.0;
        let of_blend = if is_alone { 0 } else { 2 << self.levels(blend) };
        let of_fill = self.fill.map_or(0, |width| {
            let closing = (width / self.cell[0].min(self.cell[1])).ceil() as usize + 1;
            closing.max(2 << self.levels(width / 2.0)) + SMOOTHINGS
        });
        of_blend + of_fill
    }

    /// So that squares of 2^levels samples are as wide as `metres`.
    fn levels(&self, metres: f64) -> u32 {
        let samples = metres / self.cell[0].min(self.cell[1]);
        (samples.ceil() as usize).next_power_of_two().ilog2()
    }
}

/// Heights of a rectangle of samples, row by row; NaN where void.
pub(super) struct Composition<'a> {
    rules: &'a Rules,
    columns: Range<i64>,
    rows: Range<i64>,
    heights: Vec<f32>,
}

impl<'a> Composition<'a> {
    /// Without a height yet; columns and rows are counted on the lattice.
    pub(super) fn new(rules: &'a Rules, [columns, rows]: [Range<i64>; 2]) -> Self {
        let samples = (columns.end - columns.start) as usize * (rows.end - rows.start) as usize;
        Self {
            rules,
            columns,
            rows,
            heights: vec![f32::NAN; samples],
        }
    }

    fn width(&self) -> usize {
        (self.columns.end - self.columns.start) as usize
    }

    /// Whether nothing was laid here yet.
    fn is_void(&self) -> bool {
        self.heights.iter().all(|height| height.is_nan())
    }

    /// How far heights below are from those that count.
    pub(super) fn differences(&self, below: &[f32]) -> Faults {
        let both = self
            .heights
            .iter()
            .zip(below)
            .map(|(above, below)| (above - below).abs());
        both.filter(|&apart| apart > AGREEMENT)
            .fold(Faults::default(), |faults, apart| Faults {
                disagreeing: faults.disagreeing + 1,
                apart: faults.apart.max(apart),
                ..faults
            })
    }

    /// Heights of a file go where no earlier one has any.
    pub(super) fn lay(&mut self, file: usize, below: &[f32]) {
        let blend = self.rules.blends[file];
        let bends = if blend == 0.0 || self.is_void() {
            None
        } else {
            self.bends(below, blend)
        };
        for (index, (height, &below)) in self.heights.iter_mut().zip(below).enumerate() {
            if height.is_nan() {
                *height = below + bends.as_ref().map_or(0.0, |bends| bends[index]);
            }
        }
    }

    /// By how much heights below the others are bent; none where both agree everywhere.
    fn bends(&self, below: &[f32], blend: f64) -> Option<Vec<f32>> {
        let apart = |(&above, &below): (&f32, &f32)| {
            let apart = above - below;
            if apart.abs() > AGREEMENT || apart.is_nan() {
                apart
            } else {
                0.0
            }
        };
        let apart: Vec<f32> = self.heights.iter().zip(below).map(apart).collect();
        if !apart.iter().any(|&apart| apart.abs() > 0.0) {
            return None;
        }
        let spread = self.values(apart).spread(self.rules.levels(blend));
        let there: Vec<bool> = self.heights.iter().map(|height| !height.is_nan()).collect();
        let distances = distances(&there, self.width(), self.rules.cell);
        let bend = |(apart, distance): (f32, f32)| {
            if apart.is_nan() {
                return 0.0;
            }
            apart * fading(f64::from(distance) / blend) as f32
        };
        Some(spread.into_iter().zip(distances).map(bend).collect())
    }

    /// Fills voids that are not too wide. Returns how many samples of `columns` and `rows` it filled.
    pub(super) fn fill(&mut self, [columns, rows]: [&Range<i64>; 2]) -> u64 {
        let Some(width) = self.rules.fill else { return 0 };
        let is_narrow = self.narrow(width / 2.0);
        let is_filled = |(height, is_narrow): (&f32, bool)| height.is_nan() && is_narrow;
        let filled: Vec<bool> = self.heights.iter().zip(is_narrow).map(is_filled).collect();
        if !filled.contains(&true) {
            return 0;
        }
        let spread = self.values(self.heights.clone()).spread(self.rules.levels(width / 2.0));
        let places = (0..filled.len()).filter(|&index| filled[index]);
        let places: Vec<usize> = places.filter(|&index| !spread[index].is_nan()).collect();
        for &place in &places {
            self.heights[place] = spread[place];
        }
        for _ in 0..SMOOTHINGS {
            let smoother: Vec<f32> = places.iter().map(|&place| self.mean_around(place)).collect();
            places
                .iter()
                .zip(smoother)
                .for_each(|(&place, height)| self.heights[place] = height);
        }
        let is_inside = |place: &&usize| {
            let (column, row) = ((**place % self.width()) as i64, (**place / self.width()) as i64);
            columns.contains(&(self.columns.start + column)) && rows.contains(&(self.rows.start + row))
        };
        places.iter().filter(is_inside).count() as u64
    }

    /// Samples that are in the data when these are grown by a distance and then shrunk by it: holes close, outer rims stay.
    fn narrow(&self, distance: f64) -> Vec<bool> {
        let there: Vec<bool> = self.heights.iter().map(|height| !height.is_nan()).collect();
        let grown = distances(&there, self.width(), self.rules.cell);
        let beyond: Vec<bool> = grown.iter().map(|&from| f64::from(from) > distance).collect();
        let shrunk = distances(&beyond, self.width(), self.rules.cell);
        shrunk.iter().map(|&from| f64::from(from) > distance).collect()
    }

    fn mean_around(&self, place: usize) -> f32 {
        let (width, column) = (self.width(), place % self.width());
        let beside = [
            (column > 0).then(|| place - 1),
            (column + 1 < width).then_some(place + 1),
            place.checked_sub(width),
            Some(place + width).filter(|&below| below < self.heights.len()),
        ];
        let heights = beside.into_iter().flatten().map(|place| self.heights[place]);
        let (sum, count) = heights
            .filter(|height| !height.is_nan())
            .fold((0.0, 0.0), |(sum, count), height| (sum + height, count + 1.0));
        if count > 0.0 { sum / count } else { self.heights[place] }
    }

    fn values(&self, values: Vec<f32>) -> Values {
        Values {
            first: [self.columns.start, self.rows.start],
            columns: self.width(),
            rows: (self.rows.end - self.rows.start) as usize,
            values,
        }
    }

    /// Heights of columns and rows of it.
    pub(super) fn window(self, [columns, rows]: [&Range<i64>; 2]) -> Vec<f32> {
        if (&self.columns, &self.rows) == (columns, rows) {
            return self.heights;
        }
        let width = self.width();
        let from = (columns.start - self.columns.start) as usize;
        let count = (columns.end - columns.start) as usize;
        let lines = rows.clone().map(|row| (row - self.rows.start) as usize * width + from);
        lines
            .flat_map(|start| self.heights[start..start + count].iter().copied())
            .collect()
    }
}

/// 1 at a joint, 0 from where it has no effect on, level at both.
fn fading(share: f64) -> f64 {
    let t = 1.0 - share.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
#[path = "composition_tests.rs"]
mod tests;
