//! The program as a user runs it: what it prints, and its exit codes.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use terrain_tiles::archive::Writer;
use terrain_tiles::metadata::{Asked, FORMAT, Metadata, Source, VERSION};

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_terrain-server"))
}

/// An archive without a tile: the server still has both roots.
fn empty_archive(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let metadata = Metadata {
        format: FORMAT.to_owned(),
        version: VERSION,
        scheme: "geographic-tms".to_owned(),
        bounds: [0.0, 0.0, 1.0, 1.0],
        heights: [0.0, 0.0],
        min_zoom: 0,
        max_zoom: 0,
        bound: "surface".to_owned(),
        max_error: 1.0,
        asked: Asked::default(),
        plan: String::new(),
        source: Source {
            files: Vec::new(),
            crs: "EPSG:4326".to_owned(),
            vertical_datum: "unspecified".to_owned(),
            heights_above: String::new(),
            geoid: None,
            samples: [2, 2],
        },
        generator: "test".to_owned(),
        outside: terrain_tiles::outside::Outside::default(),
        zooms: Vec::new(),
    };
    Writer::create(&path).unwrap().finish(&metadata).unwrap();
    path
}

/// Exit code 2 and one line, which is returned.
fn refusal(output: &Output) -> String {
    let line = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{line}");
    line
}

#[test]
fn a_bad_archive_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let junk = folder.path().join("junk.pmtiles");
    fs::write(&junk, "junk").unwrap();
    let line = refusal(&program().arg(&junk).output().unwrap());
    assert!(
        line.ends_with("junk.pmtiles: not a readable PMTiles archive: Invalid magic number\n"),
        "{line}"
    );
    let line = refusal(&program().arg(folder.path().join("none.pmtiles")).output().unwrap());
    assert!(
        line.ends_with("none.pmtiles: No such file or directory (os error 2)\n"),
        "{line}"
    );
}

#[test]
fn two_archives_of_one_name_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let paths = [
        empty_archive(folder.path(), "a.pmtiles"),
        empty_archive(folder.path(), "a.tiles"),
    ];
    let line = refusal(&program().args(paths).output().unwrap());
    assert_eq!(line, "error: two archives are called “a”; rename one\n");
}

#[test]
fn a_port_that_is_taken_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let holder = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = holder.local_addr().unwrap();
    let archive = empty_archive(folder.path(), "a.pmtiles");
    let line = refusal(
        &program()
            .arg(archive)
            .args(["--listen", &taken.to_string()])
            .output()
            .unwrap(),
    );
    assert!(
        line.starts_with(&format!("error: cannot listen on {taken}: Address already in use")),
        "{line}"
    );
}

#[test]
fn it_prints_its_address_answers_there_and_stops_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let archive = empty_archive(folder.path(), "a.pmtiles");
    let mut server = program()
        .arg(archive)
        .args(["--listen", "127.0.0.1:0"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(server.stdout.take().unwrap())
        .lines()
        .map_while(Result::ok);
    let address = lines.take(2).last().unwrap();
    let host = address.trim_start_matches("http://").trim_end_matches('/').to_owned();
    let mut stream = TcpStream::connect(&host).unwrap();
    write!(
        stream,
        "GET /healthz HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    )
    .unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    assert!(reply.starts_with("HTTP/1.1 200 OK") && reply.ends_with("ok"), "{reply}");
    assert!(
        Command::new("kill")
            .args(["-INT", &server.id().to_string()])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(server.wait().unwrap().code(), Some(0));
}
