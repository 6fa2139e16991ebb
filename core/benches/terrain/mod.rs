//! Fractal terrain, and meshes of it inside a tolerance, for benchmarks.

use glam::{DVec2, DVec3};
use terrain_core::Surface;
use terrain_core::height_field::ground::Ground;
use terrain_core::height_field::heights::Heights;
use terrain_core::height_field::plan::PlanMap;
use terrain_core::height_field::reference::{Bound, Reference};
use terrain_core::height_field::refine::{Refinement, refine};
use terrain_core::height_field::simplify::{Allowance, Quality, Shape, Simplifier, VertexKind};
use terrain_core::height_field::triangulate::{Outline, triangulate};

/// Metres by which the midpoint of neighbouring samples may be displaced, and how that grows with distance: some 0.16
/// triangles a sample are left at 5 m, as on SRTM of mountains.
const ROUGHNESS: f64 = 4.0;
const GROWTH: f64 = 0.8;
/// Plan units in a cell.
const UNITS: f64 = 256.0;

/// Heights on a square grid.
pub(crate) struct Terrain {
    /// Samples along each side.
    pub(crate) side: usize,
    heights: Vec<f32>,
    curvature: Vec<DVec2>,
}

impl Terrain {
    /// Midpoint displacement: the middles of edges and of squares, from the whole side down to one cell.
    pub(crate) fn new(side: usize) -> Self {
        let mut random = fastrand::Rng::with_seed(1);
        let mut heights = vec![0.0_f32; side * side];
        let mut step = side - 1;
        while step > 1 {
            let half = step / 2;
            let reach = ROUGHNESS * (half as f64).powf(GROWTH);
            let mut displaced = |mean: f32| mean + ((random.f64() - 0.5) * 2.0 * reach) as f32;
            for row in (0..side).step_by(half) {
                for column in (0..side).step_by(half) {
                    let at = |column: usize, row: usize| heights[row * side + column];
                    let mean = match (column % step == 0, row % step == 0) {
                        (true, true) => continue,
                        (false, true) => (at(column - half, row) + at(column + half, row)) / 2.0,
                        (true, false) => (at(column, row - half) + at(column, row + half)) / 2.0,
                        (false, false) => {
                            let above = at(column - half, row - half) + at(column + half, row - half);
                            (above + at(column - half, row + half) + at(column + half, row + half)) / 4.0
                        }
                    };
                    heights[row * side + column] = displaced(mean);
                }
            }
            step = half;
        }
        Self {
            side,
            heights,
            curvature: vec![DVec2::ZERO; side],
        }
    }

    fn reference(&self, bound: Bound) -> Reference<'_> {
        let high = DVec2::splat((self.side - 1) as f64 * UNITS);
        Reference {
            heights: Heights {
                columns: self.side,
                rows: self.side,
                samples: &self.heights,
            },
            plan: PlanMap::fit(DVec2::ZERO, high, |plan| plan / UNITS, |grid| grid * UNITS),
            curvature: &self.curvature,
            ground: Ground::Plane(DVec2::ONE / UNITS),
            bound,
            finer: None,
        }
    }

    /// A mesh within `error`, handed to `then`.
    pub(crate) fn thinned<T>(
        &self,
        error: f64,
        bound: Bound,
        quality: Quality,
        then: impl FnOnce(Simplifier) -> T,
    ) -> T {
        let reference = self.reference(bound);
        let last = self.side - 1;
        let corner = |(column, row): (usize, usize)| {
            let height = f64::from(self.heights[row * self.side + column]);
            DVec3::new(column as f64 * UNITS, row as f64 * UNITS, height)
        };
        let outline = Outline {
            vertices: [(0, 0), (last, 0), (last, last), (0, last)].map(corner).to_vec(),
            segments: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
            ..Outline::default()
        };
        let square = triangulate(&outline, |_| true).expect("four corners in order cross nothing");
        let mut surface = Surface::new(&square.mesh, &reference);
        let refinement = Refinement {
            tolerance: error,
            height_step: 0.0,
            frame: None,
            most_vertices: None,
        };
        refine(&mut surface, refinement);
        let mut simplifier = simplifier(surface, quality);
        simplifier.thin(Allowance {
            vertical: error,
            outline: 0.0,
            breaklines: 0.0,
        });
        then(simplifier)
    }
}

/// A simplifier without constraints, vertices and triangles in the order of memory.
pub(crate) fn simplifier(surface: Surface, quality: Quality) -> Simplifier {
    let surface = surface.in_memory_order();
    let kinds = vec![VertexKind::Free; surface.vertex_count()];
    let shape = Shape {
        height_step: 0.0,
        least_altitude: 4.0,
    };
    Simplifier::new(surface, kinds, shape, quality)
}
