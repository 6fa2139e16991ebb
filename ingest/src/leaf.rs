//! The finest mesh of a leaf: built inside its sides and the raster's outline.
//!
//! ```text
//!   side's curve (fine vertices)        ─┐
//!   inner line of the strip, 4 units in ─┼─▶ constrained Delaunay, refined until the tolerance holds everywhere
//!   raster's outline, cell by cell      ─┤
//!   breaklines, cell by cell            ─┘
//! ```
//! The strip between a side and its inner line holds no vertices, so that collapses along the side never fail.

use std::collections::{BTreeSet, HashMap};

use anyhow::{Context, Result};
use glam::{DVec2, DVec3};
use terrain_codec::address::Side;
use terrain_codec::ellipsoid::{METRES_IN_A_DEGREE, on_ellipsoid};
use terrain_core::Surface;
use terrain_core::height_field::ground::distance_on_earth;
use terrain_core::height_field::reference::Reference;
use terrain_core::height_field::refine::{Frame, Refinement, refine};
use terrain_core::height_field::snapping::{Place, snapped};
use terrain_core::height_field::triangulate::{Outline, Triangulated, stepped, triangulate_beside};
use terrain_core::mesh;

use crate::border::{BorderCurve, Run};
use crate::lattice::{Lattice, STRIP, Square};
use crate::raster_outline::{BorderSource, crossing, on_line, with_passed};
use crate::strips::out_of_strips;

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

/// Lattice units by which a breakline is moved at most: out of a strip, and from place to place where lines meet; both along two axes.
const MOVED: f64 = (STRIP + 1) as f64 * std::f64::consts::SQRT_2;

/// The finest surface of a leaf.
pub(crate) struct FinestSurface<'a> {
    /// In lattice coordinates and metres; without triangles where the raster has no surface.
    pub(crate) surface: Surface<'a>,
    /// Metres that its outline strays from the raster's, but for the rounding of cuts, and edges along breaklines from these.
    pub(crate) strayed: f64,
    /// Whether it would have come to more vertices than a leaf may have.
    pub(crate) is_full: bool,
}

/// Builds the finest surface of a leaf, with the raster's outline where that may be in it; where none is given, all samples of the
/// reference have heights.
///
/// # Errors
/// When the raster's outline cannot be triangulated.
pub(crate) fn finest_surface<'a>(
    lattice: Lattice,
    source: Option<&BorderSource>,
    reference: &'a Reference<'a>,
    square: Square,
    sides: [&BorderCurve; 4],
    tolerance: f64,
) -> Result<FinestSurface<'a>> {
    let mut builder = Builder {
        lattice,
        source,
        reference,
        square,
        sides,
        extent: lattice.extent(square.zoom),
        outline: Outline::default(),
        boundary: vec![],
        strayed: 0.0,
        strayed_along_sides: 0.0,
        numbers: HashMap::new(),
        on_inner_lines: vec![],
    };
    builder.add_sides();
    let outline = builder.raster_outline();
    let breaklines = builder.breaklines();
    builder.add_lines(outline, &breaklines);
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
        strayed: builder.strayed + builder.strayed_along_sides,
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
    source: Option<&'a BorderSource<'a>>,
    reference: &'a Reference<'a>,
    square: Square,
    sides: [&'a BorderCurve; 4],
    extent: i64,
    outline: Outline,
    /// Segments with the surface to their left.
    boundary: Vec<[u32; 2]>,
    /// Metres by which the outline strays from the raster's, and edges along breaklines from these, at most.
    strayed: f64,
    /// Metres by which edges of sides along breaklines, which are straight in space, bulge from the sides.
    strayed_along_sides: f64,
    numbers: HashMap<[i64; 2], u32>,
    /// Where the raster's outline and breaklines cross the strip's inner lines.
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
        let plan = DVec2::new(at[0] as f64, at[1] as f64);
        let height = match self.source {
            Some(source) => source.height_at(plan + self.lattice.origin(self.square)),
            None => self.reference.height_near(plan),
        };
        self.vertex(at, stepped(height, self.lattice.height_step()))
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

    /// The pieces of the raster's outline that are inside the square, cut at its sides and inner lines; the surface is to their left.
    fn raster_outline(&mut self) -> Vec<[Place; 2]> {
        let Some(source) = self.source else { return Vec::new() };
        let origin = self.lattice.origin(self.square);
        let corner = [origin.x as i64, origin.y as i64];
        let steps = source.steps_around(origin, origin + self.extent as f64);
        let mut pieces = Vec::new();
        for step in steps {
            let [from, to] = step.ends.map(|at| [at[0] - corner[0], at[1] - corner[1]]);
            let points = self.cut(from, to);
            let all = points.windows(2).map(|pair| [pair[0], pair[1]]);
            let mut is_inside = false;
            pieces.extend(all.filter(|&piece| {
                let is_piece_inside = self.is_inside(piece);
                is_inside |= is_piece_inside;
                is_piece_inside && piece[0] != piece[1]
            }));
            if is_inside {
                self.strayed = self.strayed.max(source.strays(&step));
            }
        }
        pieces
    }

    fn is_inside(&self, [from, to]: [Place; 2]) -> bool {
        (0..2).all(|axis| (1..2 * self.extent).contains(&(from[axis] + to[axis])))
    }

    /// The edges along breaklines that are inside the square or on its sides, led around its strips.
    fn breaklines(&mut self) -> Vec<[Place; 2]> {
        let Some(source) = self.source else { return Vec::new() };
        let origin = self.lattice.origin(self.square);
        let corner = [origin.x as i64, origin.y as i64];
        let steps = source.breaklines_around(origin, origin + self.extent as f64);
        let within = |edge: &[Place; 2]| edge.iter().flatten().all(|c| (0..=self.extent).contains(c));
        let (mut edges, mut steps_beside, mut strayed) = (Vec::new(), Vec::new(), 0.0_f64);
        let on_lattice = |edge: &[Place; 2]| edge.map(|[x, y]| DVec2::new(x as f64, y as f64) + origin);
        let within_square = [origin, origin + self.extent as f64];
        for step in steps {
            let local = step.ends.map(|at| [at[0] - corner[0], at[1] - corner[1]]);
            let own: Vec<[Place; 2]> = out_of_strips(local, self.extent).into_iter().filter(within).collect();
            if own.is_empty() {
                steps_beside.push(step);
                continue;
            }
            let on_lattice: Vec<[DVec2; 2]> = own.iter().map(on_lattice).collect();
            strayed = strayed
                .max(source.strays(&step))
                .max(source.strays_within(&step, within_square, &on_lattice));
            edges.extend(own);
        }
        if !edges.is_empty() {
            let on_lattice: Vec<[DVec2; 2]> = edges.iter().map(on_lattice).collect();
            for step in steps_beside {
                strayed = strayed.max(source.strays_within(&step, within_square, &on_lattice));
            }
        }
        if !edges.is_empty() {
            let unit = self.lattice.degrees_per_unit() * METRES_IN_A_DEGREE;
            self.strayed = self.strayed.max(strayed + MOVED * unit);
        }
        edges
    }

    /// Puts in pieces of the outline and edges along breaklines, which are to meet at vertices only.
    fn add_lines(&mut self, outline: Vec<[Place; 2]>, breaklines: &[[Place; 2]]) {
        if breaklines.is_empty() {
            self.add_boundary(&outline);
            return;
        }
        let inner = STRIP..=self.extent - STRIP;
        let is_inner = |edge: &[Place; 2]| edge.iter().flatten().all(|c| inner.contains(c));
        let (inner_outline, outline_in_strips): (Vec<_>, Vec<_>) = outline.into_iter().partition(is_inner);
        let (inner_lines, lines_in_strips): (Vec<_>, Vec<_>) = breaklines.iter().copied().partition(is_inner);
        self.add_boundary(&outline_in_strips);
        self.add_across_strips(&lines_in_strips, &outline_in_strips);
        self.add_along_sides(&lines_in_strips);
        let ways = snapped(&[inner_outline.as_slice(), &inner_lines].concat());
        let (outline, lines) = ways.split_at(inner_outline.len());
        let edges = |ways: &[Vec<Place>]| -> Vec<[Place; 2]> {
            let pairs = ways.iter().flat_map(|way| way.windows(2));
            pairs.map(|pair| [pair[0], pair[1]]).collect()
        };
        let outline = edges(outline);
        self.add_boundary(&outline);
        let mut known: BTreeSet<[Place; 2]> = outline.into_iter().map(sorted).collect();
        for edge in edges(lines) {
            if known.insert(sorted(edge)) {
                let ends = edge.map(|end| self.line_vertex(end));
                self.outline.breaklines.push(ends);
            }
        }
    }

    fn add_boundary(&mut self, pieces: &[[Place; 2]]) {
        for piece in pieces {
            let ends = piece.map(|end| self.line_vertex(end));
            self.boundary.push(ends);
        }
    }

    /// Edges straight across a strip, from vertices that the side has; none over the outline.
    fn add_across_strips(&mut self, edges: &[[Place; 2]], outline: &[[Place; 2]]) {
        let is_across = |[from, to]: &[Place; 2]| self.is_on_side(*from) != self.is_on_side(*to);
        let across: BTreeSet<[Place; 2]> = edges.iter().copied().filter(is_across).map(sorted).collect();
        for edge in across {
            let on_side = edge.into_iter().find(|&end| self.is_on_side(end));
            let is_known = on_side.is_some_and(|end| self.numbers.contains_key(&end));
            if is_known && !outline.iter().any(|&piece| do_cross(edge, piece)) {
                let ends = edge.map(|end| self.line_vertex(end));
                self.outline.breaklines.push(ends);
            }
        }
    }

    /// Edges of sides that breaklines run along.
    fn add_along_sides(&mut self, edges: &[[Place; 2]]) {
        for side in Side::ALL {
            let axis = usize::from(matches!(side, Side::South | Side::North));
            let line = if matches!(side, Side::East | Side::North) {
                self.extent
            } else {
                0
            };
            let on_side = edges.iter().filter(|edge| edge.iter().all(|end| end[axis] == line));
            let covered = joined(on_side.map(|edge| edge.map(|end| end[1 - axis])));
            let start = side_start(self.lattice, self.square, side);
            for run in own_runs(self.sides[side as usize], side) {
                let vertices: Vec<i64> = run.vertices().map(|(along, ..)| along - start).collect();
                for pair in vertices.windows(2) {
                    if covered.iter().any(|range| range[0] <= pair[0] && pair[1] <= range[1]) {
                        self.add_along_side([pair[0], pair[1]], axis, line);
                    }
                }
            }
        }
    }

    fn add_along_side(&mut self, along: [i64; 2], axis: usize, line: i64) {
        let places = along.map(|along| on_line(axis, line, along));
        let ends = places.map(|place| self.line_vertex(place));
        self.outline.breaklines.push(ends);
        let origin = self.lattice.origin(self.square);
        let [from, to] = places.map(|[x, y]| DVec2::new(x as f64, y as f64) + origin);
        let on_earth = |at: DVec2| on_ellipsoid(self.lattice.geographic(at));
        let bulge = distance_on_earth(on_earth((from + to) / 2.0), [from, to].map(on_earth));
        self.strayed_along_sides = self.strayed_along_sides.max(bulge);
    }

    fn is_on_side(&self, at: Place) -> bool {
        at.iter()
            .any(|&coordinate| coordinate == 0 || coordinate == self.extent)
    }

    /// The ends of a step and where it passes the square's sides and inner lines, in order.
    fn cut(&self, from: [i64; 2], to: [i64; 2]) -> Vec<[i64; 2]> {
        let step = [from, to];
        let lines = [(0, 0), (STRIP, STRIP), (self.extent - STRIP, STRIP), (self.extent, 0)];
        let passed = [0, 1].into_iter().flat_map(|axis| {
            lines.into_iter().filter_map(move |(line, margin)| {
                let along = crossing(step, axis, line)?;
                let is_on_it = (margin..=self.extent - margin).contains(&along);
                is_on_it.then(|| on_line(axis, line, along))
            })
        });
        with_passed(step, passed)
    }

    fn line_vertex(&mut self, at: [i64; 2]) -> u32 {
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
                let at = |along: i64| on_line(axis, line, along);
                for pair in stops.windows(2) {
                    let [from, to] = [at(pair[0]), at(pair[1])];
                    let segment = [self.surface_vertex(from), self.surface_vertex(to)];
                    self.outline.segments.push(segment);
                }
            }
        }
    }
}

fn sorted([a, b]: [Place; 2]) -> [Place; 2] {
    [a.min(b), a.max(b)]
}

/// Ranges, those that touch as one.
fn joined(ranges: impl Iterator<Item = [i64; 2]>) -> Vec<[i64; 2]> {
    let mut sorted: Vec<[i64; 2]> = ranges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    sorted.sort_unstable();
    let mut joined: Vec<[i64; 2]> = Vec::new();
    for [from, to] in sorted {
        match joined.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => joined.push([from, to]),
        }
    }
    joined
}

/// Whether two edges cross between their ends.
fn do_cross(first: [Place; 2], second: [Place; 2]) -> bool {
    let turn = |[from, to]: [Place; 2], at: Place| {
        let [way, before] = [to, at].map(|end| [0, 1].map(|axis| i128::from(end[axis] - from[axis])));
        (way[0] * before[1] - way[1] * before[0]).signum()
    };
    let parts = |edge: [Place; 2], ends: [Place; 2]| turn(edge, ends[0]) * turn(edge, ends[1]) < 0;
    parts(first, second) && parts(second, first)
}
