//! What a selection costs: pyramids of squares in a row, all levels full, seen from low above the ground so that what is near is
//! refined to the leaves. Counted are tiles that exist, and those that are drawn.
//!
//! `cargo bench -p terrain-core --bench selection`

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use terrain_core::selection::camera::{Camera, Ellipsoid, HalfSpace};
use terrain_core::selection::hierarchy::{Hierarchy, Level};
use terrain_core::selection::oriented_box::OrientedBox;
use terrain_core::selection::select::{Choice, Demand, Selection, select};

const SIDE: f64 = 100_000.0;
const RELIEF: f64 = 500.0;
/// Where the camera is, from the middle of the first root.
const EAST: f64 = -20_000.0;
const INTERIOR_LEVELS: usize = 4;

/// Depth, column, row.
type Node = (u8, u32, u32);

/// Squares of ground side by side, each cut in four again and again.
struct Ground {
    roots: u32,
    depth: u8,
    /// By depth.
    levels: Vec<Vec<Level>>,
}

impl Ground {
    fn new(roots: u32, depth: u8) -> Self {
        let level = |depth: u8, index: usize| Level {
            error: 2000.0 / f64::from(1_u32 << depth) * (1.0 + (INTERIOR_LEVELS - 1 - index) as f64 / 4.0),
            triangles: 500 * (index as u64 + 1),
            bytes: 100_000,
        };
        let of_depth = |depth| (0..INTERIOR_LEVELS).map(|index| level(depth, index)).collect();
        Self {
            roots,
            depth,
            levels: (0..=depth).map(of_depth).collect(),
        }
    }

    /// How many tiles there are.
    fn len(&self) -> u64 {
        let of_root: u64 = (0..=self.depth).map(|depth| 1 << (2 * depth)).sum();
        u64::from(self.roots) * of_root
    }
}

impl Hierarchy for Ground {
    type Node = Node;

    fn roots(&self) -> impl Iterator<Item = Node> {
        (0..self.roots).map(|x| (0, x, 0))
    }

    fn parent(&self, (depth, x, y): Node) -> Option<Node> {
        (depth > 0).then(|| (depth - 1, x / 2, y / 2))
    }

    fn children(&self, (depth, x, y): Node) -> impl Iterator<Item = Node> {
        let child = move |(right, up)| (depth + 1, 2 * x + right, 2 * y + up);
        let parts = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter();
        parts.filter(move |_| depth < self.depth).map(child)
    }

    fn neighbours(&self, (depth, x, y): Node) -> [Option<Node>; 4] {
        let (last_column, last_row) = ((self.roots << depth) - 1, (1 << depth) - 1);
        [
            (x > 0).then(|| (depth, x - 1, y)),
            (y > 0).then(|| (depth, x, y - 1)),
            (x < last_column).then_some((depth, x + 1, y)),
            (y < last_row).then_some((depth, x, y + 1)),
        ]
    }

    fn bounds(&self, (depth, x, y): Node) -> OrientedBox {
        let half = SIDE / f64::from(2_u32 << depth);
        let middle = |index: u32| f64::from(2 * index + 1) * half - SIDE / 2.0;
        OrientedBox {
            centre: DVec3::new(middle(x), middle(y), 0.0),
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            half_sizes: [half, half, RELIEF],
        }
    }

    fn levels(&self, (depth, ..): Node) -> &[Level] {
        &self.levels[usize::from(depth)]
    }
}

/// Low above the ground, looking along it.
fn camera(east: f64) -> Camera {
    let eye = DVec3::new(east, 0.0, 3000.0);
    let half_space = |normal: DVec3| HalfSpace {
        normal,
        offset: -normal.dot(eye),
    };
    let ahead = DVec3::new(1.0, 0.0, -0.15);
    Camera {
        eye,
        frustum: [ahead + DVec3::Y, ahead - DVec3::Y, ahead + DVec3::Z, ahead - DVec3::Z]
            .map(half_space)
            .to_vec(),
        pixels_per_radian: 1000.0,
        farthest: f64::INFINITY,
        ground: Some(Ellipsoid {
            centre: DVec3::new(0.0, 0.0, -6_371_000.0),
            axis: DVec3::Z,
            equatorial: 6_369_000.0,
            polar: 6_369_000.0,
        }),
    }
}

fn demand(tolerance: f64) -> Demand {
    Demand {
        tolerance,
        keep: 0.8,
        triangles: u64::MAX,
        bytes: u64::MAX,
    }
}

fn selected(ground: &Ground, demand: &Demand, before: &[Choice<Node>]) -> Selection<Node> {
    select(black_box(ground), black_box(&camera(EAST)), demand, |_| true, before)
}

/// A camera that goes some way on from picture to picture, and begins again at the end of it.
struct Flight {
    ground: Ground,
    demand: Demand,
    moment: u32,
    drawn: Vec<Choice<Node>>,
}

impl Flight {
    /// Pictures until it begins again.
    const MOMENTS: u32 = 600;
    /// Metres from picture to picture: at 60 in a second, 3 km in one.
    const STEP: f64 = 50.0;

    fn new((roots, depth): (u32, u8), tolerance: f64) -> Self {
        Self {
            ground: Ground::new(roots, depth),
            demand: demand(tolerance),
            moment: 0,
            drawn: Vec::new(),
        }
    }

    fn go_on(&mut self) {
        let camera = camera(EAST + Self::STEP * f64::from(self.moment));
        self.moment = (self.moment + 1) % Self::MOMENTS;
        self.drawn = select(black_box(&self.ground), &camera, &self.demand, |_| true, &self.drawn).choices;
    }

    /// Flies once, and tells how many tiles are drawn on the way.
    fn tell(&mut self) {
        let (mut least, mut most) = (usize::MAX, 0);
        for _ in 0..Self::MOMENTS {
            self.go_on();
            (least, most) = (least.min(self.drawn.len()), most.max(self.drawn.len()));
        }
        println!("{} tiles, {least} to {most} drawn", self.ground.len());
    }
}

/// A view of which everything in sight is refined as far as it goes: depth 7 has 21,845 tiles, depth 6 has 5,461.
#[divan::bench(args = [4, 5, 6, 7, 8])]
fn all_in_sight_to_the_leaves(bencher: Bencher, depth: u8) {
    let ground = Ground::new(1, depth);
    let drawn = selected(&ground, &demand(1e-3), &[]).choices.len();
    println!("depth {depth}: {} tiles, {drawn} drawn", ground.len());
    bencher
        .counter(ItemsCount::new(drawn))
        .bench(|| selected(&ground, &demand(1e-3), &[]));
}

/// Two pixels, as the page asks for.
#[divan::bench(args = [4, 5, 6, 7, 8, 10, 12, 14])]
fn two_pixels(bencher: Bencher, depth: u8) {
    let ground = Ground::new(1, depth);
    let drawn = selected(&ground, &demand(2.0), &[]).choices.len();
    println!("depth {depth}: {} tiles, {drawn} drawn", ground.len());
    bencher
        .counter(ItemsCount::new(drawn))
        .bench(|| selected(&ground, &demand(2.0), &[]));
}

/// The same after a picture that is already there.
#[divan::bench(args = [7, 14])]
fn two_pixels_again(bencher: Bencher, depth: u8) {
    let ground = Ground::new(1, depth);
    let before = selected(&ground, &demand(2.0), &[]).choices;
    bencher.bench(|| selected(&ground, &demand(2.0), &before));
}

/// For a quarter of the triangles, which takes several attempts.
#[divan::bench(args = [7, 14])]
fn a_quarter_of_the_triangles(bencher: Bencher, depth: u8) {
    let ground = Ground::new(1, depth);
    let drawn = selected(&ground, &demand(2.0), &[]).choices.len() as u64;
    let less = Demand {
        triangles: drawn * 500 / 4,
        ..demand(2.0)
    };
    bencher.bench(|| selected(&ground, &less, &[]));
}

/// A thousand, ten thousand and a hundred thousand tiles: roots, and depth below them.
const GROWING: [(u32, u8); 3] = [(3, 4), (2, 6), (5, 7)];

/// A picture of a flight within two pixels.
#[divan::bench(args = GROWING, sample_count = 600, sample_size = 1)]
fn flying(bencher: Bencher, size: (u32, u8)) {
    let mut flight = Flight::new(size, 2.0);
    flight.tell();
    bencher.bench_local(|| flight.go_on());
}

/// A picture of a flight in which everything in sight is refined as far as it goes.
#[divan::bench(args = GROWING, sample_count = 600, sample_size = 1)]
fn flying_over_leaves(bencher: Bencher, size: (u32, u8)) {
    let mut flight = Flight::new(size, 1e-3);
    flight.tell();
    bencher.bench_local(|| flight.go_on());
}

fn main() {
    divan::main();
}
