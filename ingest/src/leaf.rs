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
use terrain_core::height_field::triangulate::{Outline, Triangulated, stepped, triangulate_beside};
use terrain_core::mesh;
use terrain_tiles::address::Side;

use crate::border::{BorderCurve, Run};
use crate::georeference::GeoReference;
use crate::lattice::{Lattice, STRIP, Square};
use crate::raster_outline::{BorderSource, crossing};

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

/// Vertices for each sample of a leaf's window, at most: a mesh of all samples has one, and what needs so many on the whole has
/// walls of thousands of errors between them all.
const VERTICES_A_SAMPLE: usize = 32;

/// The finest surface of a leaf.
pub(crate) struct FinestSurface<'a> {
    /// In lattice coordinates and metres; without triangles where the raster has no surface.
    pub(crate) surface: Surface<'a>,
    /// Metres that its outline strays from the raster's, but for the rounding of cuts.
    pub(crate) strayed: f64,
    /// Whether it would have come to more vertices than a leaf may have.
    pub(crate) is_full: bool,
}

/// Builds the finest surface of a leaf.
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
) -> Result<FinestSurface<'a>> {
    let mut builder = Builder {
        lattice,
        georeference,
        reference,
        square,
        sides,
        extent: lattice.extent(square.zoom),
        outline: Outline::default(),
        boundary: vec![],
        strayed: 0.0,
        numbers: HashMap::new(),
        on_inner_lines: vec![],
    };
    builder.add_sides();
    builder.add_raster_outline();
    builder.add_inner_lines();
    let Triangulated { mut mesh, breaklines } = triangulate_beside(&builder.outline, &builder.boundary)
        .with_context(|| format!("tile {}", square.address()))?;
    mesh::separate_fans(&mut mesh, |_| false);
    let mut surface = Surface::new(&mesh, reference).with_breaklines(&breaklines);
    let most_vertices = VERTICES_A_SAMPLE * reference.heights.columns * reference.heights.rows;
    let refinement = Refinement {
        tolerance,
        height_step: lattice.height_step(),
        frame: Some(frame(lattice, square)),
        most_vertices: Some(most_vertices),
    };
    refine(&mut surface, refinement);
    Ok(FinestSurface {
        is_full: surface.vertex_count() >= most_vertices,
        surface,
        strayed: builder.strayed,
    })
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
    /// Segments with the surface to their left.
    boundary: Vec<[u32; 2]>,
    /// Metres by which the outline strays from the raster's, at most.
    strayed: f64,
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
        let global = DVec2::new(at[0] as f64, at[1] as f64) + self.lattice.origin(self.square);
        let height = self.source().height_at(global);
        self.vertex(at, stepped(height, self.lattice.height_step()))
    }

    fn source(&self) -> BorderSource<'_> {
        BorderSource {
            lattice: self.lattice,
            georeference: self.georeference,
            heights: self.reference.heights,
        }
    }

    fn add_sides(&mut self) {
        for (side, curve) in Side::ALL.into_iter().zip(self.sides) {
            let start = side_start(self.lattice, self.square, side);
            for run in own_runs(curve, side) {
                let mut before = None;
                for (along, height, _) in run.vertices() {
                    let at = on_side(side, (along - start) as f64, self.extent as f64);
                    let number = self.vertex([at.x as i64, at.y as i64], height);
                    if let Some(before) = before {
                        let is_forwards = matches!(side, Side::South | Side::East);
                        let ends = if is_forwards {
                            [before, number]
                        } else {
                            [number, before]
                        };
                        self.boundary.push(ends);
                    }
                    before = Some(number);
                }
            }
        }
    }

    /// Every step of the raster's outline, cut at the square's sides and inner lines.
    fn add_raster_outline(&mut self) {
        let origin = self.lattice.origin(self.square);
        let corner = [origin.x as i64, origin.y as i64];
        let steps = self.source().steps_around(origin, origin + self.extent as f64);
        for step in steps {
            let mut is_inside = false;
            let [from, to] = step.ends.map(|at| [at[0] - corner[0], at[1] - corner[1]]);
            let points = self.cut(from, to);
            for pair in points.windows(2) {
                is_inside |= self.add_outline_piece(pair[0], pair[1]);
            }
            if is_inside {
                self.strayed = self.strayed.max(self.source().strays(&step));
            }
        }
    }

    /// The ends of a step and where it passes the square's sides and inner lines, in order.
    fn cut(&self, from: [i64; 2], to: [i64; 2]) -> Vec<[i64; 2]> {
        let mut points = vec![from, to];
        for axis in [0, 1] {
            for (line, margin) in [(0, 0), (STRIP, STRIP), (self.extent - STRIP, STRIP), (self.extent, 0)] {
                let along = crossing([from, to], axis, line);
                let on_it = along.filter(|along| (margin..=self.extent - margin).contains(along));
                points.extend(on_it.map(|along| if axis == 0 { [line, along] } else { [along, line] }));
            }
        }
        let product =
            |at: &[i64; 2], axis: usize| i128::from(at[axis] - from[axis]) * i128::from(to[axis] - from[axis]);
        points.sort_by_key(|at| product(at, 0) + product(at, 1));
        points.dedup();
        points
    }

    /// Adds a piece that is inside the square.
    fn add_outline_piece(&mut self, from: [i64; 2], to: [i64; 2]) -> bool {
        let is_inside = (0..2).all(|axis| (1..2 * self.extent).contains(&(from[axis] + to[axis])));
        if is_inside && from != to {
            let ends = [from, to].map(|end| self.outline_vertex(end));
            self.boundary.push(ends);
        }
        is_inside
    }

    fn outline_vertex(&mut self, at: [i64; 2]) -> u32 {
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
                    let segment = [self.surface_vertex(from), self.surface_vertex(to)];
                    self.outline.segments.push(segment);
                }
            }
        }
    }
}
