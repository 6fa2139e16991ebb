#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use terrain_codec::address::TileAddress;
use terrain_tiles::archive::Writer;

use super::*;
use crate::form::{Form, TileRequest};

#[path = "../tests/empty_archive/mod.rs"]
mod empty_archive;

const ROOT: TileRequest = TileRequest {
    address: TileAddress { zoom: 0, x: 0, y: 0 },
    form: Form::Progressive,
};

/// An archive of one root tile with these bytes.
fn write(path: &Path, bytes: &[u8]) {
    let mut writer = Writer::create(path).unwrap();
    writer.add(ROOT.address, bytes).unwrap();
    writer.finish(&empty_archive::metadata()).unwrap();
}

fn root(catalogue: &Catalogue, name: &str) -> Vec<u8> {
    ROOT.body(&catalogue.find(name).unwrap()).unwrap().to_vec()
}

#[test]
fn archives_come_change_and_go_with_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.pmtiles", "b.pmtiles"].map(|name| folder.path().join(name));
    let catalogue = Catalogue::open(vec![folder.path().to_owned()]).unwrap();
    assert!(catalogue.names().is_empty());
    write(&a, b"first");
    fs::write(folder.path().join("notes.txt"), "no archive").unwrap();
    catalogue.refresh();
    assert_eq!(
        (catalogue.names(), root(&catalogue, "a")),
        (vec!["a".to_owned()], b"first".to_vec())
    );
    let first = catalogue.find("a").unwrap();
    write(&a, b"other");
    write(&b, b"b");
    catalogue.refresh();
    assert_eq!((catalogue.names().len(), root(&catalogue, "a")), (2, b"other".to_vec()));
    assert_eq!(
        ROOT.body(&first).unwrap(),
        &b"first"[..],
        "who began with it reads it to the end"
    );
    let kept = catalogue.find("b").unwrap();
    catalogue.refresh();
    assert!(
        Arc::ptr_eq(&kept, &catalogue.find("b").unwrap()),
        "what did not change stays open"
    );
    fs::remove_file(&a).unwrap();
    catalogue.refresh();
    assert_eq!(catalogue.names(), ["b"]);
}

#[test]
fn a_file_that_is_half_written_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pmtiles");
    write(&path, b"first");
    let catalogue = Catalogue::open(vec![path.clone()]).unwrap();
    let whole = fs::read(&path).unwrap();
    fs::remove_file(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    catalogue.refresh();
    assert_eq!(root(&catalogue, "a"), b"first");
    fs::write(&path, &whole).unwrap();
    catalogue.refresh();
    assert_eq!(root(&catalogue, "a"), b"first");
}

#[test]
fn a_bad_archive_is_refused_where_it_is_named_and_passed_over_in_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let [good, bad] = ["good.pmtiles", "bad.pmtiles"].map(|name| folder.path().join(name));
    write(&good, b"good");
    fs::write(&bad, "junk").unwrap();
    assert!(Catalogue::open(vec![bad]).is_err());
    assert_eq!(
        Catalogue::open(vec![folder.path().to_owned()]).unwrap().names(),
        ["good"]
    );
    assert!(Catalogue::open(vec![folder.path().join("none")]).is_err());
}
