//! The ellipsoid and grid positions against GeographicLib.

use std::fmt::Debug;
use std::fs;
use std::path::Path;

use glam::{DAffine2, DMat2, DMat3, DVec2, DVec3};
use terrain_codec::ellipsoid::{self, Geodetic};
use terrain_ingest::georeference::{Crs, GeoReference};
use terrain_ingest::raster;
use terrain_tests::{geographiclib, random_numbers};

/// The largest of many differences, which is printed at the end.
struct Worst {
    what: &'static str,
    limit: f64,
    count: usize,
    metres: f64,
}

impl Worst {
    fn of(what: &'static str, limit: f64) -> Self {
        let (count, metres) = (0, 0.0);
        Self {
            what,
            limit,
            count,
            metres,
        }
    }

    fn take(&mut self, metres: f64, at: impl Debug) {
        let Self { what, limit, .. } = self;
        assert!(metres < *limit, "{what}: {metres} m off at {at:?}");
        self.count += 1;
        self.metres = self.metres.max(metres);
    }
}

impl Drop for Worst {
    fn drop(&mut self) {
        let Self { what, count, .. } = self;
        println!("{what}: {count} points agree to {:.6} µm", self.metres * 1e6);
    }
}

/// Points all over the Earth, from the deep sea to a low orbit, poles and antimeridian included.
fn points() -> Vec<Geodetic> {
    let mut numbers = random_numbers(1);
    let mut next = move || numbers.next().unwrap_or_default();
    let mut points: Vec<Geodetic> = (0..20_000)
        .map(|index| Geodetic {
            longitude: next() * 360.0 - 180.0,
            latitude: (next() * 2.0 - 1.0).asin().to_degrees(),
            height: if index % 4 == 0 {
                next() * 500_000.0
            } else {
                next() * 20_000.0 - 11_000.0
            },
        })
        .collect();
    for latitude in [-90.0, -89.999_999, -45.0, 0.0, 1e-9, 89.999_999_9, 90.0] {
        for longitude in [-180.0, -90.0, 0.0, 1e-12, 90.0, 180.0] {
            points.push(Geodetic {
                longitude,
                latitude,
                height: 100.0,
            });
        }
    }
    points
}

/// Metres on the ground between two longitudes at a latitude, in degrees.
fn ground(longitude_difference: f64, latitude: f64) -> f64 {
    let wrapped = longitude_difference - (longitude_difference / 360.0).round() * 360.0;
    wrapped.to_radians() * ellipsoid::SEMI_MAJOR * latitude.to_radians().cos()
}

#[test]
fn earth_centred_positions_agree_to_ten_nanometres() {
    let mut worst = Worst::of("geodetic to Earth-centred", 1e-8);
    for point in points() {
        let (expected, _) = geographiclib::to_earth_centred(point);
        worst.take((ellipsoid::to_earth_centred(point) - expected).length(), point);
    }
}

#[test]
fn geodetic_coordinates_agree_to_ten_nanometres() {
    let mut worst = Worst::of("Earth-centred to geodetic", 1e-8);
    for point in points() {
        let (position, _) = geographiclib::to_earth_centred(point);
        let (ours, theirs) = (ellipsoid::to_geodetic(position), geographiclib::to_geodetic(position));
        let north = (ours.latitude - theirs.latitude).to_radians() * ellipsoid::SEMI_MAJOR;
        let east = ground(ours.longitude - theirs.longitude, theirs.latitude);
        let error = DVec3::new(east, north, ours.height - theirs.height).abs().max_element();
        worst.take(error, (point, ours, theirs));
    }
}

#[test]
fn local_frames_agree() {
    for point in points() {
        let (_, expected) = geographiclib::to_earth_centred(point);
        let ours = ellipsoid::east_north_up(point.longitude, point.latitude);
        let difference: DMat3 = ours - expected;
        let error = difference
            .to_cols_array()
            .into_iter()
            .fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        assert!(error < 1e-15, "{point:?}: axes are {error} off");
        let up = ellipsoid::normal(point.longitude, point.latitude);
        assert!((up - expected.z_axis).length() < 1e-15, "{point:?}");
    }
}

#[test]
#[expect(clippy::unwrap_used, reason = "tests fail by panicking")]
fn a_utm_raster_is_where_geographiclib_says() {
    let crs = Crs {
        name: "EPSG:32631".to_owned(),
        definition: "EPSG:32631".to_owned(),
    };
    let matrix = DMat2::from_diagonal(DVec2::new(90.0, -90.0));
    let to_crs = DAffine2::from_mat2_translation(matrix, DVec2::new(657_641.0, 4_987_332.0));
    let (columns, rows) = (922, 1262);
    let georeference = GeoReference::new(&crs, to_crs, columns, rows).unwrap();
    let mut numbers = random_numbers(2);
    let mut worst = Worst::of("positions between the nodes of a table", 1e-5);
    for _ in 0..5_000 {
        let fraction = DVec2::new(numbers.next().unwrap(), numbers.next().unwrap());
        let grid = fraction * DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0);
        let expected = geographiclib::from_utm(31, true, to_crs.transform_point2(grid));
        let metres = geographiclib::distance(georeference.geographic(grid), expected);
        worst.take(metres, grid);
        let cells = (georeference.grid(expected) - grid).length();
        assert!(cells < 1e-7, "{grid} comes back {cells} cells off");
    }
}

/// Samples a side of a small raster that is put at many places, and metres between them.
const SIDE: usize = 8;
const CELL: f64 = 10.0;

/// Compares positions of the samples of a small raster around a place of a projection with what is expected of each.
#[expect(clippy::unwrap_used, reason = "tests fail by panicking")]
fn compare_around(definition: &str, place: DVec2, expected: impl Fn(DVec2) -> DVec2, worst: &mut Worst) {
    let crs = Crs {
        name: definition.to_owned(),
        definition: definition.to_owned(),
    };
    let to_crs = DAffine2::from_mat2_translation(DMat2::from_diagonal(DVec2::new(CELL, -CELL)), place);
    let georeference = GeoReference::new(&crs, to_crs, SIDE, SIDE).unwrap();
    for index in 0..SIDE * SIDE {
        let grid = DVec2::new((index % SIDE) as f64, (index / SIDE) as f64);
        let (ours, theirs) = (georeference.geographic(grid), expected(to_crs.transform_point2(grid)));
        worst.take(geographiclib::distance(ours, theirs), (definition, grid, ours, theirs));
    }
}

#[test]
fn utm_agrees_with_geographiclib_to_a_micrometre() {
    let mut worst = Worst::of("UTM", 1e-6);
    let mut numbers = random_numbers(3);
    let mut next = move || numbers.next().unwrap_or_default();
    for zone in 1..=60 {
        let west = f64::from(zone) * 6.0 - 186.0;
        let of_zone = [
            // Its corners, its edge and its meridian at the equator, Svalbard's latitude, and anywhere.
            DVec2::new(west, 83.99),
            DVec2::new(west + 6.0, -79.99),
            DVec2::new(west, 0.0),
            DVec2::new(west + 3.0, 0.001),
            DVec2::new(west + 9.0, 78.0),
            DVec2::new(west + 6.0 * next(), 164.0 * next() - 80.0),
        ];
        // Two of them, by turns.
        for place in of_zone.into_iter().skip(zone as usize % 3).step_by(3) {
            let (projected, is_north) = geographiclib::to_utm(zone, place);
            let code = if is_north { 32_600 } else { 32_700 } + zone;
            let expected = |point| geographiclib::from_utm(zone, is_north, point);
            compare_around(&format!("EPSG:{code}"), projected, expected, &mut worst);
        }
    }
}

#[test]
fn ups_agrees_with_geographiclib_to_a_micrometre_but_for_the_table_beside_the_pole() {
    for (code, south) in [("EPSG:5041", 1.0), ("EPSG:5042", -1.0)] {
        for latitude in [84.0, 85.3, 89.0, 89.99] {
            // A kilometre from the pole, longitudes bend so much that their table errs by a 100,000th of a cell.
            let limit = if latitude > 89.5 { 1e-5 * CELL } else { 1e-6 };
            let mut worst = Worst::of("UPS", limit);
            for longitude in [-179.9, -90.0, -33.3, 0.0, 45.0, 90.0, 134.5] {
                let (projected, is_north) = geographiclib::to_utm(0, DVec2::new(longitude, south * latitude));
                let expected = |point| geographiclib::from_utm(0, is_north, point);
                compare_around(code, projected, expected, &mut worst);
            }
        }
    }
}

#[test]
fn transverse_mercator_agrees_with_the_exact_formulas_to_a_micrometre() {
    let mut worst = Worst::of("transverse Mercator", 1e-6);
    let mut numbers = random_numbers(4);
    for index in 0..60 {
        let mut next = || numbers.next().unwrap_or_default() * 2.0 - 1.0;
        let meridian = (next() * 180.0 * 8.0).round() / 8.0;
        // Up to some 9° from the meridian, and up to 87° north or south.
        let reach = if index % 10 == 0 { 0.0 } else { 1e6 };
        let place = DVec2::new(reach * next(), 9.6e6 * next());
        let definition =
            format!("+proj=tmerc +lat_0=0 +lon_0={meridian} +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +towgs84=0,0,0 +type=crs");
        let expected = |point| geographiclib::from_transverse_mercator(meridian, point);
        compare_around(&definition, place, expected, &mut worst);
    }
}

#[test]
fn local_coordinates_agree_to_a_hundredth_of_a_micrometre() {
    let mut worst = Worst::of("east, north, up", 1e-8);
    let origins = points();
    // Each point from one beside it, some ten kilometres off and 5 km higher.
    for origin in origins.into_iter().filter(|origin| origin.latitude.abs() < 89.9) {
        let point = Geodetic {
            longitude: origin.longitude + 0.1,
            latitude: origin.latitude - 0.05,
            height: origin.height + 5000.0,
        };
        let frame = ellipsoid::east_north_up(origin.longitude, origin.latitude);
        let apart = ellipsoid::to_earth_centred(point) - ellipsoid::to_earth_centred(origin);
        let error = (frame.transpose() * apart - geographiclib::to_local(origin, point)).length();
        worst.take(error, (origin, point));
    }
}

/// A geoid in GeographicLib's format, of random heights: `columns` around the Earth, half as many rows and one.
#[expect(clippy::unwrap_used, reason = "tests fail by panicking")]
fn write_geoid(path: &Path, columns: usize) {
    let rows = columns / 2 + 1;
    let header = format!(
        "P5\n# Geoid file in PGM format for the GeographicLib::Geoid class\n# Description random heights\n\
         # DateTime 2026-11-28\n# MaxBilinearError 1\n# RMSBilinearError 1\n# MaxCubicError 1\n# RMSCubicError 1\n\
         # Offset -108\n# Scale 0.003\n# Origin 90N 0E\n# AREA_OR_POINT Point\n# Vertical_Datum WGS84\n{columns} {rows}\n65535\n"
    );
    let nodes = random_numbers(5).map(|number| (number * 65_535.0) as u16);
    let nodes = nodes.take(columns * rows).flat_map(u16::to_be_bytes);
    fs::write(path, header.into_bytes().into_iter().chain(nodes).collect::<Vec<u8>>()).unwrap();
}

#[test]
#[expect(clippy::unwrap_used, reason = "tests fail by panicking")]
fn geoids_agree_to_ten_micrometres_wherever_they_are_asked() {
    let folder = tempfile::tempdir().unwrap();
    for columns in [24, 360] {
        let mut worst = Worst::of("geoid", 1e-5);
        let path = folder.path().join(format!("random{columns}.pgm"));
        write_geoid(&path, columns);
        let places: Vec<DVec2> = points()
            .iter()
            .map(|point| DVec2::new(point.longitude, point.latitude))
            .flat_map(|place| [place, DVec2::new(place.x + 360.0, place.y), place.round()])
            .collect();
        let ours = raster::undulations(&path, &places).unwrap();
        let theirs = geographiclib::undulations(folder.path(), &format!("random{columns}"), &places);
        for ((ours, theirs), place) in ours.into_iter().zip(theirs).zip(places) {
            worst.take((ours.unwrap() - theirs).abs(), place);
        }
    }
}

#[test]
fn cells_are_as_long_as_geodesics() {
    let mut worst = Worst::of("lengths of geodesics", 1e-6);
    for latitude in [-80.0, -33.0, 0.0, 46.0, 71.5] {
        let step = 1.0 / 1200.0;
        let georeference = GeoReference::wgs84(11, 11, DVec2::new(7.0, latitude), DVec2::new(step, -step));
        let middle = DVec2::splat(5.0);
        let along = |direction: DVec2| {
            let ends = [middle - direction / 2.0, middle + direction / 2.0].map(|grid| georeference.geographic(grid));
            geographiclib::distance(ends[0], ends[1])
        };
        let error = georeference.cell_metres(middle) - DVec2::new(along(DVec2::X), along(DVec2::Y));
        worst.take(error.abs().max_element(), latitude);
    }
}

#[test]
fn round_figures_are_those_of_the_ellipsoid() {
    let along_meridian = |latitude: f64| {
        let at = |latitude| {
            ellipsoid::to_earth_centred(Geodetic {
                longitude: 0.0,
                latitude,
                height: 0.0,
            })
        };
        (at(latitude + 0.5) - at(latitude - 0.5)).length()
    };
    let shortest_degree = along_meridian(0.0);
    assert!((0.0..1000.0).contains(&(shortest_degree - ellipsoid::LEAST_METRES_IN_A_DEGREE)));
    let least_radius = shortest_degree.to_degrees();
    assert!(
        (0.0..1000.0).contains(&(least_radius - ellipsoid::LEAST_CURVATURE_RADIUS)),
        "{least_radius}"
    );
    let mean_radius = (2.0 * ellipsoid::SEMI_MAJOR + ellipsoid::SEMI_MINOR) / 3.0;
    assert!((mean_radius - ellipsoid::MEAN_RADIUS).abs() < 500.0);
    let degree_of_equator = ellipsoid::SEMI_MAJOR.to_radians();
    assert!((degree_of_equator - ellipsoid::METRES_IN_A_DEGREE).abs() < 5.0);
}
