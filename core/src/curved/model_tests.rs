#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

/// Two triangles over a unit square, folded along its diagonal, with each triangle's own normal at its corners.
fn folded_square() -> (Mesh, Vec<[DVec3; 3]>) {
    let corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.5), (1.0, 1.0, 0.0), (0.0, 1.0, 0.5)];
    let mesh = Mesh {
        positions: corners.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let normal = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        [(b - a).cross(c - a); 3]
    };
    let normals = mesh.triangles.iter().map(normal).collect();
    (mesh, normals)
}

/// Patches on both sides of every edge have the same control points there, to the bit.
fn assert_no_gaps(model: &CurvedModel) {
    for edge in 0..3 * model.patches.len() as u32 {
        let twin = model.topology.twin(edge);
        if twin != NONE {
            let [own, mut other] = [edge, twin].map(|edge| model.patches[edge as usize / 3].curve(edge as usize % 3));
            other.reverse();
            assert_eq!(own, other);
        }
    }
}

#[test]
fn creases_stay_where_normals_differ() {
    let (mesh, normals) = folded_square();
    let model = CurvedModel::from_mesh(&mesh, &normals).unwrap();
    assert_eq!(model.creases(0), [false, false, true]);
    assert_eq!(model.creases(1), [true, false, false]);
    assert_eq!(model.neighbours(0), [None, None, Some(1)]);
    assert_no_gaps(&model);
    // Each patch stays in its triangle's plane: with one normal at all corners it is flat.
    for (patch, normals) in model.patches().iter().zip(&normals) {
        let normal = normals[0].normalize();
        assert!(
            patch
                .points
                .iter()
                .all(|point| normal.dot(*point - patch.points[0]).abs() < 1e-15)
        );
    }
}

#[test]
fn smooth_edges_have_coplanar_centres_after_the_second_pass() {
    let (mesh, _) = folded_square();
    let up = DVec3::Z;
    let smooth = vec![[up, DVec3::new(0.1, 0.0, 1.0), up], [up, up, DVec3::new(0.0, 0.1, 1.0)]];
    let first = CurvedModel::first_pass(&mesh, &smooth).unwrap();
    let mut model = first.clone();
    assert_eq!(model.refine_centres(), [Refined::Plane; 2]);
    assert_no_gaps(&model);
    let volume = |model: &CurvedModel| {
        let [one, other] = [0, 1].map(|patch| model.patches()[patch].points[CENTRE]);
        let [_, a, b, _] = model.patches()[0].curve(2);
        (b - a).cross(one - a).dot(other - a).abs()
    };
    assert!(
        volume(&model) < 1e-15 && volume(&first) > 1e-4,
        "{} {}",
        volume(&first),
        volume(&model)
    );
}

#[test]
fn what_is_no_model_is_refused_by_name() {
    let (mesh, normals) = folded_square();
    let missing = CurvedModel::from_mesh(&mesh, &normals[..1]);
    assert_eq!(missing.unwrap_err(), ModelError::Count { given: 1, triangles: 2 });
    let zero = CurvedModel::from_mesh(&mesh, &[normals[0], [DVec3::ZERO; 3]]);
    assert_eq!(zero.unwrap_err(), ModelError::NoNormal(1));
    let mut twisted = mesh.clone();
    twisted.triangles[1] = [0, 3, 2];
    let refused = CurvedModel::from_mesh(&twisted, &normals);
    assert!(matches!(refused, Err(ModelError::NotManifold(_))));
}

/// A cone of four bicubic patches: their upper sides are one point each, and all sides meet.
fn cone() -> Vec<Bicubic> {
    let arc = 0.55;
    let quarter = [(1.0, 0.0), (1.0, arc), (arc, 1.0), (0.0, 1.0)];
    let turn = |(x, y): (f64, f64), quarters: u32| (0..quarters).fold((x, y), |(x, y), _| (-y, x));
    let patch = |quarters: u32| {
        let rim = quarter.map(|point| turn(point, quarters));
        [0, 1, 2, 3].map(|i| rim.map(|(x, y)| DVec3::new(x, y, 0.0).lerp(DVec3::Z, f64::from(i) / 3.0)))
    };
    (0..4).map(patch).collect()
}

/// §9: where a side of a bicubic patch is one point, as at a pole, one triangle has it as a corner, and the surface goes on round it.
#[test]
fn a_pole_is_a_vertex() {
    let model = CurvedModel::from_bicubics(&cone());
    assert_eq!(model.patches().len(), 4);
    assert_no_gaps(&model);
    let lone = (0..12).filter(|&edge| model.topology.twin(edge) == NONE).count();
    assert_eq!(lone, 4, "the rim alone");
    let pole = model.corners()[0][0];
    assert_eq!(model.topology.leaving(pole).count(), 4);
}

/// §9: where two sides that meet are one point, triangles are folded, and nothing is on the other side of what has no length.
#[test]
fn a_fold_is_a_boundary_of_no_length() {
    let mut folded: Bicubic = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| DVec3::new(f64::from(i), f64::from(j), 0.0)));
    folded[0] = [DVec3::ZERO; 4];
    folded.iter_mut().for_each(|row| row[0] = DVec3::ZERO);
    let model = CurvedModel::from_bicubics(&[folded]);
    assert_eq!(model.patches().len(), 2);
    assert_no_gaps(&model);
    assert_eq!(model.neighbours(0), [None, None, Some(1)]);
}

/// §9: between the same two vertices there may be several edges. Two sheets with the same ends and different sides stay apart.
#[test]
fn several_edges_may_join_two_vertices() {
    let sheet = |lift: f64, flip: bool| -> Bicubic {
        [0, 1, 2, 3].map(|i| {
            [0, 1, 2, 3].map(|j| {
                let (i, j) = if flip { (j, i) } else { (i, j) };
                let inside = f64::from(i32::from((1..3).contains(&i) && (1..3).contains(&j)));
                DVec3::new(i as f64, j as f64, lift * inside)
            })
        })
    };
    let model = CurvedModel::from_bicubics(&[sheet(1.0, false), sheet(-1.0, true)]);
    assert_no_gaps(&model);
    // A pillow of four triangles and four vertices: diagonals join the same two corners, and are two edges.
    assert_eq!(model.topology.vertex_slots(), 4);
    assert_eq!(model.topology.leaving(model.corners()[0][0]).count(), 4);
    assert_eq!(model.neighbours(0)[2], Some(1));
    assert_eq!(model.neighbours(2)[2], Some(3));
}
