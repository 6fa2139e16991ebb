//! Files and documents against what they are made from, read by code that shares nothing with what writes them.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;

use glam::DVec3;
use meshopt::{decode_filter_oct, decode_index_buffer, decode_index_sequence, decode_vertex_buffer};
use serde_json::{Value, json};
use terrain_codec::address::TileAddress;
use terrain_codec::tile::Tile;
use terrain_core::Mesh;

use super::{Described, Packing, Squares, TileSurface, document, file, subtree};
use crate::fixture::of_one_level;
use crate::formats::quantized_mesh::fixture::from_tile;
use crate::outside::Outside;
use crate::shading::FinestSurface;
use crate::shading::tests::surfaces_of;

/// A bumpy surface of 9 × 9 vertices over the whole square, alike where tiles meet.
fn tile(address: TileAddress) -> Tile {
    tile_with_tower(address, 0.0)
}

/// The same with a vertex in its middle that is much higher.
fn tile_with_tower(address: TileAddress, tower: f64) -> Tile {
    let height = |column: u32, row: u32| {
        let (x, y) = (address.x * 8 + column, address.y * 8 + row);
        let added = if (column, row) == (4, 4) { tower } else { 0.0 };
        f64::from(x * 37 % 101 + y * 53 % 89) * 4.0 + added
    };
    let vertex = |index: u32| {
        let (column, row) = (index % 9, index / 9);
        DVec3::new(f64::from(column) * 128.0, f64::from(row) * 128.0, height(column, row))
    };
    let cell = |index: u32| {
        let corner = index / 8 * 9 + index % 8;
        [[corner, corner + 1, corner + 10], [corner, corner + 10, corner + 9]]
    };
    let mesh = Mesh {
        positions: (0..81).map(vertex).collect(),
        triangles: (0..64).flat_map(cell).collect(),
    };
    of_one_level(address, 10, 0, &mesh, 2.5)
}

fn at(zoom: u8, x: u32, y: u32) -> TileAddress {
    TileAddress::new(zoom, x, y).unwrap()
}

/// By the decoders of meshoptimizer.
fn decompressed(bytes: &[u8], extension: &Value) -> Vec<u8> {
    let count = extension["count"].as_u64().unwrap() as usize;
    let of_words = |words: Vec<u16>| words.into_iter().flat_map(u16::to_le_bytes).collect();
    match (
        extension["mode"].as_str().unwrap(),
        extension["byteStride"].as_u64().unwrap(),
    ) {
        ("TRIANGLES", 2) => of_words(decode_index_buffer(bytes, count).unwrap()),
        ("INDICES", 2) => of_words(decode_index_sequence(bytes, count).unwrap()),
        ("ATTRIBUTES", 8) => of_words(decode_vertex_buffer::<[u16; 4]>(bytes, count).unwrap().into_flattened()),
        ("ATTRIBUTES", 4) => {
            assert_eq!(extension["filter"], "OCTAHEDRAL");
            let mut normals: Vec<[i8; 4]> = decode_vertex_buffer(bytes, count).unwrap();
            decode_filter_oct(&mut normals);
            normals
                .into_flattened()
                .into_iter()
                .map(|number| number as u8)
                .collect()
        }
        other => panic!("{other:?}"),
    }
}

/// A GLB file, read as Khronos describes it and placed as OGC does: Earth-centred positions and normals, and triangles.
struct Placed {
    description: Value,
    binary: Vec<u8>,
}

impl Placed {
    fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (b"glTF".as_slice(), 2, bytes.len()));
        let text = word(12);
        assert_eq!(&bytes[16..20], b"JSON");
        assert_eq!(&bytes[20 + text + 4..20 + text + 8], b"BIN\0");
        Self {
            description: serde_json::from_slice(&bytes[20..20 + text]).unwrap(),
            binary: bytes[20 + text + 8..].to_vec(),
        }
    }

    /// What an accessor is of, and the bytes of its view, from one item to the next as many as the last number says.
    fn bytes(&self, accessor: &Value, size: usize) -> (&Value, Vec<u8>, usize) {
        let accessor = &self.description["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &self.description["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let part = |view: &Value| {
            let [start, length] = ["byteOffset", "byteLength"].map(|name| view[name].as_u64().unwrap() as usize);
            assert_eq!((start % 4, &view["buffer"]), (0, &json!(0)));
            &self.binary[start..start + length]
        };
        let extension = &view["extensions"]["EXT_meshopt_compression"];
        let stride = view["byteStride"].as_u64().map_or(size, |stride| stride as usize);
        let bytes = match extension {
            Value::Null => part(view).to_vec(),
            extension => {
                assert_eq!((&view["buffer"], &extension["byteStride"]), (&json!(1), &json!(stride)));
                assert_eq!(extension["count"], accessor["count"]);
                decompressed(part(extension), extension)
            }
        };
        assert_eq!(view["byteLength"], bytes.len());
        assert_eq!(accessor["count"].as_u64().unwrap() as usize * stride, bytes.len());
        (accessor, bytes, stride)
    }

    /// As glTF and `KHR_mesh_quantization` have their numbers.
    fn vectors(&self, semantic: &str) -> Vec<DVec3> {
        let accessor = &self.description["meshes"][0]["primitives"][0]["attributes"][semantic];
        let (accessor, bytes, stride) = self.bytes(accessor, 12);
        let is_normalized = accessor["normalized"] == true;
        let number = |item: &[u8], place: usize| match accessor["componentType"].as_u64().unwrap() {
            5126 => f64::from(f32::from_le_bytes(item[4 * place..4 * place + 4].try_into().unwrap())),
            5123 => {
                let whole = f64::from(u16::from_le_bytes([item[2 * place], item[2 * place + 1]]));
                if is_normalized { whole / 65535.0 } else { whole }
            }
            5120 if is_normalized => f64::from(item[place] as i8) / 127.0,
            other => panic!("{other}"),
        };
        let vector = |item: &[u8]| DVec3::from([0, 1, 2].map(|place| number(item, place)));
        bytes.chunks_exact(stride).map(vector).collect()
    }

    fn indices(&self, accessor: &Value) -> Vec<u32> {
        let (_, bytes, _) = self.bytes(accessor, 2);
        let numbers = bytes.as_chunks::<2>().0.iter();
        numbers.map(|bytes| u32::from(u16::from_le_bytes(*bytes))).collect()
    }

    /// By the node's matrix, and from y upwards to z upwards.
    fn placed(&self, vector: DVec3, is_place: f64) -> DVec3 {
        let numbers = self.description["nodes"][0]["matrix"].as_array().unwrap();
        let number = |index: usize| numbers[index].as_f64().unwrap();
        let row = |axis: usize| {
            vector.x * number(axis)
                + vector.y * number(4 + axis)
                + vector.z * number(8 + axis)
                + is_place * number(12 + axis)
        };
        DVec3::new(row(0), -row(2), row(1))
    }

    fn positions(&self) -> Vec<DVec3> {
        self.vectors("POSITION")
            .iter()
            .map(|&at| self.placed(at, 1.0))
            .collect()
    }

    fn normals(&self) -> Vec<DVec3> {
        self.vectors("NORMAL")
            .iter()
            .map(|&normal| self.placed(normal, 0.0))
            .collect()
    }
}

fn measured(address: TileAddress, beside: &[TileAddress], packing: Packing) -> Placed {
    let beside: Vec<Tile> = beside.iter().map(|&address| tile(address)).collect();
    of_tile(&tile(address), &beside, packing)
}

fn of_tile(tile: &Tile, beside: &[Tile], packing: Packing) -> Placed {
    let surfaces = surfaces_of(&[beside, std::slice::from_ref(tile)].concat());
    let surface = TileSurface::measured(surfaces.last().unwrap(), packing);
    Placed::read(&file(&surface, packing, &metadata()).unwrap())
}

fn bits(vector: DVec3) -> [u64; 3] {
    vector.to_array().map(f64::to_bits)
}

#[test]
fn vertices_are_where_the_tile_has_them_within_the_step_of_their_zoom() {
    for address in [at(0, 1, 0), at(3, 5, 6), at(12, 3001, 2730)] {
        let tile = tile(address);
        let mesh = tile.surface(tile.finest());
        let positions = measured(address, &[], Packing::Plain).positions();
        let half_diagonal = 0.5_f64.powi(i32::from(address.zoom.min(11)) + 1) * 3.0_f64.sqrt();
        for (&lattice, placed) in mesh.positions.iter().zip(&positions) {
            let distance = tile.earth_centred(lattice).distance(*placed);
            assert!(distance <= half_diagonal, "{address}: {distance} m");
        }
        assert_eq!(positions.len(), mesh.positions.len());
    }
}

/// The places of each triangle's corners, in its order from the least on.
fn triangles(placed: &Placed, lattice: f64) -> BTreeSet<[[i64; 3]; 3]> {
    let positions = placed.positions();
    let indices = placed.indices(&placed.description["meshes"][0]["primitives"][0]["indices"]);
    let corner = |&vertex: &u32| {
        positions[vertex as usize]
            .to_array()
            .map(|metres| (metres / lattice).round() as i64)
    };
    let turned = |&[a, b, c]: &[u32; 3]| {
        let corners = [a, b, c].map(|vertex| corner(&vertex));
        (0..3)
            .map(|first| [0, 1, 2].map(|k| corners[(first + k) % 3]))
            .min()
            .unwrap()
    };
    indices.as_chunks::<3>().0.iter().map(turned).collect()
}

#[test]
fn packed_files_have_the_plain_ones_triangles_on_a_coarser_lattice() {
    for (address, step) in [(at(0, 1, 0), 512.0), (at(3, 5, 6), 64.0), (at(12, 3001, 2730), 0.125)] {
        let [plain, packed] = [Packing::Plain, Packing::Meshopt].map(|packing| measured(address, &[], packing));
        let coarse = |placed: &Placed| triangles(placed, step);
        assert_eq!(coarse(&packed), coarse(&plain), "{address}");
        assert_eq!(triangles(&packed, step).len(), 128);
        for position in packed.positions() {
            assert_eq!(position / step, (position / step).round(), "{address}");
        }
        let position = &packed.description["accessors"][0];
        let whole: Vec<DVec3> = packed.vectors("POSITION");
        let most = whole.iter().copied().fold(DVec3::ZERO, DVec3::max);
        assert_eq!(
            (&position["min"], &position["max"]),
            (&json!([0, 0, 0]), &json!(most.to_array().map(|at| at as u16)))
        );
        assert_eq!(
            packed.description["extensionsRequired"],
            json!(["EXT_meshopt_compression", "KHR_mesh_quantization"])
        );
        assert!(
            packed.binary.len() * 3 < plain.binary.len(),
            "{} of {}",
            packed.binary.len(),
            plain.binary.len()
        );
    }
}

#[test]
fn packed_normals_are_those_of_their_vertices() {
    let address = at(12, 3001, 2730);
    let [plain, packed] = [Packing::Plain, Packing::Meshopt].map(|packing| measured(address, &[], packing));
    let by_place = |placed: &Placed| -> BTreeMap<[i64; 3], DVec3> {
        let places = placed
            .positions()
            .into_iter()
            .map(|at| (at * 8.0).round().as_i64vec3().to_array());
        places.zip(placed.normals()).collect()
    };
    let [plain, packed] = [by_place(&plain), by_place(&packed)];
    assert_eq!(plain.len(), 81);
    for (place, normal) in plain {
        let degrees = normal.angle_between(packed[&place]).to_degrees();
        assert!(degrees < 1.5, "{degrees}");
    }
}

#[test]
fn neighbours_have_the_same_positions_and_normals_along_their_side_to_the_bit() {
    let (west, east) = (at(10, 300, 700), at(10, 301, 700));
    for packing in [Packing::Plain, Packing::Meshopt] {
        let of = |one: TileAddress, other: TileAddress| -> BTreeMap<[u64; 3], [u64; 3]> {
            let placed = measured(one, &[other], packing);
            let pairs = placed.positions().into_iter().zip(placed.normals());
            pairs.map(|(position, normal)| (bits(position), bits(normal))).collect()
        };
        let (ours, theirs) = (of(west, east), of(east, west));
        let shared: Vec<_> = ours.iter().filter(|(place, _)| theirs.contains_key(*place)).collect();
        assert_eq!(shared.len(), 9);
        let alike = shared.iter().filter(|(place, normal)| theirs[*place] == **normal);
        // Corners meet other tiles, too, which are not given here; but both are given the same.
        assert_eq!(alike.count(), 9);
    }
}

#[test]
fn a_tile_too_large_for_16_bits_has_its_positions_in_single_precision_and_still_meets_its_neighbour() {
    let (west, east) = (at(14, 4800, 11_200), at(14, 4801, 11_200));
    let tall = of_tile(&tile_with_tower(west, 4000.0), &[tile(east)], Packing::Meshopt);
    let small = of_tile(&tile(east), &[tile_with_tower(west, 4000.0)], Packing::Meshopt);
    let component = |placed: &Placed| placed.description["accessors"][0]["componentType"].clone();
    assert_eq!((component(&tall), component(&small)), (json!(5126), json!(5123)));
    let places = |placed: &Placed| -> BTreeSet<[u64; 3]> { placed.positions().into_iter().map(bits).collect() };
    assert_eq!(places(&tall).intersection(&places(&small)).count(), 9);
}

#[test]
fn the_error_has_room_for_rounding_and_grows_where_it_is_steep() {
    let error = |address, packing| {
        let surface = FinestSurface::unshaded(tile(address));
        TileSurface::measured(&surface, packing).error.unwrap()
    };
    let plain = |address| error(address, Packing::Plain);
    let flat = 2.5 + 0.5_f64.powi(11) * 3.0_f64.sqrt() / 2.0;
    assert!(plain(at(11, 300, 1000)) > flat && plain(at(11, 300, 1000)) < 2.51);
    assert!(plain(at(20, 300_000, 600_000)) > plain(at(11, 300, 1000)));
    let packed = error(at(11, 300, 1000), Packing::Meshopt);
    assert!(packed > 2.5 + 0.25 * 3.0_f64.sqrt() / 2.0 && packed < 2.8, "{packed}");
}

#[test]
fn a_whole_square_lists_the_vertices_of_its_sides() {
    let address = at(9, 200, 300);
    for packing in [Packing::Plain, Packing::Meshopt] {
        assert_sides_are_listed(address, packing);
    }
}

fn assert_sides_are_listed(address: TileAddress, packing: Packing) {
    let mesh = from_tile(&tile(address), &[], &Outside::Ellipsoid);
    let surface = TileSurface::whole_square(&mesh, address, packing);
    let placed = Placed::read(&file(&surface, packing, &metadata()).unwrap());
    let sides = &placed.description["meshes"][0]["primitives"][0]["extensions"]["CESIUM_tile_edges"];
    let positions = placed.positions();
    let degrees = |vertex: u32| {
        let place = terrain_codec::ellipsoid::to_geodetic(positions[vertex as usize]);
        [place.longitude, place.latitude]
    };
    let (near, far) = ([address.west(), address.south()], address.degrees());
    for (name, axis, value, grows) in [
        ("left", 0, near[0], true),
        ("bottom", 1, near[1], false),
        ("right", 0, near[0] + far, false),
        ("top", 1, near[1] + far, true),
    ] {
        let places: Vec<[f64; 2]> = placed.indices(&sides[name]).into_iter().map(degrees).collect();
        assert_eq!(places.len(), 9, "{name}");
        // Half a degree's 111,000th is half a metre, of which the steps of packed files are one.
        let near = if packing == Packing::Plain { 1e-7 } else { 2e-5 };
        assert!(places.iter().all(|place| (place[axis] - value).abs() < near), "{name}");
        assert!(
            places.is_sorted_by(|a, b| (a[1 - axis] < b[1 - axis]) == grows),
            "{name}"
        );
    }
}

/// Tiles of zooms 0 to `last` that hold a place.
fn column_of_tiles(last: u8) -> BTreeSet<TileAddress> {
    (0..=last)
        .map(|zoom| at(zoom, 777 >> (9 - zoom), 300 >> (9 - zoom)))
        .collect()
}

fn metadata() -> crate::metadata::Metadata {
    crate::metadata::Metadata {
        max_zoom: 9,
        heights: [0.0, 760.0],
        ..crate::archive::tests::metadata()
    }
}

#[test]
fn documents_name_every_tile_once_and_no_error_or_region_is_less_than_one_below() {
    let tiles = column_of_tiles(9);
    let describe = |address: TileAddress| {
        let error = 1000.0 / f64::from(1_u32 << address.zoom);
        Ok::<_, Infallible>(tiles.contains(&address).then_some(Described {
            heights: [0.0, 700.0],
            error,
        }))
    };
    let mut named = Vec::new();
    let mut open = vec![None];
    while let Some(root) = open.pop() {
        let Ok(document) = document(root, Packing::Meshopt, "?v=v1", &metadata(), &describe);
        let document = document.unwrap();
        assert_eq!(document["asset"]["version"], "1.1");
        let mut tiles = vec![document["root"].clone()];
        while let Some(tile) = tiles.pop() {
            let number = |value: &Value, index: usize| value["boundingVolume"]["region"][index].as_f64().unwrap();
            for child in tile["children"].as_array().into_iter().flatten() {
                assert!(child["geometricError"].as_f64() <= tile["geometricError"].as_f64());
                let told = |name: &str| child["metadata"]["properties"][name].as_f64().unwrap();
                assert!(child["geometricError"].as_f64() >= Some(told("certifiedError") + told("rounding")));
                assert!([0, 1, 4].iter().all(|&i| number(child, i) >= number(&tile, i)));
                assert!([2, 3, 5].iter().all(|&i| number(child, i) <= number(&tile, i)));
                tiles.push(child.clone());
            }
            let Some(uri) = tile["content"]["uri"].as_str() else {
                continue;
            };
            let path = uri.trim_start_matches("../").strip_suffix("?v=v1").unwrap();
            let (path, ending) = path.rsplit_once('.').unwrap();
            let numbers: Vec<u32> = path.split('/').map(|number| number.parse().unwrap()).collect();
            let address = at(numbers[0] as u8, numbers[1], numbers[2]);
            if ending == "json" {
                open.push(Some(address));
            } else {
                named.push(address);
            }
        }
    }
    named.sort_unstable();
    assert_eq!(named, tiles.into_iter().collect::<Vec<_>>());
}

#[test]
fn subtrees_tell_of_every_tile_in_morton_order_and_bound_what_is_in_it() {
    let tiles = column_of_tiles(9);
    let describe = |address: TileAddress| Ok::<_, Infallible>(tiles.contains(&address).then_some(([0.0, 760.0], 1.0)));
    let squares = Squares {
        outside: &Outside::Ellipsoid,
        describe,
    };
    let top = at(0, 1, 0);
    let Ok(bytes) = subtree(top, 9, &squares);
    let bytes = bytes.unwrap();
    assert_eq!(&bytes[..8], b"subt\x01\0\0\0");
    let length = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    let (text, binary) = bytes[24..].split_at(length(8));
    assert_eq!((text.len() % 8, binary.len()), (0, length(16)));
    let description: Value = serde_json::from_slice(text).unwrap();
    let view = |index: &Value| {
        let view = &description["bufferViews"][index.as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(start % 8, 0);
        &binary[start..start + view["byteLength"].as_u64().unwrap() as usize]
    };
    let bits = view(&description["tileAvailability"]["bitstream"]);
    assert_eq!(bits.len(), ((4_usize.pow(7) - 1) / 3).div_ceil(8));
    let is_set = |bits: &[u8], index: usize| bits[index / 8] >> (index % 8) & 1 == 1;
    // Morton: bits of x and y in turn, as the specification has it.
    let place = |address: TileAddress| {
        let first = (4_usize.pow(u32::from(address.zoom)) - 1) / 3;
        let x = address.x - (1 << address.zoom);
        first
            + (0..7)
                .map(|bit| ((x >> bit & 1) << (2 * bit) | (address.y >> bit & 1) << (2 * bit + 1)) as usize)
                .sum::<usize>()
    };
    let expected: BTreeSet<usize> = tiles
        .iter()
        .filter(|tile| tile.zoom < 7)
        .map(|&tile| place(tile))
        .collect();
    let set: BTreeSet<usize> = (0..bits.len() * 8).filter(|&index| is_set(bits, index)).collect();
    assert_eq!(
        (set, &description["tileAvailability"]["availableCount"]),
        (expected, &json!(7))
    );
    let children = view(&description["childSubtreeAvailability"]["bitstream"]);
    let set = (0..children.len() * 8).filter(|&index| is_set(children, index));
    let child = column_of_tiles(7).into_iter().next_back().unwrap();
    assert_eq!(set.collect::<Vec<_>>(), [place(child) - (4_usize.pow(7) - 1) / 3]);
    let table = &description["propertyTables"][0]["properties"];
    let numbers: Vec<f64> = view(&table["boundingSphere"]["values"])
        .as_chunks::<8>()
        .0
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect();
    for (sphere, &address) in numbers.as_chunks::<4>().0.iter().zip(&tiles) {
        let center = DVec3::from_slice(&sphere[..3]);
        let tile = tile(address);
        let mut distances = tile
            .surface(tile.finest())
            .positions
            .into_iter()
            .map(|at| tile.earth_centred(at).distance(center));
        assert!(distances.all(|distance| distance <= sphere[3]), "{address}");
    }
    let Ok(none) = subtree(at(7, 0, 0), 9, &squares);
    assert_eq!(none, None);
    let Ok(empty_root) = subtree(at(0, 0, 0), 9, &squares);
    assert!(empty_root.is_some(), "both roots are always there");
}
