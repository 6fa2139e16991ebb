use super::*;

fn at(longitude: f64, latitude: f64) -> Bucket {
    let [east, north] = [longitude + 1e-9, latitude + 1e-9];
    let mut all = Bucket::all([longitude, latitude, east, north]);
    let found = all.next();
    assert_eq!(all.count(), 0);
    found.unwrap_or_else(|| panic!("no bucket at {longitude}, {latitude}"))
}

/// Airports; the numbers worked out by hand: ((longitude + 180) · 2¹⁴ + (latitude + 90) · 2⁶ + row · 2³ + column.
#[test]
fn buckets_have_the_numbers_and_folders_that_flightgear_has() {
    for (longitude, latitude, folder, index) in [
        // San Francisco (KSFO), Paris (LFPG), Keflavík (BIKF), Sydney (YSSY).
        (-122.375, 37.619, "w130n30/w123n37", 942_050),
        (2.55, 49.01, "e000n40/e002n49", 2_990_786),
        (-22.605, 63.985, "w030n60/w023n63", 2_582_136),
        (151.177, -33.946, "e150s40/e151s34", 5_426_688),
    ] {
        let bucket = at(longitude, latitude);
        assert_eq!(
            (bucket.folder().as_str(), bucket.index()),
            (folder, index),
            "{longitude}, {latitude}"
        );
    }
}

#[test]
fn every_place_is_in_one_bucket_and_buckets_fill_their_rows() {
    for latitude in [
        -89.9, -76.01, -22.1, -21.9, 0.0, 21.99, 22.0, 61.9, 62.0, 83.0, 88.9, 89.5,
    ] {
        let [_, south, _, north] = at(0.0, latitude).bounds();
        assert!(south <= latitude && latitude < north);
        let row: Vec<[f64; 4]> = Bucket::all([-180.0, south, 180.0, north]).map(Bucket::bounds).collect();
        assert_eq!((row[0][0], row[row.len() - 1][2]), (-180.0, 180.0));
        assert!(row.windows(2).all(|pair| pair[0][2] == pair[1][0]), "{latitude}");
    }
    let widths = [0.0, 30.0, 70.0, 80.0, 84.0, 87.0, 89.5].map(|latitude| at(10.0, latitude).bounds());
    let widths = widths.map(|[west, _, east, _]| east - west);
    assert_eq!(widths, [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 12.0]);
}
