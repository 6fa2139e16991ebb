//! Whole archives of real terrain: what they claim is measured again, and a change that breaks a claim is found.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

#[path = "pyramid/country.rs"]
mod country;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use geo::{Area, Coord, LineString, Polygon};
use glam::DVec2;
use tempfile::TempDir;
use terrain_codec::LevelLimits;
use terrain_codec::address::TileAddress;
use terrain_codec::filled::Filled;
use terrain_codec::spt;
use terrain_codec::tile::Tile;
use terrain_core::height_field::reference::Bound;
use terrain_core::height_field::simplify::Quality;
use terrain_ingest::globe::Seen;
use terrain_ingest::raster::Rasters;
use terrain_ingest::store::Store;
use terrain_ingest::stored_raster::StoredRaster;
use terrain_ingest::verify::{ArchiveReport, Violation};
use terrain_ingest::{GeoReference, HeightGrid, Progress, ReadOptions, pyramid, raster, tin, verify};
use terrain_tests::{sample, shared_data};
use terrain_tiles::archive::{Reader, Writer};
use terrain_tiles::ground::{Ground, tile_at};
use terrain_tiles::metadata::{Fill, Reading};

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
