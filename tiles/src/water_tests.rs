#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use terrain_codec::address::TileAddress;

use super::*;

fn tile(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

fn rectangle([west, south, east, north]: [f64; 4]) -> Vec<[f64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north]]
}

/// The pixel of a mask at a place.
fn pixel(mask: &[u8], address: TileAddress, longitude: f64, latitude: f64) -> u8 {
    if mask.len() == 1 {
        return mask[0];
    }
    let north = address.south() + address.degrees();
    let [column, row] = [longitude - address.west(), north - latitude]
        .map(|degrees| (degrees / address.degrees() * MASK_SIDE as f64) as usize);
    mask[row * MASK_SIDE + column]
}

/// Whether a point is inside of an odd number of rings, by the angle that they turn around it.
fn is_inside(rings: &[Vec<[f64; 2]>], at: [f64; 2]) -> bool {
    let turns = |ring: &Vec<[f64; 2]>| {
        let angle = |[x, y]: [f64; 2]| (y - at[1]).atan2(x - at[0]);
        let next = ring.iter().cycle().skip(1);
        let total: f64 = ring
            .iter()
            .zip(next)
            .map(|(&a, &b)| {
                let turn = angle(b) - angle(a);
                turn - (turn / std::f64::consts::TAU).round() * std::f64::consts::TAU
            })
            .sum();
        (total / std::f64::consts::TAU).round() as i64
    };
    rings.iter().map(turns).sum::<i64>().rem_euclid(2) == 1
}

#[test]
fn a_pixel_is_water_where_its_middle_is_inside() {
    let mut chance = fastrand::Rng::with_seed(7);
    let address = tile(3, 9, 4);
    for _ in 0..20 {
        let mut place = || {
            [
                address.west() + (chance.f64() * 1.6 - 0.3) * address.degrees(),
                address.south() + (chance.f64() * 1.6 - 0.3) * address.degrees(),
            ]
        };
        let rings: Vec<Vec<[f64; 2]>> = (0..2).map(|_| (0..5).map(|_| place()).collect()).collect();
        let water = Water {
            polygons: vec![rings.clone()],
        };
        let mask = water.mask(address);
        let side = address.degrees() / MASK_SIDE as f64;
        for (row, column) in (0..MASK_SIDE)
            .step_by(7)
            .flat_map(|row| (0..MASK_SIDE).step_by(5).map(move |column| (row, column)))
        {
            let at = [
                address.west() + (column as f64 + 0.5) * side,
                address.south() + address.degrees() - (row as f64 + 0.5) * side,
            ];
            let expected = if is_inside(&rings, at) { WATER } else { LAND };
            assert_eq!(
                pixel(&mask, address, at[0], at[1]),
                expected,
                "row {row}, column {column}"
            );
        }
    }
}

#[test]
fn a_mask_of_one_kind_is_one_pixel() {
    let lake = Water {
        polygons: vec![vec![rectangle([10.0, 40.0, 20.0, 50.0])]],
    };
    assert_eq!(lake.mask(tile(0, 0, 0)), [LAND]);
    let inside = TileAddress::new(7, ((15.0 + 180.0) / 1.406_25) as u32, ((45.0 + 90.0) / 1.406_25) as u32).unwrap();
    assert_eq!(lake.mask(inside), [WATER]);
    assert_eq!(lake.mask(tile(0, 1, 0)).len(), MASK_SIDE * MASK_SIDE);
    assert_eq!(Water::default().mask(tile(0, 1, 0)), [LAND]);
}

#[test]
fn water_goes_on_past_the_antimeridian() {
    let strait = Water {
        polygons: vec![vec![rectangle([170.0, -10.0, 190.0, 10.0])]],
    };
    let [west, east] = [tile(0, 0, 0), tile(0, 1, 0)];
    let masks = [west, east].map(|address| strait.mask(address));
    assert_eq!(pixel(&masks[0], west, -175.0, 0.1), WATER);
    assert_eq!(pixel(&masks[0], west, -165.0, 0.1), LAND);
    assert_eq!(pixel(&masks[1], east, 175.0, 0.1), WATER);
    assert_eq!(pixel(&masks[1], east, 165.0, 0.1), LAND);
}

#[test]
fn islands_are_land_and_lakes_that_overlap_are_water() {
    let water = Water {
        polygons: vec![
            vec![rectangle([10.0, 10.0, 50.0, 50.0]), rectangle([20.0, 20.0, 30.0, 30.0])],
            vec![rectangle([40.0, 40.0, 60.0, 60.0])],
        ],
    };
    let address = tile(0, 1, 0);
    let mask = water.mask(address);
    let found = [[15.0, 15.0], [25.0, 25.0], [45.0, 45.0], [55.0, 55.0], [65.0, 65.0]];
    let found = found.map(|[longitude, latitude]| pixel(&mask, address, longitude, latitude));
    assert_eq!(found, [WATER, LAND, WATER, WATER, LAND]);
}

/// What TypeScript answers alike; `tests/water/record.py` records it by exact arithmetic.
#[derive(Deserialize)]
struct Case {
    polygons: Vec<Vec<Vec<[f64; 2]>>>,
    masks: Vec<RecordedMask>,
}

#[derive(Deserialize)]
struct RecordedMask {
    tile: (u8, u32, u32),
    /// Lengths of runs of land, water, land, …
    runs: Vec<usize>,
}

#[test]
fn masks_are_the_recorded_ones() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../../tests/water/cases.json")).unwrap();
    for Case { polygons, masks } in cases {
        let water = Water { polygons };
        for RecordedMask { tile: at, runs } in masks {
            let kinds = [LAND, WATER].into_iter().cycle();
            let expected: Vec<u8> = runs
                .iter()
                .zip(kinds)
                .flat_map(|(&length, kind)| std::iter::repeat_n(kind, length))
                .collect();
            let (zoom, x, y) = at;
            let mut mask = water.mask(tile(zoom, x, y));
            if mask.len() == 1 {
                mask = vec![mask[0]; MASK_SIDE * MASK_SIDE];
            }
            assert!(mask == expected, "{zoom}/{x}/{y}");
        }
    }
}
