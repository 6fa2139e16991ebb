#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::fmt::Write;
use std::fs;

use glam::DVec3;

use super::*;
use crate::georeference::GeoReference;
use crate::height_grid::HeightGrid;

const MEMORY: u64 = 1 << 20;

fn measured(mesh: &Drawing, grid: &HeightGrid, claim: &Claim) -> MeshReport {
    check(mesh, &grid.into(), claim, 4).unwrap()
}

/// A sloping plane over 9 × 9 samples in degrees, north up.
fn plane() -> HeightGrid {
    HeightGrid {
        columns: 9,
        rows: 9,
        heights: (0_u8..81)
            .map(|index| f32::from(index % 9) * 3.0 + f32::from(index / 9) * 5.0)
            .collect(),
        georeference: GeoReference::wgs84(9, 9, DVec2::new(7.0, 46.0), DVec2::new(0.25, -0.25)),
    }
}

/// Four triangles around the middle sample.
fn fan() -> Drawing {
    let corner = |column: f64, row: f64| DVec3::new(7.0 + column * 0.25, 46.0 - row * 0.25, column * 3.0 + row * 5.0);
    Drawing {
        positions: vec![
            corner(0.0, 0.0),
            corner(8.0, 0.0),
            corner(8.0, 8.0),
            corner(0.0, 8.0),
            corner(4.0, 4.0),
        ],
        triangles: vec![[1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]],
    }
}

fn claim(error: f64) -> Claim {
    Claim {
        error,
        bound: "surface".to_owned(),
    }
}

#[test]
fn a_plane_is_measured_as_a_plane() {
    let report = measured(&fan(), &plane(), &claim(0.0));
    assert!(report.holds(), "{report}");
    assert!(report.measured_between_samples < 1e-9, "{report}");
}

#[test]
fn a_vertex_moved_by_twice_the_claim_is_found() {
    let mut mesh = fan();
    mesh.positions[4].z += 2.0;
    let report = measured(&mesh, &plane(), &claim(1.0));
    assert!(!report.holds());
    assert!((report.measured_at_samples - 2.0).abs() < 1e-9, "{report}");
    assert_eq!(report.violations[0].place, Some([8.0, 45.0]));
    assert!(measured(&mesh, &plane(), &claim(2.0)).holds());
}

#[test]
fn a_missing_triangle_leaves_samples_uncovered() {
    let mut mesh = fan();
    mesh.triangles.pop();
    let report = measured(&mesh, &plane(), &claim(1.0));
    // Column 0 has 7 samples inside, columns 1, 2 and 3 have 5, 3 and 1 off the diagonals, which other triangles share.
    assert_eq!(
        report.violations[0].what,
        "16 samples that no triangle covers, the first"
    );
}

#[test]
fn a_covered_void_is_found_and_its_cells_are_no_surface() {
    let mut grid = plane();
    grid.heights[2 * 9 + 4] = f32::NAN;
    let report = measured(&fan(), &grid, &claim(1.0));
    assert_eq!(report.violation_count, 1, "{report}");
    assert_eq!(report.violations[0].what, "1 voids that a triangle covers, the first");
}

#[test]
fn a_triangle_turned_over_is_no_surface() {
    let mut mesh = fan();
    mesh.triangles[2].swap(0, 1);
    assert!(
        measured(&mesh, &plane(), &claim(1.0)).violations[0]
            .what
            .starts_with("is no surface")
    );
}

#[test]
fn ply_and_obj_say_what_they_claim() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = fan();
    let mut ply = "ply\nformat ascii 1.0\ncomment terrain-ingest certified error 0.25 bound surface\n\
        element vertex 5\nproperty double x\nproperty double y\nproperty double z\n\
        element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        .to_owned();
    let mut obj = "# terrain-ingest certified error 0.25 bound surface\n".to_owned();
    for p in &mesh.positions {
        writeln!(ply, "{} {} {}", p.x, p.y, p.z).unwrap();
        writeln!(obj, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(ply, "3 {a} {b} {c}").unwrap();
        writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    for (name, text) in [("mesh.ply", ply), ("mesh.obj", obj)] {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let report = super::mesh(&path, (&plane()).into(), None, MEMORY).unwrap();
        assert!(report.holds(), "{name}: {report}");
        assert_eq!(
            (report.claimed, report.vertices, report.triangles),
            (0.25, 5, 4),
            "{name}"
        );
    }
}

#[test]
fn files_that_are_no_meshes_or_claim_nothing_are_errors_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("empty.ply", "", "not a readable mesh"),
        (
            "quads.obj",
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
            "not a readable mesh",
        ),
        ("nothing.obj", "# nothing\n", "has no triangles"),
        ("mesh.stl", "solid", "not a .ply or .obj file"),
    ];
    for (name, text, expected) in cases {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let error = super::mesh(&path, (&plane()).into(), Some(claim(1.0)), MEMORY)
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{name}: {error}");
        let error = super::mesh(&path, (&plane()).into(), None, MEMORY)
            .unwrap_err()
            .to_string();
        assert!(error.contains("claims no error"), "{name}: {error}");
    }
}
