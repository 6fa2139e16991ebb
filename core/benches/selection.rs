//! What a selection costs: pyramids of a square, all levels full, seen from low above the middle so that what is near is refined
//! to the leaves. Counted are tiles that exist, and those that are drawn.
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
const INTERIOR_LEVELS: usize = 4;

/// Depth, column, row.
type Node = (u8, u32, u32);

/// A square of ground, cut in four again and again.
struct Square {
    depth: u8,
    /// By depth.
    levels: Vec<Vec<Level>>,
}

impl Square {
    fn new(depth: u8) -> Self {
        let level = |depth: u8, index: usize| Level {
            error: 2000.0 / f64::from(1_u32 << depth) * (1.0 + (INTERIOR_LEVELS - 1 - index) as f64 / 4.0),
            triangles: 500 * (index as u64 + 1),
            bytes: 100_000,
        };
        let of_depth = |depth| (0..INTERIOR_LEVELS).map(|index| level(depth, index)).collect();
        Self {
            depth,
            levels: (0..=depth).map(of_depth).collect(),
        }
    }

    /// How many tiles there are.
    fn len(&self) -> u64 {
        (0..=self.depth).map(|depth| 1 << (2 * depth)).sum()
    }
}

impl Hierarchy for Square {
    type Node = Node;

    fn roots(&self) -> impl Iterator<Item = Node> {
        [(0, 0, 0)].into_iter()
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
        let last = (1 << depth) - 1;
        [
            (x > 0).then(|| (depth, x - 1, y)),
            (y > 0).then(|| (depth, x, y - 1)),
            (x < last).then_some((depth, x + 1, y)),
            (y < last).then_some((depth, x, y + 1)),
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
fn camera() -> Camera {
    let eye = DVec3::new(-20_000.0, 0.0, 3000.0);
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

fn selected(square: &Square, demand: &Demand, before: &[Choice<Node>]) -> Selection<Node> {
    select(black_box(square), black_box(&camera()), demand, |_| true, before)
}

/// A view of which everything in sight is refined as far as it goes: depth 7 has 21,845 tiles, depth 6 has 5,461.
#[divan::bench(args = [4, 5, 6, 7, 8])]
fn all_in_sight_to_the_leaves(bencher: Bencher, depth: u8) {
    let square = Square::new(depth);
    let drawn = selected(&square, &demand(1e-3), &[]).choices.len();
    println!("depth {depth}: {} tiles, {drawn} drawn", square.len());
    bencher
        .counter(ItemsCount::new(drawn))
        .bench(|| selected(&square, &demand(1e-3), &[]));
}

/// Two pixels, as the page asks for.
#[divan::bench(args = [4, 5, 6, 7, 8, 10, 12, 14])]
fn two_pixels(bencher: Bencher, depth: u8) {
    let square = Square::new(depth);
    let drawn = selected(&square, &demand(2.0), &[]).choices.len();
    println!("depth {depth}: {} tiles, {drawn} drawn", square.len());
    bencher
        .counter(ItemsCount::new(drawn))
        .bench(|| selected(&square, &demand(2.0), &[]));
}

/// The same after a picture that is already there.
#[divan::bench(args = [7, 14])]
fn two_pixels_again(bencher: Bencher, depth: u8) {
    let square = Square::new(depth);
    let before = selected(&square, &demand(2.0), &[]).choices;
    bencher.bench(|| selected(&square, &demand(2.0), &before));
}

/// For a quarter of the triangles, which takes several attempts.
#[divan::bench(args = [7, 14])]
fn a_quarter_of_the_triangles(bencher: Bencher, depth: u8) {
    let square = Square::new(depth);
    let drawn = selected(&square, &demand(2.0), &[]).choices.len() as u64;
    let less = Demand {
        triangles: drawn * 500 / 4,
        ..demand(2.0)
    };
    bencher.bench(|| selected(&square, &less, &[]));
}

fn main() {
    divan::main();
}
