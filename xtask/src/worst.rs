//! Measures the most expensive traffic: time for each frame, compared with usual traffic, and memory.

use crate::bench::build;
use crate::measure::{TIME, best, machine, release};
use crate::packages::install;
use anyhow::{Result, ensure};
use std::fs::{self, File};
use std::process::Command;

/// The kinds of `traces/examples/worst.rs`, with the number of frames, and the limit of memory in MiB.
const KINDS: [(&str, u32, Option<f64>); 11] = [
    ("boot-ups", 200_000, BOUND),
    ("reboots", 1_000_000, BOUND),
    ("commands", 300_000, BOUND),
    ("guarding", 300_000, BOUND),
    ("requests", 300_000, BOUND),
    ("errors", 300_000, BOUND),
    ("cob-ids", 300_000, BOUND),
    ("cobs-64", 300_000, BOUND),
    ("consumers", 300_000, BOUND),
    // The limit of memory holds for up to 64 channels.
    ("channels", 3_000_000, None),
    ("identifiers", 3_000_000, BOUND),
];
const BOUND: Option<f64> = Some(128.0);
/// Maximum cost of a frame, as a multiple of the cost of a usual frame.
const TIMES: f64 = 20.0;
const USUAL: u32 = 300_000;
const COMMANDS: [&[&str]; 2] = [&["diagnose", "--fail-on", "never"], &["decode"]];

/// Prints the cost of a frame of each kind, and its multiple of a usual frame.
///
/// # Errors
/// If a frame costs more than twenty usual frames, or a kind takes 128 MiB on up to 64 channels.
pub fn worst() -> Result<()> {
    install(&[TIME])?;
    build()?;
    fs::create_dir_all("target/bench")?;
    println!("machine: {}", machine());
    println!("{:12} {:>9}  {:8} {:>9} {:>7} {:>7}", "traffic", "frames", "command", "ns/frame", "times", "MiB");
    let usual = made("traffic", "candump", USUAL)?;
    let mut over = Vec::new();
    for command in COMMANDS {
        let (reference, mib) = measured(command, &usual, USUAL)?;
        print("usual", USUAL, command, (reference, 1.0, mib));
        for (kind, frames, most) in KINDS {
            let (nanos, mib) = measured(command, &made("worst", kind, frames)?, frames)?;
            let times = nanos / reference;
            print(kind, frames, command, (nanos, times, mib));
            if times > TIMES || most.is_some_and(|most| mib > most) {
                over.push(format!("{} of {kind}", command.first().unwrap_or(&"")));
            }
        }
    }
    ensure!(over.is_empty(), "more than {TIMES} usual frames or 128 MiB: {}", over.join(", "));
    Ok(())
}

fn print(kind: &str, frames: u32, command: &[&str], (nanos, times, mib): (f64, f64, f64)) {
    let command = command.first().unwrap_or(&"");
    println!("{kind:12} {frames:>9}  {command:8} {nanos:>9.0} {times:>7.1} {mib:>7.1}");
}

/// Makes a capture by an example of canvass-traces.
fn made(example: &str, kind: &str, frames: u32) -> Result<String> {
    let path = format!("target/bench/{example}-{kind}-{frames}.log");
    let out = File::create(&path)?;
    let program = release(&format!("examples/{example}"));
    let status = Command::new(program).args([kind, &frames.to_string()]).stdout(out).status()?;
    ensure!(status.success(), "{kind} could not be made: {status}");
    Ok(path)
}

/// Nanoseconds of processor time for each frame, and memory in MiB.
fn measured(command: &[&str], path: &str, frames: u32) -> Result<(f64, f64)> {
    let cost = best(&[&[&*release("canvass")], command, &[path]].concat(), None)?;
    Ok((cost.cpu / f64::from(frames) * 1e9, cost.memory as f64 / 1024.0))
}
