//! What levels, the graph of collapses, level switches and the queues cost, on a grid of a million and a half vertices
//! of which a million collapse, in the order of memory, as our simplifier has it, or in random order, the least
//! favourable.
//!
//! `cargo bench -p terrain-core --bench surface_partition`

use std::sync::LazyLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use terrain_core::levels::adaptive_surface::AdaptiveSurface;
use terrain_core::levels::dag::DagBuilder;
use terrain_core::levels::level_view::LevelView;
use terrain_core::levels::refinement_queues::RefinementQueues;
use terrain_core::levels::replay::{Demand, Replay, Step};
use terrain_core::{CollapseLog, Mesh, SurfacePartition};

#[path = "../tests/surfaces/random.rs"]
mod random;

const SIDE: u32 = 1225;
const COLLAPSES: usize = 1_000_000;

/// In which order vertices are tried.
#[derive(Clone, Copy, Debug)]
enum Order {
    Memory,
    Random,
}

const ORDERS: [Order; 2] = [Order::Memory, Order::Random];

struct Input {
    mesh: Mesh,
    log: CollapseLog,
}

impl Input {
    fn of(order: Order) -> &'static Self {
        static INPUTS: [LazyLock<Input>; 2] = [
            LazyLock::new(|| Input::new(Order::Memory)),
            LazyLock::new(|| Input::new(Order::Random)),
        ];
        &INPUTS[order as usize]
    }

    fn new(order: Order) -> Self {
        let mesh = random::grid(SIDE);
        let mut random = fastrand::Rng::with_seed(7);
        let log = match order {
            Order::Memory => random::log_in_order(&mesh, (0..SIDE * SIDE).collect(), COLLAPSES, false, &mut random),
            Order::Random => random::random_log(&mesh, COLLAPSES, false, &mut random),
        };
        assert_eq!(log.collapses.len(), COLLAPSES);
        Self { mesh, log }
    }

    fn replay(&self, visit: impl FnMut(&Step)) -> Replay {
        Replay::run(&self.mesh, &self.log, Demand::Consistent, visit).expect("the log is made of valid collapses")
    }

    fn partition(&self) -> SurfacePartition {
        let replay = self.replay(|_| ());
        let batches = replay.level_batches(&self.log, 0.0);
        SurfacePartition::from_replay(&self.mesh, &replay, &batches).expect("there is one batch for each level")
    }
}

fn main() {
    divan::main();
}

/// Levels and representatives, every collapse checked; items are collapses.
#[divan::bench(args = ORDERS, sample_count = 5)]
fn levels(bencher: Bencher, order: Order) {
    let input = Input::of(order);
    bencher
        .counter(ItemsCount::new(COLLAPSES))
        .bench_local(|| input.replay(|_| ()));
}

/// Levels, representatives and graph; items are collapses.
#[divan::bench(args = ORDERS, sample_count = 5)]
fn levels_and_graph(bencher: Bencher, order: Order) {
    let input = Input::of(order);
    bencher.counter(ItemsCount::new(COLLAPSES)).bench_local(|| {
        let mut graph = DagBuilder::new(input.mesh.positions.len());
        let replay = input.replay(|step| graph.add(step));
        (replay, graph.finish())
    });
}

/// Sorting by level; items are vertices.
#[divan::bench(args = ORDERS, sample_count = 5)]
fn sort_into_a_partition(bencher: Bencher, order: Order) {
    let input = Input::of(order);
    let replay = input.replay(|_| ());
    let batches = replay.level_batches(&input.log, 0.0);
    bencher
        .counter(ItemsCount::new(input.mesh.positions.len()))
        .bench_local(|| SurfacePartition::from_replay(&input.mesh, &replay, &batches));
}

/// From the coarsest level to the finest and back, all triangles drawn both times; items are the vertices drawn.
#[divan::bench(args = ORDERS, sample_count = 20)]
fn level_switch(bencher: Bencher, order: Order) {
    let partition = Input::of(order).partition();
    let finest = partition.levels.len() - 1;
    let drawn = [0, finest].map(|index| partition.levels[index].vertex_end as usize);
    let mut view = LevelView::new(&partition);
    bencher.counter(ItemsCount::new(drawn[0] + drawn[1])).bench_local(|| {
        for to in [finest, 0] {
            view.set_level(to);
            view.triangles().for_each(|triangle| {
                black_box(triangle);
            });
        }
    });
}

/// Everything split by the queues, then collapsed again; items are splits and collapses.
#[divan::bench(args = ORDERS, sample_count = 3)]
fn queues(bencher: Bencher, order: Order) {
    let Input { mesh, log } = Input::of(order);
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
