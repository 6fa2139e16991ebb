#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::HashMap;

use super::*;
use crate::mesh::validate_topology;

/// A sphere of eight patches over an octahedron, cut finer by halving each edge so many times.
fn sphere(halvings: u32) -> CurvedModel {
    let mut triangles = Vec::new();
    for signs in 0..8 {
        let sign = |bit: u32| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        let is_outward = sign(0) * sign(1) * sign(2) > 0.0;
        triangles.push(if is_outward {
            corners
        } else {
            [corners[0], corners[2], corners[1]]
        });
    }
    for _ in 0..halvings {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[a, b]| (a + b).normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    welded(&triangles, |at| at)
}

/// A model of triangles that meet where their corners are equal.
fn welded(triangles: &[[DVec3; 3]], normal: impl Fn(DVec3) -> DVec3) -> CurvedModel {
    let mut mesh = Mesh::default();
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    for three in triangles {
        mesh.triangles.push(three.map(|at| {
            *known
                .entry((at + DVec3::ZERO).to_array().map(f64::to_bits))
                .or_insert_with(|| {
                    mesh.positions.push(at);
                    mesh.positions.len() as u32 - 1
                })
        }));
    }
    let normals: Vec<[DVec3; 3]> = triangles.iter().map(|three| three.map(&normal)).collect();
    CurvedModel::from_mesh(&mesh, &normals).unwrap()
}

/// An edge's factor and a patch's, by chance, but the same each time: from the bits of the points.
fn chance(points: &[DVec3], most: f64) -> f64 {
    let bits = points.iter().flat_map(|point| point.to_array()).map(f64::to_bits);
    let seed = bits.fold(7_u64, |seed, bits| seed.rotate_left(9).wrapping_mul(31) ^ bits);
    1.0 + (most - 1.0) * fastrand::Rng::with_seed(seed).f64()
}

fn by_chance(model: &CurvedModel, is_gradual: bool) -> Tessellation {
    let factors = Factors {
        edge: &|curve| chance(&curve, 9.0),
        patch: &|patch| chance(&patch.points, 12.0),
        is_gradual,
    };
    Tessellation::by_factors(model, &factors).unwrap()
}

/// How many triangles each pair of vertices is an edge of.
fn edge_uses(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], u32> {
    let mut uses = HashMap::new();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *uses.entry([from.min(to), from.max(to)]).or_insert(0) += 1;
        }
    }
    uses
}

#[test]
fn a_closed_model_stays_closed_whatever_the_factors() {
    for (halvings, is_gradual) in [(0, false), (0, true), (1, false), (1, true), (2, true)] {
        let model = sphere(halvings);
        let made = by_chance(&model, is_gradual);
        validate_topology(made.mesh.positions.len(), &made.mesh.triangles).unwrap();
        let uses = edge_uses(&made.mesh.triangles);
        assert!(uses.values().all(|&uses| uses == 2));
        let (vertices, edges, faces) = (made.mesh.positions.len(), uses.len(), made.mesh.triangles.len());
        assert_eq!(vertices + faces, edges + 2, "one sphere");
        assert!(faces > 20 * model.patches().len());
    }
}

/// Each patch alone, as a worker would have it, makes the same points along its edges as the patch across.
#[test]
fn patches_that_do_not_know_each_other_have_the_same_points_on_their_edge() {
    for is_gradual in [false, true] {
        let model = sphere(1);
        let alone: Vec<Tessellation> = model
            .patches()
            .iter()
            .map(|patch| {
                let single = CurvedModel::from_patches(vec![[0, 1, 2]], vec![*patch]).unwrap();
                by_chance(&single, is_gradual)
            })
            .collect();
        let bits = |at: &DVec3| (*at + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut owners: HashMap<[u64; 3], u32> = HashMap::new();
        for made in &alone {
            let boundary = edge_uses(&made.mesh.triangles)
                .into_iter()
                .filter(|(_, uses)| *uses == 1);
            let mut on_it: Vec<u32> = boundary.flat_map(|(ends, _)| ends).collect();
            on_it.sort_unstable();
            on_it.dedup();
            for vertex in on_it {
                *owners.entry(bits(&made.mesh.positions[vertex as usize])).or_insert(0) += 1;
            }
        }
        let corners = owners.values().filter(|&&owners| owners > 2).count();
        assert_eq!(corners, 18, "of an octahedron, and the middles of its edges");
        assert!(owners.values().all(|&owners| owners >= 2), "{owners:?}");
        assert!(owners.len() > 100);
    }
}

/// The distance between each triangle and the patch over the same part of the domain, by many samples, and the largest.
fn farthest(model: &CurvedModel, made: &Tessellation) -> f64 {
    let mut farthest: f64 = 0.0;
    for (patch, corners) in model.patches().iter().zip(model.corners()) {
        let _ = corners;
        for i in 0..=40_u32 {
            for j in 0..=40 - i {
                let at = DVec3::new(f64::from(i), f64::from(j), f64::from(40 - i - j)) / 40.0;
                let point = patch.point(at);
                let nearest = made
                    .mesh
                    .triangles
                    .iter()
                    .map(|three| distance(point, three.map(|corner| made.mesh.positions[corner as usize])));
                farthest = farthest.max(nearest.fold(f64::INFINITY, f64::min));
            }
        }
    }
    farthest
}

/// From a point to a triangle.
fn distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize();
    let is_over = [[a, b], [b, c], [c, a]]
        .iter()
        .all(|[from, to]| normal.cross(to - from).dot(point - from) >= 0.0);
    if is_over {
        return normal.dot(point - a).abs();
    }
    let to_edge = |[from, to]: [DVec3; 2]| {
        let along = ((point - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        point.distance(from.lerp(to, along))
    };
    [[a, b], [b, c], [c, a]]
        .into_iter()
        .map(to_edge)
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn no_point_of_the_patches_is_farther_than_the_tolerance() {
    let model = sphere(0);
    let mut before = 0;
    for tolerance in [0.1, 0.02, 0.004] {
        let made = Tessellation::within(&model, tolerance).unwrap();
        let measured = farthest(&model, &made);
        assert!(
            measured <= tolerance && measured > tolerance / 10.0,
            "{measured} of {tolerance}"
        );
        assert!(made.mesh.triangles.len() > before);
        before = made.mesh.triangles.len();
        assert!(edge_uses(&made.mesh.triangles).values().all(|&uses| uses == 2));
    }
    assert!(before < 3000, "{before} triangles");
}

#[test]
fn a_tolerance_too_small_is_refused_by_name() {
    let refused = Tessellation::within(&sphere(0), 1e-12);
    assert_eq!(refused, Err(TessellationError::TooFine(0)));
}

/// Samples of a surface by rays from the origin, which a sphere's tessellation meets once each.
fn radii(made: &Tessellation) -> Vec<f64> {
    let mut random = fastrand::Rng::with_seed(9);
    let rays = (0..200).map(|_| DVec3::new(random.f64() - 0.5, random.f64() - 0.5, random.f64() - 0.5).normalize());
    let rays: Vec<DVec3> = rays.collect();
    let mut radii = vec![f64::NAN; rays.len()];
    for three in &made.mesh.triangles {
        let [a, b, c] = three.map(|corner| made.mesh.positions[corner as usize]);
        for (ray, radius) in rays.iter().zip(&mut radii) {
            let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|side| side.dot(*ray));
            if sides.iter().all(|&side| side >= 0.0) && sides.iter().sum::<f64>() > 1e-12 {
                let normal = (b - a).cross(c - a);
                *radius = normal.dot(a) / normal.dot(*ray);
            }
        }
    }
    assert!(radii.iter().all(|radius| radius.is_finite()));
    radii
}

fn largest_change(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The eye comes nearer in small steps: whatever comes in, no point of the surface jumps. Where switching is at once, it does.
#[test]
fn the_surface_is_continuous_in_the_distance_of_the_eye() {
    let model = sphere(0);
    let view = |distance: f64| View {
        eye: DVec3::new(0.3, 0.5, 1.0).normalize() * distance,
        focal_length: 500.0,
        tolerance: 2.0,
        nearest: 0.1,
    };
    let steps = || (0..=1500).map(|step| view(400.0 * (0.997_f64).powi(step)));
    let in_view = |view: &View, is_gradual: bool| {
        let edge = |curve| view.curve_factor(curve);
        let patch = |patch: &CubicPatch| view.patch_factor(patch);
        Tessellation::by_factors(
            &model,
            &Factors {
                edge: &edge,
                patch: &patch,
                is_gradual,
            },
        )
        .unwrap()
    };
    let jump = |is_gradual: bool| {
        let all: Vec<Vec<f64>> = steps().map(|view| radii(&in_view(&view, is_gradual))).collect();
        all.windows(2)
            .map(|pair| largest_change(&pair[0], &pair[1]))
            .fold(0.0, f64::max)
    };
    let counts: Vec<usize> = [400.0, 5.0]
        .map(|distance| in_view(&view(distance), true).mesh.triangles.len())
        .to_vec();
    assert!(counts[0] < 40 && counts[1] > 500, "{counts:?}");
    let (gradual, at_once) = (jump(true), jump(false));
    assert!(gradual < 0.006 && at_once > 0.05, "{gradual} {at_once}");
}

#[test]
fn normals_are_the_patches_and_creases_have_two() {
    let smooth = by_chance(&sphere(1), true);
    assert_eq!(smooth.normals.len(), smooth.mesh.positions.len());
    for (three, normals) in smooth.mesh.triangles.iter().zip(&smooth.triangle_normals) {
        for (vertex, normal) in three.iter().zip(normals) {
            let normal = smooth.normals[*normal as usize];
            assert!(normal.dot(smooth.mesh.positions[*vertex as usize].normalize()) > 0.99 && normal.is_normalized());
        }
    }
    // Two triangles that meet at a right angle.
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mesh = Mesh {
        positions: vec![a, b, c, d],
        triangles: vec![[0, 1, 2], [1, 0, 3]],
    };
    let normals = [[DVec3::Z; 3], [DVec3::Y; 3]];
    let roof = CurvedModel::from_mesh(&mesh, &normals).unwrap();
    let factors = Factors {
        edge: &|_| 3.0,
        patch: &|_| 3.0,
        is_gradual: false,
    };
    let made = Tessellation::by_factors(&roof, &factors).unwrap();
    assert_eq!(
        (made.mesh.positions.len(), made.normals.len()),
        (16, 20),
        "four on the crease twice"
    );
    assert!(
        made.normals
            .iter()
            .all(|normal| [DVec3::Z, DVec3::Y].iter().any(|own| own.distance(*normal) < 1e-12))
    );
}

/// At a pole a side of the patch is one point: its normal is the limit from inside.
#[test]
fn a_pole_has_the_normal_of_what_is_around_it() {
    let corners = [DVec3::Z, DVec3::Z, DVec3::new(1.0, 0.0, 0.9)];
    let curves = [
        [DVec3::Z; 2],
        [DVec3::new(0.3, 0.3, 1.0), DVec3::new(0.7, 0.3, 0.95)],
        [DVec3::new(0.7, -0.3, 0.95), DVec3::new(0.3, -0.3, 1.0)],
    ];
    let patch = crate::curved::merging::with_average_centre(corners, curves);
    assert_eq!(patch.normal(DVec3::X), DVec3::ZERO);
    let normal = unit_normal(&patch, DVec3::X);
    assert!(normal.is_normalized() && normal.z.abs() > 0.9, "{normal}");
}

/// Straight sides and a bent inside, and sides that are one point: what is finer inside makes its edges finer, too, rather than
/// lattices of needles.
#[test]
fn triangles_are_no_more_than_those_of_even_lattices() {
    let place = |i: usize, j: usize| DVec3::new(i as f64, j as f64, 0.0);
    let is_inside = |i: usize| (1..3).contains(&i);
    let pillow = [0, 1, 2, 3].map(|i| {
        [0, 1, 2, 3].map(|j| match is_inside(i) && is_inside(j) {
            true => place(i, j) + DVec3::Z,
            false => place(i, j),
        })
    });
    let dome = [(0.0, 3.0), (1.7, 3.0), (3.0, 1.7), (3.0, 0.0)].map(|(radius, height)| {
        [(1.0, 0.0), (1.0, 0.55), (0.55, 1.0), (0.0, 1.0)]
            .map(|(x, y): (f64, f64)| DVec3::new(radius * x, radius * y, height))
    });
    for bicubic in [pillow, dome] {
        let model = CurvedModel::from_bicubics(&[bicubic]);
        let tolerance = 0.002;
        let made = Tessellation::within(&model, tolerance).unwrap();
        let even = model.patches().iter().map(|patch| {
            let steps = flatness::factor(flatness::triangle_error(patch), tolerance).ceil();
            steps * steps
        });
        let (triangles, even) = (made.mesh.triangles.len(), even.sum::<f64>());
        assert!(
            triangles as f64 <= even,
            "{triangles} triangles, {even} in even lattices"
        );
        let has_area = |three: &[u32; 3]| {
            let [a, b, c] = three.map(|vertex| made.mesh.positions[vertex as usize]);
            a != b && b != c && c != a
        };
        assert!(made.mesh.triangles.iter().all(has_area));
    }
}
