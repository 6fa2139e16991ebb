//! Whole archives of real terrain: what they claim is measured again, and a change that breaks a claim is found.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use geo::{Area, Coord, LineString, Polygon};
use glam::DVec2;
use tempfile::TempDir;
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::Quality;
use terrain_ingest::globe::Seen;
use terrain_ingest::raster::Rasters;
use terrain_ingest::samples::{CoarseWindow, Samples, Window};
use terrain_ingest::store::Store;
use terrain_ingest::stored_raster::StoredRaster;
use terrain_ingest::verify::{ArchiveReport, Violation};
use terrain_ingest::{GeoReference, HeightGrid, Progress, ReadOptions, pyramid, raster, tin, verify};
use terrain_tests::{sample, shared_data};
use terrain_tiles::address::{Side, TileAddress};
use terrain_tiles::archive::{Reader, Writer};
use terrain_tiles::filled::Filled;
use terrain_tiles::formats::LevelLimits;
use terrain_tiles::formats::spt;
use terrain_tiles::ground::{Ground, tile_at};
use terrain_tiles::metadata::{Fill, Reading};
use terrain_tiles::tile::Tile;

const MAX_ERROR: f64 = 10.0;

struct Built {
    folder: TempDir,
    rasters: Rasters,
    grid: HeightGrid,
}

impl Built {
    fn new(files: &[PathBuf], max_error: f64) -> Self {
        Self::reading(files, &Reading::default(), max_error)
    }

    fn reading(files: &[PathBuf], reading: &Reading, max_error: f64) -> Self {
        let mut options = ReadOptions::default();
        options.overrides.reading = reading.clone();
        let built = Self {
            folder: TempDir::new().unwrap(),
            rasters: Rasters::open(files, &options).unwrap(),
            grid: raster::read(files, &options).unwrap(),
        };
        built.build("archive.pmtiles", max_error);
        built
    }

    fn build(&self, name: &str, max_error: f64) {
        let options = pyramid::Options {
            max_error: Some(max_error),
            ..pyramid::Options::default()
        };
        let work = TempDir::new().unwrap();
        let store = Store::open(&work.path().display().to_string()).unwrap();
        let build = pyramid::Build {
            raster: &self.rasters,
            options: &options,
            store: &store,
            earlier: None,
            progress: &Progress::silent(),
        };
        build.run(&self.path(name)).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn verified(&self, name: &str) -> ArchiveReport {
        verify::archive(&self.path(name), (&self.grid).into(), 64 << 20, &Progress::silent()).unwrap()
    }
}

static SAMPLE: LazyLock<Built> = LazyLock::new(|| Built::new(&[sample("jacksboro_fault.tif")], MAX_ERROR));

fn tile(reader: &Reader, address: TileAddress) -> Tile {
    spt::decode(&reader.tile(address).unwrap().unwrap(), &LevelLimits::default()).unwrap()
}

/// Copies an archive, one tile changed on the way.
fn with_change(from: &Path, to: &Path, changed: TileAddress, change: impl Fn(&mut Tile)) {
    let reader = Reader::open(from).unwrap();
    let mut writer = Writer::create(to).unwrap();
    for address in reader.addresses() {
        let mut tile = tile(&reader, address);
        if address == changed {
            change(&mut tile);
        }
        writer.add(address, &spt::encode(&tile).unwrap()).unwrap();
    }
    writer.finish(reader.metadata()).unwrap();
}

#[test]
fn every_claim_of_the_sample_holds_and_the_leaves_keep_the_error_asked_for() {
    let report = SAMPLE.verified("archive.pmtiles");
    assert!(report.holds(), "{report}");
    let leaves = report.zooms.last().unwrap();
    assert_eq!(leaves.zoom, 11);
    assert!(
        leaves.measured_finest <= MAX_ERROR && leaves.measured_finest > 0.9 * MAX_ERROR,
        "{report}"
    );
    for pair in report.zooms.windows(2) {
        assert!(pair[0].triangles <= pair[1].triangles, "{report}");
    }
    assert!(report.shared_sides > 20 && report.mixed_tiles > 20, "{report}");
}

#[test]
fn one_thread_and_four_write_the_same_bytes() {
    let with_threads = |threads: usize, name: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| SAMPLE.build(name, 40.0));
        std::fs::read(SAMPLE.path(name)).unwrap()
    };
    assert!(with_threads(1, "one.pmtiles") == with_threads(4, "four.pmtiles"));
}

#[test]
fn a_vertex_moved_by_more_than_the_bound_is_found_and_its_tile_named() {
    let path = SAMPLE.path("archive.pmtiles");
    let reader = Reader::open(&path).unwrap();
    let address = reader.addresses().filter(|address| address.zoom == 11).nth(9).unwrap();
    with_change(&path, &SAMPLE.path("moved.pmtiles"), address, |tile| {
        let side = f64::from(1_u32 << tile.extent_bits);
        let inside = |p: &glam::DVec3| p.x > 0.2 * side && p.x < 0.8 * side && p.y > 0.2 * side && p.y < 0.8 * side;
        let finest = tile.partition.levels[0].vertex_end as usize;
        let vertex = (0..finest)
            .find(|&vertex| inside(&tile.partition.positions[vertex]))
            .unwrap();
        tile.partition.positions[vertex].z += 64.0;
        tile.partition.blue_positions[vertex].z += 64.0;
    });
    let report = SAMPLE.verified("moved.pmtiles");
    assert!(!report.holds());
    let named = |violation: &verify::Violation| violation.tile == Some(address.to_string());
    assert!(
        report
            .violations
            .iter()
            .any(|violation| named(violation) && violation.what.contains("error")),
        "{report}"
    );
}

#[test]
fn the_surfaces_of_every_zoom_cover_the_raster_once() {
    let reader = Reader::open(&SAMPLE.path("archive.pmtiles")).unwrap();
    let [west, south, east, north] = reader.metadata().bounds;
    let whole = (east - west) * (north - south);
    for zoom in 6..=11 {
        let tiles = reader.addresses().filter(|address| address.zoom == zoom);
        let area: f64 = tiles.map(|address| plan_area(&tile(&reader, address))).sum();
        assert!(
            (area / whole - 1.0).abs() < 1e-4,
            "zoom {zoom}: {area} of {whole} square degrees"
        );
    }
}

/// Square degrees of a tile's finest surface, triangle by triangle.
fn plan_area(tile: &Tile) -> f64 {
    let mesh = tile.surface(tile.finest());
    let corner = |vertex: u32| {
        let geodetic = tile.geodetic(mesh.positions[vertex as usize]);
        Coord {
            x: geodetic.longitude,
            y: geodetic.latitude,
        }
    };
    let polygon = |corners: &[u32; 3]| Polygon::new(LineString::from(corners.map(corner).to_vec()), vec![]);
    mesh.triangles
        .iter()
        .map(|corners| polygon(corners).signed_area())
        .sum()
}

#[test]
fn two_adjacent_tiles_with_a_void_sea_meet_bit_for_bit_and_nest() {
    let files = ["srtm/N51E001.hgt.zip", "srtm/N51E002.hgt.zip"].map(shared_data);
    let [Some(west), Some(east)] = files else { return };
    let built = Built::new(&[west, east], 5.0);
    let report = built.verified("archive.pmtiles");
    assert!(report.holds(), "{report}");
    assert!(report.shared_sides > 500 && report.parents > 100, "{report}");
}

/// Writes a raster in degrees whose rows are `side` samples each; voids are −9999.
fn write_raster(path: &Path, side: usize, cell: f64, corner: [f64; 2], heights: &[f64]) {
    let [left, low] = corner;
    let mut text =
        format!("ncols {side}\nnrows {side}\nxllcorner {left}\nyllcorner {low}\ncellsize {cell}\nNODATA_value -9999\n");
    for row in heights.chunks(side) {
        let row: Vec<String> = row.iter().map(|height| format!("{height:.2}")).collect();
        text.push_str(&(row.join(" ") + "\n"));
    }
    let crs = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]"#;
    std::fs::write(path.with_extension("prj"), crs).unwrap();
    std::fs::write(path, text).unwrap();
}

/// Hills with a thousand voids, each alone or beside a few others.
fn raster_with_voids(folder: &Path) -> PathBuf {
    const SIDE: usize = 320;
    let mut random = fastrand::Rng::with_seed(1);
    let height = |i: usize| {
        let [x, y] = [(i % SIDE) as f64, (i / SIDE) as f64];
        500.0 + 80.0 * (x / 40.0).sin() * (y / 55.0).cos() + 20.0 * (x / 9.0 + y / 13.0).sin()
    };
    let mut heights: Vec<f64> = (0..SIDE * SIDE).map(height).collect();
    for _ in 0..1000 {
        heights[random.usize(2..SIDE - 2) * SIDE + random.usize(2..SIDE - 2)] = -9999.0;
    }
    let path = folder.join("voids.asc");
    write_raster(&path, SIDE, 0.000277777778, [7.0, 46.0], &heights);
    path
}

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
    let is_leaf = |address: TileAddress| !address.children().iter().any(|&child| reader.checksum(child).is_some());
    for leaf in reader.addresses().filter(|&address| is_leaf(address)) {
        for across in Side::ALL.into_iter().filter_map(|side| leaf.neighbour(side)) {
            let standing = reader.standing_for(across);
            assert!(
                standing.is_none_or(|standing| standing.zoom + 1 >= leaf.zoom),
                "{leaf} beside {standing:?}"
            );
        }
    }

    // What the leaves of the country claim is measured: one that is bent is found out.
    let shallow = reader.addresses().find(|&address| is_leaf(address)).unwrap();
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
    let is_leaf = |address: TileAddress| !address.children().iter().any(|&child| reader.checksum(child).is_some());
    let leaf = reader.addresses().find(|&address| is_leaf(address)).unwrap();
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

#[test]
fn a_thousand_voids_are_gone_where_levels_err_by_more_and_that_is_claimed() {
    let folder = TempDir::new().unwrap();
    let built = Built::new(&[raster_with_voids(folder.path())], 5.0);
    let report = built.verified("archive.pmtiles");
    assert!(report.holds(), "{report}");
    let (coarsest, finest) = (&report.zooms[0], &report.zooms[report.zooms.len() - 1]);
    assert!(finest.triangles > 3000, "the leaves have every hole: {report}");
    assert!(coarsest.triangles < 50, "{report}");

    // The claim is what keeps holes open: an archive that claims less of its outlines is found out.
    let reader = Reader::open(&built.path("archive.pmtiles")).unwrap();
    let changed = reader.addresses().find(|address| address.zoom == 6).unwrap();
    with_change(
        &built.path("archive.pmtiles"),
        &built.path("lies.pmtiles"),
        changed,
        |tile| {
            tile.outline_errors.fill(10.0);
        },
    );
    let report = built.verified("lies.pmtiles");
    let of_tile = |what: &str| {
        let mut violations = report.violations.iter();
        violations.any(|violation| violation.tile == Some(changed.to_string()) && violation.what.contains(what))
    };
    assert!(of_tile("the mesh ends where the source does not"), "{report}");
}

#[test]
fn ground_that_was_filled_is_told_apart_from_what_was_measured() {
    let folder = TempDir::new().unwrap();
    let path = raster_with_voids(folder.path());
    let voids: Vec<[f64; 2]> = {
        let grid = raster::read(std::slice::from_ref(&path), &ReadOptions::default()).unwrap();
        let void = (0..grid.heights.len()).filter(|&index| grid.heights[index].is_nan());
        void.map(|index| {
            let sample = DVec2::new((index % grid.columns) as f64, (index / grid.columns) as f64);
            grid.georeference.geographic(sample).to_array()
        })
        .collect()
    };
    let reading = Reading {
        fill: Some(Fill { widest: None }),
        ..Reading::default()
    };
    let built = Built::reading(&[path], &reading, 5.0);
    let verified = |name: &str| {
        let work = TempDir::new().unwrap();
        let store = Store::open(&work.path().display().to_string()).unwrap();
        let stored = StoredRaster::take(&built.rasters, &store, 64 << 20, &Progress::silent()).unwrap();
        verify::archive(&built.path(name), stored.source(), 64 << 20, &Progress::silent()).unwrap()
    };
    let report = verified("archive.pmtiles");
    assert!(report.holds(), "{report}");

    let reader = Reader::open(&built.path("archive.pmtiles")).unwrap();
    let ground = |zoom: u8, [longitude, latitude]: [f64; 2]| {
        let square = tile_at(zoom, longitude, latitude);
        Ground::of(&tile(&reader, reader.standing_for(square).unwrap()))
    };
    let finest = reader.metadata().max_zoom;
    for &[longitude, latitude] in voids.iter().step_by(20) {
        for zoom in [finest, finest - 2] {
            assert!(ground(zoom, [longitude, latitude]).is_filled(longitude, latitude));
        }
    }
    let is_near = |place: [f64; 2]| {
        let apart = |void: &[f64; 2]| (void[0] - place[0]).abs().max((void[1] - place[1]).abs());
        voids.iter().any(|void| apart(void) < 0.0006)
    };
    let mut measured = 0;
    for step in 0..100 {
        let place = [7.002 + 0.0008 * f64::from(step), 46.044];
        if !is_near(place) {
            measured += 1;
            assert!(!ground(finest, place).is_filled(place[0], place[1]), "{place:?}");
        }
    }
    assert!(measured > 20, "{measured} places");

    let leaf = tile_at(finest, voids[0][0], voids[0][1]);
    let lies: [&dyn Fn(&mut Tile); 2] = [&|tile| tile.filled = Filled::default(), &|tile| {
        tile.filled.fill(DVec2::ZERO, DVec2::ONE);
    }];
    for lie in lies {
        with_change(&built.path("archive.pmtiles"), &built.path("lies.pmtiles"), leaf, lie);
        let report = verified("lies.pmtiles");
        let of_leaf = |violation: &&Violation| violation.tile.as_deref() == Some(&*leaf.to_string());
        assert!(
            report.violations.iter().any(|violation| of_leaf(&violation)),
            "{report}"
        );
    }
}

#[test]
fn a_projected_raster_is_certified_on_the_earth() {
    let Some(file) = shared_data("projected/elev_vinschgau_250m_utm32.tif") else {
        return;
    };
    let built = Built::new(&[file], 20.0);
    let report = built.verified("archive.pmtiles");
    assert!(report.holds(), "{report}");
    assert!(report.zooms.last().unwrap().measured_finest <= 20.0, "{report}");
}

/// Waves on samples around the Earth, half a cell from the poles, from a longitude on.
fn around_the_earth(west: f64) -> HeightGrid {
    let (columns, rows, step) = (60, 30, 6.0);
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let height = |(column, row)| {
        let column = (column + (west / step) as usize) % columns;
        100.0 * ((column as f32 / 4.0).sin() + (row as f32 / 3.0).cos()) + column as f32
    };
    let first = DVec2::new(west + step / 2.0, 90.0 - step / 2.0);
    HeightGrid {
        columns,
        rows,
        heights: places.map(height).collect(),
        georeference: GeoReference::wgs84(columns, rows, first, DVec2::new(step, -step)),
    }
}

#[test]
fn a_raster_around_the_earth_is_closed_and_the_same_wherever_it_begins() {
    let folder = TempDir::new().unwrap();
    let built = [0.0, 120.0].map(|west| {
        let grid = around_the_earth(west);
        let store = Store::open(&folder.path().join(format!("work-{west}")).display().to_string()).unwrap();
        let build = pyramid::Build {
            raster: &grid,
            options: &pyramid::Options::default(),
            store: &store,
            earlier: None,
            progress: &Progress::silent(),
        };
        let path = folder.path().join(format!("from-{west}.pmtiles"));
        build.run(&path).unwrap();
        let seen = Seen::new(&grid);
        let stored = StoredRaster::take(seen.raster(), &store, 64 << 20, &Progress::silent()).unwrap();
        let report = verify::archive(&path, stored.source(), 64 << 20, &Progress::silent()).unwrap();
        assert!(report.holds(), "{report}");
        path
    });
    let reader = Reader::open(&built[0]).unwrap();
    assert_eq!(reader.metadata().bounds, [-180.0, -90.0, 180.0, 90.0]);
    let areas = reader.addresses().filter(|address| address.zoom == 0);
    let area: f64 = areas.map(|address| plan_area(&tile(&reader, address))).sum();
    assert!((area / (360.0 * 180.0) - 1.0).abs() < 1e-9, "{area} square degrees");
    let [a, b] = built.map(|path| std::fs::read(path).unwrap());
    assert!(a == b);
}

#[test]
fn one_mesh_keeps_its_error_at_the_samples_where_that_is_what_was_asked() {
    let output = SAMPLE.path("mesh.obj");
    let options = tin::Options {
        max_error: 20.0,
        bound: Bound::Samples,
        quality: Quality::Default,
        breaklines: Vec::new(),
    };
    let report = tin::run(&SAMPLE.grid, &options, &output, &Progress::silent()).unwrap();
    let measured = verify::mesh(&output, (&SAMPLE.grid).into(), None, 64 << 20).unwrap();
    assert!(measured.holds(), "{measured}");
    assert!(
        measured.measured_at_samples <= 20.0 && measured.measured_between_samples > 20.0,
        "{measured}"
    );
    assert!(report.triangles < 12_000, "{}", report.triangles);
}
