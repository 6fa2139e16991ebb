//! The part of a raster that lies in a tile's square.

use std::ops::Range;

use glam::DVec2;
use terrain_tiles::address::TileAddress;

use super::reference::Reference;

/// A rectangle of posts around a tile's square.
pub(super) struct Window {
    columns: Range<usize>,
    rows: Range<usize>,
    /// For each post of the window, by row, whether it is in the square, or on its sides and the corner of a whole cell
    /// that reaches into the square.
    pub(super) inside: Vec<bool>,
}

impl Window {
    /// `turn` is what to add to the tile's longitudes to get the raster's.
    pub(super) fn new(reference: &Reference, address: TileAddress, turn: f64) -> Self {
        let grid = reference.grid;
        let (low, high) = square(address, turn);
        let range = |low: f64, high: f64, count: usize| {
            let (first, end) = (
                (low - 3.0).floor().max(0.0) as usize,
                (high + 4.0).ceil().max(0.0) as usize,
            );
            first.min(count)..end.min(count)
        };
        let Some((first, last)) = grid_box(reference, low, high) else {
            return Self {
                columns: 0..0,
                rows: 0..0,
                inside: Vec::new(),
            };
        };
        let mut window = Self {
            columns: range(first.x, last.x, grid.columns),
            rows: range(first.y, last.y, grid.rows),
            inside: Vec::new(),
        };
        let is_inside = |place: DVec2| place.cmpgt(low).all() && place.cmplt(high).all();
        let geographic = |post: DVec2| grid.georeference.geographic(post);
        window.inside = window
            .posts()
            .map(|(_, (column, row))| {
                let post = DVec2::new(column as f64, row as f64);
                let place = geographic(post);
                let is_on_side = !is_inside(place) && place.cmpge(low).all() && place.cmple(high).all();
                is_inside(place)
                    || (is_on_side
                        && cells_around(reference, column, row).any(|towards| is_inside(geographic(post + towards))))
            })
            .collect();
        window
    }

    /// Index in the window, column and row of every post.
    pub(super) fn posts(&self) -> impl Iterator<Item = (usize, (usize, usize))> + use<> {
        let columns = self.columns.clone();
        self.rows
            .clone()
            .flat_map(move |row| columns.clone().map(move |column| (column, row)))
            .enumerate()
    }

    /// Index in the window of a post.
    pub(super) fn index(&self, column: usize, row: usize) -> Option<usize> {
        let known = self.columns.contains(&column) && self.rows.contains(&row);
        known.then(|| (row - self.rows.start) * self.columns.len() + column - self.columns.start)
    }
}

/// A short step from a post into each whole cell that it is a corner of.
fn cells_around(reference: &Reference, column: usize, row: usize) -> impl Iterator<Item = DVec2> {
    let cells = [(-1, -1), (0, -1), (-1, 0), (0, 0)];
    let whole = cells
        .into_iter()
        .filter(move |&(c, r)| reference.cell(column as i64 + c, row as i64 + r).is_some());
    whole.map(|(c, r)| DVec2::new(c as f64 + 0.5, r as f64 + 0.5) / 50.0)
}

/// What to add to the longitudes of a tile to have those of the raster, which never jump but may exceed 180°.
pub(super) fn turn(reference: &Reference, address: TileAddress) -> f64 {
    let [west, _, east, _] = reference.grid.georeference.geographic_bounds();
    let middle = address.west() + address.degrees() / 2.0;
    (((west + east) / 2.0 - middle) / 360.0).round() * 360.0
}

fn square(address: TileAddress, turn: f64) -> (DVec2, DVec2) {
    let low = DVec2::new(address.west() + turn, address.south());
    (low, low + address.degrees())
}

/// Extent in the grid of the square from `low` to `high`, as far as the raster reaches.
fn grid_box(reference: &Reference, low: DVec2, high: DVec2) -> Option<(DVec2, DVec2)> {
    const STEPS: u32 = 32;
    let [west, south, east, north] = reference.grid.georeference.geographic_bounds();
    let (low, high) = (low.max(DVec2::new(west, south)), high.min(DVec2::new(east, north)));
    if !low.cmple(high).all() {
        return None;
    }
    let part = |i: u32| f64::from(i) / f64::from(STEPS);
    let points = (0..=STEPS).flat_map(|y| (0..=STEPS).map(move |x| DVec2::new(part(x), part(y))));
    let mut places = points.map(|at| reference.grid.georeference.grid(low + (high - low) * at));
    let first = places.next()?;
    Some(places.fold((first, first), |(low, high), grid| (low.min(grid), high.max(grid))))
}
