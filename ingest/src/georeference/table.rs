//! A smooth map of the plane as a table with tensor-product cubic interpolation, its inverse by Newton's method.
//!
//! Nodes are `spacing` cells apart and reach two beyond the raster on every side. Inside a square of four nodes the
//! value is the cubic Lagrange polynomial through four nodes a direction. At construction the table is compared with
//! the map itself in the middle of every square; where it is off by more than [`TOLERANCE`], the spacing is halved.

use glam::{DMat2, DVec2};

use super::{GeoReferenceError, nearest_turn};
use crate::store::Name;

/// Largest difference from the tabulated map, in cells of the raster.
const TOLERANCE: f64 = 1e-5;
/// Cells between nodes at first, at least.
const FIRST_SPACING: usize = 16;
/// Nodes along the longer side of a raster at first, at most.
const FIRST_NODES: usize = 256;
/// Cells between nodes at last: next to a pole, longitude bends within a cell.
const LEAST_SPACING: f64 = 1.0 / 64.0;
/// Where halving the spacing ends, whatever the error: 64 MiB.
const MOST_NODES: usize = 1 << 22;
/// Nodes beyond the raster on each side.
const MARGIN: usize = 2;
/// Newton steps; two or three are usual.
const STEPS: usize = 16;
/// A Newton step this small, in cells, is the last.
const STEP_TOLERANCE: f64 = 1e-9;

#[derive(Clone, Debug)]
pub(super) struct Table {
    spacing: f64,
    columns: usize,
    rows: usize,
    nodes: Vec<DVec2>,
    /// Where Newton's method starts: a grid point, its value, and the inverse of the Jacobian there.
    start: DVec2,
    start_value: DVec2,
    start_inverse: DMat2,
}

impl Table {
    /// Tabulates `map` over a raster of `columns` by `rows`. Values are (longitude, latitude) in degrees; turns of
    /// 360° in longitude between neighbouring nodes are taken out.
    pub(super) fn new(
        columns: usize,
        rows: usize,
        map: impl Fn(DVec2) -> Result<DVec2, GeoReferenceError>,
    ) -> Result<Self, GeoReferenceError> {
        let first = (columns.max(rows) / FIRST_NODES).next_power_of_two().max(FIRST_SPACING);
        let mut spacing = first as f64;
        loop {
            let table = Self::with_spacing(spacing, columns, rows, &map)?;
            if table.matches(&map)? {
                return Ok(table);
            }
            spacing /= 2.0;
            if spacing < LEAST_SPACING || table.nodes.len() * 4 > MOST_NODES {
                return Err(GeoReferenceError::Discontinuous);
            }
        }
    }

    fn with_spacing(
        spacing: f64,
        raster_columns: usize,
        raster_rows: usize,
        map: impl Fn(DVec2) -> Result<DVec2, GeoReferenceError>,
    ) -> Result<Self, GeoReferenceError> {
        let count = |samples: usize| ((samples - 1) as f64 / spacing).ceil() as usize + 1 + 2 * MARGIN;
        let mut table = Self {
            spacing,
            columns: count(raster_columns),
            rows: count(raster_rows),
            nodes: Vec::new(),
            start: DVec2::new((raster_columns - 1) as f64, (raster_rows - 1) as f64) / 2.0,
            start_value: DVec2::ZERO,
            start_inverse: DMat2::IDENTITY,
        };
        for index in 0..table.columns * table.rows {
            let node = DVec2::new((index % table.columns) as f64, (index / table.columns) as f64);
            let value = map(table.grid_of_node(node))?;
            let neighbour = if index % table.columns > 0 { 1 } else { table.columns };
            let before = index
                .checked_sub(neighbour)
                .map_or(value, |neighbour| table.nodes[neighbour]);
            table.nodes.push(nearest_turn(value, before.x));
        }
        table.start_value = table.forward(table.start);
        table.start_inverse = table.jacobian(table.start).inverse();
        Ok(table)
    }

    fn grid_of_node(&self, node: DVec2) -> DVec2 {
        (node - MARGIN as f64) * self.spacing
    }

    /// Compares with `map` in the middle of every square that touches the raster.
    fn matches(&self, map: impl Fn(DVec2) -> Result<DVec2, GeoReferenceError>) -> Result<bool, GeoReferenceError> {
        for row in 1..self.rows - MARGIN {
            for column in 1..self.columns - MARGIN {
                let middle = self.grid_of_node(DVec2::new(column as f64, row as f64) + 0.5);
                let value = self.forward(middle);
                let difference = nearest_turn(map(middle)?, value.x) - value;
                let error = (self.jacobian(middle).inverse() * difference).length();
                if error.is_nan() || error > TOLERANCE {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// All nodes as one number.
    pub(super) fn fingerprint(&self) -> Name {
        let nodes: Vec<u8> = self
            .nodes
            .iter()
            .flat_map(|node| node.to_array())
            .flat_map(f64::to_le_bytes)
            .collect();
        Name::of([self.spacing.to_le_bytes().as_slice(), &nodes])
    }

    /// Adds `offset` to all values.
    pub(super) fn shift(&mut self, offset: DVec2) {
        for node in &mut self.nodes {
            *node += offset;
        }
        self.start_value += offset;
    }

    /// The value at grid coordinates; beyond the table it goes on linearly.
    pub(super) fn forward(&self, grid: DVec2) -> DVec2 {
        let inside = self.clamp(grid);
        let value = self.interpolate(inside, weights, weights);
        if inside == grid {
            value
        } else {
            value + self.jacobian(inside) * (grid - inside)
        }
    }

    /// Change of the value from column to column and from row to row.
    pub(super) fn jacobian(&self, grid: DVec2) -> DMat2 {
        let inside = self.clamp(grid);
        let by_column = self.interpolate(inside, slopes, weights);
        let by_row = self.interpolate(inside, weights, slopes);
        DMat2::from_cols(by_column, by_row) * self.spacing.recip()
    }

    /// Grid coordinates of a value.
    pub(super) fn inverse(&self, value: DVec2) -> DVec2 {
        let mut grid = self.start + self.start_inverse * (value - self.start_value);
        for _ in 0..STEPS {
            let step = self.jacobian(grid).inverse() * (value - self.forward(grid));
            grid += step;
            if step.length() < STEP_TOLERANCE {
                break;
            }
        }
        grid
    }

    /// The nearest grid point that has two nodes on every side.
    fn clamp(&self, grid: DVec2) -> DVec2 {
        let nodes = DVec2::new((self.columns - MARGIN) as f64, (self.rows - MARGIN) as f64);
        grid.clamp(DVec2::splat(-self.spacing), self.grid_of_node(nodes))
    }

    fn interpolate(&self, grid: DVec2, across: fn(f64) -> [f64; 4], down: fn(f64) -> [f64; 4]) -> DVec2 {
        let node = grid / self.spacing + MARGIN as f64;
        let first = node
            .floor()
            .min(DVec2::new((self.columns - 3) as f64, (self.rows - 3) as f64));
        let (across, down) = (across(node.x - first.x), down(node.y - first.y));
        let corner = (first.y as usize - 1) * self.columns + first.x as usize - 1;
        let row_value = |row: usize| {
            let start = corner + row * self.columns;
            let nodes = &self.nodes[start..start + 4];
            nodes
                .iter()
                .zip(across)
                .map(|(&node, weight)| node * weight)
                .sum::<DVec2>()
        };
        (0..4).map(|row| row_value(row) * down[row]).sum()
    }
}

/// Cubic Lagrange weights of nodes at −1, 0, 1 and 2.
fn weights(t: f64) -> [f64; 4] {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0]
}

/// Derivatives of [`weights`].
fn slopes(t: f64) -> [f64; 4] {
    let square = 3.0 * t * t;
    [
        -(square - 6.0 * t + 2.0) / 6.0,
        (square - 4.0 * t - 1.0) / 2.0,
        -(square - 2.0 * t - 2.0) / 2.0,
        (square - 1.0) / 6.0,
    ]
}
