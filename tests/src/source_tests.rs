#![expect(clippy::unwrap_used, reason = "tests fail by panicking")]

use super::*;

/// What the files of a small crate use; each is given by its name and its text.
fn uses(files: &[(&str, &str)]) -> BTreeSet<Use> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let libraries = ["gdal", "proj-sys"].map(str::to_owned).into();
    Crate::read(folder.path(), "lib.rs", &libraries).uses()
}

fn of_file(uses: &BTreeSet<Use>, file: &str) -> Vec<String> {
    let own = uses.iter().filter(|used| used.file == file);
    own.map(|used| match &used.target {
        Target::File(name) | Target::Library(name) => name.clone(),
    })
    .collect()
}

fn edges(pairs: &[(&str, &str)]) -> Vec<Edge> {
    let owned = |&(from, to): &(&str, &str)| (from.to_owned(), to.to_owned());
    pairs.iter().map(owned).collect()
}

#[test]
fn paths_are_seen_wherever_they_stand() {
    let places = [
        "use crate::b::B;",
        "use crate::b::{self, B as C};",
        "use crate::{b::B};",
        "use crate::b::*;",
        "use super::b::B;",
        "fn f() -> crate::b::B { panic!() }",
        "fn f() { crate::b::g() }",
        "fn f() { use crate::b; }",
        "fn f<T: crate::b::B>() {}",
        "fn f() { assert!(matches!(1, crate::b::N)) }",
        "fn f() { println!(\"{}\", super::b::g(1)) }",
        "#[derive(crate::b::Derived)] struct S;",
        "mod inner { fn f() { super::super::b::g() } }",
        "impl From<crate::b::B> for S {}",
    ];
    for place in places {
        let uses = uses(&[("lib.rs", "mod a; mod b;"), ("a.rs", place), ("b.rs", "")]);
        let files: Vec<_> = of_file(&uses, "a.rs")
            .into_iter()
            .filter(|name| name == "b.rs")
            .collect();
        assert_eq!(files, ["b.rs"], "{place}");
    }
}

#[test]
fn libraries_are_named_by_their_whole_paths() {
    let text = "use std::{fs, net::TcpStream as Wire}; use gdal::Dataset; use proj_sys::*;
        fn f() { fs::read(\"\"); let proj_sys = 1; g(proj_sys); println!(\"\"); Dataset::open() }";
    let uses = uses(&[("lib.rs", text)]);
    let expected = [
        "gdal::Dataset",
        "gdal::Dataset::open",
        "proj_sys::*",
        "std::fs",
        "std::fs::read",
        "std::net::TcpStream",
        "std::println",
    ];
    assert_eq!(of_file(&uses, "lib.rs"), expected);
}

#[test]
fn re_exports_lead_to_the_file_that_they_point_at() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use b::B; use a::A;"),
        ("a.rs", "use crate::B; fn f() { crate::B::new() }"),
        ("b.rs", "mod c; pub use c::C as B;"),
        ("b/c.rs", "pub struct C;"),
    ];
    let uses = uses(&files);
    assert_eq!(of_file(&uses, "a.rs"), ["b/c.rs"]);
    assert_eq!(of_file(&uses, "lib.rs"), ["a.rs"]);
}

#[test]
fn tests_and_local_names_are_no_uses() {
    let text =
        "mod b; #[cfg(test)] use crate::b::B; #[cfg(test)] mod tests { use crate::b::B; } fn f() { let b = 1; g(b) }";
    assert_eq!(
        uses(&[("lib.rs", "mod a;"), ("a.rs", text), ("a/b.rs", "")]),
        BTreeSet::new()
    );
}

#[test]
fn a_circle_is_found_however_long() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B;"),
        ("b.rs", "use crate::c::C;"),
        ("c.rs", "fn f() { crate::a::g() }"),
        ("d.rs", "use crate::a::A;"),
    ];
    let circle = [("a.rs", "b.rs"), ("b.rs", "c.rs"), ("c.rs", "a.rs")];
    assert_eq!(edges_on_circles(&uses(&files)), edges(&circle));
    let broken = [&files[..3], &[("c.rs", ""), files[4]]].concat();
    assert_eq!(edges_on_circles(&uses(&broken)), []);
}

#[test]
fn files_that_call_each_others_methods_of_one_type_are_a_circle() {
    let files = [
        ("lib.rs", "mod a;"),
        ("a.rs", "mod b; struct S; impl S { fn f(&self) { self.g() } }"),
        ("a/b.rs", "use super::S; impl S { fn g(&self) {} }"),
    ];
    assert_eq!(
        edges_on_circles(&uses(&files)),
        edges(&[("a.rs", "a/b.rs"), ("a/b.rs", "a.rs")])
    );
    let uncalled = [
        files[0],
        ("a.rs", "mod b; struct S; impl S { fn f(&self) {} }"),
        files[2],
    ];
    assert_eq!(edges_on_circles(&uses(&uncalled)), []);
}
