#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::*;
use crate::levels::partition::{self, SurfacePartition};
use crate::levels::replay::{Demand, Replay};
use crate::mesh::{boundary_edges, validate_topology};

const COARSEST: Goal = Goal {
    tolerance: f64::INFINITY,
    triangles: 0,
};

/// An octahedron, each triangle cut in four so many times, on a sphere of radius 1 with bumps as high as `bump`.
pub(crate) fn bumpy_sphere(cuts: u32, bump: f64, seed: u64) -> Mesh {
    let axes = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut mesh = Mesh {
        positions: axes.to_vec(),
        triangles: (0..4)
            .flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]])
            .collect(),
    };
    (0..cuts).for_each(|_| mesh = cut_in_four(&mesh));
    let mut random = fastrand::Rng::with_seed(seed);
    for position in &mut mesh.positions {
        *position = position.normalize() * (1.0 + bump * (random.f64() - 0.5));
    }
    mesh
}

fn cut_in_four(mesh: &Mesh) -> Mesh {
    let mut positions = mesh.positions.clone();
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            positions.push(positions[a as usize].midpoint(positions[b as usize]));
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    Mesh { positions, triangles }
}

/// A grid of cells with two triangles each. Where it `wraps`, its last column or row is the first.
fn grid([columns, rows]: [u32; 2], wraps: [bool; 2], at: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let [width, height] = [(columns, wraps[0]), (rows, wraps[1])].map(|(cells, wraps)| cells + u32::from(!wraps));
    let vertex = |column: u32, row: u32| row % height * width + column % width;
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let cut = |(c, r): (u32, u32)| {
        let [a, b, d, e] = [vertex(c, r), vertex(c + 1, r), vertex(c + 1, r + 1), vertex(c, r + 1)];
        [[a, b, d], [a, d, e]]
    };
    let place = |v: u32| {
        at(
            f64::from(v % width) / f64::from(columns),
            f64::from(v / width) / f64::from(rows),
        )
    };
    Mesh {
        positions: (0..width * height).map(place).collect(),
        triangles: cells.flat_map(cut).collect(),
    }
}

/// A flat square of side 1.
pub(crate) fn plate(cells: u32) -> Mesh {
    grid([cells; 2], [false; 2], |x, y| DVec3::new(x, y, 0.0))
}

fn torus() -> Mesh {
    grid([48, 24], [true; 2], |u, v| {
        let (out, up) = (1.0 + 0.4 * (v * TAU).cos(), 0.4 * (v * TAU).sin());
        DVec3::new(out * (u * TAU).cos(), out * (u * TAU).sin(), up)
    })
}

/// Open at the top and, by a small hole, at the bottom.
fn bowl() -> Mesh {
    grid([40, 20], [true, false], |u, v| {
        let out = 0.2 + 0.8 * v;
        DVec3::new(out * (u * TAU).cos(), out * (u * TAU).sin(), out * out)
    })
}

/// A cube of side 1, each face a grid of its own whose sides are joined.
fn cube(cells: u32) -> Mesh {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut numbers = HashMap::new();
    let mut triangles = Vec::new();
    for [right, up] in [[DVec3::X, DVec3::Y], [DVec3::Y, DVec3::Z], [DVec3::Z, DVec3::X]] {
        for side in [1.0, -1.0] {
            let face = grid([cells; 2], [false; 2], |x, y| {
                right * side * (x - 0.5) + up * (y - 0.5) + right.cross(up) * side / 2.0
            });
            let mut number = |corner: u32| {
                let position = face.positions[corner as usize];
                let key = (position * f64::from(2 * cells)).round().as_i64vec3();
                *numbers.entry(key).or_insert_with(|| {
                    positions.push(position);
                    positions.len() as u32 - 1
                })
            };
            triangles.extend(face.triangles.iter().map(|corners| corners.map(&mut number)));
        }
    }
    Mesh { positions, triangles }
}

fn shapes() -> [(&'static str, Mesh); 4] {
    [
        ("sphere", bumpy_sphere(4, 0.02, 7)),
        ("torus", torus()),
        ("bowl", bowl()),
        ("cube", cube(6)),
    ]
}

/// The largest distance of a surface's points from another one, at `steps` steps a side of each triangle, by a formula of its
/// own: Gram's, in the triangle's plane, or the nearest of the three sides.
pub(crate) fn sampled_distance(from: &Mesh, to: &Mesh, steps: u32) -> f64 {
    let corners = |mesh: &Mesh, corners: &[u32; 3]| corners.map(|corner| mesh.positions[corner as usize]);
    let targets: Vec<[DVec3; 3]> = to.triangles.iter().map(|triangle| corners(to, triangle)).collect();
    let mut worst: f64 = 0.0;
    for triangle in &from.triangles {
        let [a, b, c] = corners(from, triangle);
        for (i, j) in (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|step| f64::from(step) / f64::from(steps));
            let point = a * (1.0 - u - v) + b * u + c * v;
            let squared = targets.iter().map(|&target| squared_by_gram(point, target));
            worst = worst.max(squared.fold(f64::INFINITY, f64::min).sqrt());
        }
    }
    worst
}

fn squared_by_gram(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (e, f, d) = (b - a, c - a, point - a);
    let (ee, ef, ff, de, df) = (e.dot(e), e.dot(f), f.dot(f), d.dot(e), d.dot(f));
    let gram = ee * ff - ef * ef;
    let (u, v) = ((de * ff - df * ef) / gram, (df * ee - de * ef) / gram);
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        return (d - e * u - f * v).length_squared();
    }
    let side = |from: DVec3, to: DVec3| {
        let share = (point - from).dot(to - from) / (to - from).length_squared();
        point.distance_squared(from.lerp(to, share.clamp(0.0, 1.0)))
    };
    side(a, b).min(side(b, c)).min(side(c, a))
}

fn simplified(mesh: &Mesh, placement: Placement, goal: Goal) -> ModelSimplifier {
    let mut simplifier = ModelSimplifier::new(mesh, placement).unwrap();
    while simplifier.next_band(goal) {}
    simplifier
}

fn coarsest(mesh: &Mesh, placement: Placement, goal: Goal) -> Mesh {
    let simplifier = simplified(mesh, placement, goal);
    let lod = SurfacePartition::from_log(mesh, simplifier.log(), 0.0).unwrap().lod(0);
    assert_eq!(lod.triangles.len(), simplifier.triangle_count());
    lod
}

/// Vertices − edges + triangles.
fn euler(mesh: &Mesh) -> i64 {
    let boundary = boundary_edges(&mesh.triangles).len();
    let edges = (3 * mesh.triangles.len() + boundary) / 2;
    mesh.positions.len() as i64 - edges as i64 + mesh.triangles.len() as i64
}

#[test]
fn every_level_is_a_manifold_of_the_models_topology() {
    for (name, mesh) in shapes() {
        for placement in [Placement::Stay, Placement::Best] {
            let simplifier = simplified(&mesh, placement, COARSEST);
            let replay = Replay::run(&mesh, simplifier.log(), Demand::Consistent, |_| ()).unwrap();
            let batches = replay.band_batches(simplifier.log(), f64::INFINITY);
            let partition = SurfacePartition::from_replay(&mesh, &replay, &batches).unwrap();
            partition::validate(&partition).unwrap();
            assert!(
                name == "cube" || partition.levels.len() > 4,
                "{name}: {} levels",
                partition.levels.len()
            );
            for level in 0..partition.levels.len() {
                let lod = partition.lod(level);
                validate_topology(lod.positions.len(), &lod.triangles).unwrap();
                manifold::check_stars(&Connectivity::new(&lod)).unwrap();
                assert_eq!(euler(&lod), euler(&mesh), "{name}, level {level}");
            }
            let finest = partition.lod(partition.levels.len() - 1);
            assert_eq!(finest.triangles.len(), mesh.triangles.len());
        }
    }
}

#[test]
fn surfaces_stay_nearly_within_the_tolerance_of_the_model_and_the_model_of_them() {
    for (name, mesh) in shapes() {
        for tolerance in [0.01, 0.04] {
            let goal = Goal {
                tolerance,
                triangles: 0,
            };
            let level = coarsest(&mesh, Placement::Best, goal);
            let back = sampled_distance(&level, &mesh, 6);
            assert!(back <= tolerance * 1.2, "{name}: {back} of {tolerance}");
            let there = sampled_distance(&mesh, &level, 3);
            assert!(there <= tolerance * 1.2, "{name}: {there} of {tolerance}");
            let used = back.max(there);
            assert!(
                name == "cube" || used > tolerance * 0.6,
                "{name}: {used} of {tolerance} is used"
            );
            assert!(
                level.triangles.len() * 2 < mesh.triangles.len(),
                "{name}: {}",
                level.triangles.len()
            );
        }
    }
}

#[test]
fn flat_faces_need_few_triangles() {
    let exact = Goal {
        tolerance: 1e-6,
        triangles: 0,
    };
    for placement in [Placement::Stay, Placement::Best] {
        let [plate, cube] = [plate(16), cube(5)].map(|mesh| coarsest(&mesh, placement, exact).triangles.len());
        assert_eq!((plate, cube), (2, 12), "{placement:?}");
    }
}

#[test]
fn no_triangle_of_a_plate_turns_over_or_becomes_a_line() {
    for jitter in [0.02, 1e-7] {
        let mut plate = plate(16);
        let mut random = fastrand::Rng::with_seed(1);
        for position in &mut plate.positions {
            *position += jitter * DVec3::new(random.f64(), random.f64(), 0.0);
        }
        for placement in [Placement::Stay, Placement::Best] {
            let simplifier = simplified(&plate, placement, COARSEST);
            let partition = SurfacePartition::from_log(&plate, simplifier.log(), 0.0).unwrap();
            for lod in (0..partition.levels.len()).map(|level| partition.lod(level)) {
                let least = lod.triangles.iter().map(|corners| {
                    let [a, b, c] = corners.map(|corner| lod.positions[corner as usize]);
                    let longest = a
                        .distance_squared(b)
                        .max(b.distance_squared(c))
                        .max(c.distance_squared(a));
                    (b - a).cross(c - a).z / longest
                });
                let least = least.fold(f64::INFINITY, f64::min);
                assert!(least > 1e-4, "{least} with {placement:?}, {jitter}");
            }
        }
    }
}

#[test]
fn the_boundary_is_not_pulled_inside() {
    let bowl = bowl();
    let edges = boundary_edges(&bowl.triangles);
    let is_on_boundary = |vertex: u32| edges.iter().any(|&(from, to)| from == vertex || to == vertex);
    let simplifier = simplified(&bowl, Placement::Best, COARSEST);
    let mut moves = simplifier
        .log()
        .collapses
        .iter()
        .filter(|collapse| collapse.red_before != collapse.red_after);
    assert!(moves.all(|collapse| is_on_boundary(collapse.blue) == is_on_boundary(collapse.red)));
}

#[test]
fn what_cannot_be_smaller_stays() {
    let tetrahedron = coarsest(&bumpy_sphere(0, 0.0, 0), Placement::Best, COARSEST);
    assert_eq!((tetrahedron.positions.len(), tetrahedron.triangles.len()), (4, 4));
    assert!(
        simplified(&tetrahedron, Placement::Best, COARSEST)
            .log()
            .collapses
            .is_empty()
    );
    assert_eq!(coarsest(&plate(1), Placement::Best, COARSEST).triangles.len(), 1);
    // The least torus has seven vertices.
    let torus = coarsest(&torus(), Placement::Stay, COARSEST);
    assert!((14..=24).contains(&torus.triangles.len()), "{}", torus.triangles.len());
}

#[test]
fn vertices_stay_where_that_is_asked_for_at_the_price_of_more_triangles() {
    let goal = Goal {
        tolerance: 0.02,
        triangles: 0,
    };
    let sphere = bumpy_sphere(4, 0.01, 3);
    let staying = simplified(&sphere, Placement::Stay, goal);
    assert!(
        staying
            .log()
            .collapses
            .iter()
            .all(|collapse| collapse.red_before == collapse.red_after)
    );
    let moving = simplified(&sphere, Placement::Best, goal);
    let (more, fewer) = (staying.triangle_count(), moving.triangle_count());
    assert!(fewer * 10 < more * 9, "{fewer} {more}");
}

#[test]
fn the_triangles_asked_for_are_what_is_left() {
    for triangles in [100, 333] {
        let goal = Goal {
            tolerance: f64::INFINITY,
            triangles,
        };
        let left = simplified(&torus(), Placement::Best, goal).triangle_count();
        assert!((triangles - 1..=triangles).contains(&left), "{left}");
    }
}

#[test]
fn bands_halve_the_triangles() {
    let simplifier = simplified(&torus(), Placement::Best, COARSEST);
    let ends: Vec<usize> = simplifier.log().bands.iter().map(|band| band.end).collect();
    let left = |end: &usize| torus().triangles.len() - 2 * end;
    assert!(left(&ends[0]) * 2 <= torus().triangles.len());
    let pairs = ends[..ends.len() - 1].windows(2);
    // A collapse takes two triangles.
    let is_half = |pair: &[usize]| (0..=4).contains(&(left(&pair[0]).abs_diff(2 * left(&pair[1]))));
    assert!(left(&ends[0]) * 2 + 4 >= torus().triangles.len());
    assert!(
        pairs
            .into_iter()
            .all(|pair| left(&pair[1]) * 2 <= left(&pair[0]) && is_half(pair)),
        "{ends:?}"
    );
}

#[test]
fn far_from_the_origin_the_work_is_the_same() {
    let goal = Goal {
        tolerance: 0.02,
        triangles: 0,
    };
    let near = bowl();
    let mut far = near.clone();
    far.positions
        .iter_mut()
        .for_each(|position| *position += DVec3::new(4e6, -3e6, 5e6));
    let [near, far] = [near, far].map(|mesh| simplified(&mesh, Placement::Best, goal).triangle_count() as f64);
    assert!((near - far).abs() < near * 0.1, "{near} {far}");
}

#[test]
fn what_is_no_manifold_is_refused_by_name() {
    let refused = |triangles: &[[u32; 3]]| {
        let mesh = Mesh {
            positions: bumpy_sphere(0, 0.0, 0).positions,
            triangles: triangles.to_vec(),
        };
        ModelSimplifier::new(&mesh, Placement::Best).err()
    };
    assert_eq!(refused(&[[0, 1, 2], [0, 3, 4]]), Some(ManifoldError::Vertex(0)));
    assert_eq!(
        refused(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]),
        Some(ManifoldError::Edge(0, 1))
    );
    let moebius = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 0], [4, 0, 1]];
    assert!(matches!(refused(&moebius), Some(ManifoldError::Edge(..))));
    assert_eq!(refused(&[[0, 0, 1]]), Some(ManifoldError::BadTriangle(0)));
}
