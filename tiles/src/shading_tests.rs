#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::cell::RefCell;
use std::convert::Infallible;

use terrain_codec::ellipsoid::normal;

use super::sums::PLACE_BITS;
use super::*;
use crate::fixture::of_one_level;

const EXTENT: f64 = 1024.0;

/// Eight by eight cells and a strip of four units along each side, all of them on one surface over the whole Earth.
fn tile(zoom: u8, x: u32, y: u32) -> Tile {
    let mut lines: Vec<f64> = (0..=8).map(|line| f64::from(line) * 128.0).collect();
    lines.splice(1..1, [4.0]);
    lines.insert(9, EXTENT - 4.0);
    tile_of(zoom, x, y, &lines, |u, v| {
        let (x, y) = (f64::from(x) + u / EXTENT, f64::from(y) + v / EXTENT);
        (4000.0 * ((2.0 * x).sin() + (3.0 * y).cos())).round()
    })
}

/// Cells between `lines` in both directions; `height` is that of places in it.
fn tile_of(zoom: u8, x: u32, y: u32, lines: &[f64], height: impl Fn(f64, f64) -> f64 + Copy) -> Tile {
    let address = TileAddress::new(zoom, x, y).unwrap();
    let width = lines.len() as u32;
    let positions = lines
        .iter()
        .flat_map(|&v| lines.iter().map(move |&u| DVec3::new(u, v, height(u, v))));
    let cells = (0..width - 1).flat_map(|row| (0..width - 1).map(move |column| row * width + column));
    let mesh = Mesh {
        positions: positions.collect(),
        triangles: cells
            .flat_map(|a| [[a, a + 1, a + width + 1], [a, a + width + 1, a + width]])
            .collect(),
    };
    of_one_level(address, 10, 0, &mesh, 1.0)
}

/// Finds tiles among some.
pub(crate) fn read_from(tiles: &[Tile]) -> impl Fn(TileAddress) -> Result<Option<Tile>, Infallible> {
    |address| Ok(tiles.iter().find(|tile| tile.address == address).cloned())
}

/// Surfaces of tiles, shaded among themselves.
pub(crate) fn surfaces_of(tiles: &[Tile]) -> Vec<Arc<FinestSurface>> {
    let shading = Shading::new(1 << 30);
    let read = read_from(tiles);
    let surface = |tile: &Tile| shading.surface(0, tile.address, &read).unwrap().unwrap();
    tiles.iter().map(surface).collect()
}

/// The shaded surface of a tile among others, of which those above are none.
fn shaded_among(tile: &Tile, others: &[Tile]) -> FinestSurface {
    let around: Vec<Arc<Sums>> = others.iter().map(|tile| Arc::new(Sums::of(tile.clone()))).collect();
    super::shaded(&Sums::of(tile.clone()), &around, None)
}

/// Normals by place, with all tiles around.
fn shaded(tile: &Tile) -> HashMap<Place, DVec3> {
    let around = tile.address.around().into_iter();
    let around: Vec<Tile> = around.map(|at| self::tile(at.zoom, at.x, at.y)).collect();
    let normals = shaded_among(tile, &around).normals.unwrap();
    normals
        .at_places
        .into_iter()
        .map(|(place, bytes)| (place, oct_decode(bytes)))
        .collect()
}

#[test]
fn normals_on_a_side_are_the_same_bits_in_all_tiles_there() {
    for (a, b, shared) in [
        (tile(5, 20, 10), tile(5, 21, 10), 11),
        (tile(5, 20, 10), tile(5, 20, 11), 11),
        (tile(5, 20, 10), tile(5, 21, 11), 1),
    ] {
        let of_b = shaded(&b);
        let both = shaded(&a)
            .into_iter()
            .filter_map(|(place, normal)| Some((normal, *of_b.get(&place)?)));
        let both: Vec<(DVec3, DVec3)> = both.collect();
        assert_eq!(both.len(), shared);
        assert!(both.iter().all(|(a, b)| a == b));
    }
}

#[test]
fn the_antimeridian_is_a_side_like_others() {
    let (west, east) = (tile(3, 15, 3), tile(3, 0, 3));
    let of_east = shaded(&east);
    let mut shared = 0;
    for (place, normal) in shaded(&west).into_iter().filter(|(place, _)| place[0] == 0) {
        assert_eq!(of_east[&place], normal, "{place:?}");
        shared += 1;
    }
    assert_eq!(shared, 11);
}

#[test]
fn across_the_strip_the_normal_hardly_changes() {
    let tile = tile(5, 20, 10);
    let all = shaded(&tile);
    let unit = 1_i128 << (PLACE_BITS - 10);
    let [left, bottom] = [20_i128 << PLACE_BITS, 10_i128 << PLACE_BITS];
    for along in 2..8 {
        let side = all[&[left, bottom + along * 128 * unit]];
        let inner = all[&[left + 4 * unit, bottom + along * 128 * unit]];
        assert!(side.angle_between(inner).to_degrees() < 10.0);
    }
}

#[test]
fn steps_in_strips_along_sides_and_along_those_of_children_do_not_tilt_normals() {
    let lines = [
        0.0, 4.0, 128.0, 256.0, 384.0, 508.0, 512.0, 516.0, 640.0, 768.0, 896.0, 1020.0, 1024.0,
    ];
    let is_inside = |along: f64| ![0.0, EXTENT / 2.0, EXTENT].contains(&along);
    let height = |u: f64, v: f64| if is_inside(u) && is_inside(v) { 40.0 } else { 0.0 };
    let stepped = |x: u32, y: u32| tile_of(14, x, y, &lines, height);
    let own = stepped(9000, 11_000);
    let beside = own.address.around().into_iter();
    let beside: Vec<Tile> = beside.map(|address| stepped(address.x, address.y)).collect();
    let surface = shaded_among(&own, &beside);
    for (vertex, &at) in surface.mesh.positions.iter().enumerate() {
        let found = surface.normal(vertex as u32).unwrap();
        let place = own.geodetic(at);
        let tilt = found
            .dot(normal(place.longitude, place.latitude))
            .min(1.0)
            .acos()
            .to_degrees();
        assert!(tilt < 1.0, "{tilt}° at {at}");
    }
}

#[test]
fn at_a_pole_all_tiles_have_the_normal_of_the_ellipsoid() {
    for (y, expected) in [(0, DVec3::NEG_Z), (7, DVec3::Z)] {
        let tile = tile(3, 5, y);
        let row = i128::from(if y == 0 { 0 } else { 8_u32 }) << PLACE_BITS;
        let normals = shaded(&tile);
        let at_pole: Vec<_> = normals.into_iter().filter(|(place, _)| place[1] == row).collect();
        assert_eq!(at_pole.len(), 11);
        let expected = oct_decode(oct_encode(expected));
        assert!(at_pole.iter().all(|&(_, normal)| normal == expected), "{at_pole:?}");
    }
}

/// Tiles of zooms 3 to 7 on a rough surface, of which vertices of a zoom are every second one of the next: one of zoom 7, all around it, all above
/// these, and so on.
fn rough() -> Vec<Tile> {
    let lines: Vec<f64> = (0..=16).map(|line| f64::from(line) * 64.0).collect();
    let mut addresses = vec![TileAddress::new(7, 100, 60).unwrap()];
    let mut all = Vec::new();
    for _ in 3..=7 {
        let mut around: Vec<TileAddress> = addresses.iter().flat_map(|address| address.around()).collect();
        around.extend(&addresses);
        around.sort_unstable();
        around.dedup();
        addresses = around.iter().filter_map(|address| address.parent()).collect();
        addresses.dedup();
        all.extend(around);
    }
    let made = |TileAddress { zoom, x, y }| {
        let part = f64::from(1_u32 << zoom);
        tile_of(zoom, x, y, &lines, |u, v| {
            let (x, y) = ((f64::from(x) + u / EXTENT) / part, (f64::from(y) + v / EXTENT) / part);
            let octave =
                |k: i32| 2_f64.powi(20 - k) * ((x * 9.0 * 2_f64.powi(k)).sin() + (y * 7.0 * 2_f64.powi(k)).cos());
            (3..10).map(octave).sum::<f64>().round()
        })
    };
    all.into_iter().map(made).collect()
}

#[test]
fn a_normal_hardly_turns_from_a_zoom_to_the_next() {
    let tiles = rough();
    let shading = Shading::new(1 << 30);
    let surface = |address| shading.surface(0, address, &read_from(&tiles)).unwrap().unwrap();
    let mut address = tiles[0].address;
    assert_eq!(address, TileAddress::new(7, 99, 59).unwrap());
    let (mut both, mut would_turn) = (0, 0);
    while address.zoom > 3 {
        let (own, above) = (surface(address), surface(address.parent().unwrap()));
        let around: Vec<Tile> = tiles
            .iter()
            .filter(|tile| address.around().contains(&tile.address))
            .cloned()
            .collect();
        let alone = shaded_among(&own.tile, &around);
        for (&place, &found) in &own.normals.as_ref().unwrap().at_places {
            let before = place_above(place).and_then(|place| above.normal_at_place(place));
            if let Some(before) = before {
                let turned = oct_decode(found).angle_between(before).to_degrees();
                assert!(turned <= 2.0, "{address} {place:?}: {turned}°");
                both += 1;
                would_turn +=
                    usize::from(alone.normal_at_place(place).unwrap().angle_between(before).to_degrees() > 5.0);
            }
        }
        address = address.parent().unwrap();
    }
    assert_eq!(both, 4 * 81);
    assert!(would_turn > 100, "{would_turn}");
}

#[test]
fn turned_normals_are_the_same_bits_in_tiles_of_different_parents() {
    let tiles = rough();
    let shading = Shading::new(1 << 30);
    let surface = |x, y| {
        let address = TileAddress::new(7, x, y).unwrap();
        shading.surface(0, address, &read_from(&tiles)).unwrap().unwrap()
    };
    let (west, east) = (surface(99, 60), surface(100, 60));
    assert_ne!(west.tile.address.parent(), east.tile.address.parent());
    let [west, east] = [&west, &east].map(|surface| &surface.normals.as_ref().unwrap().at_places);
    let shared = west.iter().filter_map(|(place, bytes)| Some((bytes, east.get(place)?)));
    let shared: Vec<_> = shared.collect();
    assert_eq!(shared.len(), 17);
    assert!(shared.iter().all(|(west, east)| west == east));
}

#[test]
fn what_is_in_memory_is_not_read_again_and_a_failure_is_not_kept() {
    let tiles = rough();
    let shading = Shading::new(1 << 30);
    let asked: RefCell<Vec<TileAddress>> = RefCell::default();
    let address = TileAddress::new(7, 100, 60).unwrap();
    let read = |at: TileAddress| {
        asked.borrow_mut().push(at);
        Ok::<_, Infallible>(tiles.iter().find(|tile| tile.address == at).cloned())
    };
    let failing = |at: TileAddress| {
        let found = tiles.iter().find(|tile| tile.address == at).cloned();
        if at.zoom == 4 { Err(at) } else { Ok(found) }
    };
    assert!(shading.surface(0, address, &failing).is_err());
    let surface = shading.surface(0, address, &read).unwrap().unwrap();
    let first = asked.borrow().len();
    assert!(first > 18, "{first}");
    assert!(Arc::ptr_eq(
        &surface,
        &shading.surface(0, address, &read).unwrap().unwrap()
    ));
    assert_eq!(asked.borrow().len(), first);
    assert!(shading.surface(1, address, &read).unwrap().is_some());
    assert!(asked.borrow().len() > first, "another archive has other tiles");
}
