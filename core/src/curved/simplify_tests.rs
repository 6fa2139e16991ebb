#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use crate::curved::patch::{CORNERS, CubicPatch};
use crate::mesh::Mesh;
use crate::space::distance::squared_to_triangle;
use crate::topology::half_edges::{NONE, edges_of};

const SIDE: u32 = 9;

/// A bumpy square, or a bumpy torus where it is closed, with random heights and diagonals.
fn bumpy(random: &mut fastrand::Rng, is_closed: bool) -> CurvedModel {
    rough(random, is_closed, 0.1)
}

/// The same with heights up to `height`.
fn rough(random: &mut fastrand::Rng, is_closed: bool, height: f64) -> CurvedModel {
    let place = |column: u32, row: u32, up: f64| {
        if !is_closed {
            return DVec3::new(f64::from(column), f64::from(row), up);
        }
        let turn = std::f64::consts::TAU / f64::from(SIDE);
        let [(sin_u, cos_u), (sin_v, cos_v)] = [column, row].map(|step| (turn * f64::from(step)).sin_cos());
        let radius = 3.0 + (1.0 + up) * cos_v;
        DVec3::new(radius * cos_u, radius * sin_u, (1.0 + up) * sin_v)
    };
    let positions = (0..SIDE * SIDE).map(|index| place(index % SIDE, index / SIDE, height * random.f64()));
    let positions: Vec<DVec3> = positions.collect();
    let squares = if is_closed { SIDE } else { SIDE - 1 };
    let mut triangles = Vec::new();
    for square in 0..squares * squares {
        let at = |right: u32, up: u32| (square / squares + up) % SIDE * SIDE + (square % squares + right) % SIDE;
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        triangles.extend(if random.bool() {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        });
    }
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for corners in &triangles {
        let [a, b, c] = corners.map(|corner| positions[corner as usize]);
        corners
            .iter()
            .for_each(|&corner| normals[corner as usize] += (b - a).cross(c - a));
    }
    let normals: Vec<_> = triangles
        .iter()
        .map(|corners| corners.map(|corner| normals[corner as usize]))
        .collect();
    CurvedModel::from_mesh(&Mesh { positions, triangles }, &normals).unwrap()
}

/// Points of a patch on a grid of its domain, row by row.
fn grid(patch: &CubicPatch, steps: u32) -> Vec<Vec<DVec3>> {
    let at = |i: u32, j: u32| {
        let [u, v] = [i, j].map(|step| f64::from(step) / f64::from(steps));
        patch.point(DVec3::new(u, v, 1.0 - u - v))
    };
    (0..=steps)
        .map(|i| (0..=steps - i).map(|j| at(i, j)).collect())
        .collect()
}

fn points(model: &CurvedModel, steps: u32) -> Vec<DVec3> {
    let rows = model.patches.iter().flat_map(|patch| grid(patch, steps));
    rows.flatten().collect()
}

/// The patches as flat triangles.
fn facets(model: &CurvedModel, steps: usize) -> Vec<[DVec3; 3]> {
    let mut facets = Vec::new();
    for patch in &model.patches {
        let rows = grid(patch, steps as u32);
        for i in 0..steps {
            for j in 0..steps - i {
                facets.push([rows[i][j], rows[i + 1][j], rows[i][j + 1]]);
                if j + 1 < steps - i {
                    facets.push([rows[i + 1][j], rows[i + 1][j + 1], rows[i][j + 1]]);
                }
            }
        }
    }
    facets
}

/// The largest distance of a point from facets.
fn farthest(points: &[DVec3], facets: &[[DVec3; 3]]) -> f64 {
    let nearest = |point: &DVec3| {
        let squares = facets.iter().map(|facet| squared_to_triangle(*point, *facet));
        squares.fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max).sqrt()
}

/// How far facets of a patch's 12th parts can be from it, for patches of about 3 units.
const SAG: f64 = 0.005;

#[test]
fn no_level_is_farther_from_the_model_than_certified() {
    let mut random = fastrand::Rng::with_seed(7);
    for is_closed in [false, true] {
        let model = bumpy(&mut random, is_closed);
        let given_facets: Vec<[DVec3; 3]> = model
            .patches
            .iter()
            .map(|patch| CORNERS.map(|corner| patch.points[corner]))
            .collect();
        let flat = model.patches.iter().flat_map(|patch| grid(&patch.flat(), 3));
        let given: Vec<DVec3> = flat.flatten().collect();
        let levels = simplify(model, &Options::default(), |_| ());
        let last = levels.len() - 1;
        assert!(levels.patch_count(last) * 2 < levels.patch_count(0));
        for level in [last / 3, last * 2 / 3, last] {
            let shown = levels.model(level);
            let measured = farthest(&given, &facets(&shown, 12)).max(farthest(&points(&shown, 6), &given_facets));
            let error = levels.error(level);
            assert!(
                measured <= error + SAG,
                "level {level}: {measured} measured, {error} certified"
            );
            // Where patches stand for a few others each; what comes after is certified ever more loosely.
            if level == last / 3 {
                assert!(
                    measured * 15.0 >= error,
                    "level {level}: {measured} measured, {error} certified"
                );
            }
        }
    }
}

/// Asserts what holds for every level; how many loops its boundary has, and Euler's characteristic.
fn assert_whole(shown: &CurvedModel) -> [i64; 2] {
    let topology = &shown.topology;
    let edges = 0..3 * shown.patches.len() as u32;
    for edge in edges.clone() {
        let twin = topology.twin(edge);
        assert_ne!(topology.origin(edge), topology.end(edge));
        let patch = &shown.patches[edge as usize / 3];
        let corner = patch.points[CORNERS[edge as usize % 3]];
        if twin != NONE {
            let mut across = shown.patches[twin as usize / 3].curve(twin as usize % 3);
            across.reverse();
            assert_eq!(patch.curve(edge as usize % 3), across, "a gap");
        }
        assert!(corner.is_finite());
    }
    let boundary: Vec<u32> = edges.filter(|&edge| topology.twin(edge) == NONE).collect();
    let onwards = |edge: u32| {
        boundary
            .iter()
            .copied()
            .find(|&other| topology.origin(other) == topology.end(edge))
    };
    let mut seen: Vec<u32> = Vec::new();
    let mut loops = 0;
    for &start in &boundary {
        let mut edge = start;
        loops += i64::from(!seen.contains(&start));
        while !seen.contains(&edge) {
            seen.push(edge);
            edge = onwards(edge).unwrap();
        }
    }
    let faces = shown.patches.len() as i64;
    let edge_count = (3 * faces + boundary.len() as i64) / 2;
    [loops, i64::from(topology.vertex_slots()) - edge_count + faces]
}

/// Every level is a surface without gaps, of the model's topology, with fewer patches than the one before, none of which turns
/// from its corners' triangle.
#[test]
fn every_level_is_whole() {
    let mut random = fastrand::Rng::with_seed(8);
    for round in 0..6 {
        let mut model = bumpy(&mut random, round % 2 == 0);
        if round % 3 == 2 {
            model = with_hole(&model, 30 + round);
        }
        let topology = assert_whole(&model);
        let count = model.patches.len();
        let levels = simplify(model, &Options::default(), |_| ());
        assert_eq!(levels.patch_count(0), count);
        let counts: Vec<usize> = (0..levels.len()).map(|level| levels.patch_count(level)).collect();
        assert!(
            counts.is_sorted_by(|a, b| a >= b) && counts[counts.len() - 1] * 2 < count,
            "{counts:?}"
        );
        for level in 0..levels.len() {
            let shown = levels.model(level);
            assert_eq!(assert_whole(&shown), topology, "level {level} of round {round}");
            assert!(
                shown.patches.iter().all(|patch| turn(patch) >= 0.2 - 1e-9),
                "level {level} of round {round}"
            );
        }
    }
}

/// The least cosine between normals at a patch's corners and its corners' triangle.
fn turn(patch: &CubicPatch) -> f64 {
    let [a, b, c] = CORNERS.map(|corner| patch.points[corner]);
    let chord = (b - a).cross(c - a).normalize();
    let normals = [DVec3::X, DVec3::Y, DVec3::Z].map(|at| patch.normal(at).normalize().dot(chord));
    normals.into_iter().fold(1.0, f64::min)
}

/// Without the patches around a vertex.
fn with_hole(model: &CurvedModel, vertex: u32) -> CurvedModel {
    let kept = model.corners().iter().zip(&model.patches);
    let kept = kept.filter(|(corners, _)| !corners.contains(&vertex));
    let (corners, patches): (Vec<[u32; 3]>, Vec<CubicPatch>) = kept.map(|(corners, patch)| (*corners, *patch)).unzip();
    let number = |corner: u32| corner - u32::from(corner > vertex);
    CurvedModel::from_patches(corners.iter().map(|three| three.map(number)).collect(), patches).unwrap()
}

/// A patch cut into four at the middles of its curves, and those again.
fn cut_twice(patch: &CubicPatch) -> CurvedModel {
    let middle = |a: DVec3, b: DVec3| a.midpoint(b);
    let four = |[a, b, c]: [DVec3; 3]| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
    };
    let places: Vec<[DVec3; 3]> = four([DVec3::X, DVec3::Y, DVec3::Z])
        .into_iter()
        .flat_map(four)
        .collect();
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut number = |at: DVec3| {
        let found = vertices.iter().position(|vertex| *vertex == at);
        found.unwrap_or_else(|| {
            vertices.push(at);
            vertices.len() - 1
        }) as u32
    };
    let corners = places.iter().map(|three| three.map(&mut number)).collect();
    CurvedModel::from_patches(corners, places.iter().map(|three| patch.part(*three)).collect()).unwrap()
}

/// Parts of one patch become that patch again, by T-in-T and T alone: any centre, any corners.
#[test]
fn what_was_cut_is_merged_exactly() {
    let mut random = fastrand::Rng::with_seed(11);
    for _ in 0..20 {
        let mut points = [
            [0.0, 0.0],
            [1.0, 0.0],
            [0.0, 1.0],
            [2.0, 0.0],
            [1.0, 1.0],
            [0.0, 2.0],
            [3.0, 0.0],
            [2.0, 1.0],
            [1.0, 2.0],
            [0.0, 3.0],
        ]
        .map(|[x, y]| DVec3::new(x, y, 0.0));
        points
            .iter_mut()
            .for_each(|point| *point += 0.3 * DVec3::new(random.f64(), random.f64(), random.f64()));
        let patch = CubicPatch { points };
        let options = Options {
            max_error: 1e-9,
            ..Options::default()
        };
        let levels = simplify(cut_twice(&patch), &options, |_| ());
        let last = levels.model(levels.len() - 1);
        assert_eq!(last.patches.len(), 1);
        let turned = [
            last.patches[0],
            last.patches[0].rotated(),
            last.patches[0].rotated().rotated(),
        ];
        assert!(turned.iter().any(|whole| whole.deviation(&patch) < 1e-9));
    }
}

#[test]
fn an_error_asked_for_is_kept_and_used() {
    let mut random = fastrand::Rng::with_seed(9);
    for max_error in [0.05, 0.2] {
        let options = Options {
            max_error,
            ..Options::default()
        };
        let mut model = bumpy(&mut random, true);
        model.bend_at_most(max_error / 2.0);
        let levels = simplify(model, &options, |_| ());
        assert!(levels.error(0) <= max_error * 0.51 && levels.error(0) > max_error * 0.3);
        let error = levels.error(levels.len() - 1);
        assert!(
            error <= max_error * (1.0 + 1e-9) && error > 0.7 * max_error,
            "{error} of {max_error}"
        );
    }
}

#[test]
fn patches_asked_for_are_the_end() {
    let mut random = fastrand::Rng::with_seed(12);
    let options = Options {
        patches: 70,
        ..Options::default()
    };
    let mut told = Vec::new();
    let levels = simplify(bumpy(&mut random, true), &options, |count| told.push(count));
    let last = levels.patch_count(levels.len() - 1);
    assert!((50..=70).contains(&last), "{last}");
    assert_eq!(told.last(), Some(&last));
}

#[test]
fn the_same_model_gives_the_same_levels() {
    let make = || {
        simplify(
            bumpy(&mut fastrand::Rng::with_seed(13), true),
            &Options::default(),
            |_| (),
        )
    };
    assert_eq!(make(), make());
}

#[test]
fn a_long_side_is_not_made() {
    let options = Options {
        longest_side: 2.5,
        ..Options::default()
    };
    let levels = simplify(bumpy(&mut fastrand::Rng::with_seed(14), false), &options, |_| ());
    let last = levels.model(levels.len() - 1);
    let side = |patch: &CubicPatch| {
        let [a, b, c] = CORNERS.map(|corner| patch.points[corner]);
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    };
    let longest = last.patches.iter().map(side).fold(0.0, f64::max);
    assert!(longest <= 2.5 && longest > 1.5, "{longest}");
}

/// Surfaces that have nothing to merge, or nothing that may be: they stay what they are.
#[test]
fn what_cannot_be_merged_stays() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let flat = |[a, b, c]: [u32; 3]| {
        let at = [a, b, c].map(|corner| corners[corner as usize]);
        let inner = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| [at[i].lerp(at[j], 1.0 / 3.0), at[j].lerp(at[i], 1.0 / 3.0)]);
        CubicPatch::from_curves(at, inner, (at[0] + at[1] + at[2]) / 3.0)
    };
    let surfaces: [&[[u32; 3]]; 3] = [
        &[[0, 1, 2]],
        // A pillow: two patches with the same corners and curves.
        &[[0, 1, 2], [0, 2, 1]],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    ];
    for triangles in surfaces {
        let patches = triangles.iter().map(|corners| flat(*corners)).collect();
        let model = CurvedModel::from_patches(triangles.to_vec(), patches).unwrap();
        let levels = simplify(model, &Options::default(), |_| ());
        assert_eq!((levels.len(), levels.patch_count(0)), (1, triangles.len()));
    }
    // All points are one: no curve has a direction.
    let model = bumpy(&mut fastrand::Rng::with_seed(15), true);
    let nothing = vec![
        CubicPatch {
            points: [DVec3::ONE; 10]
        };
        model.patches.len()
    ];
    let model = CurvedModel::from_patches(model.corners().to_vec(), nothing).unwrap();
    assert_eq!(simplify(model, &Options::default(), |_| ()).len(), 1);
}

#[test]
fn creases_and_boundaries_keep_their_ends() {
    let mut random = fastrand::Rng::with_seed(10);
    let mut model = bumpy(&mut random, false);
    let middle = |vertex: u32| vertex / SIDE == SIDE / 2;
    for edge in 0..model.is_crease.len() as u32 {
        let ends = [model.topology.origin(edge), model.topology.end(edge)];
        model.is_crease[edge as usize] = ends.into_iter().all(middle);
    }
    let at = |vertex: u32| {
        let edge = model.topology.leaving(vertex).next().unwrap();
        model.patches[edge as usize / 3].points[CORNERS[edge as usize % 3]]
    };
    let corners = [
        0,
        SIDE - 1,
        SIDE * (SIDE - 1),
        SIDE * SIDE - 1,
        SIDE * (SIDE / 2),
        SIDE * (SIDE / 2) + SIDE - 1,
    ];
    let kept = corners.map(at);
    let levels = simplify(model.clone(), &Options::default(), |_| ());
    let last = levels.model(levels.len() - 1);
    assert!(last.patches.len() * 3 < model.patches.len());
    let has = |at: &DVec3| {
        last.patches
            .iter()
            .any(|patch| CORNERS.iter().any(|&corner| patch.points[corner] == *at))
    };
    assert!(kept.iter().all(has));
    // The crease is one line of curves from end to end: no patch lies across it.
    let along: f64 = (0..last.patches.len() as u32)
        .flat_map(edges_of)
        .filter(|&edge| last.is_crease[edge as usize])
        .map(|edge| {
            let curve = last.patches[edge as usize / 3].curve(edge as usize % 3);
            (curve[3].x - curve[0].x).abs()
        })
        .sum();
    assert!(
        (along - 2.0 * f64::from(SIDE - 1)).abs() < 1e-9,
        "both sides of all crease edges: {along}"
    );
}

/// Where all edges are straight and all patches flat, swapped diagonals cost nothing either.
#[test]
fn a_plane_is_merged_exactly_by_swaps() {
    let mut random = fastrand::Rng::with_seed(16);
    for _ in 0..5 {
        let options = Options {
            max_error: 1e-9,
            ..Options::default()
        };
        let levels = simplify(rough(&mut random, false, 0.0), &options, |_| ());
        let last = levels.patch_count(levels.len() - 1);
        assert!(last <= 8, "{last} patches are left");
    }
}
