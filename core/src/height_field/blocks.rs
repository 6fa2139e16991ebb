//! The relief under a window, searched by branch and bound: blocks are cut into smaller ones only where their bounds cannot
//! tell that nothing in them matters.
//!
//! After A. H. Land, A. G. Doig, *An automatic method of solving discrete programming problems*, 1960.
//!
//! ```text
//! blocks ← those about as large as a triangle (an edge), where they meet it
//! for each block that meets it, until there are none:
//!     if its bound says that nothing in it matters: forget it
//!     if it is small: visit its samples in the triangle (the pieces of the edge in its cells)
//!     otherwise: its four parts (smaller blocks along the edge) are next
//! ```

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use glam::DVec2;
use smallvec::SmallVec;

use crate::height_field::chunks::Chunks;
use crate::height_field::relief::{CHUNK, CORNERS, Chunk, NO_SURFACE};
use crate::height_field::scan::{self, ON_A_LINE};

/// Columns and rows of chunks of a level that are kept at hand.
const KEPT: usize = 4;
/// Level of the blocks whose samples are visited one by one: cutting them further costs as much.
const SMALLEST: u8 = 2;
/// Cells along the longer side of a triangle's rectangle up to which its samples are visited without a look at blocks.
const SMALL: f64 = 12.0;
/// Blocks along the longer side of a triangle's rectangle, at most, to begin with.
const BLOCKS_ACROSS: f64 = 3.0;

/// Sine of the angle to the rows below which a line counts as one of them.
const LEVEL: f64 = 1e-12;

/// A square of cells and a bound of what it holds.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Column and row of its first corner, in samples.
    pub first: DVec2,
    /// Cells along its side.
    pub side: f64,
    /// Heights at its corners, row by row, metres.
    pub patch: [f64; 4],
    /// Least and greatest height of the surface above the bilinear patch through the corners, metres.
    pub residual: [f64; 2],
    /// Whether the corners are known to be samples.
    pub is_sampled: bool,
}

impl Block {
    /// Places of the corners, in the order of [`Block::patch`].
    #[must_use]
    #[inline]
    pub fn corners(&self) -> [DVec2; 4] {
        let step = self.side;
        [
            DVec2::ZERO,
            DVec2::new(step, 0.0),
            DVec2::new(0.0, step),
            DVec2::splat(step),
        ]
        .map(|offset| self.first + offset)
    }

    /// Height of the patch at a place.
    #[must_use]
    #[inline]
    pub fn height(&self, at: DVec2) -> f64 {
        let share = (at - self.first) / self.side;
        let [a, b, c, d] = self.patch;
        let (above, below) = (a + (b - a) * share.x, c + (d - c) * share.x);
        above + (below - above) * share.y
    }

    /// What the patch has in it that no plane has, metres: the height of a corner above the plane through the other three.
    #[must_use]
    #[inline]
    pub fn twist(&self) -> f64 {
        let [a, b, c, d] = self.patch;
        a - b - c + d
    }
}

/// The relief under a window. A few chunks of each level are kept at hand, so that what it takes does not grow with the window.
pub struct Relief<'a> {
    chunks: &'a dyn Chunks,
    levels: Vec<Level>,
}

struct Level {
    /// Columns and rows of chunks that are kept, each where its column and row, divided by these, leave it.
    sides: [usize; 2],
    kept: Vec<RefCell<Kept>>,
    /// Columns and rows of blocks that the window meets.
    blocks: [Range<usize>; 2],
}

/// A chunk at hand, if there is one.
#[derive(Clone, Default)]
struct Kept {
    place: Option<[usize; 2]>,
    chunk: Option<Arc<Chunk>>,
}

impl<'a> Relief<'a> {
    /// A view of what lies in these columns and rows of samples.
    #[must_use]
    pub fn new(chunks: &'a dyn Chunks, columns: Range<usize>, rows: Range<usize>) -> Self {
        let [width, height] = chunks.size();
        let level = |level: u8| {
            let blocks = [(columns.clone(), width), (rows.clone(), height)].map(|(samples, count)| {
                let cells = samples.start..samples.end.min(count).saturating_sub(1).max(samples.start + 1);
                cells.start >> level..((cells.end - 1) >> level) + 1
            });
            let sides = blocks.clone().map(|range| {
                let chunks = range.start / CHUNK..(range.end - 1) / CHUNK + 1;
                chunks.len().min(KEPT)
            });
            Level {
                kept: vec![RefCell::default(); sides[0] * sides[1]],
                sides,
                blocks,
            }
        };
        Self {
            chunks,
            levels: (0..=chunks.top()).map(level).collect(),
        }
    }

    /// The level of the largest blocks.
    #[must_use]
    pub fn top(&self) -> u8 {
        (self.levels.len() - 1) as u8
    }

    /// The chunk with a block of the window; none where no sample is.
    fn chunk(&self, level: u8, x: usize, y: usize) -> Option<Arc<Chunk>> {
        self.with_chunk(level, x, y, Clone::clone)
    }

    /// What is read of the chunk with a block of the window; none where no sample is.
    #[inline]
    fn of_chunk<R>(&self, level: u8, x: usize, y: usize, read: impl FnOnce(&Chunk) -> R) -> Option<R> {
        self.with_chunk(level, x, y, |chunk| read(chunk))
    }

    #[inline]
    fn with_chunk<R>(&self, level: u8, x: usize, y: usize, read: impl FnOnce(&Arc<Chunk>) -> R) -> Option<R> {
        let Level { sides, kept, .. } = &self.levels[usize::from(level)];
        let place = [x / CHUNK, y / CHUNK];
        let mut kept = kept[place[1] % sides[1] * sides[0] + place[0] % sides[0]].borrow_mut();
        if kept.place != Some(place) {
            *kept = Kept {
                place: Some(place),
                chunk: self.chunks.chunk(level, place[0], place[1]),
            };
        }
        kept.chunk.as_ref().map(read)
    }

    /// A block of the window; none where no sample is.
    #[inline]
    fn block(&self, level: u8, x: usize, y: usize) -> Option<Block> {
        let (column, row) = (x % CHUNK, y % CHUNK);
        let read = |chunk: &Chunk| {
            (
                chunk.residual(column, row),
                chunk.patch(column, row),
                chunk.is_sampled(),
            )
        };
        let (residual, patch, is_sampled) = self.of_chunk(level, x, y, read)?;
        let side = f64::from(1_u32 << level);
        (residual != NO_SURFACE).then(|| Block {
            first: DVec2::new(scan::double(x), scan::double(y)) * side,
            side,
            patch,
            residual: residual.map(f64::from),
            is_sampled,
        })
    }

    /// Samples whose column and row are multiples of 2^`level`, in these columns and rows counted in such steps; NaN where void.
    #[must_use]
    pub fn samples(&self, level: u8, columns: Range<usize>, rows: Range<usize>) -> Vec<f32> {
        let [across, down] = &self.levels[usize::from(level)].blocks;
        let sample = |column: usize, row: usize| {
            let (x, y) = (column.min(across.end - 1), row.min(down.end - 1));
            let place = [column - x / CHUNK * CHUNK, row - y / CHUNK * CHUNK];
            // The last blocks have a corner after their first.
            let is_inside = (across.start..=across.end).contains(&column) && (down.start..=down.end).contains(&row);
            let sample = is_inside.then(|| self.of_chunk(level, x, y, |chunk| chunk.sample(place[0], place[1])));
            sample.flatten().unwrap_or(f32::NAN)
        };
        rows.flat_map(|row| columns.clone().map(move |column| sample(column, row)))
            .collect()
    }

    /// Heights at the corners of a cell, row by row; NaN where void or outside of the window.
    fn cell_corners(&self, column: usize, row: usize) -> [f64; 4] {
        let [across, down] = &self.levels[0].blocks;
        let is_inside = across.contains(&column) && down.contains(&row);
        let read = |chunk: &Chunk| chunk.patch(column % CHUNK, row % CHUNK);
        let corners = is_inside.then(|| self.of_chunk(0, column, row, read));
        corners.flatten().unwrap_or([f64::NAN; 4])
    }

    /// The cell with a surface at a place, column and row, and its corners' heights, row by row; where the place is on a grid
    /// line, of any of the cells beside it.
    #[must_use]
    pub fn cell(&self, at: DVec2) -> Option<([usize; 2], [f64; 4])> {
        let candidates = |coordinate: f64, blocks: &Range<usize>| {
            let last = blocks.end - 1;
            let inside = (coordinate.max(0.0) as usize).clamp(blocks.start, last);
            let after = ((coordinate + ON_A_LINE).max(0.0) as usize).clamp(blocks.start, last);
            let before = ((coordinate - ON_A_LINE).max(0.0) as usize).clamp(blocks.start, last);
            [inside, before, after]
        };
        let [across, down] = &self.levels[0].blocks;
        let (columns, rows) = (candidates(at.x, across), candidates(at.y, down));
        let first = ([columns[0], rows[0]], self.cell_corners(columns[0], rows[0]));
        if !first.1.iter().any(|corner| corner.is_nan()) {
            return Some(first);
        }
        let beside = rows.into_iter().flat_map(|row| columns.map(|column| [column, row]));
        let mut valid = beside.map(|[column, row]| ([column, row], self.cell_corners(column, row)));
        valid.find(|(_, corners)| !corners.iter().any(|corner| corner.is_nan()))
    }

    /// The level to begin with for what is that many cells long.
    fn level_for(&self, cells: f64) -> u8 {
        let side = (cells / BLOCKS_ACROSS).ceil().max(1.0) as u32;
        (side.next_power_of_two().trailing_zeros() as u8).clamp(SMALLEST, self.top().max(SMALLEST))
    }

    /// Calls `visit` with the place and height of samples in a triangle, or up to `margin` cells beside it: all those in blocks
    /// of which `may_matter` says so.
    pub fn visit_samples(
        &self,
        corners: [DVec2; 3],
        margin: f64,
        may_matter: impl FnMut(&Block) -> bool,
        mut visit: impl FnMut(DVec2, f64),
    ) {
        let triangle = Triangle::new(corners, margin);
        let extent = triangle.high - triangle.low;
        if extent.max_element() <= SMALL {
            let [columns, rows] = self.blocks_between(0, triangle.low, triangle.high);
            self.visit_rectangle(columns, rows, &triangle, &mut visit);
            return;
        }
        self.visit_small_blocks(&triangle, may_matter, |block| {
            let [column, row] = [block.first.x, block.first.y].map(|first| first as usize);
            let side = block.side as usize;
            self.visit_rectangle(column..column + side, row..row + side, &triangle, &mut visit);
        });
    }

    /// Calls `visit` with the small blocks that meet a triangle, or are up to `margin` cells beside it: all those in blocks of
    /// which `may_matter` says so, and of which it says so themselves.
    pub fn visit_blocks(
        &self,
        corners: [DVec2; 3],
        margin: f64,
        may_matter: impl FnMut(&Block) -> bool,
        visit: impl FnMut(&Block),
    ) {
        self.visit_small_blocks(&Triangle::new(corners, margin), may_matter, visit);
    }

    #[inline(always)]
    fn visit_small_blocks(
        &self,
        triangle: &Triangle,
        mut may_matter: impl FnMut(&Block) -> bool,
        mut visit: impl FnMut(&Block),
    ) {
        let level = self
            .level_for((triangle.high - triangle.low).max_element())
            .min(self.top());
        let mut waiting: SmallVec<[(u8, usize, usize); 64]> = SmallVec::new();
        let [columns, rows] = self.blocks_between(level, triangle.low, triangle.high);
        for y in rows {
            waiting.extend(columns.clone().map(|x| (level, x, y)));
        }
        while let Some((level, x, y)) = waiting.pop() {
            let side = f64::from(1_u32 << level);
            if !triangle.meets(DVec2::new(scan::double(x), scan::double(y)) * side, side) {
                continue;
            }
            let Some(block) = self.block(level, x, y).filter(&mut may_matter) else {
                continue;
            };
            if level <= SMALLEST {
                visit(&block);
                continue;
            }
            let [across, down] = &self.levels[usize::from(level - 1)].blocks;
            for y in [2 * y, 2 * y + 1].into_iter().filter(|y| down.contains(y)) {
                let parts = [2 * x, 2 * x + 1].into_iter().filter(|x| across.contains(x));
                waiting.extend(parts.map(|x| (level - 1, x, y)));
            }
        }
    }

    fn blocks_between(&self, level: u8, low: DVec2, high: DVec2) -> [Range<usize>; 2] {
        let per_cell = 1.0 / f64::from(1_u32 << level);
        let [across, down] = &self.levels[usize::from(level)].blocks;
        [(low.x, high.x, across), (low.y, high.y, down)].map(|(low, high, blocks)| {
            let [first, last] = [low, high].map(|cell| (cell * per_cell).max(0.0) as usize);
            first.clamp(blocks.start, blocks.end)..(last + 1).clamp(blocks.start, blocks.end)
        })
    }

    /// Visits the samples at the corners of some cells that are in a triangle.
    #[inline(always)]
    fn visit_rectangle(
        &self,
        columns: Range<usize>,
        rows: Range<usize>,
        triangle: &Triangle,
        visit: &mut impl FnMut(DVec2, f64),
    ) {
        let [across, down] = &self.levels[0].blocks;
        let mut kept = Kept::default();
        for row in rows.start..=rows.end {
            let [low, high] = triangle.columns(scan::double(row));
            let found = scan::whole_numbers(low, high, columns.end + 1);
            let mut column = found.start.max(columns.start);
            let y = row.min(down.end - 1);
            while column < found.end {
                // A chunk has the corners along all of its sides.
                let x = column.min(across.end - 1);
                let end = found.end.min(x / CHUNK * CHUNK + CORNERS);
                let place = [x / CHUNK, y / CHUNK];
                if kept.place != Some(place) {
                    kept = Kept {
                        place: Some(place),
                        chunk: self.chunk(0, x, y),
                    };
                }
                if let Some(chunk) = &kept.chunk {
                    let (row_of_chunk, offset) = (row - y / CHUNK * CHUNK, x / CHUNK * CHUNK);
                    for column in column..end {
                        let height = chunk.sample_at_level_0(column - offset, row_of_chunk);
                        if !height.is_nan() {
                            visit(DVec2::new(scan::double(column), scan::double(row)), f64::from(height));
                        }
                    }
                }
                column = end;
            }
        }
    }

    /// Calls `visit(from, to)` with the parameters of stretches of the line `a → b`, each in one cell or a void: all those in
    /// blocks of which `may_matter(block, from, to)` says so.
    pub fn visit_stretches(
        &self,
        a: DVec2,
        b: DVec2,
        mut may_matter: impl FnMut(&Block, f64, f64) -> bool,
        mut visit: impl FnMut(f64, f64),
    ) {
        let level = self.level_for((b - a).abs().max_element()).min(self.top());
        let mut waiting: SmallVec<[(u8, f64, f64); 32]> = SmallVec::new();
        waiting.push((level, 0.0, 1.0));
        while let Some((level, from, to)) = waiting.pop() {
            let per_cell = 1.0 / f64::from(1_u32 << level);
            let [start, end] = [from, to].map(|t| a.lerp(b, t) * per_cell);
            scan::visit_cells(start, end, |first, last| {
                let [first, last] = [first, last].map(|share| from + share * (to - from));
                let Some(block) = self.block_at(level, a.lerp(b, (first + last) / 2.0)) else {
                    return;
                };
                if !may_matter(&block, first, last) {
                    return;
                }
                if level > SMALLEST {
                    waiting.push((level - 1, first, last));
                    return;
                }
                let [start, end] = [first, last].map(|t| a.lerp(b, t));
                scan::visit_cells(start, end, |from, to| {
                    visit(first + from * (last - first), first + to * (last - first));
                });
            });
        }
    }

    /// The block with surface at a place; where that is on a line between blocks, of any of those beside it.
    fn block_at(&self, level: u8, at: DVec2) -> Option<Block> {
        let place = at / f64::from(1_u32 << level);
        let [across, down] = &self.levels[usize::from(level)].blocks;
        let index =
            |coordinate: f64, blocks: &Range<usize>| (coordinate.max(0.0) as usize).clamp(blocks.start, blocks.end - 1);
        let (x, y) = (index(place.x, across), index(place.y, down));
        self.block(level, x, y).or_else(|| {
            let (beside_x, beside_y) = (index(place.x - ON_A_LINE, across), index(place.y - ON_A_LINE, down));
            self.block(level, beside_x, y)
                .or_else(|| self.block(level, x, beside_y))
                .or_else(|| self.block(level, beside_x, beside_y))
        })
    }
}

/// A triangle as what is on the inner side of three lines and in a rectangle.
struct Triangle {
    low: DVec2,
    high: DVec2,
    /// Inner normals, and the least product with a place.
    sides: [(DVec2, f64); 3],
    /// 1 over the normals' columns.
    per_column: [f64; 3],
}

impl Triangle {
    fn new(corners: [DVec2; 3], margin: f64) -> Self {
        let [a, b, c] = corners;
        let margin = margin + ON_A_LINE;
        let turn = if (b - a).perp_dot(c - a) < 0.0 { -1.0 } else { 1.0 };
        let side = |from: DVec2, to: DVec2| {
            let normal = (to - from).perp().normalize_or_zero() * turn;
            (normal, normal.dot(from) - margin)
        };
        let sides = [side(a, b), side(b, c), side(c, a)];
        Self {
            low: a.min(b).min(c) - margin,
            high: a.max(b).max(c) + margin,
            per_column: sides.map(|(normal, _)| 1.0 / normal.x),
            sides,
        }
    }

    /// The first and the last column where a row crosses the triangle; the first is beyond the last where it does not.
    #[inline]
    fn columns(&self, row: f64) -> [f64; 2] {
        let mut found = [self.low.x, self.high.x];
        for (&(normal, least), per_column) in self.sides.iter().zip(self.per_column) {
            let rest = least - normal.y * row;
            if normal.x > LEVEL {
                found[0] = found[0].max(rest * per_column);
            } else if normal.x < -LEVEL {
                found[1] = found[1].min(rest * per_column);
            } else if rest > LEVEL * self.high.x.abs().max(self.low.x.abs()) {
                found[1] = f64::NEG_INFINITY;
            }
        }
        found
    }

    /// Whether a square meets the triangle, or may do.
    #[inline]
    fn meets(&self, first: DVec2, side: f64) -> bool {
        let last = first + side;
        let is_beside = first.x > self.high.x || first.y > self.high.y || last.x < self.low.x || last.y < self.low.y;
        !is_beside
            && self.sides.iter().all(|&(normal, least)| {
                let reach = (normal.x.max(0.0) + normal.y.max(0.0)) * side;
                normal.dot(first) + reach >= least
            })
    }
}

#[cfg(test)]
#[path = "blocks_tests.rs"]
mod tests;
