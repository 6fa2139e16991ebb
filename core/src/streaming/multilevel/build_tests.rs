#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::super::LevelView;
use super::super::tests::square;
use super::*;
use crate::levels::collapse_log::{Band, Collapse, CollapseLog};
use crate::mesh::Mesh;

#[test]
fn a_partition_has_the_same_surfaces_as_a_multilevel_mesh() {
    let position = |x: f64, y: f64| glam::DVec3::new(x, y, x * y);
    let fine = Mesh {
        positions: [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (2.0, 2.0), (3.0, 2.0)]
            .map(|(x, y)| position(x, y))
            .to_vec(),
        triangles: square().triangles().to_vec(),
    };
    let keep = |blue, red: u32| Collapse {
        blue,
        red,
        red_before: fine.positions[red as usize],
        red_after: fine.positions[red as usize],
        closes_hole: false,
    };
    let log = CollapseLog {
        collapses: vec![keep(5, 4), keep(4, 0)],
        bands: vec![Band { end: 1, error: 1.0 }, Band { end: 2, error: 2.0 }],
    };
    let partition = SurfacePartition::from_log(&fine, &log, 0.0).unwrap();
    let mesh = MultilevelMesh::from_partition(&partition).unwrap();
    let mut view = LevelView::default();
    for level in 0..3 {
        view.set_level(&mesh, level).unwrap();
        let lod = partition.lod(2 - level);
        assert_eq!(view.triangles(), lod.triangles);
        let positions: Vec<_> = lod.positions.iter().map(|p| p.to_array()).collect();
        assert_eq!(view.positions(), positions);
    }
}

#[test]
fn a_moved_vertex_keeps_its_place_of_the_finest_surface() {
    let fine = Mesh {
        positions: vec![glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y, glam::DVec3::ONE],
        triangles: vec![[0, 1, 2], [2, 1, 3]],
    };
    let collapse = Collapse {
        blue: 3,
        red: 1,
        red_before: glam::DVec3::X,
        red_after: glam::DVec3::X * 2.0,
        closes_hole: false,
    };
    let log = CollapseLog {
        collapses: vec![collapse],
        bands: vec![Band { end: 1, error: 1.0 }],
    };
    let partition = SurfacePartition::from_log(&fine, &log, 0.0).unwrap();
    let mesh = MultilevelMesh::from_partition(&partition).unwrap();
    assert_eq!(mesh.positions()[1], [1.0, 0.0, 0.0]);
}

#[test]
fn arrays_that_are_no_partition_are_refused() {
    let nothing = SurfacePartition::default();
    let refusal = MultilevelMesh::from_partition(&nothing);
    assert!(matches!(refusal, Err(FromPartitionError::Partition(_))), "{refusal:?}");
}
