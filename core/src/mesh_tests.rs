use super::*;

/// Nine vertices in three rows, each square cut from lower left to upper right.
pub(crate) fn three_by_three() -> Mesh {
    Mesh {
        positions: (0..9)
            .map(|v| DVec3::new(f64::from(v % 3), f64::from(v / 3), 0.0))
            .collect(),
        triangles: [
            [0, 1, 4],
            [0, 4, 3],
            [1, 2, 5],
            [1, 5, 4],
            [3, 4, 7],
            [3, 7, 6],
            [4, 5, 8],
            [4, 8, 7],
        ]
        .to_vec(),
    }
}

fn butterfly() -> Mesh {
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let positions = vec![
        at(0.0, 0.0),
        at(-2.0, -1.0),
        at(-1.0, -2.0),
        at(2.0, 1.0),
        at(1.0, 2.0),
        at(0.0, 3.0),
    ];
    Mesh {
        positions,
        triangles: vec![[0, 1, 2], [0, 3, 4], [0, 4, 5]],
    }
}

#[test]
fn fans_that_meet_in_a_vertex_get_one_each() {
    let mut mesh = butterfly();
    separate_fans(&mut mesh, |_| false);
    assert_eq!(validate(&mesh), Ok(()));
    assert_eq!(mesh.positions.len(), 7);
    assert_eq!(mesh.positions[6], mesh.positions[0]);
    let with_copy: Vec<bool> = mesh.triangles.iter().map(|corners| corners.contains(&6)).collect();
    assert!(
        with_copy == [false, true, true] || with_copy == [true, false, false],
        "{with_copy:?}"
    );
}

#[test]
fn shared_vertices_stay_one() {
    let mut mesh = butterfly();
    separate_fans(&mut mesh, |position| position == DVec3::ZERO);
    assert_eq!(mesh, butterfly());
}

#[test]
fn the_validator_names_the_fault() {
    let with = |triangles: Vec<[u32; 3]>| Mesh {
        triangles,
        ..butterfly()
    };
    assert_eq!(validate(&with(vec![[0, 2, 1]])), Err(MeshError::NotCounterClockwise(0)));
    assert_eq!(validate(&with(vec![[0, 3, 3]])), Err(MeshError::Degenerate(0)));
    assert_eq!(
        validate(&with(vec![[0, 3, 9]])),
        Err(MeshError::IndexOutOfRange {
            triangle: 0,
            vertex: 9,
            count: 6
        })
    );
    assert_eq!(
        validate(&with(vec![[0, 3, 4], [0, 3, 5]])),
        Err(MeshError::NonManifoldEdge(0, 3))
    );
    let mut mesh = butterfly();
    mesh.positions[2].z = f64::NAN;
    assert_eq!(validate(&mesh), Err(MeshError::NotFinite(2)));
}
