//! What CI runs: one step after the other, those first that are quick and find most. A step that fails hides no other.

use crate::as_found::as_found;
use crate::attack;
use crate::browser;
use crate::consent;
use crate::docs;
use crate::fleet;
use crate::fuzz::fuzz;
use crate::incidents::incidents;
use crate::peers;
use crate::run::{is_there, run, target_folder};
use crate::storm::storm;
use crate::{vcan, web, windows};
use anyhow::{Result, bail};
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::thread::JoinHandle;
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

/// How long CI runs each fuzz target, in seconds: long enough for the seeds and for what is found at once.
const FUZZ: u32 = 5;
/// How long it does at night.
const FUZZ_AT_NIGHT: u32 = 120;

/// Something that must pass.
struct CiStep {
    name: &'static str,
    /// The command that does the same by itself.
    alone: &'static str,
    run: fn() -> Result<()>,
}

const FORMAT: CiStep = CiStep { name: "format", alone: "cargo fmt --all --check", run: format };
const ALL_TESTS: &str = "cargo nextest run --workspace --locked";

const STEPS: [CiStep; 16] = [
    FORMAT,
    CiStep { name: "tests", alone: ALL_TESTS, run: tests },
    CiStep { name: "examples in the documentation", alone: "cargo test --workspace --locked --doc", run: doc_tests },
    CiStep { name: "lints", alone: LINTS, run: lints },
    CiStep { name: "documentation", alone: "cargo doc --workspace --locked --no-deps", run: documentation },
    CiStep { name: "without features", alone: "cargo check --no-default-features", run: without_features },
    CiStep { name: "book", alone: "cargo xtask docs", run: book },
    CiStep { name: "programs of others", alone: "cargo xtask peers; cargo xtask browser", run: fetched },
    CiStep { name: "peers and browser", alone: "cargo xtask peers; cargo xtask browser", run: peers_and_browser },
    CiStep { name: "attack", alone: "cargo xtask attack --for 45s", run: attacked },
    CiStep { name: "page as WebAssembly", alone: "cargo xtask web-test", run: page },
    CiStep { name: "fleets", alone: "cargo xtask fleet", run: fleet::step },
    CiStep { name: "real SocketCAN", alone: "cargo xtask vcan", run: on_vcan },
    CiStep {
        name: "self-test",
        alone: "cargo run --release -- selftest; the same with --null, and with --fuzz",
        run: self_test,
    },
    CiStep { name: "Windows", alone: "cargo xtask windows --check", run: windows::step },
    CiStep { name: "fuzz targets", alone: "cargo xtask fuzz", run: || fuzz(FUZZ) },
];

/// What takes long and finds little: once a night is enough.
const NIGHTLY: [CiStep; 6] = [
    CiStep { name: "Windows, by Wine", alone: "cargo xtask windows", run: windows::test },
    CiStep { name: "fuzz targets", alone: "cargo xtask fuzz", run: || fuzz(FUZZ_AT_NIGHT) },
    CiStep { name: "attack", alone: "cargo xtask attack --for 10m", run: attacked_long },
    CiStep { name: "as found", alone: "cargo xtask as-found --all", run: || as_found(&["--all".to_owned()]) },
    CiStep { name: "storm", alone: "cargo xtask storm", run: storm },
    CiStep { name: "incidents", alone: "cargo xtask incidents", run: incidents },
];

/// Everything that must pass: format, lints, documentation, all tests, with all their set-up.
pub fn ci() -> Result<()> {
    // Downloads mostly wait, and compilations do not.
    if let Ok(mut fetching) = FETCHING.lock() {
        *fetching = Some(std::thread::spawn(fetch));
    }
    all(&STEPS)
}

/// What is worth running once a night, beside [`ci`].
pub fn nightly() -> Result<()> {
    all(&NIGHTLY)
}

/// What is worth running after each change.
pub fn everyday() -> Result<()> {
    all(&[FORMAT, CiStep { name: "tests", alone: ALL_TESTS, run: everyday_tests }])
}

/// What installs the programs of others while this compiles.
static FETCHING: Mutex<Option<JoinHandle<Result<()>>>> = Mutex::new(None);

/// Installs what the steps after that of [`fetched`] need. They look for it themselves too, and say what is missing.
fn fetch() -> Result<()> {
    let needed = peers::install_all().and_then(|()| browser::install_all()).and_then(|()| vcan::install_all());
    // Without these, their steps are left out.
    let optional = windows::install_compiler().and_then(|()| web::prepare());
    if let Err(missing) = optional {
        eprintln!("{missing:#}");
    }
    needed
}

/// Waits for them.
fn fetched() -> Result<()> {
    let fetching = FETCHING.lock().ok().and_then(|mut fetching| fetching.take());
    fetching.map_or(Ok(()), |fetching| fetching.join().unwrap_or_else(|_| bail!("installing has panicked")))
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

/// What can be switched off really can: it is features of these two.
fn without_features() -> Result<()> {
    run("cargo", &["check", "--package", "canvass", "--package", "canvass-bus", "--no-default-features", "--locked"])
}

/// The program that the tests have built prints the reference pages.
fn book() -> Result<()> {
    docs::book(&built())
}

/// The program, as the tests have built it.
fn built() -> PathBuf {
    target_folder().join("debug/canvass")
}

/// The page, tried beside the program that the tests have built.
fn page() -> Result<()> {
    web::step(|| these(&["page"]))
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
    these(&["peers", "browser"])
}

/// The program's tests in those files: all is compiled.
fn these(files: &[&str]) -> Result<()> {
    if has_nextest() {
        let binaries: Vec<String> = files.iter().map(|file| format!("binary({file})")).collect();
        let chosen = format!("package(canvass) & ({})", binaries.join(" | "));
        return test(&[&["--workspace", "-E", &chosen], &FEATURES[..]].concat());
    }
    let chosen: Vec<&str> = files.iter().flat_map(|file| ["--test", file]).collect();
    test(&[&["--package", "canvass"], &chosen[..], &FEATURES[..]].concat())
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

/// With the same features as the tests: the libraries that they have compiled.
fn doc_tests() -> Result<()> {
    run("cargo", &[&["test", "--workspace", "--locked", "--doc"], &FEATURES[..]].concat())
}

fn on_vcan() -> Result<()> {
    vcan::test(&[])
}

/// Of the program that the tests have built.
fn attacked() -> Result<()> {
    attack::built("45s")
}

fn attacked_long() -> Result<()> {
    attack::attack(&["--for".to_owned(), "10m".to_owned()])
}

/// All cases and properties against all faults and liberties, and the fuzzer against all faults. The tests try a part of it.
fn self_test() -> Result<()> {
    // The same optimised program as on SocketCAN, with all checks of arithmetic: nothing more is compiled.
    let program = vcan::program()?;
    let program = program.to_string_lossy();
    run(&program, &["selftest"])?;
    run(&program, &["selftest", "--null"])?;
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
