use terrain_codec::ellipsoid::{Geodetic, normal, to_earth_centred};

use super::*;

fn corner(longitude: f64, latitude: f64, height: f64) -> Corner {
    let at = Geodetic {
        longitude,
        latitude,
        height,
    };
    Corner::new(to_earth_centred(at), normal(longitude, latitude))
}

fn area(cut: &Cut) -> f64 {
    let of = |&(_, triangle): &(usize, [u32; 3])| {
        let [a, b, c] = triangle.map(|index| cut.corners[index as usize].position);
        (b - a).cross(c - a).length() / 2.0
    };
    cut.triangles.iter().map(of).sum()
}

/// A triangle over four buckets, one of which is beyond the antimeridian.
#[test]
fn the_parts_of_a_triangle_are_the_triangle_and_share_their_points_to_the_bit() {
    for west in [7.9, 179.9, -0.1] {
        let triangle = [
            corner(west, 46.02, 800.0),
            corner(west + 0.3, 46.05, 3_000.0),
            corner(west + 0.12, 46.21, -20.0),
        ];
        let middle = west + 0.1;
        let boxes = [
            [middle - 0.25, 46.0, middle, 46.125],
            [middle, 46.0, middle + 0.25, 46.125],
            [middle - 0.25, 46.125, middle, 46.25],
            [middle, 46.125, middle + 0.25, 46.25],
        ];
        // As buckets are told, from -180 to 180.
        let around = |degrees: f64| {
            if degrees >= 180.0 - 1e-9 {
                degrees - 360.0
            } else {
                degrees
            }
        };
        let cuts = boxes.map(|[west, south, east, north]| {
            let turned = around(west) - west;
            let mut cut = Cut::default();
            cut.add(triangle, [west + turned, south, east + turned, north], 0);
            cut
        });
        let [a, b, c] = triangle.map(|corner| corner.position);
        let whole = (b - a).cross(c - a).length() / 2.0;
        let parts: f64 = cuts.iter().map(area).sum();
        assert!((parts - whole).abs() < 1e-7 * whole, "{west}: {parts} {whole}");
        assert!(cuts.iter().all(|cut| area(cut) > 1e-3 * whole));
        let points = |cut: &Cut| -> Vec<[u64; 3]> { cut.known.keys().copied().collect() };
        for (one, other, shared) in [(0, 1, 2), (2, 3, 2), (0, 2, 2), (1, 3, 2)] {
            let others = points(&cuts[other]);
            let both = points(&cuts[one]).into_iter().filter(|point| others.contains(point));
            assert_eq!(both.count(), shared, "{west}: {one} {other}");
        }
        for (cut, [west, south, east, north]) in cuts.iter().zip(boxes) {
            for corner in &cut.corners {
                let place = to_geodetic(corner.position);
                let longitude = place.longitude + 360.0 * ((west - place.longitude) / 360.0).round();
                assert!(longitude > west - 1e-9 && longitude < east + 1e-9, "{place:?}");
                assert!(
                    place.latitude > south - 1e-9 && place.latitude < north + 1e-9,
                    "{place:?}"
                );
            }
        }
    }
}
