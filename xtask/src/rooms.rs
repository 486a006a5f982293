//! `cargo xtask rooms`: whether the folders of each crate use each other in one direction only.
//!
//! What a file uses is read from its imports and its paths; what a module passes on by `pub use` counts as used from
//! where it is. At each level of a crate, two folders that use each other are a circle, directly or by way of others;
//! a folder and a file beside it that use each other are one where that is asked for. Files of one folder may use each other. Tests are not looked at.

mod circles;
mod imports;
mod modules;

use anyhow::{Context, Result, bail};
use modules::Crate;
use std::path::Path;

/// The crates whose folders are known to use each other in one direction, and how many folders make a circle: in those
/// with 1, neither does a file use the folder beside it that uses the file.
const CRATES: [(&str, usize); 3] = [("traces", 2), ("analyzer", 1), ("reports", 1)];

/// Checks the crates that are named, or all of [`CRATES`].
pub fn rooms(named: &[String]) -> Result<()> {
    let named = named.iter().map(|name| (name.as_str(), 1));
    let all: Vec<(&str, usize)> = if named.len() == 0 { CRATES.to_vec() } else { named.collect() };
    let mut found = 0;
    for (folder, folders) in &all {
        for circle in circles(Path::new(folder), *folders)? {
            eprintln!("{folder}: {circle}");
            found += 1;
        }
    }
    if found > 0 {
        bail!("{found} circles: move what both sides use to a file of its own, which uses neither");
    }
    let names: Vec<&str> = all.iter().map(|row| row.0).collect();
    eprintln!("no circles in {}", names.join(", "));
    Ok(())
}

/// The circles of the crate in that folder, in words.
fn circles(folder: &Path, folders: usize) -> Result<Vec<String>> {
    let read = Crate::read(&folder.join("src")).with_context(|| format!("the crate in {}", folder.display()))?;
    Ok(circles::of(&read, folders))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folders_of_these_crates_use_each_other_in_one_direction() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        for (folder, folders) in CRATES {
            let found = circles(&root.join(folder), folders).unwrap();
            assert!(found.is_empty(), "{folder}:\n{}", found.join("\n"));
        }
    }
}
