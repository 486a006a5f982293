//! What CI runs.

use crate::browser;
use crate::fuzz::fuzz;
use crate::peers;
use crate::run::{is_there, run};
use crate::vcan;
use anyhow::Result;
use std::process::Command;

/// The tests that exchange captures with other people's programs, and those in a browser, beside all others.
const FEATURES: [&str; 2] = ["--features", "canvass/peers,canvass/browser"];

/// Those on real SocketCAN are built and run by themselves, as they bring a kernel with CAN: with the others they are
/// only linted.
const LINTED: [&str; 2] = ["--features", "canvass/peers,canvass/browser,canvass/vcan"];

/// Format, lints, build, documentation, all tests: those with peers, on real SocketCAN and in a browser too.
pub fn ci() -> Result<()> {
    components()?;
    run("cargo", &["fmt", "--all", "--check"])?;
    let clippy = [&["clippy", "--workspace", "--all-targets", "--locked"], &LINTED[..], &["--", "-D", "warnings"]];
    run("cargo", &clippy.concat())?;
    run("cargo", &["build", "--workspace", "--locked"])?;
    // Documentation is checked before the tests, so that their count is the last thing printed.
    documentation()?;
    run("cargo", &["test", "--workspace", "--locked", "--doc"])?;
    fuzz()?;
    peers::install_all()?;
    vcan::test(&[])?;
    browser::install_all()?;
    let all = [&["--workspace", "--locked", "--no-fail-fast"], &FEATURES[..]].concat();
    if is_there("cargo", &["nextest", "--version"]) {
        run("cargo", &[&["nextest", "run"], &all[..]].concat())
    } else {
        run("cargo", &[&["test", "--all-targets"], &all[..]].concat())
    }
}

/// rustfmt and clippy, where a minimal toolchain came without them.
fn components() -> Result<()> {
    for component in ["fmt", "clippy"] {
        if !is_there("cargo", &[component, "--version"]) {
            let name = if component == "fmt" { "rustfmt" } else { "clippy" };
            run("rustup", &["component", "add", name])?;
        }
    }
    Ok(())
}

/// Broken links and missing docs of the libraries are errors. The program's doc comments are its help texts, whose
/// brackets are no links.
fn documentation() -> Result<()> {
    eprintln!("$ cargo doc");
    let status = Command::new("cargo")
        .args(["doc", "--workspace", "--exclude", "canvass", "--exclude", "xtask"])
        .args(["--locked", "--no-deps", "--quiet"])
        .env("RUSTDOCFLAGS", "-D warnings")
        .status()?;
    anyhow::ensure!(status.success(), "cargo doc ended with {status}");
    Ok(())
}
