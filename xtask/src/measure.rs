//! Measures other programs: processor time by the kernel's count, memory by GNU time.

use crate::packages::Package;
use crate::run::target_folder;
use anyhow::{Context, Result, ensure};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use std::fs::{self, File};
use std::process::{Command, Stdio};

pub const TIME: Package = Package { program: TIME_PATH, probe: &["--version"], package: "time" };
pub const RUNS: usize = 3;

/// GNU time, not the shell's builtin, which reports no memory.
const TIME_PATH: &str = "/usr/bin/time";
const RESULT: &str = "target/bench/time";

/// The cost of running a program.
#[derive(Clone, Copy)]
pub struct Cost {
    /// Seconds on all processors; other programs on the machine affect it little.
    pub cpu: f64,
    /// Peak memory, in KiB.
    pub memory: u64,
}

/// Runs a program on this input, and discards its output.
pub fn cost(command: &[&str], input: Stdio) -> Result<Cost> {
    let before = of_children()?;
    let status = Command::new(TIME_PATH)
        .args(["--quiet", "--format", "%M", "--output", RESULT])
        .args(command)
        .stdin(input)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .with_context(|| format!("can't run {TIME_PATH}"))?;
    ensure!(status.success(), "{} ended with {status}", command.join(" "));
    let cpu = of_children()? - before;
    let result = fs::read_to_string(RESULT)?;
    let memory = result.trim().parse().with_context(|| format!("{TIME_PATH} says {result}"))?;
    Ok(Cost { cpu, memory })
}

/// Processor seconds of all ended child programs. GNU time rounds to hundredths; it takes less than one hundredth
/// itself.
fn of_children() -> Result<f64> {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN)?;
    Ok((usage.user_time() + usage.system_time()).num_microseconds() as f64 / 1e6)
}

/// The path of a program of the release profile.
pub fn release(name: &str) -> String {
    target_folder().join("release").join(name).to_string_lossy().into_owned()
}

/// The processor, and the number of its cores.
pub fn machine() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(" unknown processor");
    let cores = info.lines().filter(|line| line.starts_with("processor")).count();
    format!("{}, {cores} cores", model.trim_start_matches(['\t', ':', ' ']))
}

/// The lowest cost of several runs.
pub fn best(command: &[&str], input: Option<&str>) -> Result<Cost> {
    best_of(RUNS, command, input)
}

pub fn best_of(runs: usize, command: &[&str], input: Option<&str>) -> Result<Cost> {
    let mut best: Option<Cost> = None;
    for _ in 0..runs {
        let input = input.map(File::open).transpose()?.map_or_else(Stdio::null, Stdio::from);
        let cost = cost(command, input)?;
        best = Some(best.filter(|best| best.cpu <= cost.cpu).unwrap_or(cost));
    }
    best.context("no run")
}
