//! What levels, the graph of collapses, level switches and the queues cost, on a grid of a million and a half vertices
//! of which a million collapse in random order: memory is visited in the least favourable way.
//!
//! `cargo bench -p terrain-core --bench surface_partition`

use std::sync::LazyLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use terrain_core::adaptive_surface::AdaptiveSurface;
use terrain_core::dag::DagBuilder;
use terrain_core::level_view::LevelView;
use terrain_core::refinement_queues::RefinementQueues;
use terrain_core::replay::{Demand, Replay};
use terrain_core::{CollapseLog, Mesh, SurfacePartition};

#[path = "../tests/surfaces/random.rs"]
mod random;

const SIDE: u32 = 1225;
const COLLAPSES: usize = 1_000_000;

struct Input {
    mesh: Mesh,
    log: CollapseLog,
}

static INPUT: LazyLock<Input> = LazyLock::new(|| {
    let mesh = random::grid(SIDE);
    let log = random::random_log(&mesh, COLLAPSES, false, &mut fastrand::Rng::with_seed(7));
    assert_eq!(log.collapses.len(), COLLAPSES);
    Input { mesh, log }
});

static PARTITION: LazyLock<SurfacePartition> = LazyLock::new(|| {
    let Input { mesh, log } = &*INPUT;
    let replay = replay(Demand::Consistent);
    SurfacePartition::from_replay(mesh, &replay, &replay.level_batches(log, 0.0)).expect("one batch for each level")
});

fn main() {
    divan::main();
}

fn replay(demand: Demand) -> Replay {
    let Input { mesh, log } = &*INPUT;
    Replay::run(mesh, log, demand, |_| ()).expect("the log is made of valid collapses")
}

/// Levels and representatives, every collapse checked; items are collapses.
#[divan::bench(sample_count = 5)]
fn levels(bencher: Bencher) {
    LazyLock::force(&INPUT);
    bencher
        .counter(ItemsCount::new(COLLAPSES))
        .bench_local(|| replay(Demand::Consistent));
}

/// Levels, representatives and graph; items are collapses.
#[divan::bench(sample_count = 5)]
fn levels_and_graph(bencher: Bencher) {
    let Input { mesh, log } = &*INPUT;
    bencher.counter(ItemsCount::new(COLLAPSES)).bench_local(|| {
        let mut graph = DagBuilder::new(mesh.positions.len());
        let replay = Replay::run(mesh, log, Demand::Consistent, |step| graph.add(step));
        (replay, graph.finish())
    });
}

/// Sorting by level; items are vertices.
#[divan::bench(sample_count = 5)]
fn sort_into_a_partition(bencher: Bencher) {
    let Input { mesh, log } = &*INPUT;
    let replay = replay(Demand::Consistent);
    let batches = replay.level_batches(log, 0.0);
    bencher
        .counter(ItemsCount::new(mesh.positions.len()))
        .bench_local(|| SurfacePartition::from_replay(mesh, &replay, &batches));
}

/// From the coarsest level to one of a share of all levels and back, all triangles drawn; items are the vertices
/// that come and go, and those drawn.
#[divan::bench(args = [10, 50, 100], sample_count = 20)]
fn level_switch_percent(bencher: Bencher, percent: usize) {
    let finest = PARTITION.levels.len() - 1;
    let level = finest * percent / 100;
    let [coarse, fine] = [0, level].map(|index| PARTITION.levels[index].vertex_end as usize);
    let mut view = LevelView::new(&PARTITION);
    bencher.counter(ItemsCount::new(coarse + fine)).bench_local(|| {
        for to in [level, 0] {
            view.set_level(to);
            view.triangles().for_each(|triangle| {
                black_box(triangle);
            });
        }
    });
}

/// Everything split by the queues, then collapsed again; items are splits and collapses.
#[divan::bench(sample_count = 3)]
fn queues(bencher: Bencher) {
    let Input { mesh, log } = &*INPUT;
    let mut surface = AdaptiveSurface::new(mesh, log).expect("the log is made of valid collapses");
    let mut random = fastrand::Rng::with_seed(3);
    let own: Vec<f64> = (0..COLLAPSES).map(|_| 0.5 + random.f64()).collect();
    let errors = surface.dag().monotone_errors(&own);
    let error = |collapse: u32| errors[collapse as usize];
    let mut queues = RefinementQueues::new(&surface, error);
    bencher.counter(ItemsCount::new(2 * COLLAPSES)).bench_local(|| {
        let changes = [0.0, 2.0].map(|maximum| queues.update(&mut surface, maximum, error));
        assert_eq!((changes[0].splits, changes[1].collapses), (COLLAPSES, COLLAPSES));
    });
}
