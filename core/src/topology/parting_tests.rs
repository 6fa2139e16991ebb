#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::collections::BTreeSet;

use glam::DVec3;

use super::*;
use crate::topology::connectivity::Connectivity;
use crate::topology::manifold::check_stars;

fn is_manifold(mesh: &Mesh) -> bool {
    check_stars(&Connectivity::new(mesh)).is_ok()
}

/// The tetrahedron of four vertices, fronts outwards where the last three are counter-clockwise seen from the first one.
fn tetrahedron([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 4] {
    [[a, b, c], [a, c, d], [a, d, b], [d, c, b]]
}

/// Tetrahedra over the edge from 0 to 1, each between two of the vertices around it.
fn around_an_edge(angles_in_degrees: &[f64], bodies: &[[u32; 2]]) -> Mesh {
    let around = angles_in_degrees.iter().map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(cos, sin, 0.5)
    });
    Mesh {
        positions: [DVec3::ZERO, DVec3::Z].into_iter().chain(around).collect(),
        triangles: bodies.iter().flat_map(|&[c, d]| tetrahedron([1, 0, c, d])).collect(),
    }
}

#[test]
fn surfaces_that_touch_in_a_vertex_are_parted_there_and_nowhere_else() {
    let mesh = Mesh {
        positions: (0..7).map(|vertex| DVec3::splat(f64::from(vertex))).collect(),
        triangles: [tetrahedron([0, 1, 2, 3]), tetrahedron([4, 5, 6, 0])].concat(),
    };
    assert!(!is_manifold(&mesh));
    let (parted, originals) = parted(&mesh).unwrap();
    assert_eq!(originals, [0, 1, 2, 3, 4, 5, 6, 0]);
    assert_eq!(parted.positions[7], mesh.positions[0]);
    assert_eq!(parted.triangles[..4], mesh.triangles[..4]);
    assert!(is_manifold(&parted));
    assert_eq!(super::parted(&parted).unwrap().0, parted);
}

#[test]
fn bodies_that_touch_along_an_edge_are_parted_into_those_bodies() {
    let three = [[2, 3], [4, 5], [6, 7]];
    for turn in [0.0, 100.0, 200.0, 300.0] {
        let angles = [10.0, 60.0, 130.0, 170.0, 250.0, 330.0].map(|degrees| degrees + turn);
        for count in [2, 3] {
            let mut mesh = around_an_edge(&angles, &three[..count]);
            // One triangle of each body by turns, so that their order tells nothing.
            let by_turns = (0..4).flat_map(|turn| (0..count).map(move |body| 4 * body + turn));
            mesh.triangles = by_turns.map(|triangle| mesh.triangles[triangle]).collect();
            let (parted, originals) = parted(&mesh).unwrap();
            assert!(is_manifold(&parted), "{count} bodies, turned by {turn}°");
            let unused = 2 * (3 - count);
            assert_eq!(parted.positions.len(), 4 * count + unused);
            for (body, &[c, d]) in three[..count].iter().enumerate() {
                let corners = parted.triangles.iter().skip(body).step_by(count).flatten();
                let vertices: BTreeSet<u32> = corners.copied().collect();
                assert_eq!(vertices.len(), 4, "a body has vertices of its own");
                let given: BTreeSet<u32> = vertices.iter().map(|&vertex| originals[vertex as usize]).collect();
                assert_eq!(given, BTreeSet::from([0, 1, c, d]));
            }
        }
    }
}

#[test]
fn bodies_that_touch_in_a_whole_triangle_keep_its_two_sides() {
    let mesh = around_an_edge(&[0.0, 60.0, 120.0], &[[2, 3], [3, 4]]);
    let (parted, _) = parted(&mesh).unwrap();
    assert!(is_manifold(&parted));
    let [one, other] = [0..4, 4..8].map(|body| parted.triangles[body].as_flattened().to_vec());
    assert!(one.iter().all(|vertex| !other.contains(vertex)), "{one:?} {other:?}");
}

#[test]
fn where_a_surface_still_meets_itself_it_is_parted_on_the_other_side() {
    // Hollows: their fronts look inwards, so that what is between them counts as inside.
    let mut mesh = around_an_edge(&[10.0, 60.0, 130.0, 170.0], &[[2, 3], [4, 5]]);
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    let (parted, _) = parted(&mesh).unwrap();
    assert!(is_manifold(&parted), "{parted:?}");
    assert_eq!(parted.positions.len(), 8);
}

#[test]
fn boundaries_stay_and_none_arises() {
    let sheet = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE],
        triangles: vec![[0, 1, 2], [2, 1, 3]],
    };
    assert_eq!(parted(&sheet), Ok((sheet, vec![0, 1, 2, 3])));
}

#[test]
fn edges_whose_triangles_do_not_pair_are_named() {
    let refused = |triangles: &[[u32; 3]]| {
        let positions = vec![DVec3::ZERO; 5];
        let triangles = triangles.to_vec();
        parted(&Mesh { positions, triangles }).unwrap_err()
    };
    let fin = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    assert_eq!(refused(&fin), ManifoldError::Edge(0, 1));
    assert_eq!(refused(&[[0, 1, 2], [1, 2, 3]]), ManifoldError::Edge(1, 2));
}
