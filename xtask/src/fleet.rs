//! `cargo xtask fleet`: the workspace in `fleet`: its format, its lints and its tests, and the examples of other programs that
//! read a lake.

pub mod bench;
mod cluster;
mod readers;

use crate::run::run;
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// Its manifest.
const MANIFEST: &str = "fleet/Cargo.toml";
/// Where its programs are built.
const TARGET: &str = "fleet/target";

/// Builds and tests.
///
/// # Errors
/// If something is missing, is not as it should be or fails.
pub fn test() -> Result<()> {
    run("cargo", &["fmt", "--manifest-path", MANIFEST, "--all", "--check"])?;
    // Answers are held against those of the program.
    run("cargo", &["build", "--locked"])?;
    lints_and_tests()?;
    readers::read()
}

/// The engine has five hundred crates: they are built once, without what debuggers need, and the lints look at the same build
/// that the tests run from.
fn lints_and_tests() -> Result<()> {
    let root = std::env::current_dir()?;
    let program = root.join("target/debug/canvass");
    let words = ["test", "--manifest-path", MANIFEST, "--target-dir", TARGET, "--locked", "--no-fail-fast"];
    eprintln!("$ cargo {} (compiled by clippy-driver)", words.join(" "));
    let status = Command::new("cargo")
        .args(words)
        .env("RUSTC_WORKSPACE_WRAPPER", "clippy-driver")
        .env("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__")
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .env("CARGO_PROFILE_TEST_DEBUG", "0")
        .env("CARGO_INCREMENTAL", "0")
        .env("CANVASS_PROGRAM", program)
        .env_remove("CARGO_TARGET_DIR")
        .status()
        .context("can't run cargo")?;
    ensure!(status.success(), "the tests of {MANIFEST} ended with {status}");
    Ok(())
}
