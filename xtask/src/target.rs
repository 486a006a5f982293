//! Rust's standard libraries for other systems.

use crate::consent;
use crate::run::run;
use anyhow::{Context, Result};
use std::path::Path;
use std::process::Command;

/// Installs the library for this target, unless it is installed.
pub fn add(target: &str) -> Result<()> {
    let told =
        Command::new("rustc").args(["--print", "target-libdir", "--target", target]).output().context("rustc")?;
    if Path::new(String::from_utf8_lossy(&told.stdout).trim()).is_dir() {
        return Ok(());
    }
    consent::ask(&format!("Rust's library for {target}"), &format!("rustup target add {target}"))?;
    run("rustup", &["target", "add", target])
}
