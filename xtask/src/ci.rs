//! The steps of CI, in the order of speed and benefit. A failed step does not stop the others.

use crate::as_found::as_found;
use crate::attack;
use crate::browser;
use crate::compiled::FEATURES;
use crate::consent;
use crate::dist::{self, dist};
use crate::docs;
use crate::fleet;
use crate::fuzz::fuzz;
use crate::incidents::incidents;
use crate::peers;
use crate::python;
use crate::run::{is_there, run, target_folder};
use crate::storm::storm;
use crate::{vcan, web, windows};
use anyhow::{Result, bail};
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The tests that the test step leaves to other steps, as a filter of nextest.
const WITHOUT_NEEDS: [&str; 2] =
    ["-E", "not (package(canvass) & (binary(peers) | binary(browser) | binary(vcan) | binary(page)))"];

/// The command of the lints.
const LINTS: &str =
    "cargo clippy --workspace --all-targets --features canvass/peers,canvass/browser,canvass/vcan,canvass/page";

/// The command that compiles the fuzz targets without sanitizers. The sanitizers compile all crates once more, and find
/// little in seconds: the targets run at night.
const FUZZ_TARGETS: &str =
    "cargo check --manifest-path fuzz-targets/Cargo.toml --target-dir target/fuzz-targets --locked";
/// Duration of each fuzz target at night, in seconds.
const FUZZ_AT_NIGHT: u32 = 120;

/// A step that must pass.
struct CiStep {
    name: &'static str,
    /// The command for this step alone.
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
    CiStep { name: "Python module", alone: "cargo xtask python", run: python::test },
    CiStep { name: "attack", alone: "cargo xtask attack --for 45s", run: attacked },
    CiStep { name: "page as WebAssembly", alone: "cargo xtask web-test", run: page },
    CiStep { name: "real SocketCAN", alone: "cargo xtask vcan --without-nightly", run: vcan::by_day },
    CiStep {
        name: "self-test",
        alone: "cargo run --release -- selftest; the same with --null, with --alone --count 20, and with --fuzz --seeds 2",
        run: self_test,
    },
    CiStep { name: "Windows", alone: "cargo xtask windows --check", run: windows::step },
    CiStep { name: "fuzz targets", alone: FUZZ_TARGETS, run: fuzz_targets },
];

/// Steps that take long and find little; they run nightly.
const NIGHTLY: [CiStep; 11] = [
    CiStep { name: "fleets", alone: "cargo xtask fleet", run: fleet::test },
    CiStep {
        name: "self-test",
        alone: "cargo run --release -- selftest --alone; the same with --fuzz",
        run: self_test_at_night,
    },
    CiStep { name: "self-test of the wire", alone: "cargo run --release -- selftest --wire", run: wire },
    CiStep { name: "real SocketCAN", alone: "cargo xtask vcan", run: on_vcan },
    CiStep { name: "Windows, by Wine", alone: "cargo xtask windows", run: windows::test },
    CiStep { name: "fuzz targets", alone: "cargo xtask fuzz", run: || fuzz(FUZZ_AT_NIGHT) },
    CiStep { name: "release files", alone: "cargo xtask dist; cargo xtask dist --check", run: release_files },
    CiStep { name: "attack", alone: "cargo xtask attack --for 10m", run: attacked_long },
    CiStep { name: "as found", alone: "cargo xtask as-found --all", run: || as_found(&["--all".to_owned()]) },
    CiStep { name: "storm", alone: "cargo xtask storm", run: storm },
    CiStep { name: "incidents", alone: "cargo xtask incidents", run: || incidents(&[]) },
];

/// Makes the release files, and installs, runs and removes each of them.
fn release_files() -> Result<()> {
    dist(&[])?;
    dist(&[dist::CHECK.to_owned()])
}

/// Runs all steps of CI: format, lints, documentation, all tests, with their set-up.
pub fn ci() -> Result<()> {
    // Downloads mostly wait, while compilations use the processor.
    if let Ok(mut fetching) = FETCHING.lock() {
        *fetching = Some(std::thread::spawn(fetch));
    }
    all(&STEPS)
}

/// Runs the nightly steps, which [`ci`] does not have.
pub fn nightly() -> Result<()> {
    all(&NIGHTLY)
}

/// Runs the checks for each change.
pub fn everyday() -> Result<()> {
    all(&[FORMAT, CiStep { name: "tests", alone: ALL_TESTS, run: everyday_tests }])
}

/// The thread that installs other programs during compilation.
static FETCHING: Mutex<Option<JoinHandle<Result<()>>>> = Mutex::new(None);

/// Installs the programs for the steps after [`fetched`]. These steps also check for themselves, and report missing
/// programs.
fn fetch() -> Result<()> {
    let needed = peers::install_all()
        .and_then(|()| python::install())
        .and_then(|()| browser::install_all())
        .and_then(|()| vcan::install_all());
    // If these programs can't be installed, the steps that need them are skipped.
    let optional = windows::install_compiler().and_then(|()| web::prepare());
    if let Err(missing) = optional {
        eprintln!("{missing:#}");
    }
    needed
}

/// Waits for the installations.
fn fetched() -> Result<()> {
    let fetching = FETCHING.lock().ok().and_then(|mut fetching| fetching.take());
    fetching.map_or(Ok(()), |fetching| fetching.join().unwrap_or_else(|_| bail!("the installation panicked")))
}

/// Runs all steps, and prints their results at the end.
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

/// Checks that `canvass` and `canvass-bus` compile without their optional features.
fn without_features() -> Result<()> {
    run("cargo", &["check", "--package", "canvass", "--package", "canvass-bus", "--no-default-features", "--locked"])
}

/// Compiles the fuzz targets.
fn fuzz_targets() -> Result<()> {
    let words: Vec<&str> = FUZZ_TARGETS.split_whitespace().skip(1).collect();
    run("cargo", &words)
}

/// Builds the book; the program built for the tests prints the reference pages.
fn book() -> Result<()> {
    docs::book(&built())
}

/// The path of the program built for the tests.
fn built() -> PathBuf {
    target_folder().join("debug/canvass")
}

/// Tests the page against the program that was built for the tests.
fn page() -> Result<()> {
    web::step(|| these(&["page"]))
}

fn everyday_tests() -> Result<()> {
    test(&["--workspace"])
}

/// Runs the tests that have no step of their own. With nextest, one compilation also serves the tests with steps of
/// their own; cargo can't leave such tests out.
fn tests() -> Result<()> {
    if !has_nextest() {
        return everyday_tests();
    }
    // The profile tells which tests mostly wait, and may run at the same time as others (.config/nextest.toml).
    let places = (2 * std::thread::available_parallelism()?.get() + 1).to_string();
    let side_by_side = ["--profile", "ci", "--test-threads", &places];
    test(&[&["--workspace"], &FEATURES[..], &WITHOUT_NEEDS, &side_by_side].concat())
}

fn peers_and_browser() -> Result<()> {
    peers::install_all()?;
    browser::install_all()?;
    these(&["peers", "browser"])
}

/// Runs the program's tests in these files; everything is compiled already.
fn these(files: &[&str]) -> Result<()> {
    if has_nextest() {
        let binaries: Vec<String> = files.iter().map(|file| format!("binary({file})")).collect();
        let chosen = format!("package(canvass) & ({})", binaries.join(" | "));
        return test(&[&["--workspace", "-E", &chosen], &FEATURES[..]].concat());
    }
    let chosen: Vec<&str> = files.iter().flat_map(|file| ["--test", file]).collect();
    test(&[&["--package", "canvass"], &chosen[..], &FEATURES[..]].concat())
}

/// Runs tests with nextest, if installed, which runs all crates side by side.
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

/// Runs the examples in the documentation, with the same features as the tests, so that the compiled libraries are
/// reused.
fn doc_tests() -> Result<()> {
    run("cargo", &[&["test", "--workspace", "--locked", "--doc"], &FEATURES[..]].concat())
}

fn on_vcan() -> Result<()> {
    vcan::test(&[])
}

/// Attacks the program built for the tests.
fn attacked() -> Result<()> {
    attack::built("45s")
}

fn attacked_long() -> Result<()> {
    attack::attack(&["--for".to_owned(), "10m".to_owned()])
}

/// Runs the selftest: all cases and properties against all faults and liberties, and the fuzzer against all faults. The
/// tests run only a part of the selftest.
fn self_test() -> Result<()> {
    by_selftest(&[&[], &["--null"], &["--alone", "--count", "20"], &["--fuzz", "--seeds", "2"]])
}

/// Runs the parts of the selftest of which CI runs a sample.
fn self_test_at_night() -> Result<()> {
    run("cargo", &["build", "--locked", "--bin", "canvass"])?;
    by_selftest(&[&["--alone"], &["--fuzz"]])
}

fn wire() -> Result<()> {
    run("cargo", &["build", "--locked", "--bin", "canvass"])?;
    by_selftest(&[&["--wire"]])
}

/// Runs the selftest with each of these options, by the program that was built for the tests: it checks its arithmetic.
fn by_selftest(options: &[&[&str]]) -> Result<()> {
    let program = built();
    options.iter().try_for_each(|options| run(&program.to_string_lossy(), &[&["selftest"], *options].concat()))
}

/// Installs a component of the toolchain, if a minimal toolchain lacks it.
fn component(command: &str, name: &str) -> Result<()> {
    if is_there("cargo", &[command, "--version"]) {
        return Ok(());
    }
    consent::ask(name, &format!("rustup component add {name}"))?;
    run("rustup", &["component", "add", name])
}

/// Builds the documentation of the libraries; broken links and missing docs are errors. The program's doc comments are
/// help texts, whose brackets are no links.
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
