//! What the packages are made with.

use crate::consent;
use crate::run::{is_there, run};
use crate::venv::Venv;
use anyhow::{Context, Result};
use std::process::Command;

/// The tools from PyPI.
pub const VENV: Venv = Venv {
    folder: "target/dist-venv",
    python: "target/dist-venv/bin/python",
    requirements: "packaging/requirements.txt",
    probe: "import ziglang, cyclonedx.validation.json",
};

/// Lets cargo find Zig, and its own subcommand that builds with it.
///
/// # Errors
/// If the system does not tell the current folder.
pub fn with_zig(cargo: &mut Command) -> Result<()> {
    let folder = std::env::current_dir()?.join(VENV.folder).join("bin");
    let old = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(folder.clone()).chain(std::env::split_paths(&old)))?;
    cargo.env("PATH", path).env("CARGO_ZIGBUILD_ZIG_PATH", folder.join("python-zig"));
    Ok(())
}

/// Installs a subcommand of cargo from the registry, unless it is there.
///
/// # Errors
/// If it can't be installed.
pub fn install_subcommand(name: &str) -> Result<()> {
    let word = name.strip_prefix("cargo-").context("the name of a subcommand")?;
    if is_there("cargo", &[word, "--version"]) {
        return Ok(());
    }
    consent::ask(name, &format!("cargo install --locked {name}"))?;
    run("cargo", &["install", "--locked", name])
}
