//! What CI runs: one step after the other, those first that are quick and find most. A step that fails hides no other.

use crate::attack::attack;
use crate::browser;
use crate::consent;
use crate::fleet;
use crate::fuzz::fuzz;
use crate::peers;
use crate::run::{is_there, run};
use crate::{vcan, web, windows};
use anyhow::{Result, bail};
use std::process::Command;
use std::time::{Duration, Instant};

/// What CI compiles at once: also the tests that need other people's programs, a browser, or a kernel with CAN, and that have
/// steps of their own.
const FEATURES: [&str; 2] = ["--features", "canvass/peers,canvass/browser,canvass/vcan,canvass/page"];

/// Which of these the step of the tests leaves to their own steps, as nextest says it.
const WITHOUT_NEEDS: [&str; 2] =
    ["-E", "not (package(canvass) & (binary(peers) | binary(browser) | binary(vcan) | binary(page)))"];

/// How the lints are run by themselves.
const LINTS: &str =
    "cargo clippy --workspace --all-targets --features canvass/peers,canvass/browser,canvass/vcan,canvass/page";

/// Something that must pass.
struct CiStep {
    name: &'static str,
    /// The command that does the same by itself.
    alone: &'static str,
    run: fn() -> Result<()>,
}

const FORMAT: CiStep = CiStep { name: "format", alone: "cargo fmt --all --check", run: format };
const ALL_TESTS: &str = "cargo nextest run --workspace --locked";

const STEPS: [CiStep; 14] = [
    FORMAT,
    CiStep { name: "build", alone: "cargo build --workspace --locked", run: build },
    CiStep { name: "tests", alone: ALL_TESTS, run: tests },
    CiStep { name: "lints", alone: LINTS, run: lints },
    CiStep { name: "documentation", alone: "cargo doc --workspace --locked --no-deps", run: documentation },
    CiStep { name: "examples in the documentation", alone: "cargo test --workspace --locked --doc", run: doc_tests },
    CiStep { name: "peers and browser", alone: "cargo xtask peers; cargo xtask browser", run: peers_and_browser },
    CiStep { name: "real SocketCAN", alone: "cargo xtask vcan", run: on_vcan },
    CiStep { name: "page as WebAssembly", alone: "cargo xtask web-test", run: web::step },
    CiStep { name: "Windows", alone: "cargo xtask windows --build", run: windows::step },
    CiStep { name: "fleets", alone: "cargo xtask fleet", run: fleet::test },
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
    all(&[FORMAT, CiStep { name: "tests", alone: ALL_TESTS, run: everyday_tests }])
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
    let clippy = [&["clippy", "--workspace", "--all-targets", "--locked"], &FEATURES[..], &["--", "-D", "warnings"]];
    run("cargo", &clippy.concat())
}

fn build() -> Result<()> {
    run("cargo", &[&["build", "--workspace", "--locked"], &FEATURES[..]].concat())?;
    // What can be switched off really can.
    run("cargo", &["check", "--workspace", "--no-default-features", "--locked"])
}

fn everyday_tests() -> Result<()> {
    test(&["--workspace"])
}

/// With nextest they come from the same compilation as the tests that have steps of their own; cargo can't leave those out.
fn tests() -> Result<()> {
    if has_nextest() { test(&[&["--workspace"], &FEATURES[..], &WITHOUT_NEEDS].concat()) } else { everyday_tests() }
}

fn peers_and_browser() -> Result<()> {
    peers::install_all()?;
    browser::install_all()?;
    // As the tests before, but only these: all is compiled.
    let chosen: &[&str] = if has_nextest() {
        &["--workspace", "-E", "package(canvass) & (binary(peers) | binary(browser))"]
    } else {
        &["--package", "canvass", "--test", "peers", "--test", "browser"]
    };
    test(&[chosen, &FEATURES[..]].concat())
}

/// By nextest, which runs the tests of all crates side by side, where it is there.
fn test(which: &[&str]) -> Result<()> {
    let more = [which, &["--locked", "--no-fail-fast"]].concat();
    if has_nextest() {
        return run("cargo", &[&["nextest", "run"], &more[..]].concat());
    }
    let targets: &[&str] = if which.contains(&"--test") { &["test"] } else { &["test", "--all-targets"] };
    run("cargo", &[targets, &more[..]].concat())
}

fn has_nextest() -> bool {
    is_there("cargo", &["nextest", "--version"])
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
    // The same optimised program as on SocketCAN, with all checks of arithmetic: nothing more is compiled.
    let program = vcan::program()?;
    let program = program.to_string_lossy();
    run(&program, &["selftest"])?;
    run(&program, &["selftest", "--fuzz"])
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
