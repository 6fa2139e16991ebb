//! A curved surface over samples: cubic triangles, refined until every sample is within the tolerance, and simplified by
//! collapses that keep it so.
//!
//! ```text
//! slopes of the first surface ← planes through the samples around its vertices
//! insert vertices until every sample is within the tolerance
//! repeat until nothing collapses:
//!     for each vertex worth a try, for each neighbour, nearest first:
//!         check kinds, link, outline, orientation
//!         fit height and slope of the neighbour to all samples under the triangles that it will have
//!         collapse if these are within the tolerance
//! ```

use glam::DVec2;

use crate::height_field::attempts::Attempts;
use crate::height_field::corner_fit::{CornerFit, Tangent};
use crate::height_field::cubic::{Cubic, SlopedPoint, Unknown};
use crate::height_field::fan::Fan;
use crate::height_field::filters;
use crate::height_field::flat::GridPoint;
use crate::height_field::heights::Heights;
use crate::height_field::reference::{Deviation, Reference};
use crate::height_field::refine::{Refinement, refine_by};
use crate::height_field::ring::Ring;
use crate::height_field::rules::VertexKind;
use crate::height_field::sampled_surface::{Chosen, Gathered, Place, SampledSurface};
use crate::height_field::scan;
use crate::height_field::surface::Surface;
use crate::topology::edge_collapse::{Edge, link_allows};

/// Into how many of its neighbours, the nearest first, a vertex is tried to collapse.
const NEIGHBOURS: usize = 4;
/// Samples on each side of a vertex through which the plane of its first slope goes.
const AROUND: i64 = 2;

/// A surface of cubic triangles over a reference.
pub struct CubicSurface<'a> {
    sampled: SampledSurface<'a>,
    /// For each vertex, metres a column and a row.
    slopes: Vec<DVec2>,
    attempts: Attempts,
    least_altitude: f64,
    around_blue: Ring,
    around_red: Vec<u32>,
    ring: Ring,
    gathered: Gathered,
    fan: Fan,
    unknowns: Vec<Option<Unknown>>,
    fit: CornerFit,
}

impl<'a> CubicSurface<'a> {
    /// Begins with a surface whose vertices may all go but those where its outline turns; its reference's bound is at samples.
    /// Inserts vertices until every sample is within `tolerance` metres; no triangle will be lower than `least_altitude` in
    /// plan units.
    #[must_use]
    pub fn refined(mut surface: Surface<'a>, tolerance: f64, least_altitude: f64) -> Self {
        let refinement = Refinement {
            tolerance,
            height_step: 0.0,
            frame: None,
            most_vertices: None,
        };
        refine_by(&mut surface, refinement, |surface, corners| {
            let heights = surface.reference.heights;
            let sloped = |vertex: u32| {
                let point = surface.point(vertex);
                let slope = slope_around(heights, point.grid);
                SlopedPoint { point, slope }
            };
            deviation_of(surface.reference, corners.map(sloped))
        });
        let surface = surface.in_memory_order();
        let count = surface.vertex_count() as u32;
        let heights = surface.reference.heights;
        let slopes = (0..count).map(|vertex| slope_around(heights, surface.grid(vertex)));
        Self {
            slopes: slopes.collect(),
            sampled: SampledSurface::new(surface, vec![VertexKind::Free; count as usize]),
            attempts: Attempts::new(count as usize),
            least_altitude,
            around_blue: Ring::default(),
            around_red: Vec::new(),
            ring: Ring::default(),
            gathered: Gathered::default(),
            fan: Fan::default(),
            unknowns: Vec::new(),
            fit: CornerFit::default(),
        }
    }

    /// Collapses what keeps every sample within `tolerance` metres.
    pub fn thin(&mut self, tolerance: f64) {
        for vertex in 0..self.slopes.len() as u32 {
            self.try_again(vertex);
        }
        while self.round(tolerance) > 0 {}
    }

    /// The largest difference between the surface and a sample.
    #[must_use]
    pub fn deviation(&self) -> Deviation {
        let reference = self.sampled.surface.reference;
        self.triangles()
            .map(|corners| deviation_of(reference, corners))
            .fold(Deviation::NONE, Deviation::or)
    }

    /// Corners of all triangles, counter-clockwise in plan.
    pub fn triangles(&self) -> impl Iterator<Item = [SlopedPoint; 3]> + '_ {
        self.corners().map(|corners| corners.map(|corner| self.sloped(corner)))
    }

    /// The same by the numbers of vertices, of which some may be no triangle's.
    pub fn corners(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.sampled.surface.triangles().map(|(_, corners)| corners)
    }

    /// Vertices that are left.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        let connectivity = &self.sampled.surface.connectivity;
        (0..self.slopes.len() as u32)
            .filter(|&vertex| connectivity.is_live(vertex))
            .count()
    }

    fn sloped(&self, vertex: u32) -> SlopedPoint {
        SlopedPoint {
            point: self.sampled.surface.point(vertex),
            slope: self.slopes[vertex as usize],
        }
    }

    fn try_again(&mut self, vertex: u32) {
        let is_border = self.sampled.kinds[vertex as usize] == VertexKind::Border;
        self.attempts.set_worth_it(vertex, !is_border);
    }

    /// Tries every vertex that is worth it; tells how many collapsed.
    fn round(&mut self, tolerance: f64) -> usize {
        let mut count = 0;
        for vertex in 0..self.slopes.len() as u32 {
            if self.attempts.is_worth_it(vertex) && self.sampled.surface.connectivity.is_live(vertex) {
                count += usize::from(self.try_vertex(vertex, tolerance));
            }
        }
        count
    }

    fn try_vertex(&mut self, blue: u32, tolerance: f64) -> bool {
        self.attempts.set_worth_it(blue, false);
        self.around_blue.surround(&self.sampled.surface, blue);
        self.gathered.clear();
        self.sampled.gather_around(blue, &mut self.gathered.around_blue);
        let chosen = self
            .nearest_first(blue)
            .into_iter()
            .take(NEIGHBOURS)
            .find_map(|index| self.checked(blue, index, tolerance));
        let Some((chosen, slope)) = chosen else { return false };
        self.sampled.collapse(blue, &chosen, &mut self.gathered);
        self.slopes[chosen.red as usize] = slope;
        for place in 0..self.sampled.ring.vertices.len() {
            self.try_again(self.sampled.ring.vertices[place]);
        }
        self.try_again(chosen.red);
        true
    }

    /// Places around a vertex, in the order of distance.
    fn nearest_first(&self, centre: u32) -> Vec<usize> {
        let at = self.sampled.surface.plan(centre);
        let distance = |&index: &usize| self.around_blue.plan[index].distance_squared(at);
        let mut order: Vec<usize> = (0..self.around_blue.plan.len()).collect();
        order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        order
    }

    /// Passes the collapse of a vertex into a neighbour, numbered around it, through all filters.
    fn checked(&mut self, blue: u32, index: usize, tolerance: f64) -> Option<(Chosen, DVec2)> {
        let surface = &self.sampled.surface;
        let edge = Edge::new(&surface.connectivity, blue, &self.around_blue.vertices, index);
        if !filters::kinds_allow(surface, &self.sampled.kinds, edge) {
            return None;
        }
        surface.connectivity.ring(edge.red, &mut self.around_red);
        let strays = self.sampled.strays(edge);
        if !strays.is_straight
            || !link_allows(
                &surface.connectivity,
                edge,
                &self.around_blue.vertices,
                &self.around_red,
            )
        {
            return None;
        }
        self.ring
            .surround_collapsed(surface, edge, &self.around_blue, &self.around_red);
        let plan = surface.plan(edge.red);
        if !self.ring.is_seen_from(plan, self.least_altitude) {
            return None;
        }
        self.gathered.others.clear();
        self.sampled
            .gather_around_other(edge.red, blue, &mut self.gathered.others);
        let grid = surface.grid(edge.red);
        let Tangent { height, slope } = self.fitted(edge.red, tolerance)?;
        let point = GridPoint { grid, height };
        let place = Place {
            plan,
            point,
            squares: 0.0,
        };
        let red = edge.red;
        let chosen = Chosen {
            red,
            place,
            strays,
            breakline_strays: 0.0,
            closes: None,
        };
        Some((chosen, slope))
    }

    /// The tangent of a vertex amid the ring, within the tolerance of all samples gathered.
    fn fitted(&mut self, vertex: u32, tolerance: f64) -> Option<Tangent> {
        let surface = &self.sampled.surface;
        let centre = surface.grid(vertex);
        let Ring { points, is_closed, .. } = &self.ring;
        self.fan.spread(surface.reference, centre, points, *is_closed);
        let around = self.ring.vertices.iter().zip(points);
        let sloped = around.map(|(&vertex, &point)| SlopedPoint {
            point,
            slope: self.slopes[vertex as usize],
        });
        let following = sloped.clone().skip(1).chain(sloped.clone().take(1));
        self.unknowns.clear();
        self.unknowns.extend(
            sloped
                .zip(following)
                .map(|(second, third)| Unknown::new(centre, second, third)),
        );
        self.fit.clear();
        let mut sector = 0;
        for sample in self.gathered.around_blue.iter().chain(&self.gathered.others) {
            sector = self.fan.sector_of(sample, sector)?;
            let unknown = self.unknowns[sector].as_ref()?;
            self.fit.push(unknown.asked(sample.at - centre, sample.height));
        }
        let reach = points.iter().map(|point| point.grid.distance(centre)).sum::<f64>() / points.len() as f64;
        let present = Tangent {
            height: surface.height(vertex),
            slope: self.slopes[vertex as usize],
        };
        self.fit.solve(present, reach, tolerance)
    }
}

/// The worst of a cubic triangle at samples.
fn deviation_of(reference: &Reference, corners: [SlopedPoint; 3]) -> Deviation {
    let mut worst = Deviation::NONE;
    let Some(cubic) = Cubic::through(corners) else {
        return worst;
    };
    let Heights { columns, rows, .. } = reference.heights;
    scan::visit_rows(
        corners.map(|corner| corner.point.grid),
        [columns, rows],
        |row, columns| {
            for column in columns {
                let at = DVec2::new(column as f64, row as f64);
                let size = (cubic.height(at) - reference.heights.sample(column, row)).abs();
                if size > worst.size {
                    worst = Deviation { size, at };
                }
            }
        },
    );
    worst
}

/// Slope of the plane of least squares through the samples around a place; level where there are too few.
fn slope_around(heights: Heights, grid: DVec2) -> DVec2 {
    let centre = grid.round();
    let (mut count, mut mean, mut mean_height) = (0.0, DVec2::ZERO, 0.0);
    let samples = || {
        let offsets = (-AROUND..=AROUND).flat_map(|down| (-AROUND..=AROUND).map(move |across| [across, down]));
        offsets.filter_map(move |[across, down]| {
            let [column, row] = [centre.x as i64 + across, centre.y as i64 + down];
            let is_inside = (0..heights.columns as i64).contains(&column) && (0..heights.rows as i64).contains(&row);
            let height = is_inside.then(|| heights.sample(column as usize, row as usize))?;
            (!height.is_nan()).then_some((DVec2::new(across as f64, down as f64), height))
        })
    };
    for (offset, height) in samples() {
        (count, mean, mean_height) = (count + 1.0, mean + offset, mean_height + height);
    }
    (mean, mean_height) = (mean / count, mean_height / count);
    let (mut across, mut both, mut down, mut rise) = (0.0, 0.0, 0.0, DVec2::ZERO);
    for (offset, height) in samples() {
        let offset = offset - mean;
        across += offset.x * offset.x;
        both += offset.x * offset.y;
        down += offset.y * offset.y;
        rise += offset * (height - mean_height);
    }
    let determinant = across * down - both * both;
    if determinant > 0.0 {
        DVec2::new(down * rise.x - both * rise.y, across * rise.y - both * rise.x) / determinant
    } else {
        DVec2::ZERO
    }
}

#[cfg(test)]
#[path = "cubic_surface_tests.rs"]
mod tests;
