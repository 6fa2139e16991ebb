#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::fs;

use pmtiles::PmTilesWriter;

use super::*;
use crate::metadata::{Asked, Source};
use crate::outside::Outside;
use crate::water::Water;

pub(crate) fn metadata() -> Metadata {
    Metadata {
        format: FORMAT.to_owned(),
        version: VERSION,
        scheme: "geographic-tms".to_owned(),
        bounds: [-123.5, 48.0, -122.25, 49.0],
        heights: [-3.0, 2_000.0],
        min_zoom: 0,
        max_zoom: 2,
        bound: "surface".to_owned(),
        max_error: 1.0,
        asked: Asked::default(),
        plan: String::new(),
        source: Source {
            files: vec!["a.tif".to_owned()],
            crs: "EPSG:4326".to_owned(),
            vertical_datum: "unspecified".to_owned(),
            heights_above: String::new(),
            geoid: None,
            samples: [10, 10],
            heights: Some([0.0, 100.0]),
        },
        generator: "test".to_owned(),
        zooms: Vec::new(),
        outside: Outside::default(),
        water: Water::default(),
    }
}

/// All 42 tiles of zooms 0 to 2, and bytes that tell them apart.
fn tiles() -> Vec<(TileAddress, Vec<u8>)> {
    let all = (0..3_u8).flat_map(|zoom| {
        let columns = 2_u32 << zoom;
        (0..columns).flat_map(move |x| (0..columns / 2).filter_map(move |y| TileAddress::new(zoom, x, y)))
    });
    all.map(|address| (address, format!("tile {address}").into_bytes()))
        .collect()
}

fn write(path: &Path, tiles: impl Iterator<Item = (TileAddress, Vec<u8>)>) {
    let mut writer = Writer::create(path).unwrap();
    for (address, bytes) in tiles {
        writer.add(address, &bytes).unwrap();
    }
    writer.finish(&metadata()).unwrap();
}

#[test]
fn every_tile_comes_back_in_the_order_of_ids() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pmtiles");
    write(&path, tiles().into_iter());
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.metadata(), &metadata());
    assert_eq!(reader.addresses().len(), 2 + 8 + 32);
    for (address, bytes) in tiles() {
        assert_eq!(reader.tile(address).unwrap(), Some(bytes));
    }
    assert_eq!(reader.tile(TileAddress::new(3, 0, 0).unwrap()).unwrap(), None);
    let ids: Vec<u64> = reader
        .addresses()
        .map(|address| TileId::from(coordinate(address)).value())
        .collect();
    assert!(ids.is_sorted());
}

#[test]
fn thousands_of_tiles_go_through_leaf_directories() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.pmtiles");
    let all = (0..20_000_u32).filter_map(|n| TileAddress::new(9, n / 32 * 7 % 1024, n % 512));
    let mut unique: Vec<_> = all.collect();
    unique.sort();
    unique.dedup();
    // Pseudo-random lengths keep the directory from compressing into the root.
    let bytes =
        |a: TileAddress| vec![7; 1 + (a.x.wrapping_mul(2_654_435_761) ^ a.y.wrapping_mul(40_503)) as usize % 997];
    write(&path, unique.iter().map(|&a| (a, bytes(a))));
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.addresses().len(), unique.len());
    for &address in unique.iter().step_by(501) {
        assert_eq!(reader.tile(address).unwrap(), Some(bytes(address)), "{address}");
    }
}

#[test]
fn roots_and_a_child_are_where_the_drawing_says() {
    let at = |zoom, x, y| {
        let there = coordinate(TileAddress::new(zoom, x, y).unwrap());
        (there.z(), there.x(), there.y())
    };
    assert_eq!(at(0, 0, 0), (1, 0, 0));
    assert_eq!(at(0, 1, 0), (1, 1, 0));
    assert_eq!(at(1, 3, 0), (2, 3, 1));
    assert_eq!(at(1, 3, 1), (2, 3, 0));
    for (tile, _) in tiles() {
        assert_eq!(address(coordinate(tile)), Some(tile));
    }
    assert_eq!(address(TileCoord::new(0, 0, 0).unwrap()), None);
    assert_eq!(
        address(TileCoord::new(2, 1, 2).unwrap()),
        None,
        "the southern half is never used"
    );
}

#[test]
fn bytes_depend_on_the_tiles_and_not_on_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
    write(&one, tiles().into_iter());
    write(&two, tiles().into_iter().rev());
    assert_eq!(fs::read(one).unwrap(), fs::read(two).unwrap());
}

#[test]
fn a_dropped_writer_leaves_the_folder_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pmtiles");
    write(&path, tiles().into_iter());
    let before = fs::read(&path).unwrap();
    let mut writer = Writer::create(&path).unwrap();
    writer.add(TileAddress::new(0, 0, 0).unwrap(), b"new").unwrap();
    drop(writer);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(fs::read(&path).unwrap(), before);
}

#[test]
fn a_tile_added_twice_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(&folder.path().join("a.pmtiles")).unwrap();
    let root = TileAddress::new(0, 1, 0).unwrap();
    writer.add(root, b"a").unwrap();
    writer.add(root, b"b").unwrap();
    let error = writer.finish(&metadata()).unwrap_err().to_string();
    assert!(error.ends_with("a.pmtiles: tile 0/1/0 was added twice"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_is_not_ours_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pmtiles");
    let refusal = |path: &Path| Reader::open(path).err().map(|error| error.to_string()).unwrap();
    assert!(refusal(&path).contains("No such file"));

    fs::write(&path, b"not an archive at all").unwrap();
    assert!(refusal(&path).contains("not a readable PMTiles archive: Invalid magic number"));

    for (kind, refused) in [
        (TileType::Png, "its tiles are Png, compression None"),
        (TileType::Unknown, "its metadata: missing field"),
    ] {
        let builder = PmTilesWriter::new(kind).metadata("{}");
        builder
            .create(File::create(&path).unwrap())
            .unwrap()
            .finalize()
            .unwrap();
        let line = refusal(&path);
        assert!(
            line.contains(&format!("not of surface-partition-tiles version 3: {refused}")),
            "{line}"
        );
    }

    write(&path, tiles().into_iter());
    let mut later = metadata();
    later.version = VERSION + 1;
    Writer::create(&path).unwrap().finish(&later).unwrap();
    assert!(refusal(&path).contains("its metadata say surface-partition-tiles version 4"));
}

#[test]
fn a_file_cut_short_or_scribbled_on_is_an_error_and_never_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pmtiles");
    write(&path, tiles().into_iter());
    let sound = fs::read(&path).unwrap();
    let read_all = |bytes: &[u8]| -> Result<(), ArchiveError> {
        fs::write(&path, bytes).unwrap();
        let reader = Reader::open(&path)?;
        tiles()
            .iter()
            .try_for_each(|(address, _)| reader.tile(*address).map(drop))
    };
    assert!(read_all(&sound).is_ok());
    for length in [0, 1, 126, 127, 200, 16_384, sound.len() - 1] {
        fs::write(&path, &sound[..length]).unwrap();
        assert!(Reader::open(&path).is_err(), "{length} bytes");
    }
    for position in (0..127).chain((127..600).step_by(7)) {
        let mut broken = sound.clone();
        broken[position] ^= 0xA5;
        // Some fields do not matter for reading; what counts is that none brings the program down.
        drop(read_all(&broken));
    }
}

#[test]
fn no_damaged_byte_passes_for_a_tile() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pmtiles");
    write(&path, tiles().into_iter());
    let sound = fs::read(&path).unwrap();
    let tile_bytes: usize = tiles().iter().map(|(_, bytes)| bytes.len()).sum();
    for position in sound.len() - tile_bytes..sound.len() {
        let mut broken = sound.clone();
        broken[position] ^= 1;
        fs::write(&path, broken).unwrap();
        let reader = Reader::open(&path).unwrap();
        let all = tiles();
        let refused = all.iter().filter(|(address, _)| match reader.tile(*address) {
            Err(error) => error.to_string().ends_with("is damaged, or the file was overwritten"),
            Ok(_) => false,
        });
        assert_eq!(refused.count(), 1, "byte {position}");
    }
}

#[test]
fn a_file_overwritten_while_it_is_open_gives_no_tile_of_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let [path, other] = ["a", "b"].map(|name| folder.path().join(name));
    write(&path, tiles().into_iter());
    let swapped = |bytes: Vec<u8>| bytes.into_iter().rev().collect();
    write(
        &other,
        tiles().into_iter().map(|(address, bytes)| (address, swapped(bytes))),
    );
    let reader = Reader::open(&path).unwrap();
    let later = Reader::open(&other).unwrap();
    assert_ne!(reader.version(), later.version());
    fs::copy(&other, &path).unwrap();
    for (address, _) in tiles() {
        assert!(reader.tile(address).is_err(), "{address}");
        assert_ne!(reader.checksum(address), later.checksum(address));
    }
}

#[test]
fn a_pipe_is_refused_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
    assert!(made.success());
    let error = Reader::open(&path).err().unwrap().to_string();
    assert!(error.ends_with("it is no regular file"), "{error}");
}
