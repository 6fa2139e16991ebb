//! What a mesh inside a tolerance costs, and what one log for all errors costs in triangles, on fractal terrain whose
//! roughness from sample to sample is the same at every size.
//!
//! `cargo bench -p terrain-core --bench simplify`, or with the largest side of the grid, 4097 if none is given, after `--`

use cpu_time::ProcessTime;
use glam::{DVec2, DVec3};
use terrain_core::Surface;
use terrain_core::plan::PlanMap;
use terrain_core::reference::{Bound, Reference};
use terrain_core::refine::{Refinement, refine};
use terrain_core::simplify::{Allowance, Quality, Shape, Simplifier, VertexKind};
use terrain_core::triangulate::{Outline, triangulate};

/// Metres of the curves' tolerance, and of the finest rung of the ladder.
const ERROR: f64 = 5.0;
/// Metres by which the midpoint of neighbouring samples may be displaced, and how that grows with distance: some 0.16
/// triangles a sample are left at 5 m, as on SRTM of mountains.
const ROUGHNESS: f64 = 4.0;
const GROWTH: f64 = 0.8;
/// Larger grids are not made at the best quality: it would take most of the time and show nothing new.
const LARGEST_AT_BEST: usize = 1025;
/// Plan units in a cell.
const UNITS: f64 = 256.0;

fn main() {
    let largest: usize = std::env::args()
        .filter_map(|argument| argument.parse().ok())
        .next()
        .unwrap_or(4097);
    println!("CPU seconds per million samples, and triangles per sample, at {ERROR} m");
    println!(
        "{:>6}  {:>10}  {:>13}  {:>13}  {:>13}  {:>13}",
        "side", "bound", "fast", "default", "best", "ladder e, 2e"
    );
    let sides = (8..).map(|bits| (1 << bits) + 1).take_while(|&side| side <= largest);
    for side in sides {
        let terrain = Terrain::new(side);
        for bound in [Bound::Samples, Bound::Surface] {
            let columns = [Quality::Fast, Quality::Default, Quality::Best].map(|quality| {
                if quality == Quality::Best && side > LARGEST_AT_BEST {
                    return format!("{:>13}", "–");
                }
                let started = ProcessTime::now();
                let triangles = terrain.thinned(ERROR, bound, quality, |simplifier| {
                    simplifier.surface().triangle_count()
                });
                terrain.per_sample(started, triangles)
            });
            let started = ProcessTime::now();
            let rungs = [std::f64::consts::SQRT_2 * ERROR, 2.0 * ERROR];
            let triangles = terrain.laddered(ERROR, &rungs, bound, |_, triangles, _| triangles);
            let ladder = terrain.per_sample(started, triangles[1]);
            println!(
                "{side:>6}  {:>10}  {}  {ladder}",
                format!("{bound:?}"),
                columns.join("  ")
            );
        }
    }
    println!("\none log for all errors against a mesh made for each, 513 × 513");
    println!(
        "{:>8}  {:>10}  {:>9}  {:>9}  {:>6}  {:>6}",
        "error, m", "bound", "one log", "dedicated", "ratio", "rounds"
    );
    let terrain = Terrain::new(513);
    let rungs: Vec<f64> = (0..9).map(|rung| ERROR * (f64::from(rung) / 2.0).exp2()).collect();
    for bound in [Bound::Samples, Bound::Surface] {
        terrain.laddered(ERROR, &rungs, bound, |error, triangles, rounds| {
            let dedicated = terrain.thinned(error, bound, Quality::Default, |simplifier| {
                simplifier.surface().triangle_count()
            });
            let ratio = triangles as f64 / dedicated as f64;
            println!(
                "{error:>8.2}  {:>10}  {triangles:>9}  {dedicated:>9}  {ratio:>6.3}  {rounds:>6}",
                format!("{bound:?}")
            );
        });
    }
}

struct Terrain {
    side: usize,
    heights: Vec<f32>,
    curvature: Vec<DVec2>,
}

impl Terrain {
    /// Midpoint displacement: the middles of edges and of squares, from the whole side down to one cell.
    fn new(side: usize) -> Self {
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
            columns: self.side,
            rows: self.side,
            heights: &self.heights,
            plan: PlanMap::fit(DVec2::ZERO, high, |plan| plan / UNITS, |grid| grid * UNITS),
            curvature: &self.curvature,
            ground: DVec2::ONE,
            bound,
        }
    }

    /// A mesh within `error`, handed to `then`.
    fn thinned<T>(&self, error: f64, bound: Bound, quality: Quality, then: impl FnOnce(Simplifier) -> T) -> T {
        let reference = self.reference(bound);
        let last = self.side - 1;
        let corner = |(column, row): (usize, usize)| {
            let height = f64::from(self.heights[row * self.side + column]);
            DVec3::new(column as f64 * UNITS, row as f64 * UNITS, height)
        };
        let outline = Outline {
            vertices: [(0, 0), (last, 0), (last, last), (0, last)].map(corner).to_vec(),
            segments: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
            has_outside: false,
        };
        let square = triangulate(&outline, |_| true).expect("four corners in order cross nothing");
        let mut surface = Surface::new(&square, &reference);
        let refinement = Refinement {
            tolerance: error,
            height_step: 0.0,
            frame: None,
        };
        refine(&mut surface, refinement);
        let mut simplifier = simplifier(surface, quality);
        simplifier.thin(Allowance {
            vertical: error,
            outline: 0.0,
        });
        then(simplifier)
    }

    /// A mesh within `finest`, and one log from there through all errors; `then` gets each error, the triangles left and the
    /// rounds it took.
    fn laddered<T>(
        &self,
        finest: f64,
        errors: &[f64],
        bound: Bound,
        mut then: impl FnMut(f64, usize, u32) -> T,
    ) -> Vec<T> {
        self.thinned(finest, bound, Quality::Default, |thinned| {
            let mut simplifier = simplifier(thinned.into_surface(), Quality::Default);
            let mut rungs = Vec::new();
            for &vertical in errors {
                let before = simplifier.rounds();
                simplifier.simplify(Allowance { vertical, outline: 0.0 });
                let triangles = simplifier.surface().triangle_count();
                rungs.push(then(vertical, triangles, simplifier.rounds() - before));
            }
            rungs
        })
    }

    fn per_sample(&self, started: ProcessTime, triangles: usize) -> String {
        let samples = (self.side * self.side) as f64;
        let seconds = started.elapsed().as_secs_f64() / samples * 1e6;
        format!("{seconds:>6.2} {:>6.3}", triangles as f64 / samples)
    }
}

fn simplifier(surface: Surface, quality: Quality) -> Simplifier {
    let surface = surface.in_memory_order();
    let kinds = vec![VertexKind::Free; surface.vertex_count()];
    let shape = Shape {
        height_step: 0.0,
        least_altitude: 4.0,
    };
    Simplifier::new(surface, kinds, shape, quality)
}
