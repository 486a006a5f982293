//! `cargo xtask fleet`: format, lints and tests of the workspace in `fleet`, and the examples of other programs that
//! read a lake. `cargo xtask fleet --check`: format and lints, without tests.

pub mod bench;
mod cluster;
mod readers;

use crate::run::{cargo, run, target_folder};
use anyhow::{Context, Result, anyhow, bail, ensure};

/// The manifest of the fleet workspace.
const MANIFEST: &str = "fleet/Cargo.toml";
/// The folder of the built programs.
const TARGET: &str = "fleet/target";

/// Runs the command with its options: `--check` compiles without tests.
///
/// # Errors
/// If an option is unknown, a program is missing, or a check fails.
pub fn command(words: &[String]) -> Result<()> {
    match words {
        [] => test(),
        [check] if check == "--check" => checked(),
        _ => bail!("expected nothing or --check, found {}", words.join(" ")),
    }
}

/// The step of CI: format, types and lints. Code for a query engine of five hundred crates takes eight minutes, which CI
/// leaves to the night, with the tests.
///
/// # Errors
/// If the format is wrong, or there is a warning.
pub fn checked() -> Result<()> {
    formatted()?;
    let words = ["clippy", "--manifest-path", MANIFEST, "--target-dir", TARGET, "--locked", "--all-targets"];
    run("cargo", &[&words[..], &["--", "-D", "warnings"]].concat())
}

fn formatted() -> Result<()> {
    run("cargo", &["fmt", "--manifest-path", MANIFEST, "--all", "--check"])
}

/// Builds and tests. The tests compare their answers with the answers of `canvass`, which is built as in CI so that the
/// crates are shared.
///
/// # Errors
/// If a program is missing, or a check fails.
pub fn test() -> Result<()> {
    run("cargo", &["build", "--workspace", "--locked"])?;
    formatted()?;
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
