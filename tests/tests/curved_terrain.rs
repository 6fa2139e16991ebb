//! Curved surfaces of rasters, measured again from their patches by code of its own.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use glam::{DVec2, DVec3};
use terrain_core::curved::levels::CurvedLevels;
use terrain_ingest::curved_terrain::{self, Frame};
use terrain_ingest::georeference::GeoReference;
use terrain_ingest::{HeightGrid, Progress};

/// Degrees between samples.
const STEP: f64 = 0.001;
const CORNER: DVec2 = DVec2::new(7.0, 46.0);
/// Share of a patch by which rounding may put a sample beside it.
const BESIDE: f64 = 1e-6;

fn grid(columns: usize, rows: usize, heights: Vec<f32>) -> HeightGrid {
    HeightGrid {
        columns,
        rows,
        heights,
        georeference: GeoReference::wgs84(columns, rows, CORNER, DVec2::new(STEP, -STEP)),
    }
}

/// Hills, steps and noise, with voids of some sizes.
fn random_grid(random: &mut fastrand::Rng) -> HeightGrid {
    let (columns, rows) = (random.usize(2..60), random.usize(2..60));
    let [high, long, rough] = [100.0, 12.0, 20.0].map(|most| random.f32() * most);
    let step = if random.bool() { 50.0 } else { 0.0 };
    let mut heights = Vec::new();
    for index in 0..columns * rows {
        let (x, y) = ((index % columns) as f32, (index / columns) as f32);
        let hills = high * (x / (1.0 + long)).sin() * (y / (2.0 + long)).cos();
        heights.push(hills + rough * random.f32() + if x + 2.0 * y > 50.0 { step } else { 0.0 });
    }
    for _ in 0..random.usize(0..8) {
        let (column, row) = (random.usize(0..columns), random.usize(0..rows));
        let (across, down) = (random.usize(1..6), random.usize(1..6));
        for row in row..(row + down).min(rows) {
            for column in column..(column + across).min(columns) {
                heights[row * columns + column] = f32::NAN;
            }
        }
    }
    grid(columns, rows, heights)
}

type Patch = [DVec3; 10];

/// Control points of all patches, above longitude and latitude.
fn patches(levels: &CurvedLevels, frame: Frame) -> Vec<Patch> {
    let [origin, scale] = [frame.origin, frame.scale].map(DVec2::from);
    let placed = |point: DVec3| (point.truncate() / scale + origin).extend(point.z);
    let all = levels.patches().iter();
    all.map(|patch| patch.patch.points.map(placed)).collect()
}

/// De Casteljau's algorithm.
fn at(patch: &Patch, [u, v, w]: [f64; 3]) -> DVec3 {
    let mut points = patch.to_vec();
    // Rows of a triangle of points: the first has all its weight on the first corner.
    for degree in (1..=3).rev() {
        let place = |row: usize, index: usize| row * (row + 1) / 2 + index;
        let mut next = Vec::new();
        for row in 0..degree {
            for index in 0..=row {
                let [first, second, third] = [(row, index), (row + 1, index), (row + 1, index + 1)]
                    .map(|(row, index)| points[place(row, index)]);
                next.push(u * first + v * second + w * third);
            }
        }
        points = next;
    }
    points[0]
}

/// Largest difference at the samples of cells with four of them, and how many of those no patch covers.
fn measured(grid: &HeightGrid, patches: &[Patch]) -> (f64, usize) {
    let mut off = vec![f64::INFINITY; grid.heights.len()];
    for patch in patches {
        let [a, b, c] = [patch[0], patch[6], patch[9]].map(|corner| {
            let from_corner = (corner.truncate() - CORNER) / STEP;
            DVec2::new(from_corner.x, -from_corner.y)
        });
        let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).ceil());
        for row in low.y as usize..=(high.y as usize).min(grid.rows - 1) {
            for column in low.x as usize..=(high.x as usize).min(grid.columns - 1) {
                let place = DVec2::new(column as f64, row as f64);
                let area = (b - a).perp_dot(c - a);
                let [v, w] = [(place - a).perp_dot(c - a), (b - a).perp_dot(place - a)].map(|part| part / area);
                let weights = [1.0 - v - w, v, w];
                let height = f64::from(grid.height(column, row));
                if weights.iter().all(|&weight| weight > -BESIDE) && !height.is_nan() {
                    let found = &mut off[row * grid.columns + column];
                    *found = found.min((at(patch, weights).z - height).abs());
                }
            }
        }
    }
    let (mut worst, mut missed) = (0.0_f64, 0);
    for row in 0..grid.rows - 1 {
        for column in 0..grid.columns - 1 {
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| (column + right, row + down));
            if corners.iter().all(|&(column, row)| !grid.height(column, row).is_nan()) {
                for (column, row) in corners {
                    let off = off[row * grid.columns + column];
                    missed += usize::from(off.is_infinite());
                    worst = worst.max(if off.is_finite() { off } else { 0.0 });
                }
            }
        }
    }
    (worst, missed)
}

#[test]
fn curved_surfaces_of_random_rasters_hold_what_they_claim() {
    for seed in 0..300 {
        let mut random = fastrand::Rng::with_seed(seed);
        let grid = random_grid(&mut random);
        let max_error = 0.1 + 20.0 * random.f64() * random.f64();
        if !grid.has_surface() {
            assert!(curved_terrain::run(&grid, max_error, &Progress::silent()).is_err());
            continue;
        }
        let (levels, report) = curved_terrain::run(&grid, max_error, &Progress::silent()).unwrap();
        let (worst, missed) = measured(&grid, &patches(&levels, report.frame));
        assert_eq!(missed, 0, "seed {seed}");
        assert!(
            worst <= report.certified_error + 1e-9,
            "seed {seed}: {worst} m, {report}"
        );
        assert!(
            report.certified_error <= max_error,
            "seed {seed}: {max_error} m asked, {report}"
        );
    }
}

#[test]
fn a_plane_is_two_patches_of_any_size() {
    for (columns, rows) in [(2, 2), (2, 40), (60, 45)] {
        let heights = (0..columns * rows).map(|index| (3 * (index % columns) + index / columns) as f32);
        let grid = grid(columns, rows, heights.collect());
        let (levels, _) = curved_terrain::run(&grid, 0.01, &Progress::silent()).unwrap();
        assert_eq!(levels.patch_count(0), 2, "{columns} × {rows}");
    }
}

#[test]
fn no_error_and_no_surface_are_refused() {
    let flat = grid(3, 3, vec![0.0; 9]);
    assert!(curved_terrain::run(&flat, 0.0, &Progress::silent()).is_err());
    let line = grid(3, 3, vec![0.0, 0.0, 0.0, f32::NAN, f32::NAN, f32::NAN, 0.0, 0.0, 0.0]);
    let refused = curved_terrain::run(&line, 1.0, &Progress::silent()).unwrap_err();
    assert!(refused.to_string().contains("no cell"), "{refused}");
}
