#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use glam::DVec2;

use super::*;
use crate::height_field::evaluator::SPIKE;
use crate::height_field::ground::Ground;
use crate::height_field::heights::Heights;
use crate::height_field::plan::PlanMap;
use crate::height_field::reference::{Bound, Reference};
use crate::height_field::refine::{Refinement, refine};
use crate::height_field::snapping::snapped;
use crate::height_field::triangulate::{Outline, Triangulated, triangulate};
use crate::levels::adaptive_surface::AdaptiveSurface;
use crate::levels::partition::{self, SurfacePartition};
use crate::levels::replay::{Demand, Replay};
use crate::mesh::{self, Mesh};

const SIZE: usize = 33;
/// Metres by which rounding in doubles may put a deviation above its bound.
const ROUNDING: f64 = 1e-9;
/// Plan units in a cell.
const SCALE: f64 = 16.0;

fn hills() -> Vec<f32> {
    let wave = |i: usize, period: f32| (i as f32 / period).sin();
    (0..SIZE * SIZE)
        .map(|i| 40.0 * wave(i % SIZE, 5.0) * wave(i / SIZE, 7.0) + ((i * 7919) % 13) as f32 * 0.4)
        .collect()
}

fn reference<'a>(heights: &'a [f32], curvature: &'a [DVec2], bound: Bound) -> Reference<'a> {
    let plan = PlanMap::fit(
        DVec2::ZERO,
        DVec2::splat((SIZE - 1) as f64 * SCALE),
        |p| p / SCALE,
        |p| p * SCALE,
    );
    Reference {
        heights: Heights {
            columns: SIZE,
            rows: SIZE,
            samples: heights,
        },
        plan,
        curvature,
        ground: Ground::Plane(DVec2::splat(30.0 / SCALE)),
        bound,
        finer: None,
    }
}

fn square(heights: &[f32]) -> Outline {
    let last = SIZE - 1;
    let corners = [(0, 0), (last, 0), (last, last), (0, last)];
    let vertex =
        |(c, r): (usize, usize)| DVec3::new(c as f64 * SCALE, r as f64 * SCALE, f64::from(heights[r * SIZE + c]));
    let vertices = corners.map(vertex).to_vec();
    Outline {
        vertices,
        segments: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
        ..Outline::default()
    }
}

fn refined<'a>(reference: &'a Reference<'a>, tolerance: f64, height_step: f64) -> Surface<'a> {
    let mesh = triangulate(&square(reference.heights.samples), |_| true).unwrap().mesh;
    let mut surface = Surface::new(&mesh, reference);
    let frame = None;
    refine(
        &mut surface,
        Refinement {
            tolerance,
            height_step,
            frame,
            most_vertices: None,
        },
    );
    surface.in_memory_order()
}

fn simplifier(surface: Surface, quality: Quality) -> Simplifier {
    let kinds = vec![VertexKind::Free; surface.vertex_count()];
    let shape = Shape {
        height_step: 0.125,
        least_altitude: 1.0,
    };
    Simplifier::new(surface, kinds, shape, quality)
}

fn worst(reference: &Reference, mesh: &Mesh) -> f64 {
    let point = |v: u32| {
        let position = mesh.positions[v as usize];
        crate::height_field::reference::GridPoint {
            grid: position.truncate() / SCALE,
            height: position.z,
        }
    };
    let mut worst: f64 = 0.0;
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(point);
        worst = worst.max(reference.triangle_deviation([a, b, c]).size);
        if reference.bound == Bound::Surface {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                worst = worst.max(reference.edge_deviation(from, to).size);
            }
        }
    }
    worst
}

#[test]
fn refined_and_simplified_surfaces_stay_inside_the_volume_at_every_level() {
    let (heights, curvature) = (hills(), [DVec2::splat(1e-6); SIZE]);
    for bound in [Bound::Surface, Bound::Samples] {
        let reference = reference(&heights, &curvature, bound);
        let surface = refined(&reference, 2.0, 0.125);
        let (fine, _) = surface.mesh();
        mesh::validate(&fine).unwrap();
        assert!(
            worst(&reference, &fine) <= 2.0,
            "{bound:?} {}",
            worst(&reference, &fine)
        );
        let mut simplifier = simplifier(surface, Quality::Default);
        for vertical in [2.0, 4.0, 8.0] {
            simplifier.simplify(Allowance {
                vertical,
                outline: 0.0,
                breaklines: 0.0,
            });
        }
        let partition = SurfacePartition::from_log(&fine, simplifier.log(), 2.0).unwrap();
        partition::validate(&partition).unwrap();
        let mut counts = Vec::new();
        for (level, claimed) in partition.levels.iter().enumerate() {
            let mesh = partition.lod(level);
            mesh::validate(&mesh).unwrap();
            let measured = worst(&reference, &mesh);
            assert!(
                measured <= claimed.error + ROUNDING,
                "{bound:?} level {level}: {measured}"
            );
            counts.push(mesh.triangles.len());
        }
        assert!(counts.windows(2).all(|pair| pair[0] * 10 < pair[1] * 9), "{counts:?}");
        assert_eq!(simplifier.surface().triangle_count(), counts[0]);
    }
}

/// A closed line in the middle, joined to a corner by another one, which another crosses.
fn lines() -> Vec<Vec<DVec2>> {
    let lines: [&[(f64, f64)]; 3] = [
        &[(10.0, 8.0), (21.0, 9.0), (18.0, 20.0), (9.0, 17.0), (10.0, 8.0)],
        &[(10.0, 8.0), (5.0, 6.0), (0.0, 0.0)],
        &[(12.0, 3.0), (3.0, 12.0)],
    ];
    let place = |&(x, y): &(f64, f64)| DVec2::new(x, y);
    lines.map(|line| line.iter().map(place).collect()).to_vec()
}

/// A surface with lines, refined.
fn refined_along_lines<'a>(reference: &'a Reference<'a>, lines: &[Vec<DVec2>], tolerance: f64) -> Surface<'a> {
    let mut outline = square(reference.heights.samples);
    let steps: Vec<[[i64; 2]; 2]> = lines
        .iter()
        .flat_map(|line| line.windows(2))
        .flat_map(|pair| {
            let at = |part: usize| {
                (pair[0].lerp(pair[1], part as f64 / 9.0) * SCALE)
                    .round()
                    .as_i64vec2()
                    .to_array()
            };
            (0..9).map(move |part| [at(part), at(part + 1)])
        })
        .collect();
    for edge in snapped(&steps).iter().flat_map(|way| way.windows(2)) {
        let ends = [edge[0], edge[1]].map(|[x, y]| {
            let plan = DVec2::new(x as f64, y as f64);
            let known = outline.vertices.iter().position(|vertex| vertex.truncate() == plan);
            let height = || reference.heights.height_near(plan / SCALE).unwrap();
            known.unwrap_or_else(|| {
                outline.vertices.push(plan.extend(height()));
                outline.vertices.len() - 1
            }) as u32
        });
        outline.breaklines.push(ends);
    }
    let Triangulated { mesh, breaklines } = triangulate(&outline, |_| true).unwrap();
    let mut surface = Surface::new(&mesh, reference).with_breaklines(&breaklines);
    let refinement = Refinement {
        tolerance,
        height_step: 0.125,
        frame: None,
        most_vertices: None,
    };
    refine(&mut surface, refinement);
    surface.in_memory_order()
}

/// How far, in cells, points along lines are from the nearest of some edges, at most.
fn farthest(lines: &[Vec<DVec2>], edges: &[[DVec2; 2]]) -> f64 {
    let off = |at: DVec2, [from, to]: [DVec2; 2]| {
        let share = (at - from).dot(to - from) / (to - from).length_squared();
        at.distance(from.lerp(to, share.clamp(0.0, 1.0)))
    };
    let points = lines.iter().flat_map(|line| line.windows(2)).flat_map(|pair| {
        let at = |part: i32| pair[0].lerp(pair[1], f64::from(part) / 50.0);
        (0..=50).map(at).collect::<Vec<_>>()
    });
    let distance = |at: DVec2| {
        edges
            .iter()
            .map(|&edge| off(at * SCALE, edge))
            .fold(f64::INFINITY, f64::min)
            / SCALE
    };
    points.map(distance).fold(0.0, f64::max)
}

#[test]
fn breaklines_stay_edges_near_where_they_were_at_every_level() {
    let (heights, curvature) = (hills(), [DVec2::ZERO; SIZE]);
    let lines = lines();
    for quality in [Quality::Fast, Quality::Default, Quality::Best] {
        let reference = reference(&heights, &curvature, Bound::Surface);
        let mut simplifier = simplifier(refined_along_lines(&reference, &lines, 2.0), quality);
        for (vertical, cells) in [(2.0, 0.1), (8.0, 0.5), (40.0, 2.0)] {
            let metres = 30.0 * cells;
            let allowance = Allowance {
                vertical,
                outline: 0.0,
                breaklines: metres,
            };
            simplifier.thin(allowance);
            let edges = simplifier.breaklines();
            let mesh = simplifier.surface().mesh().0;
            mesh::validate(&mesh).unwrap();
            let with_edges = Surface::new(&mesh, &reference).with_breaklines(&edges);
            assert_eq!(with_edges.breaklines.len(), edges.len(), "all are edges of the mesh");
            let found = farthest(&lines, &edges);
            assert!(found <= cells + 0.75 / SCALE, "{quality:?}: {found} cells");
            assert!(simplifier.breaklines_strayed() <= metres);
            let ends = |place: DVec2| edges.iter().flatten().filter(|&&end| end == place * SCALE).count();
            let meeting = [(10.0, 8.0), (0.0, 0.0), (12.0, 3.0)].map(|(x, y)| ends(DVec2::new(x, y)));
            assert_eq!(meeting, [3, 1, 1], "{quality:?}: ends stay, and where lines meet");
        }
        let edges = simplifier.breaklines();
        assert!((6..=14).contains(&edges.len()), "{quality:?}: {} edges", edges.len());
    }
}

#[test]
fn thinned_surfaces_stay_inside_the_volume_and_more_work_leaves_fewer_triangles() {
    let (heights, curvature) = (hills(), [DVec2::splat(1e-6); SIZE]);
    for bound in [Bound::Surface, Bound::Samples] {
        let reference = reference(&heights, &curvature, bound);
        let count = |quality| {
            let mut simplifier = simplifier(refined(&reference, 2.0, 0.125), quality);
            simplifier.thin(Allowance {
                vertical: 2.0,
                outline: 0.0,
                breaklines: 0.0,
            });
            assert!(simplifier.log().collapses.is_empty(), "thinning leaves no record");
            let (mesh, _) = simplifier.into_surface().mesh();
            mesh::validate(&mesh).unwrap();
            let measured = worst(&reference, &mesh);
            assert!(measured <= 2.0 + ROUNDING, "{bound:?} {quality:?}: {measured}");
            mesh.triangles.len()
        };
        let [fast, default, best] = [Quality::Fast, Quality::Default, Quality::Best].map(count);
        assert!(
            default * 100 < fast * 97 && best * 100 < default * 95,
            "{fast} {default} {best}"
        );
    }
}

#[test]
fn every_sample_stays_under_the_triangle_whose_list_it_is_in() {
    let (heights, curvature) = (hills(), [DVec2::ZERO; SIZE]);
    let reference = reference(&heights, &curvature, Bound::Samples);
    let mut simplifier = simplifier(refined(&reference, 1.0, 0.125), Quality::Best);
    simplifier.thin(Allowance {
        vertical: 4.0,
        outline: 0.0,
        breaklines: 0.0,
    });
    let mut seen = 0;
    for (triangle, corners) in simplifier.sampled.surface.triangles() {
        let corners = corners.map(|corner| simplifier.sampled.surface.point(corner).grid);
        let mut found = Vec::new();
        simplifier.sampled.samples.gather(&reference, triangle, &mut found);
        for sample in &found {
            let side = |i: usize| (corners[(i + 1) % 3] - corners[i]).perp_dot(sample.at - corners[i]);
            assert!((0..3).all(|i| side(i) >= -1e-9), "{sample:?} is outside {corners:?}");
        }
        seen += found.len();
    }
    assert_eq!(seen, SIZE * SIZE, "each sample is under one triangle");
}

#[test]
fn no_vertex_stands_out_of_the_surface_where_the_bound_is_at_samples() {
    let (heights, curvature) = (hills(), [DVec2::ZERO; SIZE]);
    let reference = reference(&heights, &curvature, Bound::Samples);
    let mut simplifier = simplifier(refined(&reference, 1.0, 0.0), Quality::Best);
    simplifier.thin(Allowance {
        vertical: 1.0,
        outline: 0.0,
        breaklines: 0.0,
    });
    let off = |vertex: &u32| {
        let point = simplifier.sampled.surface.point(*vertex);
        (point.height - reference.heights.height_near(point.grid).unwrap()).abs()
    };
    let worst = (0..simplifier.sampled.kinds.len() as u32)
        .filter(|&vertex| simplifier.sampled.surface.connectivity.is_live(vertex))
        .max_by(|a, b| off(a).total_cmp(&off(b)))
        .unwrap();
    // Heights are multiples of an eighth of a metre.
    assert!(
        off(&worst) <= SPIKE + 0.125,
        "{} m at {:?}",
        off(&worst),
        simplifier.sampled.surface.point(worst)
    );
    assert!(off(&worst) > 1.0, "vertices use their freedom");
}

#[test]
fn a_plane_is_two_triangles() {
    let heights: Vec<f32> = (0..SIZE * SIZE)
        .map(|i| (i % SIZE) as f32 * 2.0 + (i / SIZE) as f32)
        .collect();
    let curvature = [DVec2::ZERO; SIZE];
    let reference = reference(&heights, &curvature, Bound::Surface);
    assert_eq!(refined(&reference, 0.01, 0.0).triangle_count(), 2);
}

#[test]
fn a_fully_triangulated_plane_collapses_to_two_triangles() {
    let heights: Vec<f32> = (0..SIZE * SIZE)
        .map(|i| (i % SIZE) as f32 * 2.0 + (i / SIZE) as f32)
        .collect();
    let curvature = [DVec2::ZERO; SIZE];
    let reference = reference(&heights, &curvature, Bound::Surface);
    for quality in [Quality::Default, Quality::Best] {
        let mut simplifier = simplifier(Surface::new(&whole_cells(&reference), &reference), quality);
        simplifier.thin(Allowance {
            vertical: 0.001,
            outline: 0.0,
            breaklines: 0.0,
        });
        assert_eq!(simplifier.surface().triangle_count(), 2, "{quality:?}");
    }
}

#[test]
fn vertices_of_a_round_do_not_meet_so_levels_stay_few() {
    let (heights, curvature) = (hills(), [DVec2::ZERO; SIZE]);
    let reference = reference(&heights, &curvature, Bound::Surface);
    let surface = refined(&reference, 0.5, 0.0);
    let (fine, _) = surface.mesh();
    let mut simplifier = simplifier(surface, Quality::Default);
    simplifier.simplify(Allowance {
        vertical: 10.0,
        outline: 0.0,
        breaklines: 0.0,
    });
    let levels = highest_level(&fine, simplifier.log());
    assert!(
        levels < simplifier.rounds() && simplifier.rounds() < 40,
        "{levels} levels of {} rounds",
        simplifier.rounds()
    );
    assert!(
        simplifier.log().collapses.len() > 300,
        "{}",
        simplifier.log().collapses.len()
    );
}

/// The papers' rule by brute force: 1 + the highest level of the edge's endpoints and all their neighbours.
fn highest_level(mesh: &Mesh, log: &CollapseLog) -> u32 {
    let mut triangles = mesh.triangles.clone();
    let mut levels = vec![0; mesh.positions.len()];
    for collapse in &log.collapses {
        let ends = [collapse.blue, collapse.red];
        let star = triangles
            .iter()
            .filter(|corners| corners.iter().any(|corner| ends.contains(corner)));
        let level = 1 + star.flatten().map(|&vertex| levels[vertex as usize]).max().unwrap();
        ends.iter().for_each(|&end| levels[end as usize] = level);
        triangles.retain(|corners| !ends.iter().all(|end| corners.contains(end)));
        let corners = triangles.as_flattened_mut();
        corners
            .iter_mut()
            .filter(|corner| **corner == collapse.blue)
            .for_each(|corner| *corner = collapse.red);
    }
    levels.into_iter().max().unwrap()
}

#[test]
fn the_outline_of_a_hole_strays_no_further_than_allowed() {
    let mut heights = hills();
    for row in 10..20 {
        for column in 10 + row % 3..20 {
            heights[row * SIZE + column] = f32::NAN;
        }
    }
    let curvature = [DVec2::ZERO; SIZE];
    let reference = reference(&heights, &curvature, Bound::Surface);
    let fine = whole_cells(&reference);
    let count = |allowed: f64| {
        let mut simplifier = simplifier(Surface::new(&fine, &reference), Quality::Default);
        simplifier.simplify(Allowance {
            vertical: 1000.0,
            outline: allowed,
            breaklines: 0.0,
        });
        let (mesh, _) = simplifier.surface().mesh();
        mesh::validate(&mesh).unwrap();
        let boundary: f64 = mesh.triangles.iter().map(|t| plan_area(&mesh, t)).sum();
        (mesh.triangles.len(), boundary)
    };
    let (exact_triangles, exact_area) = count(0.0);
    let (loose_triangles, loose_area) = count(45.0);
    let valid_cells = fine.triangles.len() as f64 / 2.0 * SCALE * SCALE;
    assert!((exact_area - valid_cells).abs() < 1e-6, "{exact_area} {valid_cells}");
    assert!(loose_triangles < exact_triangles && (loose_area - valid_cells).abs() > 1.0);
}

/// Hills with single voids far from each other, one of two by two and a large one.
fn hills_with_voids() -> Vec<f32> {
    let mut heights = hills();
    let mut void = |column: usize, row: usize| heights[row * SIZE + column] = f32::NAN;
    for row in (4..SIZE - 4).step_by(6) {
        for column in (4..SIZE - 12).step_by(6) {
            void(column, row);
        }
    }
    (0..12).for_each(|i| void(24 + i % 4, 10 + i / 4));
    heights
}

/// Edges that one triangle has, and how many loops they are.
fn boundary_loops(mesh: &Mesh) -> usize {
    let mut after: std::collections::BTreeMap<u32, u32> = mesh::boundary_edges(&mesh.triangles).into_iter().collect();
    let mut loops = 0;
    while let Some((start, mut at)) = after.pop_first() {
        while at != start {
            at = after.remove(&at).unwrap();
        }
        loops += 1;
    }
    loops
}

#[test]
fn holes_within_what_the_outline_may_stray_are_closed_and_no_others() {
    let (heights, curvature) = (hills_with_voids(), [DVec2::ZERO; SIZE]);
    for bound in [Bound::Surface, Bound::Samples] {
        for quality in [Quality::Fast, Quality::Default, Quality::Best] {
            let reference = reference(&heights, &curvature, bound);
            let fine = Surface::new(&whole_cells(&reference), &reference).mesh().0;
            let mut simplifier = simplifier(Surface::new(&fine, &reference), quality);
            // A cell is 30 m wide: the middle of a hole of one void is so far from its edge, that of the large one 60 m.
            for (vertical, outline) in [(2.0, 29.0), (4.0, 45.0), (8.0, 45.0), (1000.0, 45.0)] {
                simplifier.simplify(Allowance {
                    vertical,
                    outline,
                    breaklines: 0.0,
                });
                assert!(simplifier.outline_strayed() <= outline);
            }
            let log = simplifier.log().clone();
            let partition = SurfacePartition::from_log(&fine, &log, 2.0).unwrap();
            partition::validate(&partition).unwrap();
            let mut loops = Vec::new();
            for (level, claimed) in partition.levels.iter().enumerate() {
                let mesh = partition.lod(level);
                mesh::validate(&mesh).unwrap();
                let measured = worst(&reference, &mesh);
                assert!(
                    measured <= claimed.error + ROUNDING,
                    "{bound:?} level {level}: {measured}"
                );
                loops.push(boundary_loops(&mesh));
            }
            assert_eq!(
                loops[3..],
                [17, 17],
                "{bound:?} {quality:?}: outer outline, fifteen voids, the large one"
            );
            assert_eq!(loops[0], 2, "{bound:?} {quality:?}: the large one stays: {loops:?}");
            let closing = log.collapses.iter().filter(|collapse| collapse.closes_hole).count();
            assert_eq!(closing, 15);
            let replay = Replay::run(&fine, &log, Demand::Consistent, |_| ()).unwrap();
            assert_eq!(replay.collapse_levels.len(), log.collapses.len());
        }
    }
}

/// Splitting and collapsing again in a random order opens holes and closes them.
#[test]
fn a_closed_hole_opens_again_wherever_the_surface_is_refined() {
    let (heights, curvature) = (hills_with_voids(), [DVec2::ZERO; SIZE]);
    let reference = reference(&heights, &curvature, Bound::Surface);
    let fine = Surface::new(&whole_cells(&reference), &reference).mesh().0;
    let mut simplifier = simplifier(Surface::new(&fine, &reference), Quality::Default);
    simplifier.simplify(Allowance {
        vertical: 20.0,
        outline: 45.0,
        breaklines: 0.0,
    });
    let log = simplifier.log();
    let mut surface = AdaptiveSurface::new(&fine, log).unwrap();
    assert_eq!(boundary_loops(&surface.mesh()), 2);
    let closing = |&collapse: &u32| log.collapses[collapse as usize].closes_hole;
    let closings: Vec<u32> = (0..log.collapses.len() as u32).filter(closing).collect();
    for (opened, &collapse) in closings.iter().enumerate() {
        surface.force_split(collapse);
        let mesh = surface.mesh();
        assert!(boundary_loops(&mesh) >= 3 + opened, "hole {opened}");
        assert!(mesh.triangles.iter().all(|triangle| plan_area(&mesh, triangle) > 0.0));
    }
    let count = fine.triangles.len();
    (0..log.collapses.len() as u32).for_each(|collapse| drop(surface.force_split(collapse)));
    assert_eq!(surface.triangles().len(), count);
}

fn plan_area(mesh: &Mesh, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].truncate());
    (b - a).perp_dot(c - a) / 2.0
}

/// Every valid cell as two triangles.
fn whole_cells(reference: &Reference) -> Mesh {
    let mut mesh = Mesh::default();
    for index in 0..SIZE * SIZE {
        let plan = DVec2::new((index % SIZE) as f64, (index / SIZE) as f64) * SCALE;
        mesh.positions
            .push(plan.extend(f64::from(reference.heights.samples[index])));
        if reference
            .heights
            .cell_is_valid((index % SIZE) as i64, (index / SIZE) as i64)
        {
            let a = index as u32;
            let below = a + SIZE as u32;
            mesh.triangles.extend([[a, a + 1, below + 1], [a, below + 1, below]]);
        }
    }
    mesh
}
