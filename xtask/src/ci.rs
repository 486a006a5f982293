//! What CI runs: one step after the other, those first that are quick and find most. A step that fails hides no other.

use crate::attack::attack;
use crate::browser;
use crate::consent;
use crate::fuzz::fuzz;
use crate::peers;
use crate::run::{is_there, run};
use crate::{vcan, web, windows};
use anyhow::{Result, bail};
use std::process::Command;
use std::time::{Duration, Instant};

/// The tests that exchange captures with other people's programs, and those in a browser.
const FEATURES: [&str; 2] = ["--features", "canvass/peers,canvass/browser"];

/// Those on real SocketCAN are built and run by themselves, as they bring a kernel with CAN: with the others they are
/// only linted.
const LINTED: [&str; 2] = ["--features", "canvass/peers,canvass/browser,canvass/vcan"];

/// How the lints are run by themselves.
const LINTS: &str = "cargo clippy --workspace --all-targets --features canvass/peers,canvass/browser,canvass/vcan";

/// Something that must pass.
struct CiStep {
    name: &'static str,
    /// The command that does the same by itself.
    alone: &'static str,
    run: fn() -> Result<()>,
}

const FORMAT: CiStep = CiStep { name: "format", alone: "cargo fmt --all --check", run: format };
const BUILD: CiStep = CiStep { name: "build", alone: "cargo build --workspace --locked", run: build };
const TESTS: CiStep = CiStep { name: "tests", alone: "cargo nextest run --workspace --locked", run: tests };

const STEPS: [CiStep; 13] = [
    FORMAT,
    BUILD,
    TESTS,
    CiStep { name: "lints", alone: LINTS, run: lints },
    CiStep { name: "documentation", alone: "cargo doc --workspace --locked --no-deps", run: documentation },
    CiStep { name: "examples in the documentation", alone: "cargo test --workspace --locked --doc", run: doc_tests },
    CiStep { name: "peers and browser", alone: "cargo xtask peers; cargo xtask browser", run: peers_and_browser },
    CiStep { name: "real SocketCAN", alone: "cargo xtask vcan", run: on_vcan },
    CiStep { name: "page as WebAssembly", alone: "cargo xtask web-test", run: web::step },
    CiStep { name: "Windows", alone: "cargo xtask windows --build", run: windows::step },
    CiStep { name: "fuzz targets", alone: "cargo xtask fuzz", run: fuzz },
    CiStep { name: "attack", alone: "cargo xtask attack --for 45s", run: attacked },
    CiStep { name: "self-test", alone: "cargo run --release -- selftest; the same with --fuzz", run: self_test },
];

/// Everything that must pass: format, lints, documentation, all tests, with all their set-up.
pub fn ci() -> Result<()> {
    all(&STEPS)
}

/// What is worth running after each change.
pub fn everyday() -> Result<()> {
    all(&[FORMAT, BUILD, TESTS])
}

/// Runs all steps, and says at the end how each went.
fn all(steps: &[CiStep]) -> Result<()> {
    let began = Instant::now();
    let mut rows = Vec::new();
    for step in steps {
        eprintln!("== {}", step.name);
        let started = Instant::now();
        let result = (step.run)();
        if let Err(error) = &result {
            eprintln!("error: {}: {error:#}", step.name);
        }
        rows.push((step, started.elapsed(), result.is_ok()));
    }
    let failed: Vec<_> = rows.iter().filter(|row| !row.2).map(|row| row.0).collect();
    rows.iter().for_each(|(step, time, good)| eprintln!("{}", row(step.name, *time, *good)));
    eprintln!("{}", row("together", began.elapsed(), failed.is_empty()));
    if failed.is_empty() {
        return Ok(());
    }
    let again: Vec<String> = failed.iter().map(|step| format!("{} (again: {})", step.name, step.alone)).collect();
    bail!("{} of {} steps failed: {}", failed.len(), steps.len(), again.join("; "))
}

fn row(name: &str, time: Duration, good: bool) -> String {
    let seconds = time.as_secs();
    let sign = if good { "ok    " } else { "FAILED" };
    format!("{sign}  {name:32} {:3} min {:02} s", seconds / 60, seconds % 60)
}

fn format() -> Result<()> {
    component("fmt", "rustfmt")?;
    run("cargo", &["fmt", "--all", "--check"])
}

fn lints() -> Result<()> {
    component("clippy", "clippy")?;
    let clippy = [&["clippy", "--workspace", "--all-targets", "--locked"], &LINTED[..], &["--", "-D", "warnings"]];
    run("cargo", &clippy.concat())
}

fn build() -> Result<()> {
    run("cargo", &["build", "--workspace", "--locked"])?;
    // What can be switched off really can.
    run("cargo", &["check", "--package", "canvass", "--no-default-features", "--locked"])
}

fn tests() -> Result<()> {
    test(&["--workspace"])
}

fn peers_and_browser() -> Result<()> {
    peers::install_all()?;
    browser::install_all()?;
    test(&[&FEATURES[..], &["--package", "canvass", "--test", "peers", "--test", "browser"]].concat())
}

/// By nextest, which runs the tests of all crates side by side, where it is there.
fn test(which: &[&str]) -> Result<()> {
    let more = [which, &["--locked", "--no-fail-fast"]].concat();
    if is_there("cargo", &["nextest", "--version"]) {
        return run("cargo", &[&["nextest", "run"], &more[..]].concat());
    }
    let targets: &[&str] = if which.contains(&"--test") { &["test"] } else { &["test", "--all-targets"] };
    run("cargo", &[targets, &more[..]].concat())
}

fn doc_tests() -> Result<()> {
    run("cargo", &["test", "--workspace", "--locked", "--doc"])
}

fn on_vcan() -> Result<()> {
    vcan::test(&[])
}

fn attacked() -> Result<()> {
    attack(&["--for".to_owned(), "45s".to_owned()])
}

/// All cases and properties against all faults and liberties, and the fuzzer against all faults. The tests try a part of it.
fn self_test() -> Result<()> {
    let selftest = ["run", "--release", "--locked", "--quiet", "--", "selftest"];
    run("cargo", &selftest)?;
    run("cargo", &[&selftest[..], &["--fuzz"]].concat())
}

/// A component of the toolchain, where a minimal one came without it.
fn component(command: &str, name: &str) -> Result<()> {
    if is_there("cargo", &[command, "--version"]) {
        return Ok(());
    }
    consent::ask(name, &format!("rustup component add {name}"))?;
    run("rustup", &["component", "add", name])
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_fails_hides_no_other_and_is_named_with_its_command() {
        static RUN: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        fn good() -> Result<()> {
            RUN.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Ok(())
        }
        fn bad() -> Result<()> {
            bail!("no")
        }
        let steps = [
            CiStep { name: "first", alone: "do first", run: bad },
            CiStep { name: "second", alone: "do second", run: good },
        ];
        let error = all(&steps).unwrap_err().to_string();
        assert_eq!(error, "1 of 2 steps failed: first (again: do first)");
        assert_eq!(RUN.load(std::sync::atomic::Ordering::Relaxed), 1);
        assert!(all(&steps[1..]).is_ok());
    }
}
