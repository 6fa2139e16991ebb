#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;
use crate::damage;
use crate::progressive::tests::hills;

fn mesh() -> ProgressiveMesh {
    ProgressiveMesh::quantised(&hills(20), 12).unwrap()
}

#[test]
fn positions_stay_within_half_a_step() {
    let partition = hills(20);
    let mesh = mesh();
    assert_eq!(
        mesh.partition
            .positions
            .iter()
            .fold(0.0_f64, |high, at| high.max(at.max_element())),
        4096.0
    );
    for (at, quantised) in partition.positions.iter().zip(&mesh.in_units().positions) {
        assert!((*at - *quantised).abs().max_element() <= mesh.step.x / 2.0 * 1.000_001);
    }
}

#[test]
fn a_model_comes_back_and_encodes_to_as_many_levels() {
    let mesh = mesh();
    let bytes = encode(&mesh).unwrap();
    let decoded = decode(&bytes, &LevelLimits::default()).unwrap();
    assert_eq!((decoded.origin, decoded.step), (mesh.origin, mesh.step));
    assert_eq!(decoded.partition.levels, mesh.partition.levels);
    assert_eq!(decoded.partition.triangles.len(), 2 * 19 * 19);
}

#[test]
fn levels_that_are_there_are_read_and_the_rest_may_be_missing() {
    let bytes = encode(&mesh()).unwrap();
    let (_, stream) = Head::read(&bytes, &LevelLimits::default()).unwrap();
    let lengths: Vec<usize> = stream.whole().iter().map(|entry| entry.length).collect();
    let end = |levels: usize| bytes.len() - lengths[levels..].iter().sum::<usize>();
    let three = decode_prefix(&bytes[..end(3)], &LevelLimits::default()).unwrap();
    assert_eq!(three.partition.levels, mesh().partition.levels[..3]);
    let all = decode(&bytes, &LevelLimits::default()).unwrap();
    assert_eq!(
        three.partition.lod(1).triangles.len(),
        all.partition.lod(1).triangles.len()
    );
    assert_eq!(
        decode(&bytes[..end(3)], &LevelLimits::default()),
        Err(DecodeError::Truncated(end(3)))
    );
    let cut = decode_prefix(&bytes[..end(1) + lengths[1] / 2], &LevelLimits::default()).unwrap();
    let [first, second] = [0, 1].map(|level| mesh().partition.levels[level]);
    assert!((first.vertex_end + 1..second.vertex_end).contains(&cut.partition.levels[1].vertex_end));
    assert_eq!(
        cut.partition.levels[1].error, first.error,
        "what is cut claims no more than before"
    );
}

/// A torus of `2 · side²` triangles and a closed surface without a plan view.
fn torus(side: u32) -> SurfacePartition {
    let angle = |step: u32| f64::from(step) / f64::from(side) * std::f64::consts::TAU;
    let position = |vertex: u32| {
        let (around, across) = (angle(vertex / side), angle(vertex % side));
        let radius = 3.0 + across.cos();
        DVec3::new(radius * around.cos(), radius * around.sin(), across.sin())
    };
    let number = |x: u32, y: u32| y % side * side + x % side;
    let quads = (0..side * side).map(|quad| (quad % side, quad / side));
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [number(x, y), number(x, y + 1), number(x + 1, y + 1), number(x + 1, y)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let positions: Vec<DVec3> = (0..side * side).map(position).collect();
    SurfacePartition {
        representatives: (0..side * side).collect(),
        blue_positions: positions.clone(),
        positions,
        levels: vec![terrain_core::levels::partition::Level {
            vertex_end: side * side,
            triangle_end: triangles.len() as u32,
            error: 0.0,
        }],
        triangles,
    }
}

/// Six times the volume inside a closed mesh, which tells also whether its triangles look outwards.
fn six_volumes(mesh: &terrain_core::Mesh) -> f64 {
    let at = |corner: u32| mesh.positions[corner as usize];
    mesh.triangles
        .iter()
        .map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))))
        .sum()
}

#[test]
fn a_closed_model_comes_back_from_few_bytes_and_closed_from_a_part_of_them() {
    let mesh = ProgressiveMesh::quantised(&torus(40), 12).unwrap();
    let bytes = encode(&mesh).unwrap();
    let whole = decode(&bytes, &LevelLimits::default()).unwrap().partition.lod(0);
    crate::progressive::tests::assert_same_levels(
        &decode(&bytes, &LevelLimits::default()).unwrap().partition,
        &mesh.partition,
    );
    assert!(bytes.len() < 3 * whole.triangles.len(), "{} bytes", bytes.len());
    let half = decode_prefix(&bytes[..bytes.len() / 2], &LevelLimits::default())
        .unwrap()
        .partition
        .lod(0);
    assert_eq!(
        half.triangles.len(),
        2 * half.positions.len(),
        "closed, with one hole through it"
    );
    let edges = || half.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: std::collections::BTreeSet<[u32; 2]> = edges().collect();
    assert!(all.len() == edges().count() && edges().all(|[a, b]| all.contains(&[b, a])));
    let kept = six_volumes(&half) / six_volumes(&whole);
    assert!((0.8..1.1).contains(&kept), "{kept} of the volume");
}

/// What a whole decoder finds.
fn partition_of(bytes: &[u8]) -> Option<SurfacePartition> {
    Some(decode(bytes, &LevelLimits::default()).ok()?.partition)
}

#[test]
fn damaged_bytes_give_a_model_or_an_error_and_no_panic() {
    damage::hold_with_flipped_bits(&encode(&mesh()).unwrap(), partition_of);
}

#[test]
fn damaged_seeds_of_the_fuzz_target_give_a_model_or_an_error_and_no_panic() {
    let seeds = damage::seeds("spm");
    assert!(!seeds.is_empty(), "the corpus has a mesh");
    damage::hold_with_damaged_seeds(&seeds, partition_of);
}

#[test]
fn counts_above_the_limits_are_refused_before_any_is_made() {
    let bytes = encode(&mesh()).unwrap();
    let limits = |vertices, triangles, levels| LevelLimits {
        vertices,
        triangles,
        levels,
    };
    assert_eq!(
        decode(&bytes, &limits(399, 1 << 20, 99)),
        Err(DecodeError::Limit("the number of vertices"))
    );
    assert_eq!(
        decode(&bytes, &limits(400, 721, 99)),
        Err(DecodeError::Limit("the number of triangles"))
    );
    assert_eq!(
        decode(&bytes, &limits(400, 722, 1)),
        Err(DecodeError::Limit("the number of levels"))
    );
}

#[test]
fn a_lattice_that_is_none_is_refused() {
    let partition = hills(10);
    assert_eq!(
        ProgressiveMesh::quantised(&partition, 32),
        Err(ProgressiveMeshError::Lattice)
    );
    let flat = ProgressiveMesh {
        step: DVec3::new(1.0, 0.0, 1.0),
        ..mesh()
    };
    assert_eq!(encode(&flat), Err(ProgressiveMeshError::Lattice));
}

#[test]
fn a_model_in_space_decodes_to_the_arrays_that_were_recorded() {
    let golden = |name: &str| std::fs::read(format!("{}/golden/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let mesh = decode(&golden("open_torus.spm"), &LevelLimits::default())
        .unwrap()
        .in_units();
    let positions = mesh.positions.iter().chain(&mesh.blue_positions);
    let coordinates = positions.flat_map(|position| position.to_array());
    let mut bytes: Vec<u8> = coordinates.flat_map(f64::to_le_bytes).collect();
    let ends = mesh
        .levels
        .iter()
        .flat_map(|level| [level.vertex_end, level.triangle_end]);
    let indices = mesh.representatives.iter().copied();
    let all = indices.chain(mesh.triangles.as_flattened().iter().copied()).chain(ends);
    bytes.extend(all.flat_map(u32::to_le_bytes));
    assert!(bytes == golden("open_torus.arrays"));
}
