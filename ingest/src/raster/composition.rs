//! Heights of several files become one: which counts, how others are bent to meet it, and how voids are filled.
//!
//! ```text
//! lay      the file that counts first; below it the next, bent near the joint by as much as both differ there
//! fill     voids that are no wider than so many metres, smoothly from their rims
//! ```
//! What is made at a sample depends on the samples within [`Rules::reach`] of it, not on what rectangle is read.

use std::ops::Range;

use terrain_tiles::spread::Values;

use crate::distances::{distances, fading};
use crate::samples::Faults;

/// Metres by which files may differ where they overlap without being bent.
pub(super) const AGREEMENT: f32 = 0.01;
/// How often filled samples become the mean of those around them.
const SMOOTHINGS: usize = 16;

/// What is asked of a composition, in metres.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    /// Column and row of the mosaic's first sample, on the lattice.
    pub(super) origin: [i64; 2],
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

/// Heights of a rectangle of samples: metres, row by row; NaN where void. Columns and rows are counted from the mosaic's first sample,
/// and may be beside it.
#[derive(Clone, Debug)]
pub(super) struct Area {
    pub(super) columns: Range<i64>,
    pub(super) rows: Range<i64>,
    pub(super) heights: Vec<f32>,
}

impl Area {
    /// Without a height.
    pub(super) fn void([columns, rows]: [Range<i64>; 2]) -> Self {
        let samples = (columns.end - columns.start) as usize * (rows.end - rows.start) as usize;
        Self {
            columns,
            rows,
            heights: vec![f32::NAN; samples],
        }
    }

    fn width(&self) -> usize {
        (self.columns.end - self.columns.start) as usize
    }

    /// Where the samples of a row are that `columns` has.
    pub(super) fn run(&self, row: i64, columns: &Range<i64>) -> Range<usize> {
        let start = (row - self.rows.start) as usize * self.width() + (columns.start - self.columns.start) as usize;
        start..start + (columns.end - columns.start) as usize
    }

    /// A rectangle of it.
    fn part(&self, [columns, rows]: [Range<i64>; 2]) -> Self {
        let lines = rows.clone().map(|row| &self.heights[self.run(row, &columns)]);
        Self {
            heights: lines.flatten().copied().collect(),
            columns,
            rows,
        }
    }

    /// So many samples more on all sides, as far as `within` reaches.
    fn grown(&self, samples: i64, within: &Self) -> [Range<i64>; 2] {
        let grow = |range: &Range<i64>, within: &Range<i64>| {
            (range.start - samples).max(within.start)..(range.end + samples).min(within.end)
        };
        [grow(&self.columns, &within.columns), grow(&self.rows, &within.rows)]
    }

    /// Whether each sample has a height.
    fn there(&self) -> Vec<bool> {
        self.heights.iter().map(|height| !height.is_nan()).collect()
    }
}

/// Heights of a rectangle of samples, laid one file below the other.
pub(super) struct Composition<'a> {
    rules: &'a Rules,
    all: Area,
}

impl<'a> Composition<'a> {
    /// Without a height yet.
    pub(super) fn new(rules: &'a Rules, rectangle: [Range<i64>; 2]) -> Self {
        Self {
            rules,
            all: Area::void(rectangle),
        }
    }

    /// How far heights below are from those that count, in columns and rows of `within`.
    pub(super) fn differences(&self, below: &Area, [columns, rows]: [&Range<i64>; 2]) -> Faults {
        let columns = common(columns, &below.columns);
        let rows = common(rows, &below.rows);
        let rows = rows.filter(|_| !columns.is_empty());
        let lines = rows.flat_map(|row| {
            let (above, below) = (
                &self.all.heights[self.all.run(row, &columns)],
                &below.heights[below.run(row, &columns)],
            );
            above.iter().zip(below).map(|(above, below)| (above - below).abs())
        });
        lines
            .filter(|&apart| apart > AGREEMENT)
            .fold(Faults::default(), |faults, apart| Faults {
                disagreeing: faults.disagreeing + 1,
                apart: faults.apart.max(apart),
                ..faults
            })
    }

    /// Heights of a file, in a rectangle of this one, go where no earlier one has any.
    pub(super) fn lay(&mut self, file: usize, below: &Area) {
        let blend = self.rules.blends[file];
        let bends = if blend == 0.0 { None } else { self.bends(below, blend) };
        for row in below.rows.clone() {
            let (to, from) = (self.all.run(row, &below.columns), below.run(row, &below.columns));
            for (height, index) in self.all.heights[to].iter_mut().zip(from) {
                if height.is_nan() {
                    *height = below.heights[index] + bends.as_ref().map_or(0.0, |bends| bends[index]);
                }
            }
        }
    }

    /// By how much heights below the others are bent; none where both agree everywhere.
    fn bends(&self, below: &Area, blend: f64) -> Option<Vec<f32>> {
        let own = [below.columns.clone(), below.rows.clone()];
        let apart = |(&above, &below): (&f32, &f32)| {
            let apart = above - below;
            if apart.abs() > AGREEMENT || apart.is_nan() {
                apart
            } else {
                0.0
            }
        };
        let above = self.all.part(own.clone());
        let apart: Vec<f32> = above.heights.iter().zip(&below.heights).map(apart).collect();
        if !apart.iter().any(|&apart| apart.abs() > 0.0) {
            return None;
        }
        let levels = self.rules.levels(blend);
        let near = self.all.part(below.grown(2 << levels, &self.all));
        let mut differences = Area::void([near.columns.clone(), near.rows.clone()]);
        for row in below.rows.clone() {
            let (to, from) = (differences.run(row, &own[0]), below.run(row, &own[0]));
            differences.heights[to].copy_from_slice(&apart[from]);
        }
        let spread = self.values(&differences).spread(levels);
        let away = distances(&near.there(), near.width(), self.rules.cell);
        let bend = |(apart, distance): (f32, f32)| {
            if apart.is_nan() {
                return 0.0;
            }
            apart * fading(f64::from(distance) / blend) as f32
        };
        let bends = Area {
            heights: spread.into_iter().zip(away).map(bend).collect(),
            ..near
        };
        Some(bends.part(own).heights)
    }

    /// Fills voids that are not too wide. Returns which samples of `columns` and `rows` it filled: their indices in that rectangle.
    pub(super) fn fill(&mut self, [columns, rows]: [&Range<i64>; 2]) -> Vec<usize> {
        let Some(width) = self.rules.fill else {
            return Vec::new();
        };
        let is_narrow = self.narrow(width / 2.0);
        let is_filled = |(height, is_narrow): (&f32, bool)| height.is_nan() && is_narrow;
        let filled: Vec<bool> = self.all.heights.iter().zip(is_narrow).map(is_filled).collect();
        if !filled.contains(&true) {
            return Vec::new();
        }
        let spread = self.values(&self.all).spread(self.rules.levels(width / 2.0));
        let places = (0..filled.len()).filter(|&index| filled[index]);
        let places: Vec<usize> = places.filter(|&index| !spread[index].is_nan()).collect();
        for &place in &places {
            self.all.heights[place] = spread[place];
        }
        for _ in 0..SMOOTHINGS {
            let smoother: Vec<f32> = places.iter().map(|&place| self.mean_around(place)).collect();
            places
                .iter()
                .zip(smoother)
                .for_each(|(&place, height)| self.all.heights[place] = height);
        }
        let width = self.all.width();
        let inside = |place: usize| {
            let column = self.all.columns.start + (place % width) as i64;
            let row = self.all.rows.start + (place / width) as i64;
            let is_inside = columns.contains(&column) && rows.contains(&row);
            let index = || (row - rows.start) * (columns.end - columns.start) + column - columns.start;
            is_inside.then(|| index() as usize)
        };
        places.into_iter().filter_map(inside).collect()
    }

    /// Samples that are in the data when these are grown by a distance and then shrunk by it: holes close, outer rims stay.
    fn narrow(&self, distance: f64) -> Vec<bool> {
        let grown = distances(&self.all.there(), self.all.width(), self.rules.cell);
        let beyond: Vec<bool> = grown.iter().map(|&from| f64::from(from) > distance).collect();
        let shrunk = distances(&beyond, self.all.width(), self.rules.cell);
        shrunk.iter().map(|&from| f64::from(from) > distance).collect()
    }

    fn mean_around(&self, place: usize) -> f32 {
        let (width, column) = (self.all.width(), place % self.all.width());
        let beside = [
            (column > 0).then(|| place - 1),
            (column + 1 < width).then_some(place + 1),
            place.checked_sub(width),
            Some(place + width).filter(|&below| below < self.all.heights.len()),
        ];
        let heights = beside.into_iter().flatten().map(|place| self.all.heights[place]);
        let (sum, count) = heights
            .filter(|height| !height.is_nan())
            .fold((0.0, 0.0), |(sum, count), height| (sum + height, count + 1.0));
        if count > 0.0 {
            sum / count
        } else {
            self.all.heights[place]
        }
    }

    /// An area, counted on the lattice.
    fn values(&self, area: &Area) -> Values<f32> {
        let [left, top] = self.rules.origin;
        Values {
            first: [left + area.columns.start, top + area.rows.start],
            columns: area.width(),
            rows: (area.rows.end - area.rows.start) as usize,
            values: area.heights.clone(),
        }
    }

    /// Heights of columns and rows of it.
    pub(super) fn window(self, columns: &Range<i64>, rows: &Range<i64>) -> Vec<f32> {
        if (&self.all.columns, &self.all.rows) == (columns, rows) {
            return self.all.heights;
        }
        self.all.part([columns.clone(), rows.clone()]).heights
    }
}

/// What two ranges have in common.
pub(super) fn common(a: &Range<i64>, b: &Range<i64>) -> Range<i64> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

#[cfg(test)]
#[path = "composition_tests.rs"]
mod tests;
