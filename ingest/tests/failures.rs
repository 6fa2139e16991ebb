//! What the world outside does to a build: folders that cannot be written, a disk that is full, files that vanish. One line, an exit
//! code that says whose fault it is, and nothing half-written under the final name.
#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

mod in_folder;
mod run;

use std::fs::{self, Permissions};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use tempfile::TempDir;

use in_folder::{SAMPLE, names, tells_its_cause_once, text};
use run::run;

const BUILD: [&str; 6] = [SAMPLE, "--max-error", "40", "-o", "out.pmtiles", "--quiet"];
const TIN: [&str; 7] = ["tin", SAMPLE, "--max-error", "10", "-o", "out.ply", "--quiet"];

/// One line on standard error, which is returned without its end.
fn failure(output: &Output, code: i32) -> String {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.starts_with("error: ") && tells_its_cause_once(&error), "{error}");
    assert!(output.stdout.is_empty());
    error.trim_end().to_owned()
}

/// Runs the program where no file may have more bytes: a write beyond fails as on a full disk, with another word.
fn run_on_a_small_disk(folder: &Path, bytes: u64, arguments: &[&str]) -> Output {
    // The shell counts in blocks of 512 bytes.
    let limits = format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"", bytes / 512);
    Command::new("sh")
        .args(["-c", &limits, env!("CARGO_BIN_EXE_terrain-ingest")])
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs the program as one whom permissions bind, which they do not the superuser.
fn run_bound_by_permissions(folder: &Path, arguments: &[&str]) -> Output {
    let is_superuser = fs::metadata("/proc/self").unwrap().uid() == 0;
    if !is_superuser {
        return run(folder, arguments);
    }
    Command::new("setpriv")
        .args(["--bounding-set=-dac_override", env!("CARGO_BIN_EXE_terrain-ingest")])
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// A folder in which nothing can be made.
fn locked(folder: &Path, name: &str) {
    fs::create_dir(folder.join(name)).unwrap();
    fs::set_permissions(folder.join(name), Permissions::from_mode(0o555)).unwrap();
}

#[test]
fn where_nothing_can_be_written_the_line_names_the_place() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    locked(path, "locked");
    let cases: [(&[&str], &str); 4] = [
        (
            &[SAMPLE, "-o", "locked/out.pmtiles"],
            "error: locked/out.pmtiles.work: Permission denied (os error 13)",
        ),
        (
            &[SAMPLE, "-o", "out.pmtiles", "--work", "locked"],
            "error: locked/lock: Permission denied (os error 13)",
        ),
        (
            &[SAMPLE, "-o", "out.pmtiles", "--work", "locked/work"],
            "error: locked/work: Permission denied (os error 13)",
        ),
        (
            &["tin", SAMPLE, "--max-error", "50", "-o", "locked/out.ply"],
            "error: locked/out.ply: Permission denied (os error 13)",
        ),
    ];
    for (arguments, line) in cases {
        let output = run_bound_by_permissions(path, &[arguments, &["--quiet"]].concat());
        assert_eq!(failure(&output, 1), line);
        assert_eq!(names(path), ["locked"], "{arguments:?}");
        assert_eq!(names(&path.join("locked")), [""; 0], "{arguments:?}");
    }
}

#[test]
fn a_device_or_a_pipe_is_never_replaced_by_an_output() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    // As a device would be, but anybody can make one.
    let _sockets = ["out.pmtiles", "out.ply"].map(|name| UnixListener::bind(path.join(name)).unwrap());
    for (arguments, name) in [(&BUILD[..], "out.pmtiles"), (&TIN, "out.ply")] {
        let line = failure(&run(path, arguments), 2);
        assert_eq!(
            line,
            format!("error: {name}: is a device or a pipe, and no file that can be replaced")
        );
        assert!(fs::metadata(path.join(name)).unwrap().file_type().is_socket());
    }
    assert_eq!(names(path), ["out.ply", "out.pmtiles"]);
}

#[test]
fn an_archive_that_has_no_place_at_the_end_leaves_the_work_that_makes_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    locked(path, "locked");
    let arguments = |output| [SAMPLE, "--max-error", "40", "-o", output, "--work", "work", "--quiet"];
    let output = run_bound_by_permissions(path, &arguments("locked/out.pmtiles"));
    assert_eq!(
        failure(&output, 1),
        "error: locked/out.pmtiles: Permission denied (os error 13); finished work is kept in work: the same command goes on from there"
    );
    assert_eq!(names(&path.join("locked")), [""; 0]);
    assert!(run(path, &arguments("out.pmtiles")).status.success());
    assert!(
        run(path, &[&BUILD[..3], &["-o", "other.pmtiles", "--quiet"]].concat())
            .status
            .success()
    );
    assert_eq!(names(path), ["locked", "other.pmtiles", "out.pmtiles"]);
    assert!(fs::read(path.join("out.pmtiles")).unwrap() == fs::read(path.join("other.pmtiles")).unwrap());
}

#[test]
fn a_disk_that_is_full_amid_the_work_is_told_and_the_build_goes_on_where_there_is_room() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let line = failure(&run_on_a_small_disk(path, 8 << 10, &BUILD), 1);
    assert!(
        line.starts_with("error: out.pmtiles.work/samples/")
            && line.ends_with("File too large (os error 27); finished work is kept in out.pmtiles.work: the same command goes on from there"),
        "{line}"
    );
    assert_eq!(names(path), ["out.pmtiles.work"]);
    assert!(run(path, &BUILD).status.success());
    assert_eq!(names(path), ["out.pmtiles"]);
}

#[test]
fn a_disk_that_is_full_under_the_output_leaves_the_one_before_as_it_was() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::write(path.join("out.ply"), "before").unwrap();
    let line = failure(&run_on_a_small_disk(path, 8 << 10, &TIN), 1);
    assert_eq!(line, "error: out.ply: File too large (os error 27)");

    let kept = [&BUILD[..], &["--work", "work", "--keep-work"]].concat();
    assert!(run(path, &kept).status.success());
    let whole = fs::read(path.join("out.pmtiles")).unwrap();
    fs::write(path.join("out.pmtiles"), "before").unwrap();
    let line = failure(&run_on_a_small_disk(path, whole.len() as u64 / 2, &kept), 1);
    assert!(
        line.starts_with("error: out.pmtiles: File too large (os error 27); "),
        "{line}"
    );
    for name in ["out.ply", "out.pmtiles"] {
        assert_eq!(fs::read(path.join(name)).unwrap(), b"before", "{name}");
    }
    assert_eq!(names(path), ["out.ply", "out.pmtiles", "work"]);
    assert!(run(path, &kept).status.success());
    assert!(fs::read(path.join("out.pmtiles")).unwrap() == whole);
}

#[test]
fn what_was_left_of_a_killed_build_beside_the_output_is_gone_after_the_next() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    assert!(run(path, &BUILD).status.success());
    let whole = fs::read(path.join("out.pmtiles")).unwrap();
    fs::write(path.join(".out.pmtiles.part"), [&whole[..], b"and more"].concat()).unwrap();
    assert!(run(path, &BUILD).status.success());
    assert_eq!(names(path), ["out.pmtiles"]);
    assert!(fs::read(path.join("out.pmtiles")).unwrap() == whole);
}

#[test]
fn an_input_that_is_gone_when_the_build_goes_on_is_told_and_the_work_is_kept() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    fs::copy(SAMPLE, path.join("dem.tif")).unwrap();
    let build = ["dem.tif", "--max-error", "40", "-o", "out.pmtiles", "--quiet"];
    failure(&run_on_a_small_disk(path, 8 << 10, &build), 1);
    fs::remove_file(path.join("dem.tif")).unwrap();
    let line = failure(&run(path, &build), 2);
    assert_eq!(
        line,
        "error: dem.tif: cannot be read: No such file or directory (os error 2)"
    );
    assert_eq!(names(path), ["out.pmtiles.work"]);
}

/// Text is read slowly: what is gone as soon as a build has begun is missed by it.
#[test]
fn an_input_that_vanishes_while_it_is_read_is_told_and_nothing_is_left() {
    let folder = TempDir::new().unwrap();
    let path = folder.path();
    let side = 2_000;
    let row = (0..side)
        .map(|column| (column % 97).to_string())
        .collect::<Vec<_>>()
        .join(" ");
    let header = format!("ncols {side}\nnrows {side}\nxllcorner 10\nyllcorner 50\ncellsize 0.001\n");
    fs::write(
        path.join("dem.asc"),
        format!("{header}{}", format!("{row}\n").repeat(side)),
    )
    .unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_terrain-ingest"))
        .args(["dem.asc", "--crs", "EPSG:4326", "-o", "out.pmtiles", "--quiet"])
        .current_dir(path)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !path.join("out.pmtiles.work").exists() {
        sleep(Duration::from_millis(1));
    }
    fs::remove_file(path.join("dem.asc")).unwrap();
    let line = failure(&child.wait_with_output().unwrap(), 2);
    assert!(line.starts_with("error: dem.asc: cannot be read: "), "{line}");
    assert_eq!(names(path), [""; 0]);
}
