#![expect(clippy::unwrap_used, reason = "a test says what is wrong by failing")]

use std::io::Write;

use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn what_is_not_finished_leaves_the_file_as_it_was_and_nothing_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    fs::write(&output, "old").unwrap();
    let mut file = NewFile::create(&output).unwrap();
    file.file().write_all(b"half").unwrap();
    drop(file);
    assert_eq!(fs::read(&output).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
fn what_a_killed_program_left_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    fs::write(folder.path().join(".out.part"), "longer than what comes").unwrap();
    let mut file = NewFile::create(&output).unwrap();
    file.file().write_all(b"new").unwrap();
    file.finish().unwrap();
    assert_eq!(fs::read(&output).unwrap(), b"new");
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
fn of_two_who_write_one_file_the_second_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let mut first = NewFile::create(&output).unwrap();
    first.file().write_all(b"first").unwrap();
    let second = NewFile::create(&output).err().unwrap();
    assert_eq!(second.to_string(), "another program is writing it");
    first.finish().unwrap();
    assert_eq!(fs::read(&output).unwrap(), b"first");
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
fn what_is_no_file_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    // A socket is in a folder what a device is in /dev.
    let _socket = std::os::unix::net::UnixListener::bind(&output).unwrap();
    let refused = NewFile::create(&output).err().unwrap();
    assert_eq!(refused.to_string(), "is not a file");
    assert!(!fs::metadata(&output).unwrap().is_file());
    assert_eq!(names(folder.path()), ["out"]);
}

#[test]
fn a_link_stays_and_what_it_leads_to_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    let (output, there) = (folder.path().join("out"), elsewhere.path().join("there"));
    fs::write(&there, "old").unwrap();
    std::os::unix::fs::symlink(&there, &output).unwrap();
    let mut file = NewFile::create(&output).unwrap();
    file.file().write_all(b"new").unwrap();
    file.finish().unwrap();
    assert!(fs::symlink_metadata(&output).unwrap().is_symlink());
    assert_eq!(fs::read(&there).unwrap(), b"new");
    assert_eq!(
        (names(folder.path()), names(elsewhere.path())),
        (vec!["out".into()], vec!["there".into()])
    );
}
