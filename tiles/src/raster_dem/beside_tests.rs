use super::*;
use crate::archive::tests::metadata;
use crate::outside::{HeightField, Outside};

const PIXEL: f64 = 0.001;

/// A grid of half a degree.
fn field() -> HeightField {
    HeightField {
        bounds: [-125.0, 47.0, -121.0, 50.0],
        columns: 9,
        decimetres: vec![0; 9 * 7],
    }
}

fn at(longitude: f64, latitude: f64) -> Place {
    Place { longitude, latitude }
}

#[test]
fn ground_counts_less_and_less_as_far_as_the_grid_is_fine() {
    let mut metadata = metadata();
    metadata.outside = Outside::Extend { field: field() };
    let inside = at(-123.0, 48.1);
    let of = |place| nearest(&metadata, place, PIXEL);
    assert_eq!(
        of(inside),
        Nearest {
            place: inside,
            share: 1.0
        }
    );
    for (place, expected, share) in [
        (at(-123.6, 48.5), at(-123.499, 48.5), 0.8),
        (at(-123.0, 49.25), at(-123.0, 48.999), 0.5),
        (at(-122.25 + 0.3, 48.0 - 0.4), at(-122.251, 48.001), 0.0),
        (at(58.0, 48.5), at(-123.499, 48.5), 0.0),
    ] {
        let found = of(place);
        let off = [
            found.place.longitude - expected.longitude,
            found.place.latitude - expected.latitude,
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{place:?}: {found:?}");
        assert!((found.share - share).abs() < 1e-9, "{place:?}: {found:?}");
    }
    for outside in [Outside::Ellipsoid, Outside::Geoid { field: field() }] {
        metadata.outside = outside;
        assert_eq!(
            nearest(&metadata, at(-123.6, 48.5), PIXEL).share,
            0.0,
            "a wall is what is asked for"
        );
        assert_eq!(nearest(&metadata, inside, PIXEL).share, 1.0);
    }
}

#[test]
fn data_over_the_antimeridian_and_narrower_than_a_pixel_have_their_nearest_places() {
    let mut metadata = metadata();
    metadata.bounds = [179.5, 10.0, 180.5, 11.0];
    metadata.outside = Outside::Extend {
        field: HeightField {
            bounds: [179.0, 9.5, 181.0, 11.5],
            columns: 3,
            decimetres: vec![0; 9],
        },
    };
    let east = nearest(&metadata, at(-179.25, 10.5), PIXEL);
    assert!(
        (east.place.longitude - (-179.501)).abs() < 1e-9 && (east.share - 0.75).abs() < 1e-9,
        "{east:?}"
    );
    let west = nearest(&metadata, at(179.0, 10.5), PIXEL);
    assert!(
        (west.place.longitude - 179.501).abs() < 1e-9 && (west.share - 0.5).abs() < 1e-9,
        "{west:?}"
    );
    let wide = nearest(&metadata, at(179.25, 12.0), 5.0);
    assert!(metadata.covers(wide.place.longitude, wide.place.latitude), "{wide:?}");
}
