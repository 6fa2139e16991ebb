//! Compiles the C++ shim between GeographicLib and the oracles of this crate.

fn main() {
    let library = pkg_config::probe_library("geographiclib")
        .unwrap_or_else(|error| panic!("GeographicLib is missing, see `./task setup`: {error}"));
    cc::Build::new()
        .cpp(true)
        .std("c++17")
        .file("src/geographiclib.cpp")
        .includes(library.include_paths)
        .compile("geographiclib_shim");
    println!("cargo::rerun-if-changed=src/geographiclib.cpp");
    // Again after the shim, for the linker's order of libraries.
    for name in library.libs {
        println!("cargo::rustc-link-lib={name}");
    }
}
