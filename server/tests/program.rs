//! The program as a user runs it: what it prints, and its exit codes.
#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Output;
use std::thread::sleep;
use std::time::{Duration, Instant};

use running::{Running, program};
use terrain_tiles::archive::Writer;

mod empty_archive;
mod running;

/// An archive without a tile: the server still has both roots.
fn empty_archive(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    Writer::create(&path)
        .unwrap()
        .finish(&empty_archive::metadata())
        .unwrap();
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
fn two_models_of_one_kind_and_name_are_refused() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mesh, curved) = (
        sources.join("../codec/golden/open_torus.spm"),
        sources.join("web/test/torus.clod"),
    );
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["a.spm", "a.SPM"].map(|name| folder.path().join(name));
    let other_kind = folder.path().join("a.clod");
    for (from, to) in [(&mesh, &first), (&mesh, &second), (&curved, &other_kind)] {
        fs::copy(from, to).unwrap();
    }
    let line = refusal(&program().args([&first, &other_kind, &second]).output().unwrap());
    assert_eq!(line, "error: two models are called “a”; rename one\n");
    let mut both = program();
    both.args([&first, &other_kind]).args(["--listen", "127.0.0.1:0"]);
    let server = Running::of(both);
    for path in ["/a/model.spm", "/a/curved.clod"] {
        let reply = server.send(&format!("HEAD {path} HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"));
        assert!(reply.starts_with("HTTP/1.1 200 OK"), "{reply}");
    }
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
    let server = Running::start(&[], &empty_archive(folder.path(), "a.pmtiles"));
    let reply = server.get("/healthz");
    assert!(reply.starts_with("HTTP/1.1 200 OK") && reply.ends_with("ok"), "{reply}");
    server.signal("-INT");
    assert_eq!(server.end().0, Some(0));
}

#[test]
fn half_a_request_does_not_keep_it_from_stopping() {
    let folder = tempfile::tempdir().unwrap();
    let server = Running::start(&["--stop-within", "1"], &empty_archive(folder.path(), "a.pmtiles"));
    let mut stream = server.connect();
    stream.write_all(b"GET /healthz HTTP/1.1\r\nHost: ").unwrap();
    // Whole requests are answered, so that the half one has arrived, too.
    server.get("/healthz");
    server.signal("-TERM");
    let start = Instant::now();
    assert_eq!(server.end().0, Some(0));
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}

#[test]
fn requests_that_trickle_and_connections_that_idle_end() {
    let folder = tempfile::tempdir().unwrap();
    let server = Running::start(&["--header-timeout", "1"], &empty_archive(folder.path(), "a.pmtiles"));
    let idle = server.connect();
    let trickling: Vec<TcpStream> = (0..20)
        .map(|_| {
            let mut stream = server.connect();
            stream.write_all(b"GET / HTTP/1.1\r\n").unwrap();
            stream
        })
        .collect();
    for mut stream in trickling.into_iter().chain([idle]) {
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let mut rest = Vec::new();
        assert!(stream.read_to_end(&mut rest).is_ok(), "it is still open");
    }
}

#[test]
fn connections_beyond_the_most_wait_and_the_log_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--max-connections", "2", "--header-timeout", "1"];
    let server = Running::start(&arguments, &empty_archive(folder.path(), "a.pmtiles"));
    let held = [server.connect(), server.connect()];
    let reply = server.get("/healthz");
    assert!(reply.ends_with("ok"), "it comes when the others have ended: {reply}");
    drop(held);
    server.signal("-TERM");
    let (_, said) = server.end();
    assert!(said.contains("as many connections are open as may be"), "{said}");
}

#[test]
fn headers_and_bodies_have_limits() {
    let folder = tempfile::tempdir().unwrap();
    let server = Running::start(&["--answer-timeout", "1"], &empty_archive(folder.path(), "a.pmtiles"));
    let long = "x".repeat(40_000);
    let reply = server.send(&format!("GET / HTTP/1.1\r\nHost: a\r\nX: {long}\r\n\r\n"));
    assert!(reply.starts_with("HTTP/1.1 431"), "{reply}");
    let both = "POST /tilesets HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n";
    assert!(server.send(both).starts_with("HTTP/1.1 411"));
    assert!(
        server
            .send("GET /healthz HTTP/1.1\r\nConnection: close\r\n\r\n")
            .starts_with("HTTP/1.1 400")
    );
}

#[test]
fn archives_are_looked_at_again_when_asked_by_a_signal() {
    let folder = tempfile::tempdir().unwrap();
    empty_archive(folder.path(), "a.pmtiles");
    let server = Running::start(&["--look-every", "0"], folder.path());
    assert!(server.get("/b/layer.json").starts_with("HTTP/1.1 404"));
    empty_archive(folder.path(), "b.pmtiles");
    server.signal("-HUP");
    let start = Instant::now();
    while !server.get("/b/layer.json").starts_with("HTTP/1.1 200") {
        assert!(start.elapsed() < Duration::from_secs(10), "it never appears");
        sleep(Duration::from_millis(20));
    }
}

#[test]
fn flags_count_before_the_environment_and_that_before_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let archive = empty_archive(folder.path(), "a.pmtiles");
    let file = folder.path().join("settings.toml");
    fs::write(&file, format!("archives = [{archive:?}]\nlisten = \"127.0.0.2:0\"\n")).unwrap();
    let listening = |flags: &[&str], variable: &[(&str, &str)]| {
        let mut command = program();
        command
            .arg("--settings")
            .arg(&file)
            .args(flags)
            .envs(variable.iter().copied());
        Running::of(command).host.split(':').next().unwrap().to_owned()
    };
    let variable = [("TERRAIN_LISTEN", "127.0.0.3:0")];
    assert_eq!(listening(&["--listen", "127.0.0.4:0"], &variable), "127.0.0.4");
    assert_eq!(listening(&[], &variable), "127.0.0.3");
    assert_eq!(listening(&[], &[]), "127.0.0.2");
    fs::write(&file, format!("archives = [{archive:?}]\ncolour = 1\n")).unwrap();
    let line = refusal(&program().arg("--settings").arg(&file).output().unwrap());
    assert!(line.contains("colour"), "{line}");
    let line = refusal(&program().output().unwrap());
    assert!(line.starts_with("error: no archive and no folder is given"), "{line}");
}

#[test]
fn the_access_log_has_a_line_for_each_request() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Running::start(&["--access-log", "json"], &empty_archive(folder.path(), "a.pmtiles"));
    server.get("/healthz?x");
    server.get("/none/layer.json");
    server.signal("-TERM");
    let mut text = String::new();
    server.process.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    let lines: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let told = |line: &serde_json::Value| format!("{} {}", line["fields"]["uri"], line["fields"]["status"]);
    let told: Vec<_> = lines.iter().map(told).collect();
    assert_eq!(told, ["\"/healthz?x\" 200", "\"/none/layer.json\" 404"]);
}
