#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

fn crs(code: &str) -> Crs {
    Crs {
        name: code.to_owned(),
        definition: code.to_owned(),
    }
}

fn north_up(first: [f64; 2], cell: f64) -> DAffine2 {
    DAffine2::from_mat2_translation(DMat2::from_diagonal(DVec2::new(cell, -cell)), DVec2::from(first))
}

/// Points all over a grid and a little beyond, on no lattice.
fn scattered(columns: usize, rows: usize) -> impl Iterator<Item = DVec2> {
    let size = DVec2::new(columns as f64, rows as f64);
    let golden = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053);
    (0..500).map(move |index| (golden * f64::from(index)).fract_gl() * size - 0.5)
}

#[test]
fn a_table_is_what_proj_says_and_its_inverse_undoes_it() {
    let cases = [
        ("EPSG:32631", [657_641.0, 4_987_332.0], 90.0),
        ("EPSG:2056", [2_601_200.0, 1_184_400.0], 200.0),
        ("EPSG:27700", [326_501.0, 673_788.0], 2.5),
        ("EPSG:3857", [-13_630_153.0, 4_553_031.0], 6.5),
        ("EPSG:3035", [2_800_000.0, 5_300_000.0], 5000.0),
        ("EPSG:3031", [500_000.0, 900_000.0], 2000.0),
    ];
    for (code, first, cell) in cases {
        let (columns, rows) = (301, 203);
        let to_crs = north_up(first, cell);
        let georeference = GeoReference::new(&crs(code), to_crs, columns, rows).unwrap();
        assert!(!georeference.is_geographic(), "{code}");
        let proj = proj::Proj::new_known_crs(code, "EPSG:4326", None).unwrap();
        for grid in scattered(columns, rows) {
            let point = georeference.crs_coordinates(grid);
            let (longitude, latitude) = proj.convert((point.x, point.y)).unwrap();
            let exact = DVec2::new(longitude, latitude);
            let cells = (georeference.grid(exact) - grid).length();
            assert!(cells < 1e-5, "{code}: {grid} comes back {cells} cells off");
            let again = georeference.grid(georeference.geographic(grid));
            assert!((again - grid).length() < 1e-8, "{code}: {grid} → {again}");
        }
    }
}

#[test]
fn longitudes_go_on_beyond_the_antimeridian() {
    // UTM zone 60 south; its eastern edge is the antimeridian, half of this raster lies beyond.
    let to_crs = north_up([750_000.0, 8_000_000.0], 500.0);
    let georeference = GeoReference::new(&crs("EPSG:32760"), to_crs, 400, 100).unwrap();
    let [west, _, east, _] = georeference.geographic_bounds();
    assert!(west > 179.0 && west < 180.0 && east > 181.0, "{west} … {east}");
    let mut before = georeference.geographic(DVec2::ZERO).x;
    for column in 1..400 {
        let here = georeference.geographic(DVec2::new(f64::from(column), 0.0)).x;
        assert!(
            here > before && here - before < 0.01,
            "column {column}: {before} → {here}"
        );
        before = here;
    }
}

#[test]
fn longitudes_from_0_to_360_are_brought_to_the_usual_range() {
    let georeference = GeoReference::wgs84(11, 3, DVec2::new(275.0, 10.0), DVec2::new(1.0, -1.0));
    assert_eq!(georeference.geographic_bounds(), [-85.0, 8.0, -75.0, 10.0]);
    assert_eq!(georeference.grid(DVec2::new(-80.0, 9.0)), DVec2::new(5.0, 1.0));
    assert_eq!(georeference.crs_coordinates(DVec2::ZERO).x, 275.0);
}

#[test]
fn geographic_systems_that_equal_wgs84_are_affine_and_others_are_not() {
    let to_crs = north_up([-100.0, 45.0], 0.01);
    for (code, affine) in [
        ("EPSG:4326", true),
        ("OGC:CRS84", true),
        ("EPSG:4269", true),
        ("EPSG:4267", false),
    ] {
        let georeference = GeoReference::new(&crs(code), to_crs, 50, 40).unwrap();
        assert_eq!(georeference.is_geographic(), affine, "{code}");
    }
}

#[test]
fn nad27_is_shifted_by_tens_of_metres() {
    let to_crs = north_up([-100.0, 45.0], 0.01);
    let georeference = GeoReference::new(&crs("EPSG:4267"), to_crs, 50, 40).unwrap();
    let shift = (georeference.geographic(DVec2::ZERO) - DVec2::new(-100.0, 45.0)) * 111_000.0;
    assert!(shift.x < -25.0 && shift.x > -60.0 && shift.y.abs() < 20.0, "{shift} m");
}

#[test]
fn where_proj_would_change_the_shift_from_point_to_point_places_are_continuous() {
    for first in [[-80.0, 45.0], [-99.0, 25.0]] {
        let to_crs = north_up(first, 0.05);
        let georeference = GeoReference::new(&crs("EPSG:4267"), to_crs, 20, 20).unwrap();
        let place = |column: usize| georeference.geographic(DVec2::new(column as f64, 7.0));
        let steps = (1..20).map(|column| place(column).x - place(column - 1).x);
        // A datum shift changes by a tenth of a metre over such a step, from one shift to another by metres.
        assert!(steps.into_iter().all(|step| (step - 0.05).abs() < 5e-6), "{first:?}");
    }
}

#[test]
fn cells_have_their_size_on_the_ellipsoid() {
    let georeference = GeoReference::wgs84(3, 3, DVec2::new(7.0, 1.0), DVec2::new(1.0, -1.0));
    let cell = georeference.cell_metres(DVec2::new(1.0, 1.0));
    // A degree of the equator is π/180 · 6378137 m, and of its meridian 110574.3 m there.
    assert!(
        (cell.x - 111_319.490_8).abs() < 1e-3 && (cell.y - 110_574.28).abs() < 0.1,
        "{cell}"
    );
    let north = GeoReference::wgs84(3, 3, DVec2::new(7.0, 61.0), DVec2::new(1.0, -1.0));
    let cell = north.cell_metres(DVec2::new(1.0, 1.0));
    assert!(
        (cell.x - 55_800.0).abs() < 1.0 && (cell.y - 111_412.0).abs() < 1.0,
        "{cell}"
    );
}

#[test]
fn what_has_no_longitude_and_latitude_is_refused() {
    // Between two lobes of an interrupted projection.
    let over_a_cut = north_up([-5_500_000.0, 5_500_000.0], 20_000.0);
    let error = GeoReference::new(&crs("+proj=igh +type=crs"), over_a_cut, 101, 101).unwrap_err();
    assert!(matches!(error, GeoReferenceError::Untransformable { .. }), "{error}");
    let nonsense = GeoReference::new(&crs("EPSG:999999"), over_a_cut, 10, 10).unwrap_err();
    assert!(
        matches!(nonsense, GeoReferenceError::NoTransformation { .. }),
        "{nonsense}"
    );
    let beyond = GeoReference::new(&crs("EPSG:4326"), north_up([0.0, 91.0], 1.0), 10, 10).unwrap_err();
    assert!(
        matches!(
            beyond,
            GeoReferenceError::BeyondPole(_) | GeoReferenceError::Untransformable { .. }
        ),
        "{beyond}"
    );
    let flat = DAffine2::from_scale(DVec2::new(1.0, 0.0));
    assert_eq!(
        GeoReference::new(&crs("EPSG:4326"), flat, 10, 10).unwrap_err(),
        GeoReferenceError::Degenerate
    );
}

#[test]
fn a_raster_of_40_000_by_40_000_samples_has_a_table() {
    let to_crs = north_up([300_000.0, 5_300_000.0], 10.0);
    let georeference = GeoReference::new(&crs("EPSG:32632"), to_crs, 40_000, 40_000).unwrap();
    let corner = DVec2::splat(39_999.0);
    let again = georeference.grid(georeference.geographic(corner));
    assert!((again - corner).length() < 1e-6, "{again}");
}

#[test]
fn beside_a_pole_longitude_is_continuous() {
    let beside = north_up([10_000.0, 90_000.0], 1000.0);
    let georeference = GeoReference::new(&crs("EPSG:3413"), beside, 80, 80).unwrap();
    let proj = proj::Proj::new_known_crs("EPSG:3413", "EPSG:4326", None).unwrap();
    for grid in scattered(80, 80) {
        let point = georeference.crs_coordinates(grid);
        let (longitude, latitude) = proj.convert((point.x, point.y)).unwrap();
        let cells = (georeference.grid(DVec2::new(longitude, latitude)) - grid).length();
        assert!(cells < 1e-4, "{grid} comes back {cells} cells off");
    }
    assert!(!georeference.is_around());
}

#[test]
fn around_a_pole_places_are_those_of_proj_seen_from_any_longitude() {
    for (code, latitude) in [("EPSG:3413", 90.0), ("EPSG:3031", -90.0)] {
        let to_crs = north_up([-40_000.0, 37_000.0], 1000.0);
        let georeference = GeoReference::new(&crs(code), to_crs, 80, 80).unwrap();
        let [west, south, east, north] = georeference.geographic_bounds();
        assert_eq!([west, east], [-180.0, 180.0]);
        assert!(latitude == south || latitude == north);
        let pole = georeference.geographic(DVec2::new(40.0, 37.0));
        assert!((pole.y - latitude).abs() < 1e-9, "{pole}");
        let proj = proj::Proj::new_known_crs(code, "EPSG:4326", None).unwrap();
        for (number, grid) in scattered(80, 80).enumerate() {
            let facing = 7.0 * number as f64 - 1000.0;
            let seen = georeference.clone().facing(facing);
            let point = georeference.crs_coordinates(grid);
            let (longitude, latitude) = proj.convert((point.x, point.y)).unwrap();
            let place = seen.geographic(grid);
            assert!((place.x - facing).abs() <= 180.0, "{place} from {facing}");
            let turns = (place.x - longitude) / 360.0;
            assert!(
                (turns - turns.round()).abs() < 1e-7 && (place.y - latitude).abs() < 1e-9,
                "{place}"
            );
            assert!((seen.grid(place) - grid).length() < 1e-6, "{grid}");
            // The scale of the projection is 0.97 to 0.98 there, the same in all directions.
            let cell = georeference.cell_metres(grid);
            assert!(
                (cell.x - cell.y).abs() < 0.5 && (1015.0..1035.0).contains(&cell.x),
                "{cell} at {grid}"
            );
        }
    }
}

#[test]
fn a_system_that_is_nowhere_on_the_earth_is_refused() {
    let crs = Crs {
        name: "a site".to_owned(),
        definition: "LOCAL_CS[\"a site\",UNIT[\"metre\",1]]".to_owned(),
    };
    let refused = GeoReference::new(&crs, DAffine2::IDENTITY, 3, 3).err().unwrap();
    assert!(refused.to_string().contains("a site"), "{refused}");
}
