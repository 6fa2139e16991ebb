//! How far a place is from the outline of the source, in plan view: from the sides of whole cells that no other whole
//! cell shares.
//!
//! Kept in memory is the box, in Earth-centred metres, of the outline in each square of cells that has one. The sides
//! themselves are looked for in the raster again, square after square, nearest box first, as long as a box is nearer
//! than the nearest side so far.

use std::collections::HashMap;

use anyhow::Result;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Line, Rectangle};
use rstar::{AABB, PointDistance, RTree};

use super::deviation::Worst;
use super::farthest::{Far, Place};
use super::source::{Block, Patch, Source};

type Segment = Line<[f64; 3]>;
type Square = GeomWithData<Rectangle<[f64; 3]>, [usize; 2]>;

/// Cells along a side of a square: a few thousand sides at most, found again in some milliseconds.
const SQUARE: usize = 64;

/// The squares that have an outline.
pub(super) struct SourceOutline<'a> {
    source: Source<'a>,
    squares: RTree<Square>,
}

impl<'a> SourceOutline<'a> {
    /// Looks through all of the source, block by block of `side` posts.
    pub(super) fn new(source: Source<'a>, side: usize) -> Result<Self> {
        let side = side.next_power_of_two().max(SQUARE);
        let blocks = source.blocks(&source.whole(), side, |block| source.may_hold(block));
        let squares = blocks.par_iter().map(|block| squares(&source, block));
        let squares: Vec<Vec<Square>> = squares.collect::<Result<_>>()?;
        Ok(Self {
            source,
            squares: RTree::bulk_load(squares.into_iter().flatten().collect()),
        })
    }

    /// For one thread to ask about places that are near each other.
    pub(super) fn near(&self) -> NearOutline<'_> {
        NearOutline {
            outline: self,
            known: HashMap::new(),
            segments: 0,
        }
    }

    fn segments_in(&self, first: [usize; 2]) -> Result<RTree<Segment>> {
        let [columns, rows] = self.source.size();
        let block = Block {
            columns: first[0]..(first[0] + SQUARE).min(columns),
            rows: first[1]..(first[1] + SQUARE).min(rows),
        };
        let patch = self.source.patch(&block)?;
        Ok(RTree::bulk_load(segments(&self.source, &patch, &block)))
    }
}

/// The outline with the sides that were looked for last.
pub(super) struct NearOutline<'a> {
    outline: &'a SourceOutline<'a>,
    known: HashMap<[usize; 2], RTree<Segment>>,
    segments: usize,
}

impl NearOutline<'_> {
    fn segments(&mut self, square: [usize; 2]) -> Result<&RTree<Segment>> {
        /// Some 10 MB.
        const MOST: usize = 100_000;
        if !self.known.contains_key(&square) {
            if self.segments > MOST {
                self.known.clear();
                self.segments = 0;
            }
            let segments = self.outline.segments_in(square)?;
            self.segments += segments.size();
            self.known.insert(square, segments);
        }
        Ok(&self.known[&square])
    }
}

impl Far for NearOutline<'_> {
    /// Infinite where the source has no surface.
    fn distance(&mut self, on_ellipsoid: DVec3) -> Result<f64> {
        let point = on_ellipsoid.to_array();
        let mut nearest = f64::INFINITY;
        for square in self.outline.squares.nearest_neighbor_iter(&point) {
            if square.geom().distance_2(&point).sqrt() >= nearest {
                break;
            }
            nearest = nearest.min(distance(self.segments(square.data)?, on_ellipsoid));
        }
        Ok(nearest)
    }

    fn add(&mut self, places: &[Place], worst: &mut Worst) -> Result<()> {
        for place in places {
            worst.meet(self.distance(place.on_ellipsoid)?, place.grid);
        }
        Ok(())
    }
}

fn squares(source: &Source, block: &Block) -> Result<Vec<Square>> {
    if source.is_coarse(block) {
        return Ok(Vec::new());
    }
    let patch = source.patch(block)?;
    let square = |square: &Block| {
        let segments = segments(source, &patch, square);
        let ends: Vec<[f64; 3]> = segments.iter().flat_map(|line| [line.from, line.to]).collect();
        let around = AABB::from_points(&ends);
        let rectangle = Rectangle::from_corners(around.lower(), around.upper());
        let first = [square.columns.start, square.rows.start];
        (!ends.is_empty()).then(|| GeomWithData::new(rectangle, first))
    };
    Ok(block.split(SQUARE).iter().filter_map(square).collect())
}

/// Sides of the outline above and to the left of the cells of `block`, a part of the patch.
fn segments(source: &Source, patch: &Patch, block: &Block) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (column, row) in block.posts() {
        let (x, y) = (column as i64, row as i64);
        let whole = patch.cell(x, y).is_some();
        let mut add = |to: (usize, usize)| {
            let [from, to] = [(column, row), to].map(|(x, y)| DVec2::new(x as f64, y as f64));
            let metres = source.on_ellipsoid(from).distance(source.on_ellipsoid(to));
            let count = Source::pieces(1.0, metres);
            let point = |piece: usize| {
                source
                    .on_ellipsoid(from.lerp(to, piece as f64 / count as f64))
                    .to_array()
            };
            segments.extend((0..count).map(|piece| Line::new(point(piece), point(piece + 1))));
        };
        if whole != patch.cell(x - 1, y).is_some() {
            add((column, row + 1));
        }
        if whole != patch.cell(x, y - 1).is_some() {
            add((column + 1, row));
        }
    }
    segments
}

/// Distance from a point to the nearest of `lines`; infinite where there is none.
pub(super) fn distance(lines: &RTree<Segment>, point: DVec3) -> f64 {
    let point = point.to_array();
    lines
        .nearest_neighbor(&point)
        .map_or(f64::INFINITY, |line| line.distance_2(&point).sqrt())
}

#[cfg(test)]
#[path = "source_outline_tests.rs"]
mod tests;
