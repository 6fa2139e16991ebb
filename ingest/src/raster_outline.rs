//! Where the raster's surface ends, on the lattice: the one truth for sides and leaves, whichever tile asks.
//!
//! ```text
//! step     ← edge of the grid between a cell with four samples and one without, the surface on its left
//! its ends ← the samples' places, rounded to the lattice; one inside a strip goes on to the side of the tile
//! crossing ← the lattice position next to where a step passes a line: of integers alone, so the same for all
//! ```
//! No outline has a vertex in a strip then, but on the side or on the inner line.

use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::on_ellipsoid;
use terrain_core::height_field::ground::distance_on_earth;
use terrain_core::height_field::heights::Heights;

use crate::breaklines::{Breaklines, TurnedStep, is_on_surface};
use crate::georeference::GeoReference;
use crate::lattice::{Lattice, STRIP};

/// Places along each axis of a rectangle that are looked up to find the cells under it.
const PLACES: usize = 17;
/// Cells around those.
const CELLS_AROUND: f64 = 3.0;
/// How much farther a step may stray between the places that are looked at.
const BETWEEN_PLACES: f64 = 1.02;
/// Parts of a step between whose ends it is looked up whether it is in a square.
const PARTS: usize = 8;
/// Halvings of such a part to find where it leaves the square.
const HALVINGS: usize = 30;

/// What sides and outlines are made from.
pub(crate) struct BorderSource<'a> {
    pub(crate) lattice: Lattice,
    pub(crate) georeference: &'a GeoReference,
    pub(crate) heights: Heights<'a>,
    pub(crate) breaklines: &'a Breaklines,
}

/// An edge of the grid at which the surface ends, with that to its left; or a step of a breakline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Lattice positions.
    pub(crate) ends: [[i64; 2]; 2],
    /// Places on the grid, in the same order.
    samples: [DVec2; 2],
}

impl BorderSource<'_> {
    /// The steps in and around a rectangle of global lattice positions.
    pub(crate) fn steps_around(&self, low: DVec2, high: DVec2) -> Vec<Step> {
        let [low, high] = self.cells_under(low, high);
        let turns_left = self.handedness() > 0.0;
        let valid = |[column, row]: [i64; 2]| self.heights.cell_is_valid(column, row);
        let mut steps = Vec::new();
        for row in low[1]..=high[1] {
            for column in low[0]..=high[0] {
                let here = valid([column, row]);
                if here != valid([column - 1, row]) {
                    steps.push(self.step([column, row], [column, row + 1], here != turns_left));
                }
                if here != valid([column, row - 1]) {
                    steps.push(self.step([column, row], [column + 1, row], here == turns_left));
                }
            }
        }
        // Around a pole, steps over the meridian opposite to the tile seem to go around the Earth.
        let half_turn = self.lattice.extent(0);
        steps.retain(|step: &Step| (step.ends[0][0] - step.ends[1][0]).abs() < half_turn);
        steps
    }

    /// The steps of breaklines on the surface, in and around a rectangle of global lattice positions; those of no length there are left
    /// out.
    pub(crate) fn breaklines_around(&self, low: DVec2, high: DVec2) -> Vec<Step> {
        if self.breaklines.is_empty() {
            return Vec::new();
        }
        let origin = DVec2::from(self.georeference.origin().map(|first| first as f64));
        let corners = self
            .cells_under(low, high)
            .map(|[x, y]| DVec2::new(x as f64, y as f64) + origin);
        let of_lattice = self.georeference.of_lattice();
        let circle = 2 * self.lattice.extent(0);
        let seen = |turned: TurnedStep| {
            let moved = DVec2::new(turned.columns, 0.0);
            let place = |at: DVec2| {
                let [x, y] = self
                    .lattice
                    .global(of_lattice.geographic(at))
                    .round()
                    .as_i64vec2()
                    .to_array();
                [x + i64::from(turned.turns) * circle, y]
            };
            Step {
                ends: turned.step.map(place),
                samples: turned.step.map(|at| at + moved - origin),
            }
        };
        let mut steps: Vec<Step> = self.breaklines.steps_near(corners).into_iter().map(seen).collect();
        steps.retain(|step| {
            let [from, to] = step.ends;
            // Around a pole, steps over the meridian opposite to the tile seem to go around the Earth.
            from != to && (from[0] - to[0]).abs() < circle / 2 && is_on_surface(self.heights, step.samples)
        });
        steps
    }

    /// First and last column and row that steps of a rectangle may begin at.
    fn cells_under(&self, low: DVec2, high: DVec2) -> [[i64; 2]; 2] {
        let share = |index: usize| index as f64 / (PLACES - 1) as f64;
        let place = |index: usize| low + (high - low) * DVec2::new(share(index % PLACES), share(index / PLACES));
        let places = (0..PLACES * PLACES).map(|index| self.georeference.grid(self.lattice.geographic(place(index))));
        let nowhere = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = places.fold(nowhere, |(low, high), grid| (low.min(grid), high.max(grid)));
        let limit = DVec2::new(self.heights.columns as f64, self.heights.rows as f64);
        let low = (low - CELLS_AROUND).clamp(DVec2::ZERO, limit).floor();
        let high = (high + CELLS_AROUND).clamp(DVec2::ZERO, limit).ceil();
        [low, high].map(|corner| [corner.x as i64, corner.y as i64])
    }

    /// Positive where columns and rows turn as east and north do: seen in space, for beside a pole a map turns anything over.
    fn handedness(&self) -> f64 {
        let middle = DVec2::new(self.heights.columns as f64, self.heights.rows as f64) / 2.0;
        let places = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|step| self.georeference.geographic(middle + step * 0.5));
        let [at, across, down] = places.map(on_ellipsoid);
        (across - at).cross(down - at).dot(at)
    }

    fn step(&self, from: [i64; 2], to: [i64; 2], forwards: bool) -> Step {
        let [from, to] = [from, to].map(|[column, row]| DVec2::new(column as f64, row as f64));
        let samples = if forwards { [from, to] } else { [to, from] };
        Step {
            ends: samples.map(|sample| self.node(sample)),
            samples,
        }
    }

    /// The lattice position of a sample of the outline.
    fn node(&self, sample: DVec2) -> [i64; 2] {
        let place = self.lattice.global(self.georeference.geographic(sample));
        let extent = self.lattice.extent(self.lattice.leaf_zoom);
        [place.x, place.y].map(|coordinate| out_of_strip(coordinate.round() as i64, extent))
    }

    /// Longitude and latitude of a place on a step, by its share of the way in the raster.
    fn in_raster(&self, step: &Step, share: f64) -> DVec2 {
        self.georeference
            .geographic(step.samples[0].lerp(step.samples[1], share))
    }

    /// Metres, seen from above, between a step of the raster and the edges on the lattice that stand for it: its ends were
    /// rounded or moved, and what is straight in the raster, on the map and in space differ in between.
    pub(crate) fn strays(&self, step: &Step) -> f64 {
        let in_raster = |share| self.in_raster(step, share);
        let [from, to] = step.ends.map(|[x, y]| DVec2::new(x as f64, y as f64));
        let on_map = |share| self.lattice.geographic(from.lerp(to, share));
        let ends = [0.0, 1.0].map(|share| on_ellipsoid(on_map(share)));
        let between = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| {
            let place = on_ellipsoid(on_map(share));
            place.distance(on_ellipsoid(in_raster(share))) + distance_on_earth(place, ends)
        });
        BETWEEN_PLACES * between.into_iter().fold(0.0, f64::max)
    }

    /// Metres, seen from above, between what of a step of the raster is in a square of global lattice positions and the nearest of some
    /// `edges` there: where the step goes out of the square at a flat angle, they may do so far from it.
    pub(crate) fn strays_within(&self, step: &Step, [low, high]: [DVec2; 2], edges: &[[DVec2; 2]]) -> f64 {
        let circle = (2 * self.lattice.extent(0)) as f64;
        let in_raster = |share| self.in_raster(step, share);
        let is_inside = |share: f64| {
            let mut at = self.lattice.global(in_raster(share));
            at.x += ((step.ends[0][0] as f64 - at.x) / circle).round() * circle;
            at.cmpge(low).all() && at.cmple(high).all()
        };
        let looked: Vec<(f64, bool)> = (0..=PARTS)
            .map(|number| number as f64 / PARTS as f64)
            .map(|share| (share, is_inside(share)))
            .collect();
        let leaving = looked.windows(2).filter(|pair| pair[0].1 != pair[1].1).map(|pair| {
            let [(mut first, is_first_inside), (mut last, _)] = [pair[0], pair[1]];
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(first, last);
                if is_inside(middle) == is_first_inside {
                    first = middle;
                } else {
                    last = middle;
                }
            }
            first
        });
        let inside = looked
            .iter()
            .filter(|(_, is_inside)| *is_inside)
            .map(|(share, _)| *share);
        let places: Vec<DVec3> = inside
            .chain(leaving)
            .map(|share| on_ellipsoid(in_raster(share)))
            .collect();
        if places.is_empty() {
            return 0.0;
        }
        let edges: Vec<[DVec3; 2]> = edges
            .iter()
            .map(|edge| edge.map(|end| on_ellipsoid(self.lattice.geographic(end))))
            .collect();
        let nearest = |&place: &DVec3| {
            let distances = edges.iter().map(|&edge| distance_on_earth(place, edge));
            distances.fold(f64::INFINITY, f64::min)
        };
        BETWEEN_PLACES * places.iter().map(nearest).fold(0.0, f64::max)
    }

    /// Height of the surface at a global lattice position; next to the surface, of the nearest cell, carried on.
    pub(crate) fn height_at(&self, global: DVec2) -> f64 {
        let grid = self.georeference.grid(self.lattice.geographic(global));
        let cell = grid.floor();
        let around =
            (-1..=1).flat_map(|down| (-1..=1).map(move |across| DVec2::new(f64::from(across), f64::from(down))));
        let valid = around
            .map(|step| cell + step)
            .filter(|cell| self.heights.cell_is_valid(cell.x as i64, cell.y as i64));
        let off = |cell: &DVec2| grid.distance_squared(grid.clamp(*cell, *cell + 1.0));
        match valid.min_by(|a, b| off(a).total_cmp(&off(b))) {
            Some(cell) => self.bilinear(cell, grid - cell),
            None => self.heights.height_near(grid).unwrap_or(0.0),
        }
    }

    fn bilinear(&self, cell: DVec2, inside: DVec2) -> f64 {
        let sample = |across: usize, down: usize| self.heights.sample(cell.x as usize + across, cell.y as usize + down);
        let row = |down: usize| sample(0, down) + (sample(1, down) - sample(0, down)) * inside.x;
        row(0) + (row(1) - row(0)) * inside.y
    }
}

/// A coordinate in the strip along a side goes onto the side.
fn out_of_strip(coordinate: i64, extent: i64) -> i64 {
    let from_side = coordinate.rem_euclid(extent);
    match from_side {
        _ if from_side < STRIP => coordinate - from_side,
        _ if extent - from_side < STRIP => coordinate + extent - from_side,
        _ => coordinate,
    }
}

/// Where the step between two lattice positions passes `line` of the axis numbered `axis`, rounded; if strictly between its
/// ends.
pub(crate) fn crossing([from, to]: [[i64; 2]; 2], axis: usize, line: i64) -> Option<i64> {
    let along = 1 - axis;
    let (before, after) = (i128::from(from[axis] - line), i128::from(to[axis] - line));
    if before.signum() * after.signum() >= 0 {
        return None;
    }
    let length = (after - before).abs();
    let way = -before * i128::from(to[along] - from[along]) * (after - before).signum();
    Some(from[along] + (2 * way + length).div_euclid(2 * length) as i64)
}

/// The place on `line` of the axis numbered `axis` that is at `along` on the other one.
pub(crate) fn on_line(axis: usize, line: i64, along: i64) -> [i64; 2] {
    if axis == 0 { [line, along] } else { [along, line] }
}

/// The ends of a step and places that it passes, in order, each once.
pub(crate) fn with_passed([from, to]: [[i64; 2]; 2], passed: impl Iterator<Item = [i64; 2]>) -> Vec<[i64; 2]> {
    let mut points: Vec<[i64; 2]> = [from, to].into_iter().chain(passed).collect();
    let product = |at: &[i64; 2], axis: usize| i128::from(at[axis] - from[axis]) * i128::from(to[axis] - from[axis]);
    points.sort_by_key(|at| product(at, 0) + product(at, 1));
    points.dedup();
    points
}

/// Whether a point beside the line `across = 0` is on the surface that `steps` bound, given in (across, along): to the
/// positive or the negative side, next to the line at `along`. None where no step is across from it up to `reach`.
pub(crate) fn is_bounded(steps: &[[[i64; 2]; 2]], along: f64, positive: bool, reach: f64) -> Option<bool> {
    let hit = |&[from, to]: &[[i64; 2]; 2]| {
        let passes = (from[1] as f64 <= along) != (to[1] as f64 <= along);
        let share = (along - from[1] as f64) / (to[1] - from[1]) as f64;
        let across = from[0] as f64 + (to[0] - from[0]) as f64 * share;
        let is_on_the_line = from[0] == 0 && to[0] == 0;
        let is_there = passes && !is_on_the_line && (across > 0.0) == positive && across.abs() <= reach;
        is_there.then_some((across.abs(), to[1] > from[1]))
    };
    let nearest = steps.iter().filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, is_upwards)| is_upwards == positive)
}

#[cfg(test)]
#[path = "raster_outline_tests.rs"]
mod tests;
