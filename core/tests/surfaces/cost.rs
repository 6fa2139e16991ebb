//! A change of the surface costs what changes, however large the mesh is around it.

use glam::DVec2;
use terrain_core::levels::adaptive_surface::AdaptiveSurface;
use terrain_core::levels::refinement_queues::{Changes, RefinementQueues};

use crate::random::{grid, random_log};

/// Refines a square of 8 units in the middle of a grid to the full and coarsens it again. Counts both, and how often
/// an error was asked for.
fn refine_the_middle(side: u32) -> ([Changes; 2], usize) {
    let mesh = grid(side);
    let log = random_log(&mesh, usize::MAX, false, &mut fastrand::Rng::with_seed(1));
    let mut surface = AdaptiveSurface::new(&mesh, &log).unwrap();
    let middle = DVec2::splat(f64::from(side / 2));
    let is_near = |blue: u32| (mesh.positions[blue as usize].truncate() - middle).abs().max_element() < 4.0;
    let near: Vec<f64> = log
        .collapses
        .iter()
        .map(|c| f64::from(u8::from(is_near(c.blue))))
        .collect();
    let errors = surface.dag().monotone_errors(&near);
    let asked = std::cell::Cell::new(0);
    let error = |collapse: u32| {
        asked.set(asked.get() + 1);
        errors[collapse as usize]
    };
    let mut queues = RefinementQueues::new(&surface, error);
    let finer = queues.update(&mut surface, 0.5, error);
    assert!((0..errors.len() as u32).all(|c| surface.is_performed(c) == (errors[c as usize] == 0.0)));
    queues.refill(&surface, |_| 0.0);
    let coarser = queues.update(&mut surface, 0.5, |_| 0.0);
    ([finer, coarser], asked.get())
}

#[test]
fn cost_grows_with_the_change_and_not_with_the_mesh() {
    let [small, large] = [64, 512].map(refine_the_middle);
    println!("{small:?}\n{large:?}");
    for ([finer, coarser], asked) in [small, large] {
        assert_eq!((finer.collapses, coarser.splits), (0, 0));
        assert_eq!(finer.splits, coarser.collapses);
        assert!(finer.operations < 30 * finer.splits, "{finer:?}");
        assert!(coarser.operations < 30 * coarser.collapses, "{coarser:?}");
        assert!(asked < 3 * finer.splits, "{asked} errors for {} splits", finer.splits);
    }
    // Of 64 times as many vertices, no more is split than the coarser levels above the square.
    let growth = large.0[0].splits as f64 / small.0[0].splits as f64;
    assert!(growth < 5.0, "{growth} times the splits");
}
