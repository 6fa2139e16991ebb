//! The ellipsoid and grid positions against GeographicLib.

use glam::{DAffine2, DMat2, DMat3, DVec2, DVec3};
use terrain_ingest::georeference::{Crs, GeoReference};
use terrain_tests::{geographiclib, random_numbers};
use terrain_tiles::ellipsoid::{self, Geodetic};

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
    for point in points() {
        let (expected, _) = geographiclib::to_earth_centred(point);
        let error = (ellipsoid::to_earth_centred(point) - expected).length();
        assert!(error < 1e-8, "{point:?} is {error} m off");
    }
}

#[test]
fn geodetic_coordinates_agree_to_ten_nanometres() {
    for point in points() {
        let (position, _) = geographiclib::to_earth_centred(point);
        let (ours, theirs) = (ellipsoid::to_geodetic(position), geographiclib::to_geodetic(position));
        let north = (ours.latitude - theirs.latitude).to_radians() * ellipsoid::SEMI_MAJOR;
        let east = ground(ours.longitude - theirs.longitude, theirs.latitude);
        let error = DVec3::new(east, north, ours.height - theirs.height).abs().max_element();
        assert!(error < 1e-8, "{point:?} is {error} m off: {ours:?}, {theirs:?}");
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
    for _ in 0..5_000 {
        let fraction = DVec2::new(numbers.next().unwrap(), numbers.next().unwrap());
        let grid = fraction * DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0);
        let expected = geographiclib::from_northern_utm(31, to_crs.transform_point2(grid));
        let metres = geographiclib::distance(georeference.geographic(grid), expected);
        assert!(metres < 1e-5, "{grid} is {metres} m off");
        let cells = (georeference.grid(expected) - grid).length();
        assert!(cells < 1e-7, "{grid} comes back {cells} cells off");
    }
}

#[test]
fn cells_are_as_long_as_geodesics() {
    for latitude in [-80.0, -33.0, 0.0, 46.0, 71.5] {
        let step = 1.0 / 1200.0;
        let georeference = GeoReference::wgs84(11, 11, DVec2::new(7.0, latitude), DVec2::new(step, -step));
        let middle = DVec2::splat(5.0);
        let along = |direction: DVec2| {
            let ends = [middle - direction / 2.0, middle + direction / 2.0].map(|grid| georeference.geographic(grid));
            geographiclib::distance(ends[0], ends[1])
        };
        let error = georeference.cell_metres(middle) - DVec2::new(along(DVec2::X), along(DVec2::Y));
        assert!(error.abs().max_element() < 1e-6, "{latitude}°: {error} m");
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
