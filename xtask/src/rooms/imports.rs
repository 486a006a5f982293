//! Imports and re-exports of a file.

use super::modules::ModulePath;
use std::collections::BTreeMap;
use syn::visit::{self, Visit};
use syn::{Attribute, File, Item, ItemMod, ItemUse, UseTree, Visibility};

/// The paths in a file, as written.
#[derive(Default)]
pub struct Imports {
    /// Paths that the file uses itself.
    pub used: Vec<ModulePath>,
    /// Paths that the file re-exports by `pub use`, by their new names.
    pub passed_on: BTreeMap<String, ModulePath>,
    /// Modules in the file that are for tests only.
    pub tests: Vec<String>,
}

/// Reads the imports and the paths of a file.
pub fn of(file: &File) -> Imports {
    let mut imports = Imports::default();
    if !file.attrs.iter().any(is_test) {
        imports.visit_file(file);
    }
    imports
}

impl<'ast> Visit<'ast> for Imports {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes: &[Attribute] = match item {
            Item::Mod(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => &[],
        };
        match item {
            _ if !attributes.iter().any(is_test) => visit::visit_item(self, item),
            Item::Mod(module) => self.tests.push(module.ident.to_string()),
            _ => {}
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        // Modules within a file would need paths of their own, but all of them are for tests.
        visit::visit_item_mod(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let is_passed_on = !matches!(item.vis, Visibility::Inherited);
        self.tree(&item.tree, &[], is_passed_on);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let written: ModulePath = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if written.len() > 1 {
            self.used.push(written);
        }
        visit::visit_path(self, path);
    }
}

impl Imports {
    fn tree(&mut self, tree: &UseTree, before: &[String], is_passed_on: bool) {
        let with = |name: &dyn ToString| [before, &[name.to_string()]].concat();
        match tree {
            UseTree::Path(path) => self.tree(&path.tree, &with(&path.ident), is_passed_on),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.tree(tree, before, is_passed_on)),
            UseTree::Name(name) if name.ident == "self" => {
                let own = before.last().cloned().unwrap_or_default();
                self.add(own, before.to_vec(), is_passed_on);
            }
            UseTree::Name(name) => self.add(name.ident.to_string(), with(&name.ident), is_passed_on),
            UseTree::Rename(rename) => self.add(rename.rename.to_string(), with(&rename.ident), is_passed_on),
            UseTree::Glob(_) => self.used.push(before.to_vec()),
        }
    }

    fn add(&mut self, name: String, path: ModulePath, is_passed_on: bool) {
        if is_passed_on {
            self.passed_on.insert(name, path);
        } else {
            self.used.push(path);
        }
    }
}

/// Whether an attribute is `#[test]` or `#[cfg(test)]`.
fn is_test(attribute: &Attribute) -> bool {
    let of_tests = || attribute.parse_args::<syn::Ident>().is_ok_and(|what| what == "test");
    attribute.path().is_ident("test") || attribute.path().is_ident("cfg") && of_tests()
}
