//! Makes a module of WebAssembly one of JavaScript, with types: `terrain-bindings MODULE.wasm FOLDER`.
#![forbid(unsafe_code)]

use std::path::PathBuf;

use anyhow::{Context, Result};
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<()> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [module, folder] = paths.as_slice() else {
        anyhow::bail!("usage: terrain-bindings MODULE.wasm FOLDER");
    };
    let mut bindings = Bindgen::new();
    bindings
        .input_path(module)
        .web(true)?
        .omit_default_module_path(true)
        .typescript(true)
        .remove_name_section(true)
        .remove_producers_section(true);
    let made = bindings.generate(folder);
    made.with_context(|| format!("{} cannot be bound", module.display()))
}
