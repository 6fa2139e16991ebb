//! A site in its country: rasters of very different cells in one archive.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use tempfile::TempDir;
use terrain_codec::address::{Side, TileAddress};
use terrain_ingest::samples::{CoarseWindow, Samples, Window};
use terrain_ingest::store::Store;
use terrain_ingest::stored_raster::StoredRaster;
use terrain_ingest::verify::Violation;
use terrain_ingest::{Progress, verify};
use terrain_tiles::archive::Reader;
use terrain_tiles::ground::{Ground, tile_at};
use terrain_tiles::metadata::Reading;

use super::{Built, tile, with_change, write_raster};

/// A site of fine cells, with voids, in a country of `across` × `across` cells sixteen times longer that has a lake without heights.
fn site_and_country(folder: &Path, across: usize) -> [PathBuf; 2] {
    const CELL: f64 = 0.0001;
    let hills =
        |[x, y]: [f64; 2]| 700.0 + 90.0 * (x / 0.021).sin() * (y / 0.034).cos() + 25.0 * (x / 0.006 + y / 0.009).sin();
    let heights = |side: usize, cell: f64, rough: f64, is_void: &dyn Fn(usize, usize) -> bool| {
        let height = |i: usize| {
            let (column, row) = (i % side, i / side);
            let bumps = rough * (column as f64 / 3.0).sin() * (row as f64 / 4.0).cos();
            let place = [column, side - row].map(|index| index as f64 * cell);
            if is_void(column, row) {
                -9999.0
            } else {
                hills(place) + bumps
            }
        };
        (0..side * side).map(height).collect::<Vec<f64>>()
    };
    let [site, country] = ["site.asc", "country.asc"].map(|name| folder.join(name));
    let fine = heights(96, CELL, 4.0, &|column, row| row == 40 && column < 20);
    write_raster(&site, 96, CELL, [8.0371, 46.0432], &fine);
    let coarse = heights(across, 16.0 * CELL, 0.0, &|column, row| {
        (10..14).contains(&row) && (35..41).contains(&column)
    });
    write_raster(&country, across, 16.0 * CELL, [8.0, 46.0], &coarse);
    [site, country]
}

#[test]
fn a_country_is_no_deeper_than_its_cells_are_worth_around_a_site_in_it() {
    let folder = TempDir::new().unwrap();
    let [site, country] = site_and_country(folder.path(), 56);
    let built = Built::new(&[site.clone(), country], 1.0);
    let report = built.verified("archive.pmtiles");
    assert!(report.holds(), "{report}");

    let reader = Reader::open(&built.path("archive.pmtiles")).unwrap();
    let metadata = reader.metadata();
    assert!(metadata.has_leaves_above());
    let alone = Built::new(&[site], 1.0);
    let deepest_alone = Reader::open(&alone.path("archive.pmtiles"))
        .unwrap()
        .metadata()
        .max_zoom;
    assert_eq!(metadata.max_zoom, deepest_alone);
    let of_zoom = |zoom: u8| reader.addresses().filter(|address| address.zoom == zoom).count();
    assert!(
        2 * of_zoom(metadata.max_zoom) < 16 * of_zoom(metadata.max_zoom - 2),
        "{report}"
    );
    // Each leaf errs by what is asked, or by an eighth of the coarse cells of 178 m, and says so.
    for zoom in metadata.zooms.iter().filter(|zoom| zoom.leaves > 0) {
        let zooms_up = metadata.max_zoom - zoom.zoom;
        assert!(zooms_up <= 4, "{report}");
        assert!(zoom.leaf_error <= f64::from(1 << zooms_up) * 1.001, "{report}");
    }
    for leaf in reader.addresses().filter(|&address| is_leaf(&reader, address)) {
        for across in Side::ALL.into_iter().filter_map(|side| leaf.neighbour(side)) {
            let standing = reader.standing_for(across);
            assert!(
                standing.is_none_or(|standing| standing.zoom + 1 >= leaf.zoom),
                "{leaf} beside {standing:?}"
            );
        }
    }

    // What the leaves of the country claim is measured: one that is bent is found out.
    let shallow = reader.addresses().find(|&address| is_leaf(&reader, address)).unwrap();
    assert!(shallow.zoom < metadata.max_zoom);
    with_change(
        &built.path("archive.pmtiles"),
        &built.path("bent.pmtiles"),
        shallow,
        |tile| {
            for height in [&mut tile.partition.positions, &mut tile.partition.blue_positions] {
                height.iter_mut().for_each(|position| position.z += 64.0);
            }
        },
    );
    let report = built.verified("bent.pmtiles");
    assert!(!report.holds());
}

/// Samples of a raster, and how many were read; what they follow from is only told if asked for.
struct Counted<'a> {
    samples: &'a dyn Samples,
    tells: bool,
    read: AtomicUsize,
}

impl Samples for Counted<'_> {
    fn size(&self) -> [usize; 2] {
        self.samples.size()
    }

    fn window(&self, columns: Range<usize>, rows: Range<usize>) -> anyhow::Result<Window> {
        let window = self.samples.window(columns, rows)?;
        self.read.fetch_add(window.heights.len(), Ordering::Relaxed);
        Ok(window)
    }

    fn filled(&self, columns: Range<usize>, rows: Range<usize>) -> anyhow::Result<Option<Vec<[usize; 2]>>> {
        self.samples.filled(columns, rows)
    }

    fn may_hold(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        self.samples.may_hold(columns, rows)
    }

    fn is_coarse(&self, columns: Range<usize>, rows: Range<usize>) -> bool {
        self.tells && self.samples.is_coarse(columns, rows)
    }

    fn coarse(&self, columns: Range<usize>, rows: Range<usize>) -> anyhow::Result<Option<Box<dyn CoarseWindow + '_>>> {
        if self.tells {
            self.samples.coarse(columns, rows)
        } else {
            Ok(None)
        }
    }
}

#[test]
fn few_samples_of_a_country_show_all_that_every_one_on_the_lattice_of_a_site_does() {
    let folder = TempDir::new().unwrap();
    let built = Built::new(&site_and_country(folder.path(), 120), 1.0);
    let reader = Reader::open(&built.path("archive.pmtiles")).unwrap();
    let leaf = reader.addresses().find(|&address| is_leaf(&reader, address)).unwrap();
    with_change(
        &built.path("archive.pmtiles"),
        &built.path("moved.pmtiles"),
        leaf,
        |tile| {
            let middle = f64::from(1_u32 << tile.extent_bits) / 2.0;
            let finest = tile.partition.levels[0].vertex_end as usize;
            let from_middle = |vertex: &usize| {
                let at = tile.partition.positions[*vertex];
                (at.x - middle).abs().max((at.y - middle).abs())
            };
            let vertex = (0..finest)
                .min_by(|a, b| from_middle(a).total_cmp(&from_middle(b)))
                .unwrap();
            tile.partition.positions[vertex].z += 48.0;
            tile.partition.blue_positions[vertex].z += 48.0;
        },
    );

    let store = Store::open(&folder.path().join("store").display().to_string()).unwrap();
    let stored = StoredRaster::take(&built.rasters, &store, 1 << 28, &Progress::silent()).unwrap();
    let verified = |name: &str, tells: bool| {
        let source = stored.source();
        let counted = Counted {
            samples: source.samples,
            tells,
            read: AtomicUsize::new(0),
        };
        let source = verify::Source {
            samples: &counted,
            ..source
        };
        let report = verify::archive(&built.path(name), source, 8 << 20, &Progress::silent()).unwrap();
        (report, counted.read.into_inner())
    };
    let (few, read) = verified("archive.pmtiles", true);
    let (every, all) = verified("archive.pmtiles", false);
    assert!(few.holds() && every.holds(), "{few} {every}");
    assert!(3 * read < 2 * all, "{read} of {all}");
    for (few, every) in few.zooms.iter().zip(&every.zooms) {
        let pairs = [
            (few.measured_finest, every.measured_finest),
            (few.measured_coarsest, every.measured_coarsest),
            (few.measured_outline, every.measured_outline),
        ];
        for (few, every) in pairs {
            assert!((few - every).abs() < 0.01, "{few} m of {every} m");
        }
    }
    let (moved, _) = verified("moved.pmtiles", true);
    let is_found = |violation: &Violation| violation.tile.as_deref() == Some(&leaf.to_string());
    assert!(moved.violations.iter().any(is_found), "{moved}");
}

fn is_leaf(reader: &Reader, address: TileAddress) -> bool {
    !address.children().iter().any(|&child| reader.checksum(child).is_some())
}

/// Height of an archive's finest surface at degrees.
fn height_at(reader: &Reader, [longitude, latitude]: [f64; 2]) -> Option<f64> {
    let square = tile_at(reader.metadata().max_zoom, longitude, latitude);
    let tile = tile(reader, reader.standing_for(square)?);
    Ground::of(&tile).height(longitude, latitude)
}

#[test]
fn an_archive_lies_under_a_site_as_its_own_rasters_would() {
    let folder = TempDir::new().unwrap();
    let [site, country] = site_and_country(folder.path(), 56);
    let below = Built::new(std::slice::from_ref(&country), 1.0);
    let archive = below.path("archive.pmtiles");
    let reading = |underlay: &Path| Reading {
        underlay: vec![underlay.display().to_string()],
        around: Some(1200.0),
        ..Reading::default()
    };
    let over_archive = Built::reading(std::slice::from_ref(&site), &reading(&archive), 1.0);
    let report = over_archive.verified("archive.pmtiles");
    assert!(report.holds(), "{report}");

    let over_raster = Built::reading(&[site], &reading(&country), 1.0);
    let [under, one, other] =
        [&below, &over_archive, &over_raster].map(|built| Reader::open(&built.path("archive.pmtiles")).unwrap());
    // Beside the site: what the archive claims, and what both are made with.
    let most = under.metadata().finest_error(under.metadata().max_zoom) + 2.0;
    let mut found = 0;
    for step in 0..40 {
        let place = [8.0371 - 0.009 + 0.0002 * f64::from(step), 46.045];
        if let [Some(one), Some(other)] = [&one, &other].map(|reader| height_at(reader, place)) {
            found += 1;
            assert!((one - other).abs() < most, "{place:?}: {one} {other}");
        }
    }
    assert!(found > 20, "{found} places");
    // In the site, what is below does not count.
    let place = [8.0421, 46.0492];
    let [one, other] = [&one, &other].map(|reader| height_at(reader, place).unwrap());
    assert!((one - other).abs() < 2.0, "{one} {other}");
}
