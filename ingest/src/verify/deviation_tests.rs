#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use glam::DVec3;
use terrain_codec::ellipsoid::{Geodetic, SEMI_MAJOR, to_earth_centred};

use super::*;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;
use crate::verify::source::{Post, Source};
use crate::verify::space::{Earth, Raster};

fn grid(columns: usize, rows: usize, first: DVec2, step: DVec2, height: impl Fn(usize, usize) -> f32) -> HeightGrid {
    HeightGrid {
        columns,
        rows,
        heights: (0..columns * rows)
            .map(|index| height(index % columns, index / columns))
            .collect(),
        georeference: GeoReference::wgs84(columns, rows, first, step),
    }
}

/// The whole raster in blocks of `side` posts.
fn patches(grid: &HeightGrid, side: usize) -> Vec<Patch<'_>> {
    let source = Source::from(grid);
    let blocks = source.whole().split(side);
    blocks.iter().map(|block| source.patch(block).unwrap()).collect()
}

/// Visits every post of the raster, block by block.
fn visit(space: &impl Space, grid: &HeightGrid, surface: &Surface, mut visit: impl FnMut(usize, usize, f64)) {
    for patch in patches(grid, 7) {
        visit_posts(
            space,
            &patch,
            &space.verticals(&patch.posts()),
            surface,
            |(column, row), _, deviation| {
                assert_eq!(patch.post(column, row), Post::Surface);
                visit(column, row, deviation);
            },
        );
    }
}

fn at_posts(space: &impl Space, grid: &HeightGrid, surface: &Surface) -> (Worst, usize) {
    let (mut worst, mut visits) = (Worst::default(), 0);
    visit(space, grid, surface, |column, row, deviation| {
        worst.meet(deviation, DVec2::new(column as f64, row as f64));
        visits += 1;
    });
    (worst, visits)
}

fn along(space: &impl Space, grid: &HeightGrid, surface: &Surface) -> Worst {
    along_in_blocks(space, grid, surface, 512)
}

fn along_in_blocks(space: &impl Space, grid: &HeightGrid, surface: &Surface, side: usize) -> Worst {
    let patches = patches(grid, side);
    let worst = patches
        .iter()
        .map(|patch| along_edges(space, patch, surface, Worst::default()));
    worst.fold(Worst::default(), Worst::max)
}

fn earth(grid: &HeightGrid, middle_longitude: f64) -> Earth<'_> {
    Earth {
        source: grid.into(),
        middle_longitude,
    }
}

fn flat(positions: &[DVec3], triangles: &[[u32; 3]]) -> Surface {
    let foot = |p: &DVec3| Foot {
        grid: p.truncate(),
        height: p.z,
    };
    let feet = positions.iter().map(foot).collect();
    Surface::new(&Raster, positions.to_vec(), feet, triangles.to_vec())
}

fn on_earth(earth: &Earth, corners: &[DVec3], triangles: &[[u32; 3]]) -> Surface {
    let position = |p: &DVec3| {
        let place = earth.source.georeference.geographic(p.truncate());
        to_earth_centred(Geodetic {
            longitude: place.x,
            latitude: place.y,
            height: p.z,
        })
    };
    let foot = |p: &DVec3| Foot {
        grid: p.truncate(),
        height: p.z,
    };
    let positions = corners.iter().map(position).collect();
    Surface::new(earth, positions, corners.iter().map(foot).collect(), triangles.to_vec())
}

fn square(side: f64, heights: [f64; 4]) -> [DVec3; 4] {
    let [a, b, c, d] = heights;
    [
        DVec3::new(0.0, 0.0, a),
        DVec3::new(side, 0.0, b),
        DVec3::new(0.0, side, c),
        DVec3::new(side, side, d),
    ]
}

const HALVES: [[u32; 3]; 2] = [[0, 3, 1], [0, 2, 3]];
/// The same where rows run to the north.
const UPRIGHT_HALVES: [[u32; 3]; 2] = [[0, 1, 3], [0, 3, 2]];

#[test]
fn the_middle_of_a_saddle_cell_is_off_by_a_quarter_of_its_twist() {
    let grid = grid(
        2,
        2,
        DVec2::ZERO,
        DVec2::ONE,
        |x, y| if x + y == 2 { 40.0 } else { 0.0 },
    );
    let surface = flat(&square(1.0, [0.0, 0.0, 0.0, 40.0]), &HALVES);
    assert_eq!(at_posts(&Raster, &grid, &surface).0.figure, 0.0);
    let worst = along(&Raster, &grid, &surface);
    assert!((worst.figure - 10.0).abs() < 1e-9, "{worst:?}");
    assert!(worst.place.distance(DVec2::splat(0.5)) < 1e-6, "{worst:?}");
}

#[test]
fn the_same_saddle_on_the_earth_is_off_by_the_same() {
    let step = DVec2::splat(1.0 / 1200.0);
    let grid = grid(
        2,
        2,
        DVec2::new(7.0, 46.0),
        step,
        |x, y| if x + y == 2 { 40.0 } else { 0.0 },
    );
    let earth = earth(&grid, 7.0);
    let surface = on_earth(&earth, &square(1.0, [0.0, 0.0, 0.0, 40.0]), &UPRIGHT_HALVES);
    assert!(at_posts(&earth, &grid, &surface).0.figure < 1e-6);
    let worst = along(&earth, &grid, &surface);
    assert!((worst.figure - 10.0).abs() < 1e-3, "{worst:?}");
}

#[test]
fn a_flat_ocean_one_degree_wide_is_off_by_the_sagitta_of_its_diagonal() {
    let grid = grid(61, 61, DVec2::new(30.0, -0.5), DVec2::splat(1.0 / 60.0), |_, _| 0.0);
    let earth = earth(&grid, 30.5);
    let surface = on_earth(&earth, &square(60.0, [0.0; 4]), &UPRIGHT_HALVES);
    let diagonal = surface.positions[0].distance(surface.positions[3]);
    let sagitta = diagonal * diagonal / (8.0 * SEMI_MAJOR);
    for measured in [
        at_posts(&earth, &grid, &surface).0.figure,
        along(&earth, &grid, &surface).figure,
    ] {
        assert!((measured / sagitta - 1.0).abs() < 0.01, "{measured} against {sagitta}");
    }
}

#[test]
fn posts_beside_a_parallel_are_found_where_the_straight_edge_bulges_over_them() {
    // At 60° north an edge of 2° bulges towards the pole by several rows.
    let step = DVec2::new(1.0 / 60.0, 1.0 / 1200.0);
    let grid = grid(121, 41, DVec2::new(10.0, 60.0 - 20.0 / 1200.0), step, |_, _| 0.0);
    let earth = earth(&grid, 11.0);
    let corners = [
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(120.0, 0.0, 0.0),
        DVec3::new(120.0, 20.0, 0.0),
        DVec3::new(0.0, 20.0, 0.0),
    ];
    let surface = on_earth(&earth, &corners, &[[0, 1, 2], [0, 2, 3]]);
    let mut highest = 0;
    visit(&earth, &grid, &surface, |_, row, _| highest = highest.max(row));
    let bulge_degrees = (60.0_f64.to_radians().tan() / 1.0_f64.to_radians().cos())
        .atan()
        .to_degrees()
        - 60.0;
    assert_eq!(highest, 20 + (bulge_degrees * 1200.0) as usize, "{bulge_degrees}");
}

#[test]
fn an_edge_is_measured_where_it_crosses_a_ridge_between_posts() {
    // A ridge along column 1; the edge passes over it half-way between two posts.
    let grid = grid(3, 2, DVec2::ZERO, DVec2::ONE, |x, _| if x == 1 { 5.0 } else { 0.0 });
    let surface = flat(
        &[DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 0.0)],
        &[[0, 1, 2]],
    );
    let worst = along(&Raster, &grid, &surface);
    assert!((worst.figure - 5.0).abs() < 1e-9);
    let (at_posts, visits) = at_posts(&Raster, &grid, &surface);
    assert_eq!((at_posts.figure, visits), (5.0, 4));
}

#[test]
fn every_post_of_a_triangulated_square_is_visited_by_brute_force_and_by_footprint() {
    let grid = grid(23, 23, DVec2::new(7.0, 46.0), DVec2::splat(0.01), |x, y| (x * y) as f32);
    let earth = earth(&grid, 7.0);
    let corners = [
        DVec3::new(0.3, 0.1, 9.0),
        DVec3::new(21.7, 2.2, 30.0),
        DVec3::new(4.4, 20.9, 90.0),
    ];
    let surface = on_earth(&earth, &corners, &[[0, 1, 2]]);
    let facet = Facet::new(surface.corners([0, 1, 2]));
    let inside = |index: usize| {
        let (column, row) = (index % 23, index / 23);
        let up = earth.vertical(column, row);
        let position = earth.position(column, row, up, f64::from(grid.height(column, row)));
        facet.meeting((position, up), true).is_some()
    };
    let visits = at_posts(&earth, &grid, &surface).1;
    assert_eq!(visits, (0..23 * 23).filter(|&index| inside(index)).count());
    assert!(
        (190..220).contains(&visits),
        "{visits} posts in a triangle of 213 cells"
    );
}

#[test]
fn a_cap_of_flat_triangles_around_the_pole_is_off_by_its_sagitta() {
    let grid = grid(361, 11, DVec2::new(-180.0, 89.0), DVec2::new(1.0, 0.1), |_, _| 0.0);
    let earth = earth(&grid, 0.0);
    // A quarter turn west of Greenwich; the pole is a vertex on two meridians, as tiles have it.
    let corners = [
        DVec3::new(90.0, 0.0, 0.0),
        DVec3::new(180.0, 0.0, 0.0),
        DVec3::new(180.0, 10.0, 0.0),
    ];
    let surface = on_earth(&earth, &corners, &[[0, 1, 2]]);
    let chord = surface.positions[0].distance(surface.positions[1]);
    let sagitta = chord * chord / (8.0 * SEMI_MAJOR);
    let measured = along(&earth, &grid, &surface).figure;
    assert!((measured / sagitta - 1.0).abs() < 0.01, "{measured} against {sagitta}");
    let (at_posts, visits) = at_posts(&earth, &grid, &surface);
    assert!(at_posts.figure < 1.5 * sagitta && visits > 700, "{at_posts:?} {visits}");
}

#[test]
fn longitudes_beyond_the_antimeridian_are_those_of_the_raster() {
    let grid = grid(21, 5, DVec2::new(179.0, 10.0), DVec2::splat(0.1), |_, _| 0.0);
    let earth = earth(&grid, 225.0);
    let place = to_earth_centred(Geodetic {
        longitude: -179.5,
        latitude: 10.2,
        height: 7.0,
    });
    let foot = earth.foot(place);
    assert!(
        foot.grid.distance(DVec2::new(15.0, 2.0)) < 1e-6 && (foot.height - 7.0).abs() < 1e-6,
        "{foot:?}"
    );
    let post = earth.position(15, 2, earth.vertical(15, 2), 7.0);
    assert!(post.distance(place) < 1e-6, "{post} {place}");
}

#[test]
fn figures_are_the_same_whatever_the_blocks() {
    let rough = |x: usize, y: usize| ((x * 7 + y * 13) % 11) as f32 * 20.0;
    // One over hills in the middle of a raster, one past the pole, where edges bend most.
    let middle = grid(60, 60, DVec2::new(7.0, 46.0), DVec2::splat(0.01), rough);
    let pole = grid(361, 11, DVec2::new(-180.0, 89.0), DVec2::new(1.0, 0.1), rough);
    let over_middle = [
        DVec3::new(0.3, 0.1, 9.0),
        DVec3::new(58.7, 2.2, 30.0),
        DVec3::new(4.4, 57.9, 90.0),
    ];
    let over_pole = [
        DVec3::new(100.0, 0.0, 0.0),
        DVec3::new(275.0, 1.0, 0.0),
        DVec3::new(180.0, 10.0, 0.0),
    ];
    for (grid, longitude, corners) in [(middle, 7.0, over_middle), (pole, 0.0, over_pole)] {
        let earth = earth(&grid, longitude);
        let surface = on_earth(&earth, &corners, &[[0, 1, 2]]);
        let whole = along_in_blocks(&earth, &grid, &surface, 512).figure;
        assert!(whole > 50.0, "{whole}");
        for side in [1, 5, 16, 59] {
            let in_blocks = along_in_blocks(&earth, &grid, &surface, side).figure;
            assert!(
                (in_blocks / whole - 1.0).abs() < 0.01,
                "{side}: {in_blocks} instead of {whole}"
            );
        }
    }
}

#[test]
fn what_is_passed_over_is_no_worse() {
    let block = Block {
        columns: 1..42,
        rows: 1..42,
    };
    for seed in 0..30 {
        let mut random = fastrand::Rng::with_seed(seed);
        let heights: Vec<f32> = (0..43 * 43).map(|_| random.f32() * 30.0).collect();
        let rough = |has_void: bool| {
            let height = |column: usize, row: usize| match (has_void, column + row) {
                (true, 0) => f32::NAN,
                _ => heights[row * 43 + column] + (column as f32 / 7.0).sin() * 200.0,
            };
            grid(43, 43, DVec2::new(7.0, 46.0), DVec2::splat(1.0 / 1200.0), height)
        };
        let (whole, with_void) = (rough(false), rough(true));
        let mut corner = |column: f64, row: f64| DVec3::new(column, row, random.f64() * 400.0 - 200.0);
        let corners = [
            corner(2.3, 2.1),
            corner(40.2, 3.7),
            corner(2.9, 39.9),
            corner(40.5, 40.5),
        ];
        // Beside a void nothing is known of what is between the ends of an edge.
        let [passed_over, all] = [&whole, &with_void].map(|grid| {
            let earth = earth(grid, 7.0);
            let patch = Source::from(grid).patch(&block).unwrap();
            let on_plane = along_edges(&Raster, &patch, &flat(&corners, &UPRIGHT_HALVES), Worst::default());
            let on_earth = along_edges(
                &earth,
                &patch,
                &on_earth(&earth, &corners, &UPRIGHT_HALVES),
                Worst::default(),
            );
            (patch.steepest.is_some(), on_plane.figure, on_earth.figure)
        });
        assert_eq!((passed_over.0, all.0), (true, false));
        assert_eq!((passed_over.1, passed_over.2), (all.1, all.2), "seed {seed}");
    }
}
