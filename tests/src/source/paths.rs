//! What the source of one module names: `use` items, paths in code, in macros and in attributes, methods.

use std::collections::BTreeSet;

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ImplItem, Item, ItemImpl, ItemMod, ItemUse, Meta, Type, UseTree, Visibility};

/// Segments of a path as they are written.
pub(super) type Path = Vec<String>;

/// Macros that write to the standard streams, though no path says so.
const PRINTING: [&str; 5] = ["dbg", "eprint", "eprintln", "print", "println"];

/// A name that a `use` item brings in.
#[derive(Clone, Debug)]
pub(super) struct Import {
    /// The name in this module; `*` where all of a module comes in.
    pub(super) name: String,
    pub(super) path: Path,
    /// Others may use the name from here.
    pub(super) is_exported: bool,
}

/// Methods of a type that may be another file's.
#[derive(Clone, Debug)]
pub(super) struct Methods {
    pub(super) of: Path,
    pub(super) names: BTreeSet<String>,
}

/// What a module names, without its tests.
#[derive(Default)]
pub(super) struct Names {
    pub(super) imports: Vec<Import>,
    pub(super) paths: BTreeSet<Path>,
    /// Names of methods that are called on a value.
    pub(super) calls: BTreeSet<String>,
    pub(super) methods: Vec<Methods>,
    /// Modules that stand in this one, with their items where these are not in a file.
    pub(super) modules: Vec<(String, Option<Vec<Item>>)>,
}

impl Names {
    pub(super) fn of(items: &[Item]) -> Self {
        let mut names = Self::default();
        items.iter().for_each(|item| names.visit_item(item));
        names
    }

    fn add_imports(&mut self, tree: &UseTree, before: &[String], is_exported: bool) {
        let mut path = before.to_vec();
        match tree {
            UseTree::Path(part) => {
                path.push(part.ident.to_string());
                self.add_imports(&part.tree, &path, is_exported);
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.add_imports(tree, &path, is_exported);
                }
            }
            UseTree::Name(name) => {
                if name.ident != "self" {
                    path.push(name.ident.to_string());
                }
                let name = path.last().cloned().unwrap_or_default();
                self.imports.push(Import {
                    name,
                    path,
                    is_exported,
                });
            }
            UseTree::Rename(rename) => {
                if rename.ident != "self" {
                    path.push(rename.ident.to_string());
                }
                let name = rename.rename.to_string();
                self.imports.push(Import {
                    name,
                    path,
                    is_exported,
                });
            }
            UseTree::Glob(_) => self.imports.push(Import {
                name: "*".to_owned(),
                path,
                is_exported,
            }),
        }
    }

    /// Paths and calls among the tokens of a macro or an attribute.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut path = Path::new();
        let (mut colons, mut is_call) = (0, false);
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.add_path(std::mem::take(&mut path));
                    }
                    if is_call {
                        self.calls.insert(ident.to_string());
                    } else {
                        path.push(ident.to_string());
                    }
                    (colons, is_call) = (0, false);
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                TokenTree::Punct(punct) => {
                    self.add_path(std::mem::take(&mut path));
                    (colons, is_call) = (0, punct.as_char() == '.');
                }
                TokenTree::Group(group) => {
                    self.add_path(std::mem::take(&mut path));
                    (colons, is_call) = (0, false);
                    self.add_tokens(group.stream());
                }
                TokenTree::Literal(_) => (colons, is_call) = (0, false),
            }
        }
        self.add_path(path);
    }

    fn add_path(&mut self, path: Path) {
        if !path.is_empty() {
            self.paths.insert(path);
        }
    }
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_for_tests(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &'ast ImplItem) {
        let attributes = match item {
            ImplItem::Fn(function) => &function.attrs[..],
            ImplItem::Const(constant) => &constant.attrs,
            _ => &[],
        };
        if !is_for_tests(attributes) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, module: &'ast ItemMod) {
        let items = module.content.as_ref().map(|(_, items)| items.clone());
        self.modules.push((module.ident.to_string(), items));
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let is_exported = !matches!(item.vis, Visibility::Inherited);
        self.add_imports(&item.tree, &[], is_exported);
    }

    fn visit_item_impl(&mut self, item: &'ast ItemImpl) {
        if let (None, Type::Path(of)) = (&item.trait_, &*item.self_ty) {
            let name = |item: &ImplItem| match item {
                ImplItem::Fn(function) => Some(function.sig.ident.to_string()),
                _ => None,
            };
            self.methods.push(Methods {
                of: segments(&of.path),
                names: item.items.iter().filter_map(name).collect(),
            });
        }
        visit::visit_item_impl(self, item);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.add_path(segments(path));
        visit::visit_path(self, path);
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        self.calls.insert(call.method.to_string());
        visit::visit_expr_method_call(self, call);
    }

    fn visit_macro(&mut self, invocation: &'ast syn::Macro) {
        match segments(&invocation.path).as_slice() {
            [name] if PRINTING.contains(&name.as_str()) => self.add_path(vec!["std".to_owned(), name.clone()]),
            path => self.add_path(path.to_vec()),
        }
        self.add_tokens(invocation.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let Meta::List(list) = &attribute.meta {
            self.add_tokens(list.tokens.clone());
        }
    }
}

fn segments(path: &syn::Path) -> Path {
    path.segments.iter().map(|segment| segment.ident.to_string()).collect()
}

/// Whether an item is compiled for tests only.
fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test")
    })
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
