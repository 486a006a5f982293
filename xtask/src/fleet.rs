//! `cargo xtask fleet`: format, lints and tests of the workspace in `fleet`, and the examples of other programs that
//! read a lake.

pub mod bench;
mod cluster;
mod readers;

use crate::run::{cargo, run, target_folder};
use anyhow::{Context, Result, anyhow, ensure};

/// The manifest of the fleet workspace.
const MANIFEST: &str = "fleet/Cargo.toml";
/// The folder of the built programs.
const TARGET: &str = "fleet/target";

/// Builds and tests.
///
/// # Errors
/// If a program is missing, or a check fails.
pub fn test() -> Result<()> {
    // The tests compare their answers with the answers of `canvass`, which is built as in CI so that the crates are
    // shared.
    run("cargo", &["build", "--workspace", "--locked"])?;
    step()
}

/// The step of CI, which compares answers with the program that CI has already built.
///
/// # Errors
/// As [`test()`].
pub fn step() -> Result<()> {
    run("cargo", &["fmt", "--manifest-path", MANIFEST, "--all", "--check"])?;
    // The readers are downloaded while the tests are compiled and run.
    std::thread::scope(|scope| {
        let installing = scope.spawn(readers::install_all);
        let tested = lints_and_tests();
        let installed = installing.join().map_err(|_| anyhow!("the installation panicked"))?;
        tested.and(installed)
    })?;
    readers::read()
}

/// Builds the release profile.
fn release() -> Result<()> {
    let words = ["build", "--release", "--locked", "--manifest-path", MANIFEST, "--target-dir", TARGET];
    eprintln!("$ cargo {}", words.join(" "));
    let status = cargo().args(words).status().context("can't run cargo")?;
    ensure!(status.success(), "the build of {MANIFEST} ended with {status}");
    Ok(())
}

/// Runs the lints and the tests. The engine has five hundred crates: lints and tests share one build without debug
/// information.
fn lints_and_tests() -> Result<()> {
    let root = std::env::current_dir()?;
    let program = root.join(target_folder()).join("debug/canvass");
    let words = ["test", "--manifest-path", MANIFEST, "--target-dir", TARGET, "--locked", "--no-fail-fast"];
    eprintln!("$ cargo {} (compiled by clippy-driver)", words.join(" "));
    let status = cargo()
        .args(words)
        .env("RUSTC_WORKSPACE_WRAPPER", "clippy-driver")
        .env("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__")
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .env("CARGO_PROFILE_TEST_DEBUG", "0")
        .env("CARGO_INCREMENTAL", "0")
        .env("CANVASS_PROGRAM", program)
        .status()
        .context("can't run cargo")?;
    ensure!(status.success(), "the tests of {MANIFEST} ended with {status}");
    Ok(())
}
