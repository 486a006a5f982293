//! Coverage-guided fuzzing of what reads bytes, for a fixed time.

use crate::run::{is_there, run};
use anyhow::{Result, ensure};
use std::path::Path;
use std::process::Command;

/// A target under `fuzz/`, how long it runs, and where real inputs lie that it begins from.
const TARGETS: [(&str, u32, &[&str]); 4] = [
    ("description", 60, &["analyzer/tests/eds", "conformance/models"]),
    ("capture", 30, &["traces/samples"]),
    ("network", 15, &[]),
    ("filter", 15, &[]),
];

/// Runs every target. Needs a nightly toolchain for its sanitizers; without one the property tests, which every run
/// has, must do.
pub fn fuzz() -> Result<()> {
    if !is_there("cargo", &["+nightly", "--version"]) {
        eprintln!("no nightly toolchain: fuzzing is left out, the property tests are not");
        return Ok(());
    }
    if !is_there("cargo", &["fuzz", "--version"]) {
        run("cargo", &["install", "cargo-fuzz", "--locked", "--quiet"])?;
    }
    run("cargo", &["+nightly", "fuzz", "build"])?;
    TARGETS.iter().try_for_each(|(target, seconds, seeds)| run_target(target, *seconds, seeds))
}

fn run_target(target: &str, seconds: u32, seeds: &[&str]) -> Result<()> {
    // The first folder takes what the fuzzer finds; the others it only reads.
    let found = format!("fuzz/corpus/{target}");
    std::fs::create_dir_all(&found)?;
    let folders = seeds.iter().filter(|folder| Path::new(folder).is_dir());
    let time = format!("-max_total_time={seconds}");
    eprintln!("$ cargo +nightly fuzz run {target} for {seconds} s");
    let output = Command::new("cargo")
        .args(["+nightly", "fuzz", "run", target, &found])
        .args(folders)
        .args(["--", &time, "-rss_limit_mb=4096", "-print_final_stats=1"])
        .output()?;
    let log = String::from_utf8_lossy(&output.stderr);
    let last: Vec<&str> = log.lines().rev().take(if output.status.success() { 8 } else { 80 }).collect();
    last.iter().rev().for_each(|line| eprintln!("{line}"));
    ensure!(output.status.success(), "the fuzz target {target} found an input that breaks it, see above");
    Ok(())
}
