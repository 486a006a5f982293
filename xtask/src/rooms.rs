//! `cargo xtask rooms`: checks that the folders of each crate use each other in one direction only, and that the core
//! names no device profile and no manufacturer.
//!
//! Imports and paths tell what a file uses; an item that a module re-exports by `pub use` counts as used from its own
//! place. At each level of a crate, two folders that use each other, or a folder and a file beside it, form a circle,
//! directly or through others. Files of one folder may use each other. Tests are not examined.

mod circles;
mod imports;
mod modules;
mod words;

use anyhow::{Context, Result, bail};
use modules::Crate;
use std::path::Path;

/// All crates of the workspace.
const CRATES: [&str; 10] = [
    "traces",
    "macros",
    "analyzer",
    "conformance/bus",
    "conformance/device",
    "conformance/suite",
    "conformance/fuzz",
    "reports",
    ".",
    "xtask",
];

/// Checks the named crates, or all of [`CRATES`].
pub fn rooms(named: &[String]) -> Result<()> {
    let named = named.iter().map(String::as_str);
    let all: Vec<&str> = if named.len() == 0 { CRATES.to_vec() } else { named.collect() };
    let mut found = 0;
    for folder in &all {
        for circle in circles(Path::new(folder))? {
            eprintln!("{folder}: {circle}");
            found += 1;
        }
    }
    let mut named = 0;
    for folder in all.iter().filter(|folder| words::CORES.contains(folder)) {
        for word in words::check(Path::new("."), folder)? {
            eprintln!("{word}");
            named += 1;
        }
    }
    if found > 0 {
        bail!("{found} circles: move what both sides use to a file of its own, which uses neither");
    }
    if named > 0 {
        bail!("{named} names of profiles or manufacturers in the core");
    }
    eprintln!("no circles in {}; no profile and no manufacturer in the core", all.join(", "));
    Ok(())
}

/// The circles of the crate in this folder, as text.
fn circles(folder: &Path) -> Result<Vec<String>> {
    let read = Crate::read(&folder.join("src")).with_context(|| format!("the crate in {}", folder.display()))?;
    Ok(circles::of(&read))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folders_of_these_crates_use_each_other_in_one_direction() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        for folder in CRATES {
            let found = circles(&root.join(folder)).unwrap();
            assert!(found.is_empty(), "{folder}:\n{}", found.join("\n"));
        }
    }
}
