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
