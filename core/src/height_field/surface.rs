//! A mesh while it is edited over its reference surface: vertices in flat arrays beside their connectivity.

use std::collections::{BTreeSet, HashSet};
use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::height_field::reference::{Bound, Deviation, GridPoint, Reference};
use crate::height_field::scan;
use crate::mesh::{Mesh, plan_orientation};
use crate::topology::half_edges::{HalfEdges, NONE, edges_of, inverse, ordered, permute};

/// A mesh over a reference surface.
#[derive(Clone, Debug)]
pub struct Surface<'a> {
    pub(crate) reference: &'a Reference<'a>,
    pub(crate) connectivity: HalfEdges,
    /// Plan coordinates.
    plan: Vec<DVec2>,
    /// Metres.
    heights: Vec<f64>,
    /// Where vertices are on the grid; empty where that is quickly computed.
    grid: Vec<DVec2>,
    /// Edges that are kept, the lower number first.
    pub(crate) breaklines: BTreeSet<[u32; 2]>,
}

impl<'a> Surface<'a> {
    /// Takes over a mesh whose positions are plan coordinates of `reference` and heights in metres.
    #[must_use]
    pub fn new(mesh: &Mesh, reference: &'a Reference<'a>) -> Self {
        let mut surface = Self {
            reference,
            connectivity: HalfEdges::new(mesh.positions.len(), mesh.triangles.clone()),
            plan: Vec::new(),
            heights: Vec::new(),
            grid: Vec::new(),
            breaklines: BTreeSet::new(),
        };
        for position in &mesh.positions {
            surface.push(position.truncate(), position.z);
        }
        surface
    }

    /// The same with those of its edges kept that are between such plan positions; others are none of its edges.
    #[must_use]
    pub fn with_breaklines(mut self, edges: &[[DVec2; 2]]) -> Self {
        if edges.is_empty() {
            return self;
        }
        let bits = |place: DVec2| [place.x, place.y].map(|coordinate| (coordinate + 0.0).to_bits());
        let both_ways = edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
        let kept: HashSet<[[u64; 2]; 2]> = both_ways.map(|edge| edge.map(bits)).collect();
        let all = self.triangles().flat_map(|(_, [a, b, c])| [[a, b], [b, c], [c, a]]);
        let is_kept = |edge: &[u32; 2]| kept.contains(&edge.map(|end| bits(self.plan(end))));
        self.breaklines = all.filter(is_kept).map(ordered).collect();
        self
    }

    /// The edges that are kept, by the vertices' places in plan.
    #[must_use]
    pub fn breaklines(&self) -> Vec<[DVec2; 2]> {
        let edges = self.breaklines.iter();
        edges.map(|edge| edge.map(|end| self.plan(end))).collect()
    }

    /// The mesh as it is now, its vertices renumbered in order, and the number that each had here.
    #[must_use]
    pub fn mesh(&self) -> (Mesh, Vec<u32>) {
        let live: Vec<u32> = (0..self.plan.len() as u32)
            .filter(|&vertex| self.connectivity.is_live(vertex))
            .collect();
        let numbers = inverse(&live, self.plan.len());
        let mesh = Mesh {
            positions: live.iter().map(|&vertex| self.position(vertex)).collect(),
            triangles: self
                .triangles()
                .map(|(_, corners)| corners.map(|corner| numbers[corner as usize]))
                .collect(),
        };
        (mesh, live)
    }

    /// Renumbers vertices and triangles so that neighbours in plan are neighbours in memory, along a Morton curve. In place:
    /// this is where a surface needs most memory.
    #[must_use]
    pub fn in_memory_order(mut self) -> Self {
        let (order, live) = self.morton_order();
        permute(&mut self.heights, &order, live);
        permute(&mut self.plan, &order, live);
        if !self.grid.is_empty() {
            permute(&mut self.grid, &order, live);
        }
        self.connectivity.reorder(&order[..live]);
        if !self.breaklines.is_empty() {
            let numbers = inverse(&order, order.len());
            let edges = self.breaklines.iter();
            self.breaklines = edges
                .map(|edge| ordered(edge.map(|end| numbers[end as usize])))
                .collect();
        }
        self
    }

    /// Live vertices along a Morton curve through the grid, then removed ones; and how many are live.
    fn morton_order(&self) -> (Vec<u32>, usize) {
        let all = 0..self.plan.len() as u32;
        let code = |vertex: u32| u64::from(morton_code(self.grid(vertex)));
        let live = all.clone().filter(|&vertex| self.connectivity.is_live(vertex));
        // One number each of code and vertex: half as long to sort as pairs.
        let mut coded: Vec<u64> = live.map(|vertex| (code(vertex) << 32) | u64::from(vertex)).collect();
        coded.sort_unstable();
        let mut order: Vec<u32> = coded.iter().map(|&coded| coded as u32).collect();
        order.extend(all.filter(|&vertex| !self.connectivity.is_live(vertex)));
        (order, coded.len())
    }

    /// Columns and rows of the samples that the surface may cover.
    pub(crate) fn window(&self) -> [Range<usize>; 2] {
        let nowhere = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let vertices = 0..self.plan.len() as u32;
        let (low, high) = vertices.fold(nowhere, |(low, high), vertex| {
            let grid = self.grid(vertex);
            (low.min(grid), high.max(grid))
        });
        [
            scan::whole_numbers(low.x, high.x, self.reference.heights.columns),
            scan::whole_numbers(low.y, high.y, self.reference.heights.rows),
        ]
    }

    /// Triangles with their numbers.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = (u32, [u32; 3])> + '_ {
        (0..self.connectivity.triangle_slots()).filter_map(|number| Some((number, self.connectivity.corners(number)?)))
    }

    /// Vertices, removed ones counted, too.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.plan.len()
    }

    /// Triangles that are left.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles().count()
    }

    pub(crate) fn position(&self, vertex: u32) -> DVec3 {
        self.plan(vertex).extend(self.height(vertex))
    }

    pub(crate) fn point(&self, vertex: u32) -> GridPoint {
        GridPoint {
            grid: self.grid(vertex),
            height: self.height(vertex),
        }
    }

    pub(crate) fn plan(&self, vertex: u32) -> DVec2 {
        self.plan[vertex as usize]
    }

    pub(crate) fn height(&self, vertex: u32) -> f64 {
        self.heights[vertex as usize]
    }

    pub(crate) fn grid(&self, vertex: u32) -> DVec2 {
        let grid = self.grid.get(vertex as usize).copied();
        grid.unwrap_or_else(|| self.reference.plan.grid(self.plan(vertex)))
    }

    /// Moves a vertex.
    pub(crate) fn put(&mut self, vertex: u32, plan: DVec2, point: GridPoint) {
        self.plan[vertex as usize] = plan;
        self.heights[vertex as usize] = point.height;
        if let Some(grid) = self.grid.get_mut(vertex as usize) {
            *grid = point.grid;
        }
    }

    /// Adds the place of one more vertex.
    pub(crate) fn push(&mut self, plan: DVec2, height: f64) {
        self.plan.push(plan);
        self.heights.push(height);
        if !self.reference.plan.is_affine() {
            self.grid.push(self.reference.plan.grid(plan));
        }
    }

    /// Positive where the three plan positions turn left, exactly.
    pub(crate) fn orientation(&self, a: u32, b: u32, at: DVec2) -> f64 {
        let [a, b] = [a, b].map(|vertex| self.plan(vertex).extend(0.0));
        plan_orientation(a, b, at.extend(0.0))
    }

    /// Largest deviation of the whole surface from the reference, where its bound holds.
    #[must_use]
    pub fn deviation(&self) -> Deviation {
        let of_triangle = |(triangle, corners): (u32, [u32; 3])| {
            let points = corners.map(|corner| self.point(corner));
            let measured = edges_of(triangle).into_iter().filter(|&edge| {
                let twin = self.connectivity.twin(edge);
                self.reference.bound == Bound::Surface && (twin == NONE || twin > edge)
            });
            measured
                .map(|edge| {
                    self.reference.edge_deviation(
                        self.point(self.connectivity.origin(edge)),
                        self.point(self.connectivity.end(edge)),
                    )
                })
                .fold(self.reference.triangle_deviation(points), Deviation::or)
        };
        self.triangles().map(of_triangle).fold(Deviation::NONE, Deviation::or)
    }
}

/// Where a point of the grid is along a Morton curve through the samples; all beyond the last ones that it can tell apart
/// are as good as these.
pub(crate) fn morton_code(grid: DVec2) -> u32 {
    interleaved(grid.x as u16) | (interleaved(grid.y as u16) << 1)
}

/// The bits of a number, each with a 0 before it.
fn interleaved(number: u16) -> u32 {
    const STEPS: [(u32, u32); 4] = [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)];
    STEPS.iter().fold(u32::from(number), |bits, &(shift, mask)| {
        (bits | (bits << shift)) & mask
    })
}
