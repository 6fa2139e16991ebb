#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;
use crate::curved::patch::CubicPatch;
use crate::mesh::Mesh;

const SIDE: u32 = 9;

/// A bumpy square, or a bumpy torus where it is closed, with random heights and diagonals.
fn bumpy(random: &mut fastrand::Rng, is_closed: bool) -> CurvedModel {
    let place = |column: u32, row: u32, up: f64| {
        if !is_closed {
            return DVec3::new(f64::from(column), f64::from(row), up);
        }
        let turn = std::f64::consts::TAU / f64::from(SIDE);
        let [(sin_u, cos_u), (sin_v, cos_v)] = [column, row].map(|step| (turn * f64::from(step)).sin_cos());
        let radius = 3.0 + (1.0 + up) * cos_v;
        DVec3::new(radius * cos_u, radius * sin_u, (1.0 + up) * sin_v)
    };
    let positions = (0..SIDE * SIDE).map(|index| place(index % SIDE, index / SIDE, 0.1 * random.f64()));
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

fn samples(patches: &[CubicPatch], steps: u32) -> Vec<DVec3> {
    let mut places = Vec::new();
    for i in 0..=steps {
        for j in 0..=steps - i {
            let [u, v] = [i, j].map(|step| f64::from(step) / f64::from(steps));
            places.push(DVec3::new(u, v, 1.0 - u - v));
        }
    }
    patches
        .iter()
        .flat_map(|patch| places.iter().map(|&at| patch.point(at)))
        .collect()
}

/// The largest distance of a point from the nearest one of others.
fn farthest(points: &[DVec3], others: &[DVec3]) -> f64 {
    let nearest = |point: &DVec3| {
        others
            .iter()
            .map(|other| other.distance_squared(*point))
            .fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max).sqrt()
}

/// Half of the longest distance between neighbouring samples: no point of the surface is farther from one, nearly.
const SPACING: f64 = 0.12;

#[test]
fn no_level_is_farther_from_the_model_than_certified() {
    let mut random = fastrand::Rng::with_seed(7);
    for round in 0..2 {
        let model = bumpy(&mut random, round % 2 == 0);
        let given = samples(&model.patches, 6);
        let count = model.patches.len();
        let levels = simplify(model, &Options::default(), |_| ());
        let last = levels.len() - 1;
        assert!(
            levels.patch_count(last) * 2 < count,
            "{} of {count}",
            levels.patch_count(last)
        );
        for level in [last / 2, last] {
            let patches: Vec<CubicPatch> = levels.level(level).map(|patch| patch.patch).collect();
            let shown = samples(&patches, 8);
            let error = levels.error(level);
            assert!(farthest(&shown, &given) <= error + SPACING, "level {level}: {error}");
            assert!(
                farthest(&given, &shown) <= error + 3.0 * SPACING,
                "level {level}: {error}"
            );
        }
    }
}

/// Every level is a surface without gaps, of the model's topology, with fewer patches than the one before.
#[test]
fn every_level_is_whole() {
    let mut random = fastrand::Rng::with_seed(8);
    for is_closed in [false, true] {
        let model = bumpy(&mut random, is_closed);
        let given = (model.patches.to_vec(), model.corners().to_vec());
        let levels = simplify(model, &Options::default(), |_| ());
        let first: Vec<_> = levels.level(0).map(|patch| (patch.corners, patch.error)).collect();
        assert_eq!(first.len(), given.1.len());
        assert!(
            first
                .iter()
                .all(|(corners, error)| given.1.contains(corners) && *error == 0.0)
        );
        let mut counts = Vec::new();
        for level in 0..levels.len() {
            let patches: Vec<CubicPatch> = levels.level(level).map(|patch| patch.patch).collect();
            let corners: Vec<[u32; 3]> = levels.level(level).map(|patch| patch.corners).collect();
            counts.push(corners.len());
            let shown = CurvedModel::from_patches(corners, patches).unwrap();
            let edges = 0..3 * shown.patches.len() as u32;
            let boundary = edges.clone().filter(|&edge| shown.topology.twin(edge) == NONE).count();
            assert_eq!(boundary == 0, is_closed);
            for edge in edges.filter(|&edge| shown.topology.twin(edge) != NONE) {
                let [own, mut other] = [edge, shown.topology.twin(edge)]
                    .map(|edge| shown.patches[edge as usize / 3].curve(edge as usize % 3));
                other.reverse();
                assert_eq!(own, other, "level {level}");
            }
            let mut vertices: Vec<u32> = shown.corners().as_flattened().to_vec();
            vertices.sort_unstable();
            vertices.dedup();
            let characteristic = 2 * vertices.len() as i64 - shown.patches.len() as i64 - boundary as i64;
            assert_eq!(
                characteristic,
                if is_closed { 0 } else { 2 },
                "twice Euler's number, edges counted by faces"
            );
        }
        assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
    }
}

#[test]
fn an_error_asked_for_is_kept() {
    let mut random = fastrand::Rng::with_seed(9);
    let model = bumpy(&mut random, true);
    let options = Options {
        max_error: 0.5,
        ..Options::default()
    };
    let levels = simplify(model, &options, |_| ());
    let last = levels.len() - 1;
    assert!(levels.error(last) <= 0.5 && levels.error(last) > 0.0);
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
    let levels = simplify(model, &Options::default(), |_| ());
    let last: Vec<LevelPatch> = levels.level(levels.len() - 1).copied().collect();
    let uses = |vertex: u32| last.iter().any(|patch| patch.corners.contains(&vertex));
    for corner in [
        0,
        SIDE - 1,
        SIDE * (SIDE - 1),
        SIDE * SIDE - 1,
        SIDE * (SIDE / 2),
        SIDE * (SIDE / 2) + SIDE - 1,
    ] {
        assert!(uses(corner), "{corner}");
    }
    // No patch lies across the crease.
    let row = |vertex: u32| (vertex / SIDE).cmp(&(SIDE / 2)) as i32;
    let is_across = |patch: &LevelPatch| {
        let sides = patch.corners.map(row);
        sides.contains(&-1) && sides.contains(&1)
    };
    assert!(!last.iter().any(is_across));
}
