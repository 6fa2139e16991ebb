//! Triangles that the progressive codec encodes and decodes a second, on a hilly grid and on a golden tile.
//!
//! `cargo bench -p terrain-codec --bench progressive`

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::DVec3;
use terrain_codec::LevelLimits;
use terrain_codec::spm::{self, ProgressiveMesh};
use terrain_codec::spt;
use terrain_core::SurfacePartition;
use terrain_core::levels::partition::Level;

const TILE: &[u8] = include_bytes!("../golden/jacksboro_v3.spt");

fn main() {
    divan::main();
}

/// A grid of `side`² vertices, each a fixed fraction of a cell off its place, over hills of two sizes.
fn hills(side: u32) -> ProgressiveMesh {
    let chance = |x: u32, y: u32, seed: u32| f64::from((x * 7919 + y * 104_729 + seed) * 2_654_435_761 % 97);
    let position = |vertex: u32| {
        let (x, y) = (vertex % side, vertex / side);
        let hills = 2000.0 + 1500.0 * (f64::from(x) / 17.0).sin() * (f64::from(y) / 23.0).cos();
        let place = DVec3::new(
            f64::from(256 * x) + chance(x, y, 1),
            f64::from(256 * y) + chance(x, y, 2),
            hills,
        );
        (place + DVec3::Z * chance(x, y, 3)).round()
    };
    let positions: Vec<DVec3> = (0..side * side).map(position).collect();
    let cells = (0..(side - 1) * (side - 1)).map(|cell| cell / (side - 1) * side + cell % (side - 1));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]])
        .collect();
    ProgressiveMesh {
        origin: DVec3::ZERO,
        step: DVec3::ONE,
        is_height_field: true,
        sampling: None,
        partition: SurfacePartition {
            representatives: (0..side * side).collect(),
            blue_positions: positions.clone(),
            positions,
            levels: vec![Level {
                vertex_end: side * side,
                triangle_end: triangles.len() as u32,
                error: 0.0,
            }],
            triangles,
        },
    }
}

#[divan::bench(args = [33, 129, 513], sample_count = 10)]
fn encode(bencher: Bencher, side: u32) {
    let model = hills(side);
    bencher
        .counter(ItemsCount::new(model.partition.triangles.len()))
        .bench(|| spm::encode(&model));
}

#[divan::bench(args = [33, 129, 513])]
fn decode(bencher: Bencher, side: u32) {
    let model = hills(side);
    let bytes = spm::encode(&model).unwrap_or_default();
    bencher
        .counter(ItemsCount::new(model.partition.triangles.len()))
        .bench(|| spm::decode(&bytes, &LevelLimits::default()));
}

#[divan::bench]
fn decode_tile(bencher: Bencher) {
    bencher
        .counter(ItemsCount::new(1671_usize))
        .bench(|| spt::decode(TILE, &LevelLimits::default()));
}
