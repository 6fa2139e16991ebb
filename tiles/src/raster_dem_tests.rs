#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use super::*;

/// The formulas of the table above, which clients use.
fn decoded(encoding: Encoding, [red, green, blue]: [u8; 3]) -> f64 {
    let [red, green, blue] = [red, green, blue].map(f64::from);
    match encoding {
        Encoding::Terrarium => red * 256.0 + green + blue / 256.0 - 32_768.0,
        Encoding::Mapbox => -10_000.0 + (red * 65_536.0 + green * 256.0 + blue) * 0.1,
    }
}

#[test]
fn colours_are_heights_rounded_once() {
    for encoding in [Encoding::Terrarium, Encoding::Mapbox] {
        for doublings in 0..10 {
            let quantum = encoding.step() * f64::from(1 << doublings);
            for metres in [-9_000.0, -430.5, -0.001, 0.0, 0.499, 1_234.567_8, 8_848.86] {
                let height = decoded(encoding, encoding.colour(metres, quantum));
                assert!(
                    (height - metres).abs() <= quantum / 2.0 + 1e-9,
                    "{encoding:?} {quantum}: {metres} {height}"
                );
                let steps = height / quantum;
                assert!((steps - steps.round()).abs() < 1e-6, "{encoding:?} {quantum}: {height}");
            }
        }
    }
    assert_eq!(
        Encoding::Mapbox.colour(-11_000.0, 0.1),
        [0, 0, 0],
        "no lower height can be told"
    );
}

#[test]
fn voids_are_filled_with_heights_between_those_around_them() {
    let size = 64;
    let mut heights: Vec<Option<f64>> = (0..size * size)
        .map(|index| {
            let (x, y) = (index % size, index / size);
            let is_void = (10..40).contains(&x) && (20..50).contains(&y) || x > 60 && y > 60;
            (!is_void).then_some(1_000.0 + 10.0 * x as f64)
        })
        .collect();
    let before = heights.clone();
    fill::fill_voids(&mut heights, size);
    for (index, (after, before)) in heights.iter().zip(before).enumerate() {
        let after = after.unwrap();
        assert!(before.is_none_or(|before| before == after));
        let slope = 1_000.0 + 10.0 * (index % size) as f64;
        assert!((after - slope).abs() < 150.0, "{index}: {after} {slope}");
    }
    let mut nothing = vec![None; 16];
    fill::fill_voids(&mut nothing, 4);
    assert_eq!(nothing, [None; 16]);
}

#[test]
fn pixels_are_where_web_mercator_has_them() {
    let world = mercator::pixel_centres(SquareTile { zoom: 0, x: 0, y: 0 }, 256);
    assert_eq!(world.len(), 256 * 256);
    assert!((world[0].latitude - mercator::LATITUDES).abs() < 0.1 && (world[0].longitude + 180.0).abs() < 0.71);
    let tile = SquareTile { zoom: 1, x: 1, y: 0 };
    assert_eq!(
        [mercator::longitude(tile, 0.0), mercator::longitude(tile, 1.0)],
        [0.0, 180.0]
    );
    assert!(
        mercator::latitude(tile, 1.0).abs() < 1e-12
            && (mercator::latitude(tile, 0.0) - mercator::LATITUDES).abs() < 1e-9
    );
    assert!((mercator::latitude(tile, 0.5) - 66.513_260_443_11).abs() < 1e-9);
}

#[test]
fn tiles_around_one_go_on_over_the_antimeridian_and_end_in_the_north_and_south() {
    let around = |zoom, x, y| {
        let found: std::collections::BTreeSet<[u32; 2]> = mercator::around(SquareTile { zoom, x, y })
            .map(|tile| [tile.x, tile.y])
            .collect();
        found.into_iter().collect::<Vec<_>>()
    };
    assert_eq!(around(0, 0, 0), [[0_u32; 2]; 0]);
    assert_eq!(around(1, 0, 0), [[0, 1], [1, 0], [1, 1]]);
    assert_eq!(around(3, 0, 0), [[0, 1], [1, 0], [1, 1], [7, 0], [7, 1]]);
    let whole = around(3, 7, 4);
    assert_eq!((whole.len(), whole[0], whole[7]), (8, [0, 3], [7, 5]));
}

#[test]
fn files_have_the_colours_that_went_in_and_no_profile() {
    let colours: Vec<u8> = (0..256 * 256 * 3_u32).map(|index| (index * 31 % 251) as u8).collect();
    let png = image::write(image::Format::Png, image::Pixels::Colour, &colours, [256; 2]).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&png[..])).read_info().unwrap();
    let mut read = vec![0; colours.len()];
    reader.next_frame(&mut read).unwrap();
    assert_eq!(read, colours);
    assert!(!png.windows(4).any(|name| name == b"gAMA" || name == b"iCCP"));
    let webp = image::write(image::Format::WebP, image::Pixels::Colour, &colours, [256; 2]).unwrap();
    let mut read = vec![0; colours.len()];
    image_webp::WebPDecoder::new(std::io::Cursor::new(&webp[..]))
        .unwrap()
        .read_image(&mut read)
        .unwrap();
    assert_eq!(read, colours);
    for numbers in [&colours[1..], &[]] {
        let refused = image::write(image::Format::WebP, image::Pixels::Colour, numbers, [256; 2]);
        assert!(refused.is_err(), "{} numbers", numbers.len());
    }
}

#[test]
fn tiles_over_a_square_are_those_that_meet_it() {
    for (zoom, x, y) in [(0, 0, 0), (3, 5, 7), (5, 40, 21), (9, 271, 360)] {
        let address = TileAddress { zoom, x, y };
        let (west, south, side) = (address.west(), address.south(), address.degrees());
        for zoom in 0..=zoom.min(6) {
            let found: Vec<SquareTile> = mercator::tiles_over(address, zoom).collect();
            let all = (0..1_u32 << zoom).flat_map(|y| (0..1 << zoom).map(move |x| SquareTile { zoom, x, y }));
            let meets = |&tile: &SquareTile| {
                let [left, bottom, right, top] = mercator::bounds(tile);
                left < west + side && right > west && bottom < south + side && top > south
            };
            for tile in all.filter(meets) {
                assert!(found.contains(&tile), "{address} {tile:?}");
            }
            for tile in found {
                assert!(
                    mercator::meets(tile, [west, south - 1e-9, west + side, south + side + 1e-9]),
                    "{address} {tile:?}"
                );
            }
        }
    }
}
