//! Memory use for captures of gigabytes, which are generated and read through a pipe.

use crate::bench::build;
use crate::measure::{TIME, cost, machine, release};
use crate::packages::install;
use anyhow::{Result, ensure};
use std::fs;
use std::process::{Command, Stdio};

/// Limit of the memory in KiB.
const MOST: u64 = 64 * 1024;

/// A kind of capture.
struct CaptureKind {
    format: &'static str,
    size: &'static str,
    frames: &'static str,
    commands: &'static [&'static [&'static str]],
}

const KINDS: [CaptureKind; 3] = [
    CaptureKind { format: "candump", size: "10 M frames", frames: "10000000", commands: &DECODERS },
    // A line of candump has 43.3 bytes on average, a message of MCAP 83.0.
    CaptureKind { format: "candump", size: "2 GB", frames: "46200000", commands: &COMMANDS },
    CaptureKind { format: "mcap", size: "1 GB", frames: "12100000", commands: &COMMANDS },
];

/// Commands that decode, and so keep the state of the bus.
const DECODERS: [&[&str]; 6] = [
    &["decode", "--format", "text", "-"],
    &["decode", "--format", "json", "-"],
    &["decode", "--format", "csv", "-"],
    &["decode", "--events", "-"],
    &["signals", "--format", "json", "-"],
    &["diagnose", "--fail-on", "never", "-"],
];

/// Commands for large captures. MCAP is written into a file, with chunks, index and compression, and live into a pipe.
const COMMANDS: [&[&str]; 5] = [
    &["decode", "-"],
    &["diagnose", "--fail-on", "never", "-"],
    &["convert", "--to", "mcap", "-", "/dev/null"],
    &["convert", "--to", "mcap", "-", "-"],
    &["convert", "--to", "candump", "-", "/dev/null"],
];

/// Decodes 10 million frames with every command, and decodes and converts a candump log of 2 GB and an MCAP file of
/// 1 GB.
///
/// # Errors
/// If a command takes 64 MiB or more.
pub fn memory() -> Result<()> {
    install(&[TIME])?;
    build()?;
    fs::create_dir_all("target/bench")?;
    println!("machine: {}", machine());
    for CaptureKind { format, size, frames, commands } in KINDS {
        for args in commands {
            let mut traffic =
                Command::new(release("examples/traffic")).args([format, frames]).stdout(Stdio::piped()).spawn()?;
            let Some(capture) = traffic.stdout.take() else { continue };
            let canvass = release("canvass");
            let cost = cost(&[&[&*canvass], *args].concat(), capture.into())?;
            ensure!(traffic.wait()?.success(), "making the traffic failed");
            let (args, mib) = (args.join(" "), cost.memory as f64 / 1024.0);
            println!("{size} {format:8} canvass {args:38} {mib:>6.1} MiB at most, {:>6.1} s", cost.cpu);
            ensure!(cost.memory < MOST, "canvass {args} takes {mib:.1} MiB of a {format} capture of {size}");
        }
    }
    Ok(())
}
