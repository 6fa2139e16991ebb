//! Lines that the surface keeps as edges, cell by cell of the grid of samples.
//!
//! ```text
//! line ─▶ steps: parts between grid lines, where the source is bilinear along them ─▶ those on the surface
//! ```

use glam::DVec2;
use terrain_core::height_field::heights::Heights;

use crate::georeference::GeoReference;

/// Whole turns by which longitudes of lines and those of a raster may differ, at most.
const TURNS: i32 = 3;
/// Cells around a rectangle in which steps are found, too.
const CELLS_AROUND: f64 = 2.0;

/// A part of a line in a cell or along its side: its ends on the grid.
pub(crate) type GridStep = [DVec2; 2];

/// The steps that lines, in coordinates of the raster's reference system, have on the surface of some samples.
pub(crate) fn steps_on_surface(lines: &[Vec<[f64; 2]>], georeference: &GeoReference, heights: Heights) -> Vec<GridStep> {
    let last = DVec2::new((heights.columns - 1) as f64, (heights.rows - 1) as f64);
    let turns = if georeference.is_geographic() { TURNS } else { 0 };
    let mut found = Vec::new();
    for turn in -turns..=turns {
        let turned = DVec2::new(360.0 * f64::from(turn), 0.0);
        for line in lines {
            let on_grid = line.iter().map(|&at| georeference.grid_of_crs(DVec2::from(at) + turned));
            let on_grid: Vec<DVec2> = on_grid.collect();
            let steps = on_grid.windows(2).flat_map(|pair| steps([pair[0], pair[1]], [DVec2::ZERO, last]));
            found.extend(steps.filter(|&step| is_on_surface(heights, step)));
        }
    }
    found
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
