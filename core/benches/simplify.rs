//! What a mesh inside a tolerance costs, and what one log for all errors costs in triangles, on fractal terrain whose
//! roughness from sample to sample is the same at every size.
//!
//! `cargo bench -p terrain-core --bench simplify`, or with the largest side of the grid, 4097 if none is given, after `--`

use cpu_time::ProcessTime;
use terrain::{Terrain, simplifier};
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::{Allowance, Quality};

mod terrain;

/// Metres of the curves' tolerance, and of the finest rung of the ladder.
const ERROR: f64 = 5.0;
/// Larger grids are not made at the best quality: it would take most of the time and show nothing new.
const LARGEST_AT_BEST: usize = 1025;

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
                per_sample(&terrain, started, triangles)
            });
            let started = ProcessTime::now();
            let rungs = [std::f64::consts::SQRT_2 * ERROR, 2.0 * ERROR];
            let triangles = laddered(&terrain, ERROR, &rungs, bound, |_, triangles, _| triangles);
            let ladder = per_sample(&terrain, started, triangles[1]);
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
        laddered(&terrain, ERROR, &rungs, bound, |error, triangles, rounds| {
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

/// A mesh within `finest`, and one log from there through all errors; `then` gets each error, the triangles left and the
/// rounds it took.
fn laddered<T>(
    terrain: &Terrain,
    finest: f64,
    errors: &[f64],
    bound: Bound,
    mut then: impl FnMut(f64, usize, u32) -> T,
) -> Vec<T> {
    terrain.thinned(finest, bound, Quality::Default, |thinned| {
        let mut simplifier = simplifier(thinned.into_surface(), Quality::Default);
        let mut rungs = Vec::new();
        for &vertical in errors {
            let before = simplifier.rounds();
            simplifier.simplify(Allowance {
                vertical,
                outline: 0.0,
                breaklines: 0.0,
            });
            let triangles = simplifier.surface().triangle_count();
            rungs.push(then(vertical, triangles, simplifier.rounds() - before));
        }
        rungs
    })
}

fn per_sample(terrain: &Terrain, started: ProcessTime, triangles: usize) -> String {
    let samples = (terrain.side * terrain.side) as f64;
    let seconds = started.elapsed().as_secs_f64() / samples * 1e6;
    format!("{seconds:>6.2} {:>6.3}", triangles as f64 / samples)
}
