//! The modules of a crate, by their paths.

use super::imports::{self, Imports};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The path of a module from the crate's root, such as `["findings", "nodes"]`; for a use, the name of the item
/// follows.
pub type ModulePath = Vec<String>;

/// The modules of a crate and what they use.
#[derive(Default)]
pub struct Crate {
    modules: BTreeMap<ModulePath, Imports>,
}

impl Crate {
    /// Reads all files below a folder of sources.
    pub fn read(sources: &Path) -> Result<Self> {
        let mut read = Self::default();
        let mut folders = vec![sources.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
                let path = entry?.path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    let text = std::fs::read_to_string(&path)?;
                    read.add(module_path(sources, &path), &text).with_context(|| path.display().to_string())?;
                }
            }
        }
        read.leave_out_tests();
        Ok(read)
    }

    /// Removes the files whose module, or a module around it, is declared for tests only.
    fn leave_out_tests(&mut self) {
        let declared = |(module, imports): (&ModulePath, &Imports)| -> Vec<ModulePath> {
            imports.tests.iter().map(|name| [module.as_slice(), std::slice::from_ref(name)].concat()).collect()
        };
        let tests: Vec<ModulePath> = self.modules.iter().flat_map(declared).collect();
        self.modules.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
    }

    /// Adds a module with its text.
    pub fn add(&mut self, path: ModulePath, text: &str) -> Result<()> {
        self.modules.insert(path, imports::of(&syn::parse_file(text)?));
        Ok(())
    }

    /// The path of each module with the path of each module that it uses.
    pub fn uses(&self) -> impl Iterator<Item = (&[String], ModulePath)> {
        self.modules.iter().flat_map(move |(module, imports)| {
            let used = imports.used.iter().filter_map(move |used| self.absolute(module, used));
            used.map(move |used| (module.as_slice(), self.home(used)))
        })
    }

    /// Whether a path is that of a folder: a module with submodules.
    pub fn is_folder(&self, path: &[String]) -> bool {
        self.modules.keys().any(|module| module.len() > path.len() && module.starts_with(path))
    }

    /// The path from the crate's root of a path written in a module; `None` if it leads out of the crate.
    fn absolute(&self, module: &[String], written: &[String]) -> Option<ModulePath> {
        let mut base = module.to_vec();
        let mut rest = written;
        match rest.first().map(String::as_str)? {
            "crate" => return Some(rest[1..].to_vec()),
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|word| word == "super") {
                    base.pop();
                    rest = &rest[1..];
                }
            }
            child => {
                base.push(child.to_owned());
                return self.modules.contains_key(&base).then(|| [module, rest].concat());
            }
        }
        base.extend_from_slice(rest);
        Some(base)
    }

    /// The module that defines an item, as far as `pub use` can be followed.
    fn home(&self, mut path: ModulePath) -> ModulePath {
        // No item is re-exported more often than this.
        for _ in 0..8 {
            let passed_on = (1..=path.len()).rev().find_map(|length| {
                let (module, name) = (&path[..length - 1], &path[length - 1]);
                let from = self.modules.get(module)?.passed_on.get(name)?;
                Some([self.absolute(module, from)?, path[length..].to_vec()].concat())
            });
            match passed_on {
                Some(next) if next != path => path = next,
                _ => break,
            }
        }
        while !path.is_empty() && !self.modules.contains_key(&path) {
            path.pop();
        }
        path
    }
}

fn module_path(sources: &Path, file: &Path) -> ModulePath {
    let relative: PathBuf = file.strip_prefix(sources).unwrap_or(file).with_extension("");
    let mut path: ModulePath = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if matches!(path.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        path.pop();
    }
    path
}
