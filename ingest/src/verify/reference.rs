//! The surface that claims are measured against: bilinear in every cell of the raster whose four corners are heights.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rstar::RTree;
use rstar::primitives::Line;
use terrain_tiles::ellipsoid::{Geodetic, to_earth_centred};

use crate::height_grid::HeightGrid;

/// What the raster has at one of its posts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Post {
    /// A corner of at least one whole cell.
    Surface,
    /// A height without a whole cell: part of no surface.
    Lone,
    /// No height.
    Void,
}

/// A raster as a surface.
pub(super) struct Reference<'a> {
    pub(super) grid: &'a HeightGrid,
    posts: Vec<Post>,
    outline: OnceLock<RTree<Line<[f64; 3]>>>,
}

/// One whole cell: its first post, and the heights of its corners by row, then by column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    first: DVec2,
    heights: [f64; 4],
}

impl Cell {
    /// The bilinear height at a grid position, also slightly outside the cell.
    pub(super) fn height(&self, grid: DVec2) -> f64 {
        let at = grid - self.first;
        let [a, b, c, d] = self.heights;
        let (upper, lower) = (a + (b - a) * at.x, c + (d - c) * at.x);
        upper + (lower - upper) * at.y
    }
}

impl<'a> Reference<'a> {
    pub(super) fn new(grid: &'a HeightGrid) -> Self {
        let mut posts: Vec<Post> = grid
            .heights
            .iter()
            .map(|height| if height.is_finite() { Post::Lone } else { Post::Void })
            .collect();
        for row in 0..grid.rows.saturating_sub(1) {
            for column in 0..grid.columns.saturating_sub(1) {
                let first = row * grid.columns + column;
                let corners = [first, first + 1, first + grid.columns, first + grid.columns + 1];
                if corners.iter().all(|&corner| posts[corner] != Post::Void) {
                    corners.iter().for_each(|&corner| posts[corner] = Post::Surface);
                }
            }
        }
        Self {
            grid,
            posts,
            outline: OnceLock::new(),
        }
    }

    pub(super) fn post(&self, column: usize, row: usize) -> Post {
        self.posts[row * self.grid.columns + column]
    }

    pub(super) fn height(&self, column: usize, row: usize) -> f64 {
        f64::from(self.grid.heights[row * self.grid.columns + column])
    }

    /// The cell whose first post is (column, row), if it is in the raster and whole.
    pub(super) fn cell(&self, column: i64, row: i64) -> Option<Cell> {
        let (x, y) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        if x + 1 >= self.grid.columns || y + 1 >= self.grid.rows {
            return None;
        }
        let heights = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| self.height(x, y));
        let whole = heights.iter().all(|height| height.is_finite());
        whole.then_some(Cell {
            first: DVec2::new(x as f64, y as f64),
            heights,
        })
    }

    /// The whole cells at a grid position: one, or those on either side where it lies on a line between cells.
    pub(super) fn cells_at(&self, grid: DVec2) -> impl Iterator<Item = Cell> + '_ {
        const ON_THE_LINE: f64 = 1e-6;
        let range = |value: f64| (value - ON_THE_LINE).floor() as i64..=(value + ON_THE_LINE).floor() as i64;
        range(grid.y).flat_map(move |row| range(grid.x).filter_map(move |column| self.cell(column, row)))
    }

    /// Whether there is a surface at a grid position.
    pub(super) fn covers(&self, grid: DVec2) -> bool {
        self.cells_at(grid).next().is_some()
    }

    /// The point of the ellipsoid, in Earth-centred metres, at a grid position.
    pub(super) fn on_ellipsoid(&self, grid: DVec2) -> DVec3 {
        let place = self.grid.georeference.geographic(grid);
        to_earth_centred(Geodetic {
            longitude: place.x,
            latitude: place.y,
            height: 0.0,
        })
    }

    /// Plan distance in metres from a point of the ellipsoid to the outline of the surface.
    pub(super) fn outline_distance(&self, on_ellipsoid: DVec3) -> f64 {
        distance(
            self.outline.get_or_init(|| RTree::bulk_load(self.outline_segments())),
            on_ellipsoid,
        )
    }

    /// The sides that whole cells do not share with another.
    fn outline_segments(&self) -> Vec<Line<[f64; 3]>> {
        let (columns, rows) = (self.grid.columns as i64, self.grid.rows as i64);
        let mut segments = Vec::new();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let whole = self.cell(column, row).is_some();
            let mut add = |from: (i64, i64), to: (i64, i64)| {
                let point = |(x, y): (i64, i64)| self.on_ellipsoid(DVec2::new(x as f64, y as f64)).to_array();
                segments.push(Line::new(point(from), point(to)));
            };
            if whole != self.cell(column - 1, row).is_some() {
                add((column, row), (column, row + 1));
            }
            if whole != self.cell(column, row - 1).is_some() {
                add((column, row), (column + 1, row));
            }
        }
        segments
    }
}

/// Distance from a point to the nearest of `lines`; infinite where there is none.
pub(super) fn distance(lines: &RTree<Line<[f64; 3]>>, point: DVec3) -> f64 {
    let point = point.to_array();
    lines.nearest_neighbor(&point).map_or(f64::INFINITY, |line| {
        rstar::PointDistance::distance_2(line, &point).sqrt()
    })
}
