//! Greedy insertion: vertices are added to a surface where it strays furthest from its reference, until it does so
//! nowhere by more than the tolerance.
//!
//! After M. Garland, P. Heckbert, *Fast polygonal approximation of terrains and height fields*, 1995, with two
//! differences: a round inserts into all triangles that stray too far, but for those that another insertion of the
//! round has changed, so that no triangle is measured only to be replaced; and points between the samples count, too.
//!
//! ```text
//! insert the corners amid blocks of samples that are not nearly bilinear
//! all triangles are suspects
//! repeat until there are no suspects:
//!     for each suspect: find its worst point, at samples and (bound = surface) along its edges
//!     for each one that strays further than the tolerance, if it has not changed since:
//!         insert the sample nearest to the worst point, or the point itself; flip edges until all are Delaunay
//!     suspects ← triangles that changed
//! ```

use std::ops::Range;

use glam::DVec2;

use crate::height_field::reference::{Bound, Deviation};
use crate::height_field::surface::{Surface, morton_code};
use crate::height_field::triangulate::stepped;
use crate::topology::half_edges::{NONE, edges_of, next, ordered, previous};

/// Cells along the side of a block of samples.
const BLOCK: usize = 8;
/// Triangles that a walk to a point may cross.
const LONGEST_WALK: usize = 1000;
/// Below this distance all terms of the in-circle determinant, of six factors each, are exact in doubles: 12 · 2^48 < 2^53.
const EXACT_IN_CIRCLE: f64 = 4096.0;

/// How a surface is refined.
#[derive(Clone, Copy, Debug)]
pub struct Refinement {
    /// Metres that no point may stray.
    pub tolerance: f64,
    /// Heights are multiples of this, metres; 0 leaves them as they are.
    pub height_step: f64,
    /// A frame whose inside is kept free of new points but for its inner line.
    pub frame: Option<Frame>,
    /// No vertices are added once there are so many, if that is given.
    pub most_vertices: Option<usize>,
}

/// The square `0 … extent` in plan, and the width of the strip along its sides that holds no vertices inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Length of the sides.
    pub extent: f64,
    /// Width of the strip.
    pub width: f64,
}

impl Frame {
    /// Moves a point in the strip onto its inner line.
    #[must_use]
    pub fn push_in(&self, plan: DVec2) -> DVec2 {
        plan.clamp(DVec2::splat(self.width), DVec2::splat(self.extent - self.width))
    }

    /// Whether both points lie on one and the same side of the square.
    #[must_use]
    pub fn along_side(&self, a: DVec2, b: DVec2) -> bool {
        both_on(a, b, [0.0, self.extent])
    }

    /// Whether both points lie on one and the same inner line of the strip.
    fn along_inner_line(&self, a: DVec2, b: DVec2) -> bool {
        both_on(a, b, [self.width, self.extent - self.width])
    }
}

fn both_on(a: DVec2, b: DVec2, lines: [f64; 2]) -> bool {
    let on = |p: f64, q: f64| p == q && lines.contains(&p);
    on(a.x, b.x) || on(a.y, b.y)
}

/// Inserts vertices until no point of the reference is further than the tolerance away, no insertion helps, or there are too many.
pub fn refine(surface: &mut Surface, refinement: Refinement) {
    let flat = |surface: &Surface, corners: [u32; 3]| {
        let points = corners.map(|corner| surface.point(corner));
        surface.reference.triangle_worst(points, refinement.tolerance)
    };
    refine_by(surface, refinement, flat);
}

/// The same for triangles that need not be flat: `at_samples` is the worst under one.
pub(crate) fn refine_by(
    surface: &mut Surface,
    refinement: Refinement,
    at_samples: impl Fn(&Surface, [u32; 3]) -> Deviation,
) {
    let mut refiner = Refiner {
        at_samples,
        is_suspect: Vec::new(),
        suspects: Vec::new(),
        surface,
        refinement,
        unsettled: Vec::new(),
    };
    refiner.seed();
    let slots = refiner.surface.connectivity.triangle_slots();
    refiner.is_suspect.resize(slots as usize, false);
    (0..slots).for_each(|triangle| refiner.suspect(triangle));
    while refiner.round() {}
}

struct Refiner<'a, 'b, W> {
    at_samples: W,
    surface: &'a mut Surface<'b>,
    refinement: Refinement,
    suspects: Vec<u32>,
    /// For each triangle whether it is among them.
    is_suspect: Vec<bool>,
    /// Edges that may have to be flipped.
    unsettled: Vec<u32>,
}

impl<W: Fn(&Surface, [u32; 3]) -> Deviation> Refiner<'_, '_, W> {
    /// Inserts the corners amid blocks of samples that are not nearly bilinear: rounds that look at every sample again and
    /// again would come to about as many vertices.
    fn seed(&mut self) {
        let mut triangle = 0;
        for corner in self.corners_of_rough_blocks() {
            let plan = self.surface.reference.plan.plan(corner).round();
            let is_in_strip = self.refinement.frame.is_some_and(|frame| frame.push_in(plan) != plan);
            if !is_in_strip && self.insert(triangle, plan) {
                triangle = self.surface.connectivity.triangle_slots() - 1;
            }
        }
    }

    /// Those with rough blocks on all sides, neighbours close to each other: along a lone cliff, where only the blocks that
    /// it crosses are rough, vertices on a lattice would be in the way of better ones.
    fn corners_of_rough_blocks(&self) -> Vec<DVec2> {
        let [columns, rows] = self.surface.window();
        let starts = |range: &Range<usize>| (range.start..range.end.saturating_sub(BLOCK)).step_by(BLOCK);
        let is_rough: Vec<Vec<bool>> = starts(&rows)
            .map(|row| starts(&columns).map(|column| self.is_rough(column, row)).collect())
            .collect();
        let mut corners = Vec::new();
        for (row, blocks) in starts(&rows).skip(1).zip(is_rough.windows(2)) {
            for (column, place) in starts(&columns).skip(1).zip(0..) {
                if blocks.iter().all(|blocks| blocks[place] && blocks[place + 1]) {
                    corners.push(DVec2::new(column as f64, row as f64));
                }
            }
        }
        corners.sort_by_cached_key(|&corner| morton_code(corner));
        corners
    }

    /// Whether a sample of a block strays from the bilinear surface through the block's corners.
    fn is_rough(&self, column: usize, row: usize) -> bool {
        let sample = |across: usize, down: usize| self.surface.reference.heights.sample(column + across, row + down);
        let share = |steps: usize| steps as f64 / BLOCK as f64;
        let along = |from: f64, to: f64, steps: usize| from + (to - from) * share(steps);
        (0..=BLOCK).any(|down| {
            let left = along(sample(0, 0), sample(0, BLOCK), down);
            let right = along(sample(BLOCK, 0), sample(BLOCK, BLOCK), down);
            (0..=BLOCK)
                .any(|across| (along(left, right, across) - sample(across, down)).abs() > self.refinement.tolerance)
        })
    }

    /// Tells whether anything was inserted.
    fn round(&mut self) -> bool {
        let suspects = std::mem::take(&mut self.suspects);
        let strayed = |triangle: u32| {
            let worst = self.worst(triangle);
            (worst.size > self.refinement.tolerance).then_some((triangle, worst.at))
        };
        let strayed: Vec<(u32, DVec2)> = suspects.into_iter().filter_map(strayed).collect();
        self.is_suspect.fill(false);
        let mut has_new_vertex = false;
        for (triangle, at) in strayed {
            if self.is_full() {
                return false;
            }
            if !self.is_suspect[triangle as usize] {
                has_new_vertex |= self.mend(triangle, at);
                self.suspect(triangle);
            }
        }
        has_new_vertex
    }

    fn is_full(&self) -> bool {
        let most = self.refinement.most_vertices;
        most.is_some_and(|most| self.surface.vertex_count() >= most)
    }

    fn suspect(&mut self, triangle: u32) {
        if !std::mem::replace(&mut self.is_suspect[triangle as usize], true) {
            self.suspects.push(triangle);
        }
    }

    /// Splits a breakline that strays: nothing beside it would mend it. Otherwise inserts the sample next to the worst place before
    /// the place itself, since that is where the surface bends. Where vertices are there already it does so along edges that stray,
    /// and at last on the edges themselves.
    fn mend(&mut self, triangle: u32, worst: DVec2) -> bool {
        let sample = self.surface.reference.nearest_sample(worst);
        if self.split_breakline(triangle) || self.insert_at(triangle, sample) || self.insert_at(triangle, worst) {
            return true;
        }
        let tolerance = self.refinement.tolerance;
        let along = edges_of(triangle).map(|edge| (edge, self.along(edge)));
        let mut strayed = along.into_iter().filter(|(_, found)| found.size > tolerance);
        strayed.any(|(edge, found)| {
            let on_edge = self.on_edge(edge, self.surface.reference.plan.plan(found.at));
            let sample = self.surface.reference.nearest_sample(found.at);
            self.insert_at(triangle, sample) || self.insert_at(triangle, found.at) || self.insert(triangle, on_edge)
        })
    }

    /// Splits an edge of a triangle that is kept and strays, at the place next to its worst one where triangles stay upright.
    fn split_breakline(&mut self, triangle: u32) -> bool {
        let strayed = edges_of(triangle).into_iter().find_map(|edge| {
            let found = self.is_kept(edge).then(|| self.along(edge))?;
            (found.size > self.refinement.tolerance).then_some((edge, found.at))
        });
        let Some((edge, at)) = strayed else { return false };
        let plan = self.on_edge(edge, self.surface.reference.plan.plan(at)).round();
        self.can_split(edge, plan) && self.insert_on(edge, plan)
    }

    /// Whether an edge may go over a place next to it: all triangles stay upright, and the strip empty.
    fn can_split(&self, edge: u32, plan: DVec2) -> bool {
        let connectivity = &self.surface.connectivity;
        let is_upright = |edge: u32| {
            [next(edge), previous(edge)].into_iter().all(|beside| {
                let [from, to] = [connectivity.origin(beside), connectivity.end(beside)];
                self.surface.orientation(from, to, plan) > 0.0
            })
        };
        let is_in_strip = self.refinement.frame.is_some_and(|frame| frame.push_in(plan) != plan);
        let twin = connectivity.twin(edge);
        !is_in_strip && twin != NONE && is_upright(edge) && is_upright(twin)
    }

    fn is_kept(&self, edge: u32) -> bool {
        let connectivity = &self.surface.connectivity;
        let ends = || ordered([connectivity.origin(edge), connectivity.end(edge)]);
        !self.surface.breaklines.is_empty() && self.surface.breaklines.contains(&ends())
    }

    /// The place on an edge in plan that is nearest to another one.
    fn on_edge(&self, edge: u32, plan: DVec2) -> DVec2 {
        let connectivity = &self.surface.connectivity;
        let [from, to] = [connectivity.origin(edge), connectivity.end(edge)].map(|vertex| self.surface.plan(vertex));
        let along = to - from;
        from + along * ((plan - from).dot(along) / along.length_squared())
    }

    /// The worst of a triangle at samples or, if it holds there, along its edges; an edge between two suspects counts for
    /// one of them.
    fn worst(&self, triangle: u32) -> Deviation {
        let Some(corners) = self.surface.connectivity.corners(triangle) else {
            return Deviation::NONE;
        };
        if let Some(folded) = self.folded(corners) {
            return folded;
        }
        let at_samples = (self.at_samples)(self.surface, corners);
        if at_samples.size > self.refinement.tolerance || self.surface.reference.bound == Bound::Samples {
            return at_samples;
        }
        let is_counted = |&edge: &u32| {
            let twin = self.surface.connectivity.twin(edge);
            twin == NONE || twin > edge || !self.is_suspect[twin as usize / 3]
        };
        let along = edges_of(triangle)
            .into_iter()
            .filter(is_counted)
            .map(|edge| self.along(edge));
        along.fold(at_samples, Deviation::or)
    }

    /// By how much a triangle lies over others, if too much, and the middle of its longest edge.
    fn folded(&self, corners: [u32; 3]) -> Option<Deviation> {
        let corners = corners.map(|corner| self.surface.point(corner));
        let size = self.surface.reference.fold(corners);
        (size > self.refinement.tolerance).then(|| {
            let [a, b, c] = corners.map(|corner| corner.grid);
            let longest = [(a, b), (b, c), (c, a)]
                .into_iter()
                .max_by(|(a, b), (c, d)| a.distance_squared(*b).total_cmp(&c.distance_squared(*d)));
            let at = longest.map_or(a, |(from, to)| from.midpoint(to));
            Deviation { size, at }
        })
    }

    /// The worst along an edge, if the bound is to hold there and the edge is not given.
    fn along(&self, edge: u32) -> Deviation {
        let connectivity = &self.surface.connectivity;
        let [from, to] = [connectivity.origin(edge), connectivity.end(edge)];
        let [start, end] = [from, to].map(|vertex| self.surface.plan(vertex));
        let is_given = self.refinement.frame.is_some_and(|frame| frame.along_side(start, end));
        if self.surface.reference.bound == Bound::Samples || is_given {
            return Deviation::NONE;
        }
        self.surface.reference.edge_worst(
            self.surface.point(from),
            self.surface.point(to),
            self.refinement.tolerance,
        )
    }

    fn insert_at(&mut self, triangle: u32, grid: DVec2) -> bool {
        self.insert(triangle, self.surface.reference.plan.plan(grid))
    }

    /// Inserts a vertex at the whole plan position next to a place, if none is there and it belongs to the surface.
    fn insert(&mut self, triangle: u32, place: DVec2) -> bool {
        let reference = self.surface.reference;
        let plan = self
            .refinement
            .frame
            .map_or(place.round(), |frame| frame.push_in(place.round()));
        let Some((edge, is_on_edge)) = self.locate(triangle, plan) else {
            return false;
        };
        if is_on_edge {
            return self.insert_on(edge, plan);
        }
        let Some(height) = reference.height_near_grid(reference.plan.grid(plan)) else {
            return false;
        };
        let vertex = self.surface.connectivity.split_triangle(edge / 3);
        self.surface.push(plan, stepped(height, self.refinement.height_step));
        self.settle(vertex);
        true
    }

    /// Splits an edge at a place, if that belongs to the surface; both parts of a breakline are kept.
    fn insert_on(&mut self, edge: u32, plan: DVec2) -> bool {
        let reference = self.surface.reference;
        let Some(height) = reference.height_near_grid(reference.plan.grid(plan)) else {
            return false;
        };
        let ends = [
            self.surface.connectivity.origin(edge),
            self.surface.connectivity.end(edge),
        ];
        let vertex = self.surface.connectivity.split_edge(edge);
        self.surface.push(plan, stepped(height, self.refinement.height_step));
        if self.surface.breaklines.remove(&ordered(ends)) {
            let parts = ends.map(|end| ordered([end, vertex]));
            self.surface.breaklines.extend(parts);
        }
        self.settle(vertex);
        true
    }

    /// Walks from a triangle to the one with a point; gives a half-edge of that, and whether the point is on it. None if
    /// the point is a vertex or outside.
    fn locate(&self, triangle: u32, plan: DVec2) -> Option<(u32, bool)> {
        let connectivity = &self.surface.connectivity;
        let mut first = 3 * triangle;
        for _ in 0..LONGEST_WALK {
            let edges = [first, next(first), previous(first)];
            let turns = edges.map(|edge| {
                self.surface
                    .orientation(connectivity.origin(edge), connectivity.end(edge), plan)
            });
            match (0..3).find(|&side| turns[side] < 0.0) {
                Some(side) => {
                    let across = connectivity.twin(edges[side]);
                    if across == NONE {
                        return None;
                    }
                    first = across;
                }
                None => {
                    let on = turns.iter().filter(|&&turn| turn == 0.0).count();
                    let side = turns.iter().position(|&turn| turn == 0.0).unwrap_or(0);
                    return (on < 2).then_some((edges[side], on == 1));
                }
            }
        }
        None
    }

    /// Flips edges around a new vertex until all are Delaunay or given; the triangles around it become suspects.
    fn settle(&mut self, vertex: u32) {
        let mut unsettled = std::mem::take(&mut self.unsettled);
        unsettled.extend(self.surface.connectivity.leaving(vertex).map(next));
        while let Some(edge) = unsettled.pop() {
            if self.is_to_flip(edge) {
                let twin = self.surface.connectivity.twin(edge);
                self.surface.connectivity.flip(edge);
                unsettled.extend([edge, next(twin)]);
            }
        }
        unsettled.extend(self.surface.connectivity.leaving(vertex));
        self.is_suspect
            .resize(self.surface.connectivity.triangle_slots() as usize, false);
        unsettled.drain(..).for_each(|edge| self.suspect(edge / 3));
        self.unsettled = unsettled;
    }

    fn is_to_flip(&self, edge: u32) -> bool {
        let connectivity = &self.surface.connectivity;
        if connectivity.twin(edge) == NONE {
            return false;
        }
        let [a, b, c, d] = connectivity.quadrilateral(edge).map(|vertex| self.surface.plan(vertex));
        let is_given = self.refinement.frame.is_some_and(|frame| frame.along_inner_line(a, b));
        !is_given && is_in_circle([a, b, c, d]) && !self.is_kept(edge)
    }
}

/// Whether `d` is inside the circle through the counter-clockwise `a`, `b` and `c`, exactly; coordinates are whole numbers.
fn is_in_circle(corners: [DVec2; 4]) -> bool {
    let [a, b, c, d] = corners;
    let [from_a, from_b, from_c] = [a - d, b - d, c - d];
    let size = from_a.abs().max(from_b.abs()).max(from_c.abs()).max_element();
    if size < EXACT_IN_CIRCLE {
        let lifted = |p: DVec2, q: DVec2, r: DVec2| p.length_squared() * q.perp_dot(r);
        return lifted(from_a, from_b, from_c) + lifted(from_b, from_c, from_a) + lifted(from_c, from_a, from_b) > 0.0;
    }
    let [a, b, c, d] = corners.map(|p| robust::Coord { x: p.x, y: p.y });
    robust::incircle(a, b, c, d) > 0.0
}
