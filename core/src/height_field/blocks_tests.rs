use std::collections::BTreeSet;

use super::*;
use crate::height_field::chunks::ChunksInMemory;
use crate::height_field::heights::Heights;

/// A raster wider than a chunk, with a large void and lone samples in it.
const COLUMNS: usize = 300;
const ROWS: usize = 150;

fn samples() -> Vec<f32> {
    let sample = |index: usize| {
        let (column, row) = (index % COLUMNS, index / COLUMNS);
        let is_void = (100..140).contains(&column) && (30..90).contains(&row) && !index.is_multiple_of(97);
        let waves = 300.0 * (column as f32 * 0.13).sin() * (row as f32 * 0.09).cos();
        if is_void {
            f32::NAN
        } else {
            waves + ((index * 7919) % 31) as f32
        }
    };
    (0..COLUMNS * ROWS).map(sample).collect()
}

fn chunks(samples: &[f32]) -> ChunksInMemory {
    ChunksInMemory::new(Heights {
        columns: COLUMNS,
        rows: ROWS,
        samples,
    })
}

fn random_place(random: &mut fastrand::Rng) -> DVec2 {
    DVec2::new(random.f64() * (COLUMNS - 1) as f64, random.f64() * (ROWS - 1) as f64)
}

#[test]
fn blocks_of_every_level_hold_what_they_say() {
    let samples = samples();
    let chunks = chunks(&samples);
    let relief = Relief::new(&chunks, 0..COLUMNS, 0..ROWS);
    assert!(relief.top() >= 5);
    let mut random = fastrand::Rng::with_seed(1);
    let holds = |block: &Block, at: DVec2, height: f64| {
        let above = height - block.height(at);
        (block.residual[0] - 1e-3..=block.residual[1] + 1e-3).contains(&above)
    };
    for level in 0..=relief.top() {
        let block_over = |column: usize, row: usize| relief.block(level, column >> level, row >> level);
        for (index, &height) in samples.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
            let (column, row) = (index % COLUMNS, index / COLUMNS);
            // A cell with a void has no patch.
            let Some(block) = block_over(column, row).filter(|block| level > 0 || !block.patch[3].is_nan()) else {
                assert!(level == 0, "no block of level {level} over sample {column}, {row}");
                continue;
            };
            let at = DVec2::new(column as f64, row as f64);
            let is_whole = !block.patch.iter().any(|corner| corner.is_nan());
            assert!(
                !is_whole || holds(&block, at, f64::from(height)),
                "level {level}, {at}: {height}, {block:?}"
            );
        }
        for _ in 0..2000 {
            let at = random_place(&mut random);
            let Some((first, patch)) = relief.cell(at) else {
                continue;
            };
            let cell = Block {
                is_sampled: true,
                first: DVec2::new(first[0] as f64, first[1] as f64),
                side: 1.0,
                patch,
                residual: [0.0; 2],
            };
            let block = block_over(at.x as usize, at.y as usize);
            assert!(
                block.is_some_and(|block| holds(&block, at, cell.height(at))),
                "level {level}, {at}"
            );
        }
    }
}

#[test]
fn bounds_are_not_much_wider_than_what_blocks_hold() {
    let samples: Vec<f32> = (0..COLUMNS * ROWS)
        .map(|index| 300.0 * ((index % COLUMNS) as f32 * 0.13).sin() * ((index / COLUMNS) as f32 * 0.09).cos())
        .collect();
    let chunks = chunks(&samples);
    let relief = Relief::new(&chunks, 0..COLUMNS, 0..ROWS);
    for level in 1..=4 {
        let (mut claimed, mut held) = (0.0, 0.0);
        for (x, y) in (0..(ROWS >> level) - 1).flat_map(|y| (0..(COLUMNS >> level) - 1).map(move |x| (x, y))) {
            let Some(block) = relief.block(level, x, y) else {
                continue;
            };
            let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
            for (across, down) in (0..=1 << level).flat_map(|down| (0..=1 << level).map(move |across| (across, down))) {
                let (column, row) = ((x << level) + across, (y << level) + down);
                let above =
                    f64::from(samples[row * COLUMNS + column]) - block.height(DVec2::new(column as f64, row as f64));
                (least, greatest) = (f64::min(least, above), f64::max(greatest, above));
            }
            claimed += block.residual[1] - block.residual[0];
            held += greatest - least;
        }
        assert!(
            claimed >= held && claimed < 1.5 * held,
            "level {level}: {claimed} for {held}"
        );
    }
}

#[test]
fn samples_visited_are_those_in_the_triangle() {
    let samples = samples();
    let chunks = chunks(&samples);
    let relief = Relief::new(&chunks, 0..COLUMNS, 0..ROWS);
    let mut random = fastrand::Rng::with_seed(2);
    for number in 0..200 {
        let size = if number % 2 == 0 { 6.0 } else { 200.0 };
        let first = random_place(&mut random);
        let near = |random: &mut fastrand::Rng| {
            let offset = DVec2::new(random.f64() - 0.5, random.f64() - 0.5) * size;
            (first + offset).clamp(DVec2::ZERO, DVec2::new((COLUMNS - 1) as f64, (ROWS - 1) as f64))
        };
        let corners = [first, near(&mut random), near(&mut random)];
        let mut visited = BTreeSet::new();
        relief.visit_samples(
            corners,
            0.0,
            |_| true,
            |at, height| {
                let index = at.y as usize * COLUMNS + at.x as usize;
                assert_eq!(f64::from(samples[index]), height);
                visited.insert(index);
            },
        );
        let [a, b, c] = corners;
        let turn = (b - a).perp_dot(c - a).signum();
        for (index, _) in samples.iter().enumerate().filter(|(_, sample)| !sample.is_nan()) {
            let at = DVec2::new((index % COLUMNS) as f64, (index / COLUMNS) as f64);
            let inside = |(from, to): (DVec2, DVec2)| turn * (to - from).normalize().perp_dot(at - from);
            let depth = [(a, b), (b, c), (c, a)]
                .map(inside)
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            assert!(depth < 1e-6 || visited.contains(&index), "{at} is in {corners:?}");
            assert!(depth > -1e-6 || !visited.contains(&index), "{at} is beside {corners:?}");
        }
    }
}

#[test]
fn stretches_visited_are_the_cells_along_the_line_each_once() {
    let samples = samples();
    let chunks = chunks(&samples);
    let relief = Relief::new(&chunks, 0..COLUMNS, 0..ROWS);
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..100 {
        let (a, b) = (random_place(&mut random), random_place(&mut random));
        let mut visited = Vec::new();
        relief.visit_stretches(a, b, |_, _, _| true, |from, to| visited.push((from, to)));
        visited.sort_by(|a: &(f64, f64), b| (a.0 + a.1).total_cmp(&(b.0 + b.1)));
        let mut expected = Vec::new();
        scan::visit_cells(a, b, |from, to| expected.push((from, to)));
        // Blocks without samples are left out.
        expected.retain(|&(from, to)| relief.block_at(SMALLEST, a.lerp(b, (from + to) / 2.0)).is_some());
        let length = |stretches: &[(f64, f64)]| stretches.iter().map(|(from, to)| to - from).sum::<f64>();
        assert!((length(&visited) - length(&expected)).abs() < 1e-9);
        assert!(visited.windows(2).all(|pair| pair[0].1 <= pair[1].0 + 1e-9));
    }
}

#[test]
fn coarse_samples_are_samples_and_voids_stay_void() {
    let samples = samples();
    let chunks = chunks(&samples);
    let relief = Relief::new(&chunks, 40..COLUMNS, 0..ROWS);
    let coarse = relief.samples(2, 10..COLUMNS.div_ceil(4), 0..ROWS.div_ceil(4));
    let width = COLUMNS.div_ceil(4) - 10;
    for (index, &height) in coarse.iter().enumerate() {
        let own = samples[index / width * 4 * COLUMNS + (10 + index % width) * 4];
        assert!(
            height == own || height.is_nan() && own.is_nan(),
            "{index}: {height}, {own}"
        );
    }
    assert!(coarse.iter().any(|height| height.is_nan()));
}

#[test]
fn there_are_no_samples_beyond_the_last_blocks() {
    let size = 2 * CHUNK + 1;
    let samples = vec![1.0; size * size];
    let chunks = ChunksInMemory::new(Heights {
        columns: size,
        rows: size,
        samples: &samples,
    });
    let relief = Relief::new(&chunks, 0..size, 0..size);
    for level in [0, 1, 2] {
        let last = (2 * CHUNK) >> level;
        let found = relief.samples(level, last..last + 3, last..last + 2);
        assert_eq!(found[0], 1.0);
        assert!(
            found[1..].iter().all(|sample| sample.is_nan()),
            "level {level}: {found:?}"
        );
    }
}

#[test]
fn a_window_of_more_chunks_than_are_kept_is_seen_whole() {
    let columns = (2 * KEPT + 1) * CHUNK;
    let samples: Vec<f32> = (0..2 * columns).map(|index| index as f32).collect();
    let chunks = ChunksInMemory::new(Heights {
        columns,
        rows: 2,
        samples: &samples,
    });
    let relief = Relief::new(&chunks, 0..columns, 0..2);
    assert_eq!(relief.levels[0].kept.len(), KEPT);
    for _ in 0..2 {
        assert_eq!(relief.samples(0, 0..columns, 0..2), samples);
    }
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..1000 {
        let column = random.usize(..columns - 1);
        let corners = relief.cell(DVec2::new(column as f64 + 0.5, 0.5));
        let first = column as f64;
        let expected = [first, first + 1.0, first + columns as f64, first + columns as f64 + 1.0];
        assert_eq!(corners, Some(([column, 0], expected)));
    }
}
