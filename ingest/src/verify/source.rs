//! The raster that claims are measured against, by blocks: a surface that is bilinear in every cell whose four corners
//! are heights. No more of it is in memory than the blocks that are being looked at.

use std::ops::Range;

use anyhow::Result;
use glam::{DVec2, DVec3};
use terrain_codec::ellipsoid::{Geodetic, MEAN_RADIUS, to_earth_centred};

use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::samples::{CoarseWindow, Samples, Window};

/// Posts along the sides of a block that are as quickly looked at one by one.
const FEW: usize = 128;

/// A raster: its samples, wherever they are kept, and where on the Earth they are.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Heights in metres, NaN where void.
    pub samples: &'a dyn Samples,
    /// From columns and rows to longitude and latitude.
    pub georeference: &'a GeoReference,
    /// Lines that surfaces are said to keep as edges, in coordinates of the raster's reference system.
    pub breaklines: &'a [Vec<[f64; 2]>],
}

impl<'a> From<&'a HeightGrid> for Source<'a> {
    fn from(grid: &'a HeightGrid) -> Self {
        Self {
            samples: grid,
            georeference: &grid.georeference,
            breaklines: &[],
        }
    }
}

impl<'a> Source<'a> {
    /// Columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        self.samples.size()
    }

    /// All posts.
    pub(super) fn whole(&self) -> Block {
        let [columns, rows] = self.size();
        Block {
            columns: 0..columns,
            rows: 0..rows,
        }
    }

    /// Whether there may be a sample in `block` or next to it.
    pub(super) fn may_hold(&self, block: &Block) -> bool {
        self.samples.may_hold(around(&block.columns), around(&block.rows))
    }

    /// The samples of `block` and those around it.
    pub(super) fn patch(&self, block: &Block) -> Result<Patch<'a>> {
        let (columns, rows) = (around(&block.columns), around(&block.rows));
        if self.is_coarse(block)
            && let Some(coarse) = self.samples.coarse(columns.clone(), rows.clone())?
        {
            return Ok(Patch {
                steepest: Some(f64::from(coarse.steepest())),
                posts: Posts::around(coarse.around_own(), block),
                block: block.clone(),
                heights: Heights::Coarse(coarse),
            });
        }
        let window = self.samples.window(columns, rows)?;
        let is_all = window.columns == block.columns.len() + 2 && window.rows == block.rows.len() + 2;
        Ok(Patch {
            block: block.clone(),
            steepest: is_all.then(|| steepest(&window)).flatten(),
            heights: Heights::Window(window),
            posts: Posts::All,
        })
    }

    /// Whether the samples of a block and those around it all follow from others that are much farther apart, and it is worth to know.
    pub(super) fn is_coarse(&self, block: &Block) -> bool {
        let is_small = block.columns.len().min(block.rows.len()) < FEW;
        let is_first = block.columns.start == 0 || block.rows.start == 0;
        !is_small && !is_first && self.samples.is_coarse(around(&block.columns), around(&block.rows))
    }

    /// Blocks of at most `side` posts a side that are all of `whole` that is wanted; wider and narrower ones where all samples follow from
    /// others that are much farther apart.
    pub(super) fn blocks(&self, whole: &Block, side: usize, is_wanted: impl Fn(&Block) -> bool) -> Vec<Block> {
        let mut blocks = Vec::new();
        let least = whole.columns.len().max(whole.rows.len()).div_ceil(side);
        let length = least.next_power_of_two() * side;
        self.add_blocks(whole.clone(), length, side, &is_wanted, &mut blocks);
        blocks
    }

    /// Adds a block of `length` posts a side: whole if it follows from coarse samples, else in quarters, if any of these has such a block.
    /// Whether one was added.
    fn add_blocks(
        &self,
        block: Block,
        length: usize,
        side: usize,
        is_wanted: &impl Fn(&Block) -> bool,
        blocks: &mut Vec<Block>,
    ) -> bool {
        /// As many posts are looked at in such a block as in one of `side` where others are four times as far apart.
        const WIDER: usize = 4;
        if !is_wanted(&block) {
            return false;
        }
        let is_coarse = length <= WIDER * side && self.is_coarse(&block);
        if is_coarse || length < 2 * FEW {
            blocks.push(block);
            return is_coarse;
        }
        let half = length.div_ceil(2);
        let (before, mut is_any_coarse) = (blocks.len(), false);
        for quarter in block.split(half) {
            is_any_coarse |= self.add_blocks(quarter, half, side, is_wanted, blocks);
        }
        if length <= side && !is_any_coarse {
            blocks.truncate(before);
            blocks.push(block);
        }
        is_any_coarse
    }

    /// Whether the cell at a grid position is whole.
    pub(super) fn has_cell(&self, grid: DVec2) -> Result<bool> {
        let [columns, rows] = self.size();
        let at = grid.floor();
        if !(at.x >= 0.0 && at.y >= 0.0 && at.x + 1.0 < columns as f64 && at.y + 1.0 < rows as f64) {
            return Ok(false);
        }
        let (column, row) = (at.x as usize, at.y as usize);
        let corners = self.samples.window(column..column + 2, row..row + 2)?;
        Ok(corners.heights.iter().all(|height| height.is_finite()))
    }

    /// Longitude and latitude of a post.
    pub(super) fn geographic(&self, column: usize, row: usize) -> DVec2 {
        self.georeference.geographic(DVec2::new(column as f64, row as f64))
    }

    /// Whether a post is there elsewhere, too, or beyond a pole, so that no tile has it: where columns go around the Earth.
    pub(super) fn is_twice(&self, place: DVec2) -> bool {
        self.georeference.is_around() && (place.x.abs() > 180.0 || place.y.abs() > 90.0)
    }

    /// Into how many pieces a line of so many cells and metres is to be cut so that, in space, each is nearer to the ellipsoid
    /// than a ten thousandth of a cell.
    pub(super) fn pieces(cells: f64, metres: f64) -> usize {
        const NEAR: f64 = 1e-4;
        const MOST: f64 = 1e6;
        let in_a_cell = (metres / cells.max(1.0) / (8.0 * MEAN_RADIUS * NEAR)).sqrt();
        (cells * in_a_cell.max(1.0)).ceil().clamp(1.0, MOST) as usize
    }

    /// The point of the ellipsoid, in Earth-centred metres, at a grid position.
    pub(super) fn on_ellipsoid(&self, grid: DVec2) -> DVec3 {
        let place = self.georeference.geographic(grid);
        to_earth_centred(Geodetic {
            longitude: place.x,
            latitude: place.y,
            height: 0.0,
        })
    }
}

/// A range and one on either side, as far as there are any before.
fn around(range: &Range<usize>) -> Range<usize> {
    range.start.saturating_sub(1)..range.end + 1
}

/// A rectangle of posts. The cells whose first post is in it are its cells: blocks side by side share none.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Block {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Block {
    /// Posts from `low` to `high`, of a raster of `size`; the nearest one where there is none.
    pub(super) fn between(low: DVec2, high: DVec2, size: [usize; 2]) -> Self {
        let range = |low: f64, high: f64, count: usize| {
            let start = (low.floor().max(0.0) as usize).min(count - 1);
            let end = (high.ceil().max(0.0) as usize).saturating_add(1).min(count);
            start..end.max(start + 1)
        };
        Self {
            columns: range(low.x, high.x, size[0]),
            rows: range(low.y, high.y, size[1]),
        }
    }

    /// The smallest block that holds both.
    pub(super) fn union(&self, other: &Self) -> Self {
        let both = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self {
            columns: both(&self.columns, &other.columns),
            rows: both(&self.rows, &other.rows),
        }
    }

    /// Blocks of at most `side` posts a side that are this one together, row by row.
    pub(super) fn split(&self, side: usize) -> Vec<Self> {
        let parts = |range: &Range<usize>| -> Vec<Range<usize>> {
            let end = range.end;
            range
                .clone()
                .step_by(side)
                .map(|start| start..(start + side).min(end))
                .collect()
        };
        let columns = parts(&self.columns);
        let with_rows = |rows: Range<usize>| {
            columns.iter().cloned().map(move |columns| Self {
                columns,
                rows: rows.clone(),
            })
        };
        parts(&self.rows).into_iter().flat_map(with_rows).collect()
    }

    /// Column and row of every post, row by row.
    pub(super) fn posts(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let columns = self.columns.clone();
        self.rows
            .clone()
            .flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    /// Index of one of its posts in the order of [`Self::posts`].
    pub(super) fn index(&self, column: usize, row: usize) -> usize {
        (row - self.rows.start) * self.columns.len() + column - self.columns.start
    }

    /// The post of the block that is nearest to a grid position.
    pub(super) fn nearest(&self, grid: DVec2) -> (usize, usize) {
        let nearest = |value: f64, range: &Range<usize>| (value.max(0.0) as usize).clamp(range.start, range.end - 1);
        (nearest(grid.x, &self.columns), nearest(grid.y, &self.rows))
    }

    pub(super) fn contains(&self, (column, row): (usize, usize)) -> bool {
        self.columns.contains(&column) && self.rows.contains(&row)
    }

    /// Whether the box from `low` to `high` comes within one cell of its posts and cells.
    pub(super) fn is_near(&self, low: DVec2, high: DVec2) -> bool {
        let near = |low: f64, high: f64, range: &Range<usize>| {
            // What is no number is near to everything.
            !(high < range.start as f64 - 1.0 || low > range.end as f64 + 1.0)
        };
        near(low.x, high.x, &self.columns) && near(low.y, high.y, &self.rows)
    }
}

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

/// Posts of a block that are looked at, by row.
enum Posts {
    All,
    /// By row and column.
    Few(Vec<(usize, usize)>),
}

impl Posts {
    /// Those of some that are in a block, and those along its sides. Against a plane, ground that is bilinear between samples has its
    /// extremes at these, but for what edges show.
    fn around(own: Vec<[usize; 2]>, block: &Block) -> Self {
        let Block { columns, rows } = block;
        let own = own.into_iter().map(|[column, row]| (column, row));
        let across = columns
            .clone()
            .flat_map(|column| [(column, rows.start), (column, rows.end - 1)]);
        let down = rows
            .clone()
            .flat_map(|row| [(columns.start, row), (columns.end - 1, row)]);
        let mut posts: Vec<_> = own
            .filter(|&post| block.contains(post))
            .chain(across)
            .chain(down)
            .map(|(column, row)| (row, column))
            .collect();
        posts.sort_unstable();
        posts.dedup();
        Self::Few(posts)
    }
}

/// Where the heights of a patch come from.
enum Heights<'a> {
    Window(Window),
    Coarse(Box<dyn CoarseWindow + 'a>),
}

/// A block of the raster and one post around it.
pub(super) struct Patch<'a> {
    pub(super) block: Block,
    /// Metres that posts side by side in a row or a column differ at most; none where one of them, or of those around, has no height.
    pub(super) steepest: Option<f64>,
    heights: Heights<'a>,
    posts: Posts,
}

fn steepest(window: &Window) -> Option<f64> {
    let heights = &window.heights;
    let apart = |(&a, &b): (&f32, &f32)| (f64::from(b) - f64::from(a)).abs();
    let across = heights
        .chunks_exact(window.columns)
        .flat_map(|row| row.iter().zip(&row[1..]));
    let down = heights.iter().zip(&heights[window.columns..]);
    let is_whole = heights.iter().all(|height| height.is_finite());
    is_whole.then(|| across.chain(down).map(apart).fold(0.0, f64::max))
}

/// How near to a line between cells, in cells, a point counts as on it.
const ON_THE_LINE: f64 = 1e-6;

impl Patch<'_> {
    /// Column and row of the posts that are looked at, row by row.
    pub(super) fn posts(&self) -> Vec<(usize, usize)> {
        match &self.posts {
            Posts::All => self.block.posts().collect(),
            Posts::Few(posts) => posts.iter().map(|&(row, column)| (column, row)).collect(),
        }
    }

    /// The posts of a row that are looked at, among some columns: their columns, and where they are in the order of [`Self::posts`].
    pub(super) fn posts_of(&self, row: usize, columns: Range<usize>) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (first, all, some) = match &self.posts {
            Posts::All if columns.is_empty() => (0, columns, [].as_slice()),
            Posts::All => (self.block.index(columns.start, row), columns, [].as_slice()),
            Posts::Few(posts) => {
                let place = |column: usize| posts.partition_point(|&post| post < (row, column));
                let (start, end) = (place(columns.start), place(columns.end));
                (start, 0..0, &posts[start..end])
            }
        };
        let columns = all.chain(some.iter().map(|&(_, column)| column));
        columns.zip(first..)
    }

    /// NaN where void, and where there is nothing or nothing that is known.
    pub(super) fn height(&self, column: usize, row: usize) -> f64 {
        let window = match &self.heights {
            Heights::Window(window) => window,
            Heights::Coarse(coarse) => {
                let is_there = |at: usize, range: &Range<usize>| (range.start - 1..range.end + 1).contains(&at);
                return if is_there(column, &self.block.columns) && is_there(row, &self.block.rows) {
                    f64::from(coarse.height(column, row))
                } else {
                    f64::NAN
                };
            }
        };
        let (x, y) = (column.wrapping_sub(window.first[0]), row.wrapping_sub(window.first[1]));
        if x < window.columns && y < window.rows {
            f64::from(window.heights[y * window.columns + x])
        } else {
            f64::NAN
        }
    }

    /// What is at a post of the block.
    pub(super) fn post(&self, column: usize, row: usize) -> Post {
        let (x, y) = (column as i64, row as i64);
        if self.steepest.is_some() {
            Post::Surface
        } else if !self.height(column, row).is_finite() {
            Post::Void
        } else if [(0, 0), (-1, 0), (0, -1), (-1, -1)]
            .into_iter()
            .any(|(dx, dy)| self.cell(x + dx, y + dy).is_some())
        {
            Post::Surface
        } else {
            Post::Lone
        }
    }

    /// The cell whose first post is (column, row), if it is whole: a cell of the block or one before it.
    pub(super) fn cell(&self, column: i64, row: i64) -> Option<Cell> {
        let (x, y) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        let heights = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| self.height(x, y));
        let whole = heights.iter().all(|height| height.is_finite());
        whole.then_some(Cell {
            first: DVec2::new(x as f64, y as f64),
            heights,
        })
    }

    /// The whole cells of the block at a grid position: one, or those on either side of a line that it lies on.
    pub(super) fn cells_at(&self, grid: DVec2) -> impl Iterator<Item = Cell> + '_ {
        let is_own = |column: i64, row: i64| {
            let post = usize::try_from(column).ok().zip(usize::try_from(row).ok());
            post.is_some_and(|post| self.block.contains(post))
        };
        cells_around(grid)
            .filter(move |&(column, row)| is_own(column, row))
            .filter_map(|(column, row)| self.cell(column, row))
    }

    /// Whether there is a surface at a grid position of the block.
    pub(super) fn covers(&self, grid: DVec2) -> bool {
        cells_around(grid).any(|(column, row)| self.cell(column, row).is_some())
    }

    /// A short step from a post into each whole cell that it is a corner of.
    pub(super) fn towards_cells(&self, column: usize, row: usize) -> impl Iterator<Item = DVec2> {
        let cells = [(-1, -1), (0, -1), (-1, 0), (0, 0)];
        let whole = cells
            .into_iter()
            .filter(move |&(c, r)| self.cell(column as i64 + c, row as i64 + r).is_some());
        whole.map(|(c, r)| DVec2::new(c as f64 + 0.5, r as f64 + 0.5) / 50.0)
    }
}

/// First posts of the cells that a grid position is in, or on the side of.
fn cells_around(grid: DVec2) -> impl Iterator<Item = (i64, i64)> {
    let range = |value: f64| (value - ON_THE_LINE).floor() as i64..=(value + ON_THE_LINE).floor() as i64;
    range(grid.y).flat_map(move |row| range(grid.x).map(move |column| (column, row)))
}
