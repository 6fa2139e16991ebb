//! The finest mesh of a leaf: built inside its sides and the raster's outline.
//!
//! ```text
//!   side's curve (fine vertices)        ─┐
//!   inner line of the strip, 4 units in ─┼─▶ constrained Delaunay, refined until the tolerance holds everywhere
//!   raster's outline, cell by cell      ─┘
//! ```
//! The strip between a side and its inner line holds no vertices, so that collapses along the side never fail.

use std::collections::HashMap;

use anyhow::{Context, Result};
use glam::{DVec2, DVec3};
use terrain_core::Surface;
use terrain_core::height_field::reference::Reference;
use terrain_core::height_field::refine::{Frame, Refinement, refine};
use terrain_core::height_field::triangulate::{Outline, stepped, triangulate};
use terrain_core::mesh;
use terrain_tiles::address::Side;

use crate::border::{BorderCurve, Run};
use crate::georeference::GeoReference;
use crate::lattice::{Lattice, STRIP, Square};

/// How far along a side, in lattice units, rounding may put the end of an outline from the end of the side's run.
const ROUNDING: i64 = 16;

/// The frame of a square in its own lattice coordinates.
pub(crate) fn frame(lattice: Lattice, square: Square) -> Frame {
    Frame {
        extent: lattice.extent(square.zoom) as f64,
        width: STRIP as f64,
    }
}

/// Which of a run's two sides belongs to the square that the run is the `side` of.
pub(crate) fn own_half(side: Side) -> usize {
    usize::from(matches!(side, Side::West | Side::South))
}

/// Position in a square of a place on one of its sides, given along the side from the square's corner.
pub(crate) fn on_side(side: Side, along: f64, extent: f64) -> DVec2 {
    match side {
        Side::West => DVec2::new(0.0, along),
        Side::East => DVec2::new(extent, along),
        Side::South => DVec2::new(along, 0.0),
        Side::North => DVec2::new(along, extent),
    }
}

/// The runs of a side along which this square has surface, with coordinates from the square's corner.
pub(crate) fn own_runs(curve: &BorderCurve, side: Side) -> impl Iterator<Item = &Run> {
    curve.runs.iter().filter(move |run| run.has_surface[own_half(side)])
}

/// Global coordinate along `side` of the square's corner.
pub(crate) fn side_start(lattice: Lattice, square: Square, side: Side) -> i64 {
    square.edge(side).along * lattice.extent(square.zoom)
}

/// Builds the finest surface of a leaf, in its lattice coordinates and metres; without triangles where the raster has no surface there.
///
/// # Errors
/// When the raster's outline cannot be triangulated.
pub(crate) fn finest_surface<'a>(
    lattice: Lattice,
    georeference: &GeoReference,
    reference: &'a Reference<'a>,
    square: Square,
    sides: [&BorderCurve; 4],
    tolerance: f64,
) -> Result<Surface<'a>> {
    let mut builder = Builder {
        lattice,
        georeference,
        reference,
        square,
        sides,
        extent: lattice.extent(square.zoom),
        outline: Outline::default(),
        numbers: HashMap::new(),
        on_inner_lines: vec![],
    };
    builder.add_sides();
    builder.add_raster_outline();
    builder.add_inner_lines();
    let mut mesh = triangulate(&builder.outline, |plan| builder.is_inside(plan))
        .with_context(|| format!("tile {}", square.address()))?;
    mesh::separate_fans(&mut mesh, |position| is_on_side(position, lattice.extent(square.zoom)));
    let mut surface = Surface::new(&mesh, reference);
    let refinement = Refinement {
        tolerance,
        height_step: lattice.height_step(),
        frame: Some(frame(lattice, square)),
    };
    refine(&mut surface, refinement);
    Ok(surface)
}

/// Whether a lattice position lies on a side of its square, where it is shared with neighbours.
pub(crate) fn is_on_side(position: DVec3, extent: i64) -> bool {
    [position.x, position.y]
        .iter()
        .any(|&coordinate| coordinate == 0.0 || coordinate == extent as f64)
}

struct Builder<'a> {
    lattice: Lattice,
    georeference: &'a GeoReference,
    reference: &'a Reference<'a>,
    square: Square,
    sides: [&'a BorderCurve; 4],
    extent: i64,
    outline: Outline,
    numbers: HashMap<[i64; 2], u32>,
    /// Where the raster's outline crosses the strip's inner lines.
    on_inner_lines: Vec<[i64; 2]>,
}

impl Builder<'_> {
    fn vertex(&mut self, at: [i64; 2], height: f64) -> u32 {
        *self.numbers.entry(at).or_insert_with(|| {
            self.outline
                .vertices
                .push(DVec3::new(at[0] as f64, at[1] as f64, height));
            self.outline.vertices.len() as u32 - 1
        })
    }

    fn surface_vertex(&mut self, at: [i64; 2]) -> u32 {
        let grid = self.grid(DVec2::new(at[0] as f64, at[1] as f64));
        let height = self.reference.heights.height_near(grid).unwrap_or(0.0);
        self.vertex(at, stepped(height, self.lattice.height_step()))
    }

    fn grid(&self, plan: DVec2) -> DVec2 {
        self.georeference
            .grid(self.lattice.geographic(plan + self.lattice.origin(self.square)))
    }

    fn plan(&self, grid: DVec2) -> DVec2 {
        self.lattice.global(self.georeference.geographic(grid)) - self.lattice.origin(self.square)
    }

    fn is_inside(&self, plan: DVec2) -> bool {
        let cell = self.grid(plan).floor();
        self.reference.heights.cell_is_valid(cell.x as i64, cell.y as i64)
    }

    fn add_sides(&mut self) {
        for (side, curve) in Side::ALL.into_iter().zip(self.sides) {
            let start = side_start(self.lattice, self.square, side);
            let mut covered = 0;
            for run in own_runs(curve, side) {
                let [first, last] = run.ends();
                covered += last - first;
                let mut before = None;
                for (along, height, _) in run.vertices() {
                    let at = on_side(side, (along - start) as f64, self.extent as f64);
                    let number = self.vertex([at.x as i64, at.y as i64], height);
                    if let Some(before) = before {
                        self.outline.segments.push([before, number]);
                    }
                    before = Some(number);
                }
            }
            self.outline.has_outside |= covered != self.extent;
        }
    }

    /// Every edge of the grid with surface on one side only, cut at the square's sides and inner lines.
    fn add_raster_outline(&mut self) {
        for [from, to] in self.outline_steps() {
            let (from, to) = (self.plan(from).round(), self.plan(to).round());
            let mut cuts = vec![0.0, 1.0];
            for line in self.lines() {
                cuts.extend(cut(from.x, to.x, line));
                cuts.extend(cut(from.y, to.y, line));
            }
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                self.add_outline_piece(from.lerp(to, pair[0]).round(), from.lerp(to, pair[1]).round());
            }
        }
    }

    fn lines(&self) -> [f64; 4] {
        [0, STRIP, self.extent - STRIP, self.extent].map(|line| line as f64)
    }

    fn add_outline_piece(&mut self, from: DVec2, to: DVec2) {
        let extent = self.extent as f64;
        let middle = (from + to) / 2.0;
        let inside = middle.min_element() > 0.0 && middle.max_element() < extent;
        if !inside || from == to {
            return;
        }
        self.outline.has_outside = true;
        let ends = [from, to].map(|end| self.outline_vertex([end.x as i64, end.y as i64]));
        if ends[0] != ends[1] {
            self.outline.segments.push(ends);
        }
    }

    fn outline_vertex(&mut self, at: [i64; 2]) -> u32 {
        for (side, curve) in Side::ALL.into_iter().zip(self.sides) {
            let start = side_start(self.lattice, self.square, side);
            let (across, along) = if side_is_meridian(side) {
                (at[0], at[1])
            } else {
                (at[1], at[0])
            };
            if across != if own_half(side) == 1 { 0 } else { self.extent } {
                continue;
            }
            let ends = own_runs(curve, side).flat_map(Run::ends).map(|end| end - start);
            if let Some(end) = ends
                .min_by_key(|end| (end - along).abs())
                .filter(|end| (end - along).abs() <= ROUNDING)
            {
                let at = on_side(side, end as f64, self.extent as f64);
                return self.surface_vertex([at.x as i64, at.y as i64]);
            }
        }
        let inner = [STRIP, self.extent - STRIP];
        if at.iter().any(|coordinate| inner.contains(coordinate)) {
            self.on_inner_lines.push(at);
        }
        self.surface_vertex(at)
    }

    fn add_inner_lines(&mut self) {
        let [low, high] = [STRIP, self.extent - STRIP];
        for axis in [0, 1] {
            for line in [low, high] {
                let crossings = self
                    .on_inner_lines
                    .iter()
                    .filter(|at| at[axis] == line)
                    .map(|at| at[1 - axis]);
                let mut stops: Vec<i64> = crossings.filter(|along| (low..=high).contains(along)).collect();
                stops.extend([low, high]);
                stops.sort_unstable();
                stops.dedup();
                let at = |along: i64| if axis == 0 { [line, along] } else { [along, line] };
                for pair in stops.windows(2) {
                    let [from, to] = [at(pair[0]), at(pair[1])];
                    let middle = DVec2::new((from[0] + to[0]) as f64 / 2.0, (from[1] + to[1]) as f64 / 2.0);
                    if self.is_inside(middle) {
                        let segment = [self.surface_vertex(from), self.surface_vertex(to)];
                        self.outline.segments.push(segment);
                    }
                }
            }
        }
    }

    /// Grid edges between a valid and an invalid cell in the part of the raster that the square may touch.
    fn outline_steps(&self) -> Vec<[DVec2; 2]> {
        let extent = self.extent as f64;
        let places = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * extent);
        let around = places
            .iter()
            .flat_map(|&x| places.iter().map(move |&y| DVec2::new(x, y)));
        let (low, high) = around
            .map(|plan| self.grid(plan))
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), grid| {
                (low.min(grid), high.max(grid))
            });
        let limit = DVec2::new(
            self.reference.heights.columns as f64,
            self.reference.heights.rows as f64,
        );
        let (low, high) = ((low - 3.0).max(DVec2::ZERO).floor(), (high + 3.0).min(limit).ceil());
        let valid = |column: f64, row: f64| self.reference.heights.cell_is_valid(column as i64, row as i64);
        let mut steps = Vec::new();
        let mut row = low.y;
        while row <= high.y {
            let mut column = low.x;
            while column <= high.x {
                let corner = DVec2::new(column, row);
                let here = valid(column, row);
                if here != valid(column - 1.0, row) {
                    steps.push([corner, corner + DVec2::Y]);
                }
                if here != valid(column, row - 1.0) {
                    steps.push([corner, corner + DVec2::X]);
                }
                column += 1.0;
            }
            row += 1.0;
        }
        steps
    }
}

fn side_is_meridian(side: Side) -> bool {
    matches!(side, Side::West | Side::East)
}

/// Parameter at which a coordinate passes a line, if strictly between its ends.
fn cut(from: f64, to: f64, line: f64) -> Option<f64> {
    ((from - line) * (to - line) < 0.0).then(|| (line - from) / (to - from))
}
