#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::fs;

use tempfile::TempDir;

use super::*;

fn reference(name: &str, of_crs: Option<&str>, asked: Vertical) -> Result<HeightReference, ReadError> {
    HeightReference::of_file(Path::new(name), of_crs.map(str::to_owned), None, &asked)
}

fn above_ellipsoid() -> Vertical {
    Vertical {
        heights: HeightsAbove::Ellipsoid,
        ..Vertical::default()
    }
}

/// A grid around the Earth at 30°, in the format that GeographicLib has: metres are 100 + 10 · column + row.
fn grid(folder: &Path) -> String {
    let (columns, rows) = (12_u16, 7_u16);
    let mut bytes = format!("P5\n# Geoid file\n# Offset 100\n# Scale 0.5\n{columns} {rows}\n65535\n").into_bytes();
    for row in 0..rows {
        for column in 0..columns {
            bytes.extend((20 * column + 2 * row).to_be_bytes());
        }
    }
    let path = folder.join("geoid.pgm");
    fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

#[test]
fn products_are_known_by_their_names() {
    for (name, datum) in [
        ("N43E007.hgt", "EGM96"),
        ("n43_e007.tif", UNSPECIFIED),
        ("Copernicus_DSM_COG_10_N27_00_E061_00_DEM.tif", "EGM2008"),
        ("NASADEM_HGTS_n43e007.hgt", ELLIPSOID),
        ("NASADEM_HGT_n43e007.hgt", "EGM96"),
        ("TDM1_DEM__30_N43E007.tif", ELLIPSOID),
        ("USGS_13_n50w123.tif", "NAVD88"),
        ("swissalti3d_2019_2600-1199_0.5_2056_5728.tif", "LN02"),
        ("srtm_39_03.tif", "EGM96"),
        ("site.dem.wgs84", ELLIPSOID),
        ("jacksboro_fault.tif", UNSPECIFIED),
    ] {
        assert_eq!(
            reference(name, None, Vertical::default()).unwrap().datum(),
            datum,
            "{name}"
        );
    }
}

#[test]
fn what_a_user_says_goes_before_the_reference_system_and_that_before_the_name() {
    let said = Vertical {
        datum: Some("EPSG:3855".to_owned()),
        ..Vertical::default()
    };
    let datum = |of_crs, asked| reference("N43E007.hgt", of_crs, asked).unwrap().datum();
    assert_eq!(datum(Some("NAVD88 height"), said), "EGM2008");
    assert_eq!(datum(Some("NAVD88 height (ftUS)"), Vertical::default()), "NAVD88");
    assert_eq!(datum(None, Vertical::default()), "EGM96");
}

#[test]
fn names_that_mean_nothing_and_grids_that_are_not_here_are_refused() {
    let datum = Some("sea".to_owned());
    let said = Vertical {
        datum,
        ..above_ellipsoid()
    };
    let refused = reference("a.tif", None, said).err().unwrap().to_string();
    assert!(refused.contains("`sea`"), "{refused}");
    let refused = reference("a.tif", Some("DHHN92 height"), above_ellipsoid())
        .err()
        .unwrap()
        .to_string();
    assert!(refused.contains("DHHN92") && refused.contains("--geoid"), "{refused}");
    let none = Vertical {
        geoid: Some("nowhere.gtx".to_owned()),
        ..above_ellipsoid()
    };
    let refused = reference("N43E007.hgt", None, none).err().unwrap().to_string();
    assert!(refused.contains("nowhere.gtx"), "{refused}");
}

#[test]
fn heights_above_a_national_datum_become_those_above_its_own_ellipsoid_and_that_is_said() {
    let folder = TempDir::new().unwrap();
    for (name, above, apart) in [
        (
            "USGS_13_n50w123.tif",
            "ellipsoid of NAD83",
            "up to 2 m from that of WGS 84",
        ),
        (
            "swissalti3d_2019_2600-1199.tif",
            "ellipsoid of ETRS89",
            "less than 0.2 m",
        ),
        ("N43E007.hgt", ELLIPSOID, "become heights above the ellipsoid by"),
    ] {
        let asked = Vertical {
            geoid: Some(grid(folder.path())),
            ..above_ellipsoid()
        };
        let reference = reference(name, None, asked).unwrap();
        assert_eq!(reference.heights_above(), above);
        assert!(reference.remark().unwrap().contains(apart), "{:?}", reference.remark());
    }
}

#[test]
fn what_nothing_is_known_of_and_what_is_above_the_ellipsoid_stays() {
    for (name, heights) in [("a.tif", UNSPECIFIED), ("TDM1_DEM__30_N43E007.tif", ELLIPSOID)] {
        let reference = reference(name, None, above_ellipsoid()).unwrap();
        assert_eq!((reference.heights_above().as_str(), reference.geoid()), (heights, None));
    }
}

#[test]
fn the_grid_is_bilinear_and_goes_around_the_earth() {
    let folder = TempDir::new().unwrap();
    let asked = Vertical {
        geoid: Some(grid(folder.path())),
        ..above_ellipsoid()
    };
    let geoid = reference("N43E007.hgt", None, asked).unwrap().geoid.unwrap();
    for (longitude, latitude, metres) in [
        (0.0, 90.0, 100.0),
        (30.0, 90.0, 110.0),
        (15.0, 75.0, 105.5),
        (330.0, 60.0, 211.0),
        (-30.0, 60.0, 211.0),
        (345.0, 60.0, 156.0),
        (360.0, -90.0, 106.0),
        (725.0, 0.0, 100.0 + 50.0 / 30.0 + 3.0),
    ] {
        let found = geoid.undulation(DVec2::new(longitude, latitude)).unwrap();
        assert!((found - metres).abs() < 1e-4, "{longitude}, {latitude}: {found}");
    }
    assert_eq!(geoid.undulation(DVec2::new(0.0, 140.0)), None);
}

#[test]
fn samples_get_the_undulation_of_their_own_places_however_they_are_cut() {
    let folder = TempDir::new().unwrap();
    let asked = Vertical {
        geoid: Some(grid(folder.path())),
        ..above_ellipsoid()
    };
    let heights = reference("N43E007.hgt", None, asked).unwrap();
    // Across 30° of longitude, where the grid bends, and a void.
    let georeference = GeoReference::wgs84(60, 50, DVec2::new(29.0, 44.0), DVec2::new(0.05, -0.02));
    let origin = [-7, 12];
    let mut whole = vec![1000.0; 60 * 50];
    whole[61] = f64::NAN;
    let path = Path::new("N43E007.hgt");
    heights
        .to_ellipsoid(path, &georeference, origin, [&(0..60), &(0..50)], &mut whole)
        .unwrap();
    assert!(whole[61].is_nan());
    for (index, metres) in whole.iter().enumerate().filter(|(_, metres)| !metres.is_nan()) {
        let at = georeference.geographic(DVec2::new((index % 60) as f64, (index / 60) as f64));
        let expected = 1000.0 + heights.geoid.as_ref().unwrap().undulation(at).unwrap();
        assert!((metres - expected).abs() < 2e-4, "{at}: {metres} {expected}");
    }
    let (columns, rows) = (13..41, 5..33);
    let mut part = vec![1000.0; 28 * 28];
    heights
        .to_ellipsoid(path, &georeference, origin, [&columns, &rows], &mut part)
        .unwrap();
    for (index, metres) in part.iter().enumerate() {
        assert_eq!(*metres, whole[(5 + index / 28) * 60 + 13 + index % 28]);
    }
}
