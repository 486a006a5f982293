//! cargo for Windows in any project folder: MinGW's dlltool, which the compiler calls, cuts file names at blanks.

use anyhow::{Context, Result};
use std::os::unix::fs::symlink;
use std::process::Command;
use tempfile::TempDir;

/// A call of cargo, and the link by which it reaches `target`, if the project's own path has blanks.
pub struct Cargo {
    /// The call of cargo.
    pub command: Command,
    _link: Option<TempDir>,
}

/// A call of cargo that builds into `target`.
///
/// # Errors
/// If the link can't be made.
pub fn cargo() -> Result<Cargo> {
    let mut command = Command::new("cargo");
    let project = std::env::current_dir()?;
    if !project.to_string_lossy().contains(char::is_whitespace) {
        return Ok(Cargo { command, _link: None });
    }
    let target = project.join("target");
    std::fs::create_dir_all(&target)?;
    let folder = tempfile::Builder::new().prefix("canvass-windows-").tempdir()?;
    let link = folder.path().join("target");
    symlink(target, &link).with_context(|| format!("a link at {}", link.display()))?;
    command.env("CARGO_TARGET_DIR", link);
    Ok(Cargo { command, _link: Some(folder) })
}
