//! Lines that the surface keeps as edges, cell by cell of the grid of samples.
//!
//! ```text
//! line ─▶ steps: parts between grid lines, where the source is bilinear along them ─▶ those on the surface
//! ```

use std::cmp::Ordering;

use glam::DVec2;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use terrain_core::height_field::heights::Heights;

use crate::georeference::GeoReference;

/// Whole turns by which longitudes of lines and those of a raster may differ, at most.
const TURNS: i32 = 3;
/// Cells around a rectangle in which steps are found, too.
const CELLS_AROUND: f64 = 2.0;

/// A part of a line in a cell or along its side: its ends on the grid.
pub(crate) type GridStep = [DVec2; 2];

/// The lines of a raster, on its lattice of samples.
pub(crate) struct Breaklines {
    segments: RTree<GeomWithData<Rectangle<[f64; 2]>, [DVec2; 2]>>,
    /// Columns around the Earth, where columns go around it.
    around: Option<f64>,
}

/// A step, and the whole turns around the Earth by which it is seen from elsewhere.
#[derive(Clone, Copy)]
pub(crate) struct TurnedStep {
    /// On the lattice of samples, without the turns.
    pub(crate) step: GridStep,
    pub(crate) turns: i32,
    /// Columns that these are.
    pub(crate) columns: f64,
}

impl Breaklines {
    /// Of lines in coordinates of the reference system of a raster.
    pub(crate) fn new(lines: &[Vec<[f64; 2]>], georeference: &GeoReference) -> Self {
        let of_lattice = georeference.of_lattice();
        let is_around = georeference.is_around() && georeference.is_geographic();
        let turns = match georeference.is_geographic() && !is_around {
            true => -TURNS..=TURNS,
            false => 0..=0,
        };
        let [west, _, east, _] = georeference.geographic_bounds();
        let mut segments = Vec::new();
        for turn in turns {
            let turned = DVec2::new(360.0 * f64::from(turn), 0.0);
            let reaches = |a: f64, b: f64| turn == 0 || a.min(b) + turned.x <= east && a.max(b) + turned.x >= west;
            for pair in lines.iter().flat_map(|line| line.windows(2)) {
                if pair[0] != pair[1] && reaches(pair[0][0], pair[1][0]) {
                    let on_grid = |at: [f64; 2]| of_lattice.grid_of_crs(DVec2::from(at) + turned);
                    segments.push([on_grid(pair[0]), on_grid(pair[1])]);
                }
            }
        }
        let boxed = |[from, to]: [DVec2; 2]| {
            GeomWithData::new(Rectangle::from_corners(from.to_array(), to.to_array()), [from, to])
        };
        Self {
            segments: RTree::bulk_load(segments.into_iter().map(boxed).collect()),
            around: is_around.then(|| (360.0 / of_lattice.affine().matrix2.x_axis.x).round()),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.segments.size() == 0
    }

    /// Segments that come near a rectangle of the lattice of samples, each with the turns and the columns by which it does.
    fn near(&self, [low, high]: [DVec2; 2]) -> Vec<(i32, f64, [DVec2; 2])> {
        let turns = if self.around.is_some() { -TURNS..=TURNS } else { 0..=0 };
        let mut found = Vec::new();
        for turn in turns {
            let columns = self.around.map_or(0.0, |around| around * f64::from(turn));
            let moved = DVec2::new(columns, 0.0);
            let [low, high] = [low - moved - CELLS_AROUND, high - moved + CELLS_AROUND];
            let envelope = AABB::from_corners(low.to_array(), high.to_array());
            let segments = self.segments.locate_in_envelope_intersecting(&envelope);
            let segments = segments.filter(|segment| shares_in(segment.data, [low, high]).is_some());
            found.extend(segments.map(|segment| (turn, columns, segment.data)));
        }
        found
    }

    /// The steps in a rectangle of the lattice of samples and a little around it.
    pub(crate) fn steps_near(&self, [low, high]: [DVec2; 2]) -> Vec<TurnedStep> {
        let turned = |(turns, columns, segment): (i32, f64, [DVec2; 2])| {
            let moved = DVec2::new(columns, 0.0);
            let steps = steps(segment, [low - moved, high - moved]);
            steps.into_iter().map(move |step| TurnedStep { step, turns, columns })
        };
        self.near([low, high]).into_iter().flat_map(turned).collect()
    }

    /// All that is made of lines in a rectangle of the lattice of samples depends on these bytes.
    pub(crate) fn bytes_near(&self, rectangle: [DVec2; 2]) -> Vec<u8> {
        let numbers = |(turn, _, [from, to]): (i32, f64, [DVec2; 2])| [f64::from(turn), from.x, from.y, to.x, to.y];
        let mut found: Vec<[f64; 5]> = self.near(rectangle).into_iter().map(numbers).collect();
        let order = |a: &[f64; 5], b: &[f64; 5]| {
            let pairs = a.iter().zip(b);
            pairs.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(b)))
        };
        found.sort_by(order);
        found
            .as_flattened()
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect()
    }
}

/// The steps that lines, in coordinates of the raster's reference system, have on the surface of some samples.
pub(crate) fn steps_on_surface(
    lines: &[Vec<[f64; 2]>],
    georeference: &GeoReference,
    heights: Heights,
) -> Vec<GridStep> {
    let first = georeference.origin().map(|first| first as f64);
    let [low, last] = [
        DVec2::ZERO,
        DVec2::new(heights.columns as f64, heights.rows as f64) - 1.0,
    ];
    let steps = Breaklines::new(lines, georeference).steps_near([low, last].map(|at| at + DVec2::from(first)));
    let seen = |turned: TurnedStep| {
        turned
            .step
            .map(|at| at + DVec2::new(turned.columns, 0.0) - DVec2::from(first))
    };
    let steps = steps.into_iter().map(seen);
    steps.filter(|&step| is_on_surface(heights, step)).collect()
}

/// The steps of a segment in a rectangle of the grid and a little around it. They are the same, bit for bit, whatever the rectangle is.
pub(crate) fn steps(segment: [DVec2; 2], [low, high]: [DVec2; 2]) -> Vec<GridStep> {
    let [from, to] = segment;
    let Some([first, last]) = shares_in(segment, [low - CELLS_AROUND, high + CELLS_AROUND]) else {
        return Vec::new();
    };
    let mut stops: Vec<(f64, DVec2)> = Vec::new();
    stops.extend((first == 0.0).then_some((0.0, from)));
    stops.extend((last == 1.0).then_some((1.0, to)));
    let way = to - from;
    for axis in [0, 1] {
        let ends = [first, last].map(|share| from[axis] + way[axis] * share);
        let lines = ends[0].min(ends[1]).ceil() as i64..=ends[0].max(ends[1]).floor() as i64;
        for line in lines.filter(|_| way[axis] != 0.0) {
            let share = (line as f64 - from[axis]) / way[axis];
            let mut at = from + way * share;
            at[axis] = line as f64;
            stops.extend((0.0 < share && share < 1.0).then_some((share, at)));
        }
    }
    stops.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pairs = stops.windows(2).map(|pair| [pair[0].1, pair[1].1]);
    pairs.filter(|step| step[0] != step[1]).collect()
}

/// The shares of the way along a segment between which it is in a rectangle.
fn shares_in([from, to]: [DVec2; 2], [low, high]: [DVec2; 2]) -> Option<[f64; 2]> {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in [0, 1] {
        let way = to[axis] - from[axis];
        if way == 0.0 {
            if !(low[axis]..=high[axis]).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let shares = [low, high].map(|side| (side[axis] - from[axis]) / way);
        first = first.max(shares[0].min(shares[1]));
        last = last.min(shares[0].max(shares[1]));
    }
    (first <= last).then_some([first, last])
}

/// Whether there is surface on both sides of a step: what is along the outline is an edge without anyone's help.
pub(crate) fn is_on_surface(heights: Heights, [from, to]: GridStep) -> bool {
    let middle = (from + to) / 2.0;
    let cells = |axis: usize| {
        let cell = middle[axis].floor() as i64;
        let is_along_line = from[axis] == to[axis] && middle[axis].fract() == 0.0;
        (cell - i64::from(is_along_line))..=cell
    };
    cells(1).all(|row| cells(0).all(|column| heights.cell_is_valid(column, row)))
}

#[cfg(test)]
#[path = "breaklines_tests.rs"]
mod tests;
