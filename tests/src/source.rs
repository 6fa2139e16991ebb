//! The files of a crate and what each of them uses, as the source says it.
//!
//! ```text
//! lib.rs ──mod──▶ files, each read by syn ──names──▶ paths ──resolve──▶ uses: file → file, file → path of a library
//! ```
//!
//! Modules are resolved as the compiler does it: `crate`, `self`, `super`, names that `use` brings in, modules that stand in
//! the module. A re-export is a signpost: who goes by it uses the file that it points at, and a file that only re-exports a name does
//! not use it. A type whose methods stand in several files ties these together where they call each other's. Tests are left out.
//! Calls of methods are not resolved otherwise, since that takes a compiler: what a file calls methods of, it has named somewhere.

mod circles;
mod paths;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path as FilePath, PathBuf};

pub use circles::{Edge, edges_on_circles};
use paths::{Import, Names, Path};

/// A file uses something.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Use {
    /// The file, from the folder that the crate was read in.
    pub file: String,
    /// What it uses.
    pub target: Target,
}

/// What is used.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// Another file of the crate.
    File(String),
    /// A path of another crate, as `std::fs::read`.
    Library(String),
}

/// The modules of a crate, by their paths from its root.
pub struct Crate {
    modules: BTreeMap<Path, Module>,
    libraries: BTreeSet<String>,
}

struct Module {
    file: String,
    names: Names,
}

/// Re-exports that lead to re-exports are followed so many times.
const SIGNPOSTS: usize = 8;

impl Crate {
    /// Reads the crate whose root is the file `root`, given from the folder `top`. `libraries` are the other crates that it may name.
    ///
    /// # Panics
    /// Where a file cannot be read or is no Rust.
    #[must_use]
    pub fn read(top: &FilePath, root: &str, libraries: &BTreeSet<String>) -> Self {
        let standard = ["std", "core", "alloc"].map(str::to_owned);
        let mut this = Self {
            modules: BTreeMap::new(),
            libraries: libraries
                .iter()
                .map(|name| name.replace('-', "_"))
                .chain(standard)
                .collect(),
        };
        let folder = FilePath::new(root).parent().map(FilePath::to_owned).unwrap_or_default();
        this.read_file(top, root, &folder, Path::new());
        this
    }

    /// Everything that the files use of each other and of libraries.
    #[must_use]
    pub fn uses(&self) -> BTreeSet<Use> {
        let mut uses = BTreeSet::new();
        for (at, module) in &self.modules {
            let targets = self.named(at, module).chain(self.called(at, module));
            uses.extend(targets.map(|target| Use {
                file: module.file.clone(),
                target,
            }));
        }
        uses.retain(|used| used.target != Target::File(used.file.clone()));
        uses
    }

    /// Reads a file and all below it; `folder` is where the files of its modules are.
    fn read_file(&mut self, top: &FilePath, file: &str, folder: &FilePath, at: Path) {
        let text = fs::read_to_string(top.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{file}: {error}"));
        self.add_module(top, file, folder, at, &syntax.items);
    }

    fn add_module(&mut self, top: &FilePath, file: &str, folder: &FilePath, at: Path, items: &[syn::Item]) {
        let mut names = Names::of(items);
        let modules = std::mem::take(&mut names.modules);
        let file_name = file.to_owned();
        self.modules.insert(at.clone(), Module { file: file_name, names });
        for (name, items) in modules {
            let below = folder.join(&name);
            let at = [at.as_slice(), std::slice::from_ref(&name)].concat();
            match items {
                Some(items) => self.add_module(top, file, &below, at, &items),
                None => self.read_file(top, &module_file(top, folder, &name), &below, at),
            }
        }
    }

    /// What a module names in `use` items and in paths.
    fn named<'a>(&'a self, at: &'a Path, module: &'a Module) -> impl Iterator<Item = Target> + 'a {
        let Names { imports, paths, .. } = &module.names;
        // A re-exported library is used by whoever writes it down, for it appears in this crate's face.
        let imported = imports.iter().filter_map(|import| {
            let target = self.target(at, &import.path, import.name == "*")?;
            (!import.is_exported || matches!(target, Target::Library(_))).then_some(target)
        });
        imported.chain(paths.iter().filter_map(|path| self.target(at, path, false)))
    }

    /// Files with methods of a type that stands here, too, or whose methods do, if they are called here.
    fn called<'a>(&'a self, at: &'a Path, module: &'a Module) -> impl Iterator<Item = Target> + 'a {
        let own: BTreeSet<Path> = module
            .names
            .methods
            .iter()
            .map(|methods| self.absolute(at, &methods.of))
            .collect();
        let is_called = |name: &String| {
            let names = &module.names;
            names.calls.contains(name)
                || names
                    .paths
                    .iter()
                    .any(|path| path.len() > 1 && path.last() == Some(name))
        };
        let others = self.modules.iter().filter(move |(_, other)| other.file != module.file);
        let called = move |(at, other): (&Path, &Module)| {
            let mut shared = other
                .names
                .methods
                .iter()
                .filter(|methods| own.contains(&self.absolute(at, &methods.of)));
            shared
                .any(|methods| methods.names.iter().any(is_called))
                .then(|| Target::File(other.file.clone()))
        };
        others.filter_map(called)
    }

    /// What a path that is written in the module `at` means; none for a local name, or one that every program knows.
    fn target(&self, at: &Path, path: &Path, is_glob: bool) -> Option<Target> {
        // A single word that is not imported is a variable, though a module or a library may be called the same.
        if path.len() == 1 && self.import(at, &path[0]).is_none() && !is_glob {
            return None;
        }
        let resolved = self.absolute(at, path);
        if resolved.first().is_some_and(|first| first == "crate") {
            let module = &self.modules[self.module_of(&resolved[1..])];
            return Some(Target::File(module.file.clone()));
        }
        let is_library = self.libraries.contains(resolved.first()?);
        let all = if is_glob { "::*" } else { "" };
        is_library.then(|| Target::Library(resolved.join("::") + all))
    }

    /// The path from `crate` or from a library, with imported names replaced by what they stand for.
    fn absolute(&self, at: &Path, path: &Path) -> Path {
        let (mut at, mut path) = (at.clone(), path.clone());
        for _ in 0..SIGNPOSTS {
            let Some(from) = self.path_from_root(&at, &path) else {
                return path;
            };
            let depth = self.module_of(&from).len();
            let module: Path = from[..depth].to_vec();
            let Some(import) = from.get(depth).and_then(|name| self.import(&module, name)) else {
                return [&["crate".to_owned()], from.as_slice()].concat();
            };
            path = [import.path.as_slice(), &from[depth + 1..]].concat();
            at = module;
        }
        path
    }

    /// A path that is written in the module `at`, from the crate's root; none for one of a library.
    fn path_from_root(&self, at: &Path, path: &Path) -> Option<Path> {
        let supers = path.iter().take_while(|segment| *segment == "super").count();
        let up = at.len().saturating_sub(supers);
        match path.first()?.as_str() {
            "crate" => Some(path[1..].to_vec()),
            "self" => Some([at.as_slice(), &path[1..]].concat()),
            "super" => Some([&at[..up], &path[supers..]].concat()),
            first if self.is_library_here(at, first) => None,
            _ => Some([at.as_slice(), path].concat()),
        }
    }

    fn is_library_here(&self, at: &Path, first: &str) -> bool {
        let is_module = self
            .modules
            .contains_key(&[at.as_slice(), &[first.to_owned()]].concat());
        self.libraries.contains(first)
            && !is_module
            && self.import(at, first).is_none_or(|import| import.path == [first])
    }

    fn import(&self, at: &Path, name: &str) -> Option<&Import> {
        self.modules[at].names.imports.iter().find(|import| import.name == name)
    }

    /// The deepest module on the way along a path.
    fn module_of<'a>(&self, path: &'a [String]) -> &'a [String] {
        let mut depth = 0;
        while depth < path.len() && self.modules.contains_key(&path[..=depth]) {
            depth += 1;
        }
        &path[..depth]
    }
}

fn module_file(top: &FilePath, folder: &FilePath, name: &str) -> String {
    let plain: PathBuf = folder.join(format!("{name}.rs"));
    let file = if top.join(&plain).exists() {
        plain
    } else {
        folder.join(name).join("mod.rs")
    };
    file.to_string_lossy().into_owned()
}

#[cfg(test)]
#[path = "source_tests.rs"]
mod tests;
