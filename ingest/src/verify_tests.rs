#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

#[path = "verify/fixture_tests.rs"]
pub(in crate::verify) mod fixture;
#[path = "verify/format_tests.rs"]
mod format;

use terrain_codec::spt;
use terrain_tiles::archive::Writer;

use self::fixture::{LEAF, ROOT, Sample};
use super::*;

fn verify(sample: &Sample) -> ArchiveReport {
    check(sample, (&sample.grid).into(), 512, &Progress::silent()).unwrap()
}

/// Whether some violation names `tile` and says `what`.
fn names(report: &ArchiveReport, tile: TileAddress, what: &str) -> bool {
    let tile = tile.to_string();
    report
        .violations
        .iter()
        .any(|found| found.tile.as_deref() == Some(&tile) && found.what.contains(what))
}

#[test]
fn a_true_archive_of_a_plane_holds() {
    let report = verify(&Sample::new());
    assert!(report.holds(), "{report}");
    assert_eq!(report.zooms.iter().map(|zoom| zoom.tiles).collect::<Vec<_>>(), [1, 4]);
    assert_eq!((report.shared_sides, report.parents), (4, 1));
    assert!(report.mixed_tiles >= 12, "{report}");
    let leaves = &report.zooms[1];
    assert!(
        leaves.measured_finest > 1e-6 && leaves.measured_finest < 0.002,
        "{report}"
    );
    assert!(
        (leaves.measured_coarsest - fixture::HEIGHT_STEP).abs() < 0.002,
        "{report}"
    );
}

#[test]
fn an_archive_on_disk_holds_and_says_so_in_json() {
    let sample = Sample::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plane.pmtiles");
    let mut writer = Writer::create(&path).unwrap();
    for tile in sample.tiles.values() {
        writer.add(tile.address, &spt::encode(tile).unwrap()).unwrap();
    }
    writer.finish(&sample.metadata).unwrap();
    let report = archive(&path, (&sample.grid).into(), 1 << 20, &Progress::silent()).unwrap();
    assert!(report.holds(), "{report}");
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["zooms"][1]["tiles"], 4);
    assert_eq!(json["violation_count"], 0);
    assert!(report.to_string().contains("verified: "));
}

#[test]
fn a_header_that_lies_about_heights_fails() {
    let sample = Sample::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plane.pmtiles");
    let mut writer = Writer::create(&path).unwrap();
    for tile in sample.tiles.values() {
        let mut bytes = spt::encode(tile).unwrap();
        bytes[20] += u8::from(tile.address == LEAF);
        writer.add(tile.address, &bytes).unwrap();
    }
    writer.finish(&sample.metadata).unwrap();
    let report = archive(&path, (&sample.grid).into(), 1 << 20, &Progress::silent()).unwrap();
    assert!(names(&report, LEAF, "says its heights are"), "{report}");
}

#[test]
fn a_vertex_moved_by_twice_the_bound_fails_and_names_the_tile() {
    let mut sample = Sample::new();
    let finest = sample.vertex_at(LEAF, 3, 5);
    sample.tile_mut(LEAF).partition.positions[finest].z += 2.0 * fixture::CLAIMED;
    let report = verify(&sample);
    assert!(names(&report, LEAF, "vertical error"), "{report}");
    let violation = report.violations.iter().find(|v| v.what == "vertical error").unwrap();
    assert!(
        (violation.measured.unwrap() - 2.0 * fixture::CLAIMED).abs() < 0.01,
        "{violation}"
    );
    assert!(report.to_string().contains("FAILED: "));
}

#[test]
fn a_saddle_between_samples_fails_for_the_surface_and_holds_for_the_samples() {
    let mut sample = Sample::of(|column, row| if (column, row) == (4, 5) { 6.0 } else { 0.0 });
    let report = verify(&sample);
    // The twist of 6 m deviates by 1.5 m in the middle of the diagonal of a cell.
    assert!(names(&report, LEAF, "vertical error"), "{report}");
    let finest = report.zooms[1].measured_finest;
    assert!((finest - 1.5).abs() < 0.01, "{finest}");
    sample.metadata.bound = "samples".to_owned();
    let report = verify(&sample);
    assert!(report.zooms[1].measured_finest < 0.002, "{report}");
}

#[test]
fn a_t_junction_between_neighbours_fails() {
    let mut sample = Sample::new();
    // Sample (8, 5) is on the side that the tile shares with its eastern neighbour. A step of height is well within the
    // claimed error, and yet a gap.
    let vertex = sample.vertex_at(LEAF, 8, 5);
    sample.tile_mut(LEAF).partition.positions[vertex].z += fixture::HEIGHT_STEP;
    let report = verify(&sample);
    assert!(names(&report, LEAF, "are not shared with tile 1/3/1"), "{report}");
    assert!(
        report
            .violations
            .iter()
            .any(|violation| violation.what.contains("in mix")),
        "{report}"
    );
    assert!(!names(&report, LEAF, "vertical error"), "{report}");
}

#[test]
fn nesting_broken_by_one_height_step_fails() {
    let mut sample = Sample::new();
    let vertex = sample.vertex_at(ROOT, 3, 3);
    sample.tile_mut(ROOT).partition.positions[vertex].z += fixture::HEIGHT_STEP;
    let report = verify(&sample);
    assert!(names(&report, LEAF, "are not in its parent's finest"), "{report}");
    assert_eq!(report.violation_count, 1, "{report}");
}

#[test]
fn a_hole_fails_by_the_outline() {
    let mut sample = Sample::new();
    let inner = sample.vertex_at(LEAF, 5, 3) as u32;
    let tile = sample.tile_mut(LEAF);
    let hole = tile
        .partition
        .triangles
        .iter()
        .position(|triangle| triangle.contains(&inner))
        .unwrap();
    tile.partition.triangles.remove(hole);
    for level in &mut tile.partition.levels {
        level.triangle_end -= u32::from(level.triangle_end as usize > hole);
    }
    let report = verify(&sample);
    assert!(
        names(&report, LEAF, "the mesh ends where the source does not"),
        "{report}"
    );
}

#[test]
fn a_void_of_the_source_may_not_be_covered_but_may_be_a_hole() {
    let mut sample = Sample::new();
    sample.grid.heights[5 * fixture::SAMPLES + 4] = f32::NAN;
    let report = verify(&sample);
    assert!(
        names(&report, LEAF, "the mesh ends where the source does not"),
        "{report}"
    );
    let report = verify(&Sample::with_void(4, 5));
    assert!(report.holds(), "{report}");
}

/// Four voids: no post of theirs is further than a cell from the edge of what they leave out, but the middle is one and a half.
#[test]
fn a_hole_that_is_closed_is_measured_by_its_middle() {
    let violated = |claimed_cells: f64| {
        let mut sample = Sample::new();
        for post in [5, 6].map(|row| row * fixture::SAMPLES) {
            sample.grid.heights[post + 3..post + 5].fill(f32::NAN);
        }
        let cell = sample.grid.georeference.cell_metres(glam::DVec2::new(3.0, 5.0));
        for tile in sample.tiles.values_mut() {
            tile.outline_errors.fill(claimed_cells * cell.max_element());
        }
        names(&verify(&sample), LEAF, "the mesh ends where the source does not")
    };
    assert!(violated(1.4));
    assert!(!violated(1.51));
}

#[test]
fn samples_that_the_mesh_leaves_out_are_measured_from_its_outline() {
    let mut sample = Sample::with_void(4, 5);
    sample.grid.heights[5 * fixture::SAMPLES + 4] = 0.0;
    let report = verify(&sample);
    let of_leaf = |violation: &&Violation| violation.tile.as_deref() == Some("1/2/1");
    let violation = report
        .violations
        .iter()
        .filter(of_leaf)
        .find(|v| v.what.contains("a sample left out"))
        .unwrap();
    let cell = sample
        .grid
        .georeference
        .cell_metres(glam::DVec2::new(4.0, 5.0))
        .min_element();
    let measured = violation.measured.unwrap();
    assert!(
        (measured / cell - 1.0).abs() < 1e-3,
        "{measured} m with cells of {cell} m"
    );
}

#[test]
fn a_missing_tile_a_missing_parent_and_wrong_metadata_fail() {
    let mut sample = Sample::new();
    sample.tiles.remove(&LEAF);
    let report = verify(&sample);
    assert!(names(&report, LEAF, "is not in the archive"), "{report}");
    assert!(names(&report, ROOT, "none of its children"), "{report}");
    assert!(
        report
            .violations
            .iter()
            .any(|violation| violation.what.contains("4 tiles instead of 3")),
        "{report}"
    );

    let mut sample = Sample::new();
    sample.tiles.remove(&ROOT);
    assert!(names(&verify(&sample), LEAF, "has no parent"));

    let mut sample = Sample::new();
    sample.metadata.zooms[1].finest_error /= 2.0;
    let report = verify(&sample);
    assert_eq!(report.violations[0].what, "metadata: finest error of zoom 1");
}

#[test]
fn coarse_sides_that_are_not_the_parents_fail() {
    let mut sample = Sample::new();
    for address in [LEAF, TileAddress { x: 3, ..LEAF }] {
        let vertex = sample.vertex_at(address, 8, 7);
        sample.tile_mut(address).partition.positions[vertex].z += fixture::HEIGHT_STEP;
    }
    let report = verify(&sample);
    assert!(names(&report, LEAF, "are not in its parent's finest"), "{report}");
    assert!(
        !report
            .violations
            .iter()
            .any(|violation| violation.what.contains("are not shared")),
        "{report}"
    );
}

#[test]
fn bounds_and_heights_of_the_metadata_must_hold_the_source() {
    let mut sample = Sample::new();
    sample.metadata.heights[1] = 20.0;
    assert_eq!(
        verify(&sample).violations[0].what,
        "metadata: a sample is outside its heights"
    );
    let mut sample = Sample::new();
    sample.metadata.bounds[2] = 90.0;
    assert_eq!(
        verify(&sample).violations[0].what,
        "metadata: a sample is outside its bounds"
    );
}

#[test]
fn a_tile_that_is_nonsense_is_named_and_not_measured() {
    let mut sample = Sample::new();
    sample.tile_mut(LEAF).partition.positions[3].x = -1.0;
    assert!(names(&verify(&sample), LEAF, "off its lattice"));
    let mut sample = Sample::new();
    sample.tile_mut(LEAF).extent_bits = 60;
    assert!(names(&verify(&sample), LEAF, "lattice of 61 bits"));
    let mut sample = Sample::new();
    sample.tile_mut(LEAF).extent_bits = 25;
    let report = verify(&sample);
    assert!(
        report
            .violations
            .iter()
            .any(|violation| violation.what.contains("different lattices")),
        "{report}"
    );
}
