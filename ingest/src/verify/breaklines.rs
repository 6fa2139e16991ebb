//! Whether lines are kept: along each there has to be a chain of edges of the mesh, no point of which is further from all lines than is
//! claimed, nor any point of the line from the chain. Lines that are nearer to each other than that may have one chain.
//!
//! ```text
//! stretches ← lines in a tile's square and around it
//! pieces    ← where these are on the source's surface, in the square
//! near      ← edges of the mesh that are all of them near stretches: an edge may go on beyond a piece
//! chains    ← edges of these that hang together; for each piece, the best is what is nearest to all of it
//! ```
//! What is so short that the lattice hardly knows it is let pass.

use std::collections::BTreeMap;
use std::ops::Range;

use anyhow::Result;
use glam::{DVec2, DVec3};
use rstar::primitives::{GeomWithData, Line, Rectangle};
use rstar::{AABB, RTree};

use super::source::{Block, Source};
use super::source_outline::distance;

/// Cells between points of a line that are looked at, at most.
const SPACING: f64 = 0.25;
/// Metres between them, at most: what is straight between is 30 m below the ellipsoid.
const METRES_APART: f64 = 40_000.0;
/// Cells around a square in which lines are looked for, at most.
const MOST_AROUND: f64 = 256.0;
/// Whole turns around the Earth by which longitudes may differ.
const TURNS: i32 = 3;
/// Cells on either side of a point of a line that has surface on both.
const BESIDE: f64 = 1e-6;

type Segment = Line<[f64; 3]>;

/// Lines on the grid of a raster.
pub(super) struct Lines {
    /// Segments, those of a line one after the other.
    segments: Vec<[DVec2; 2]>,
    by_place: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    /// Cells between points that are looked at.
    spacing: f64,
}

impl Lines {
    pub(super) fn new(source: &Source) -> Self {
        let turns = if source.georeference.is_geographic() { TURNS } else { 0 };
        let to_grid = source.georeference.affine().inverse();
        let mut segments = Vec::new();
        for turn in -turns..=turns {
            let turned = DVec2::new(360.0 * f64::from(turn), 0.0);
            for pair in source.breaklines.iter().flat_map(|line| line.windows(2)) {
                let ends = [pair[0], pair[1]].map(|at| to_grid.transform_point2(DVec2::from(at) + turned));
                segments.push(ends);
            }
        }
        let boxed = |(number, [from, to]): (usize, &[DVec2; 2])| {
            GeomWithData::new(Rectangle::from_corners(from.to_array(), to.to_array()), number)
        };
        let longest = longest_cell(source);
        Self {
            by_place: RTree::bulk_load(segments.iter().enumerate().map(boxed).collect()),
            segments,
            spacing: SPACING.min(METRES_APART / longest),
        }
    }

    /// Lines in a block and so many `metres` around it; pieces are what is in the block, on the surface and where `is_here` holds.
    pub(super) fn stretches(
        &self,
        source: &Source,
        block: &Block,
        metres: f64,
        is_here: impl Fn(DVec2) -> bool,
    ) -> Result<Vec<Stretch<DVec2>>> {
        let first = DVec2::new(block.columns.start as f64, block.rows.start as f64);
        let last = DVec2::new(block.columns.end as f64, block.rows.end as f64);
        let cell = source.georeference.cell_metres((first + last) / 2.0).min_element();
        let around = (1.0 + metres / cell).min(MOST_AROUND);
        let is_in_block = |at: DVec2| at.cmpge(first - 1.0).all() && at.cmple(last + 1.0).all();
        let mut stretches = Vec::new();
        for points in self.points_in([first - around, last + around]) {
            let mut pieces: Vec<Range<usize>> = Vec::new();
            for (index, &at) in points.iter().enumerate() {
                if is_in_block(at) && is_here(at) && is_on_surface(source, at)? {
                    match pieces.last_mut() {
                        Some(piece) if piece.end == index => piece.end += 1,
                        _ => pieces.push(index..index + 1),
                    }
                }
            }
            stretches.push(Stretch { points, pieces });
        }
        Ok(stretches)
    }

    /// Points along lines in a rectangle, those of a stretch one after the other.
    fn points_in(&self, rectangle: [DVec2; 2]) -> Vec<Vec<DVec2>> {
        let envelope = AABB::from_corners(rectangle[0].to_array(), rectangle[1].to_array());
        let found = self.by_place.locate_in_envelope_intersecting(&envelope);
        let mut numbers: Vec<usize> = found.map(|segment| segment.data).collect();
        numbers.sort_unstable();
        let (mut lines, mut before): (Vec<Vec<DVec2>>, _) = (Vec::new(), DVec2::NAN);
        for [from, to] in numbers.into_iter().map(|number| self.segments[number]) {
            let Some([first, last]) = clipped([from, to], rectangle) else {
                continue;
            };
            let count = ((to - from).abs().max_element() * (last - first) / self.spacing)
                .ceil()
                .max(1.0);
            let share = |step: i64| first + (last - first) * step as f64 / count;
            let points = (0..=count as i64).map(share);
            let points = points.map(|share| if share == 1.0 { to } else { from.lerp(to, share) });
            match lines.last_mut() {
                Some(line) if before == from && first == 0.0 => line.extend(points),
                _ => lines.push(points.collect()),
            }
            before = if last == 1.0 { to } else { DVec2::NAN };
        }
        lines
    }
}

/// Points along a line, and which of them are looked at.
pub(super) struct Stretch<Point> {
    points: Vec<Point>,
    pieces: Vec<Range<usize>>,
}

impl<Point> Stretch<Point> {
    pub(super) fn pieces(&self) -> impl Iterator<Item = &[Point]> {
        self.pieces.iter().map(|piece| &self.points[piece.clone()])
    }
}

impl Stretch<DVec2> {
    /// The same somewhere else.
    pub(super) fn placed(&self, place: impl Fn(DVec2) -> DVec3) -> Stretch<DVec3> {
        Stretch {
            points: self.points.iter().map(|&at| place(at)).collect(),
            pieces: self.pieces.clone(),
        }
    }
}

/// Lines to which points may be near.
pub(super) struct Near(RTree<Segment>);

impl Near {
    /// Of stretches, from point to point.
    pub(super) fn to(stretches: &[Stretch<DVec3>]) -> Self {
        let parts = |line: &Stretch<DVec3>| {
            let points: Vec<[f64; 3]> = line.points.iter().map(|at| at.to_array()).collect();
            let mut parts = vec![Line::new(points[0], points[0])];
            parts.extend(points.windows(2).map(|pair| Line::new(pair[0], pair[1])));
            parts
        };
        Self(RTree::bulk_load(stretches.iter().flat_map(parts).collect()))
    }

    fn is_within(&self, metres: f64, at: [f64; 3]) -> bool {
        distance(&self.0, DVec3::from(at)) <= metres
    }
}

/// Metres along the longest side of a cell in the middle of each of the source's sides and of all.
fn longest_cell(source: &Source) -> f64 {
    let last = DVec2::new(source.size()[0] as f64, source.size()[1] as f64) - 1.0;
    let places = [0.0, 0.5, 1.0]
        .into_iter()
        .flat_map(|x| [0.0, 0.5, 1.0].map(|y| DVec2::new(x, y) * last));
    let sides = places.map(|at| source.georeference.cell_metres(at).max_element());
    sides.filter(|side| side.is_finite()).fold(f64::MIN_POSITIVE, f64::max)
}

/// Between which shares of its way a segment is in a rectangle.
fn clipped([from, to]: [DVec2; 2], [low, high]: [DVec2; 2]) -> Option<[f64; 2]> {
    let mut shares = [0.0_f64, 1.0_f64];
    for axis in 0..2 {
        let (start, way) = (from[axis], to[axis] - from[axis]);
        if way != 0.0 {
            let at = [(low[axis] - start) / way, (high[axis] - start) / way];
            shares = [shares[0].max(at[0].min(at[1])), shares[1].min(at[0].max(at[1]))];
        } else if start < low[axis] || start > high[axis] {
            return None;
        }
    }
    (shares[0] <= shares[1]).then_some(shares)
}

fn is_on_surface(source: &Source, at: DVec2) -> Result<bool> {
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        if !source.has_cell(at + DVec2::new(x, y) * BESIDE)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// An edge of a mesh in plan.
pub(super) struct PlanEdge {
    pub(super) ends: [u32; 2],
    /// It may be bent.
    pub(super) parts: Vec<Segment>,
}

/// The edges along lines, by those that hang together.
pub(super) struct Chains(Vec<RTree<Segment>>);

impl Chains {
    /// Of edges that are all of them `within` a distance of lines.
    pub(super) fn near(lines: &Near, edges: &[PlanEdge], within: f64) -> Self {
        let is_near = |at: [f64; 3]| lines.is_within(within, at);
        let near: Vec<&PlanEdge> = edges
            .iter()
            .filter(|edge| edge.parts.iter().all(|part| is_near(part.from) && is_near(part.to)))
            .collect();
        let tree = |chain: Vec<&PlanEdge>| RTree::bulk_load(chain.iter().flat_map(|edge| edge.parts.clone()).collect());
        Self(hanging_together(&near).into_iter().map(tree).collect())
    }

    /// How far the farthest point of a piece is from the best chain, and which point; infinite where there is none.
    pub(super) fn farthest(&self, piece: &[DVec3]) -> (f64, usize) {
        let of_chain = |chain: &RTree<Segment>| {
            let distances = piece.iter().map(|&at| distance(chain, at)).zip(0..);
            distances.fold((0.0, 0), |worst, here| if here.0 > worst.0 { here } else { worst })
        };
        let nearer = |a: (f64, usize), b: (f64, usize)| if b.0 < a.0 { b } else { a };
        self.0.iter().map(of_chain).fold((f64::INFINITY, 0), nearer)
    }
}

/// Edges by those that are joined, directly or by others.
fn hanging_together<'a>(edges: &[&'a PlanEdge]) -> Vec<Vec<&'a PlanEdge>> {
    let mut joined: BTreeMap<u32, u32> = BTreeMap::new();
    for edge in edges {
        let [a, b] = edge.ends.map(|end| root(&mut joined, end));
        joined.insert(a, b);
    }
    let mut groups: BTreeMap<u32, Vec<&PlanEdge>> = BTreeMap::new();
    for edge in edges {
        groups.entry(root(&mut joined, edge.ends[0])).or_default().push(edge);
    }
    groups.into_values().collect()
}

/// What stands for all vertices that are joined to one.
fn root(joined: &mut BTreeMap<u32, u32>, vertex: u32) -> u32 {
    let mut at = vertex;
    while let Some(&next) = joined.get(&at).filter(|&&next| next != at) {
        at = next;
    }
    joined.insert(vertex, at);
    at
}

#[cfg(test)]
#[path = "breaklines_tests.rs"]
mod tests;
