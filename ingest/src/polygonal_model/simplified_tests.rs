#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use glam::DVec3;
use terrain_core::levels::collapse_log::{Band, Collapse};

use super::*;

/// A flat square of 4 × 4 vertices.
fn square() -> Mesh {
    let cell = |corner: u32| [[corner, corner + 1, corner + 5], [corner, corner + 5, corner + 4]];
    Mesh {
        positions: (0..16)
            .map(|at| DVec3::new(f64::from(at % 4), f64::from(at / 4), 0.0))
            .collect(),
        triangles: (0..3).flat_map(|y| (0..3).flat_map(move |x| cell(4 * y + x))).collect(),
    }
}

/// A collapse along an edge that moves the vertex that stays from one height to another, and is a band.
fn collapse_with(log: &mut CollapseLog, mesh: &Mesh, [blue, red]: [u32; 2], heights: [f64; 2]) {
    let [red_before, red_after] = heights.map(|height| mesh.positions[red as usize].with_z(height));
    log.collapses.push(Collapse {
        blue,
        red,
        red_before,
        red_after,
        closes_hole: false,
    });
    log.bands.push(Band {
        end: log.collapses.len(),
        error: 0.0,
    });
}

#[test]
fn a_level_claims_no_less_than_a_finer_one_that_is_worse() {
    let mesh = square();
    let mut log = CollapseLog::default();
    collapse_with(&mut log, &mesh, [5, 6], [0.0, 0.5]);
    collapse_with(&mut log, &mesh, [9, 6], [0.5, 0.0]);
    let mut leveled = LeveledModel {
        partition: SurfacePartition::from_log(&mesh, &log, 0.0).unwrap(),
        columns: Vec::new(),
        lattice: None,
    };
    certify_levels(&mut leveled, &SurfaceTree::new(&mesh), &Progress::silent());
    let claims: Vec<f64> = leveled.partition.levels.iter().map(|level| level.error).collect();
    assert_eq!(claims.len(), 3);
    assert!(
        (0.5..0.51).contains(&claims[1]),
        "the vertex stands half a unit out: {claims:?}"
    );
    assert_eq!(claims, [claims[1], claims[1], 0.0]);
}
