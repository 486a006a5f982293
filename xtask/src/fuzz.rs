//! Coverage-guided fuzzing of all parsers, for a fixed time.

use crate::consent;
use crate::run::{is_there, run};
use anyhow::{Context, Result, bail, ensure};
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;

/// Default duration of each target, in seconds.
const USUAL: u32 = 15;

/// The folder of the targets. cargo-fuzz's default name `fuzz` would be mistaken for the fuzzer of devices.
const FOLDER: &str = "fuzz-targets";

/// The target that runs twice as long, as descriptions have many more paths.
const LONG: &str = "description";

/// Maximum size of a single allocation in MiB: a parser that trusts a length in its input would allocate more. A
/// container or chunk of a capture may have 32, in a buffer that grows to 64.
const MOST_AT_ONCE: &str = "-malloc_limit_mb=128";

/// Number of targets at the same time: CI's machines have two processors.
const AT_ONCE: usize = 2;

/// The program that contains all targets, and below it the variable that names the target to run.
const PROGRAM: &str = "reader";
const VARIABLE: &str = "CANVASS_FUZZ_TARGET";

/// A target: its name, and the folders with real inputs.
struct Target {
    name: String,
    seeds: Vec<String>,
}

/// `cargo xtask fuzz [--for SECONDS]`: runs every target.
///
/// # Errors
/// If the arguments are wrong, or a target finds an input that breaks it.
pub fn command(words: &[String]) -> Result<()> {
    match words {
        [] => fuzz(USUAL),
        [option, seconds] if option == "--for" => fuzz(seconds.parse().context("--for takes whole seconds")?),
        _ => bail!("expected --for SECONDS, found {}", words.join(" ")),
    }
}

/// Runs every target for `seconds` seconds. The sanitizers need a nightly toolchain. Without this toolchain only the
/// property tests remain, which every test run includes.
pub fn fuzz(seconds: u32) -> Result<()> {
    if !is_there("cargo", &["+nightly", "--version"]) {
        eprintln!("no nightly toolchain: fuzzing is left out, the property tests still run");
        return Ok(());
    }
    if !is_there("cargo", &["fuzz", "--version"]) {
        consent::ask("cargo-fuzz", "cargo install cargo-fuzz --locked --debug")?;
        // cargo-fuzz only calls other programs: its optimisation would take longer than its run.
        run("cargo", &["install", "cargo-fuzz", "--locked", "--debug", "--quiet"])?;
    }
    run("cargo", &["+nightly", "fuzz", "build", "--fuzz-dir", FOLDER])?;
    let targets = targets()?;
    let next = Mutex::new(targets.into_iter());
    let failed = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some(target) = next.lock().ok().and_then(|mut next| next.next()) {
                    if let (Err(error), Ok(mut failed)) = (run_target(&target, seconds), failed.lock()) {
                        failed.push(error.to_string());
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap_or_default();
    if failed.is_empty() { Ok(()) } else { bail!("{}", failed.join("\n")) }
}

/// All targets. The program lists them if the variable names none.
fn targets() -> Result<Vec<Target>> {
    let output = Command::new("cargo").args(["+nightly", "fuzz", "run", "--fuzz-dir", FOLDER, PROGRAM]).output();
    let output = output.context("can't run cargo fuzz")?;
    let targets: Vec<Target> = String::from_utf8_lossy(&output.stdout).lines().filter_map(target).collect();
    ensure!(!targets.is_empty(), "{FOLDER} lists no targets: {}", String::from_utf8_lossy(&output.stderr));
    Ok(targets)
}

/// The target of a line `NAME FOLDER…`; folders that do not exist are left out.
fn target(line: &str) -> Option<Target> {
    let mut words = line.split_whitespace().map(str::to_owned);
    let name = words.next()?;
    Some(Target { name, seeds: words.filter(|folder| Path::new(folder).is_dir()).collect() })
}

fn run_target(target: &Target, seconds: u32) -> Result<()> {
    // The fuzzer adds findings to the first folder, and only reads the others.
    let found = format!("{FOLDER}/corpus/{}", target.name);
    std::fs::create_dir_all(&found)?;
    let seconds = if target.name == LONG { 2 * seconds } else { seconds };
    let time = format!("-max_total_time={seconds}");
    let output = Command::new("cargo")
        .env(VARIABLE, &target.name)
        .args(["+nightly", "fuzz", "run", "--fuzz-dir", FOLDER, PROGRAM, &found])
        .args(&target.seeds)
        .args(["--", &time, MOST_AT_ONCE, "-rss_limit_mb=4096", "-print_final_stats=1"])
        .output()?;
    let log = String::from_utf8_lossy(&output.stderr);
    let last: Vec<&str> = log.lines().rev().take(if output.status.success() { 3 } else { 80 }).collect();
    let last: Vec<&str> = last.into_iter().rev().collect();
    let again = format!("{VARIABLE}={} cargo +nightly fuzz run --fuzz-dir {FOLDER} {PROGRAM}", target.name);
    eprintln!("$ {again} for {seconds} s\n{}", last.join("\n"));
    ensure!(output.status.success(), "the fuzz target {} found an input that breaks it, see above", target.name);
    Ok(())
}
