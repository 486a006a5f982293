//! Measures the diagnosis: compared with decoding of the same frames, and for hours of a healthy bus.

use crate::bench::capture;
use crate::measure::{best, cost, release};
use anyhow::{Result, ensure};
use std::fs::File;
use std::process::{Command, Stdio};

/// Number of frames for hours of a half-full bus of eight nodes.
const HEALTHY: &str = "10000000";
const HEALTHY_CAPTURE: &str = "target/bench/machine.pcap";

/// Diagnoses the frames that the other benchmarks decode, and a healthy machine.
///
/// # Errors
/// If the diagnosis finds anything in the healthy machine, if a program can't be run, or if its output is unexpected.
pub fn diagnosing() -> Result<()> {
    println!("\ndiagnosing, processor time");
    let canvass = release("canvass");
    for format in ["candump", "pcap"] {
        let path = capture(format);
        let decode = [&*canvass, "decode", "--format", "text", &path];
        let diagnose = [&*canvass, "diagnose", "--fail-on", "never", &path];
        let (decoding, diagnosis) = in_turns(&decode, &diagnose)?;
        let ratio = diagnosis / decoding;
        println!("{format}: {diagnosis:.3} s, {ratio:.2} times the {decoding:.3} s of decoding to text");
        if format == "pcap" {
            let tshark = best(&["tshark", "-n", "-d", "can.subdissector,canopen", "-r", &path], None)?.cpu;
            println!("{format}: {:.1} times as fast as one line a frame of tshark", tshark / diagnosis);
        }
    }
    healthy(&canvass)
}

/// The best processor time of each command. The commands run in turns: if a shared machine is slow for a time, it is
/// slow for both.
fn in_turns(one: &[&str], other: &[&str]) -> Result<(f64, f64)> {
    const TURNS: usize = 9;
    let mut best = (f64::MAX, f64::MAX);
    for _ in 0..TURNS {
        best.0 = best.0.min(cost(one, Stdio::null())?.cpu);
        best.1 = best.1.min(cost(other, Stdio::null())?.cpu);
    }
    Ok(best)
}

fn healthy(canvass: &str) -> Result<()> {
    let written = Command::new(release("examples/machine"))
        .args(["pcap", HEALTHY])
        .stdout(File::create(HEALTHY_CAPTURE)?)
        .status()?;
    ensure!(written.success(), "making the traffic of a healthy machine failed: {written}");
    let output = Command::new(canvass).args(["diagnose", HEALTHY_CAPTURE]).output()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let nothing = text.lines().any(|line| line == "0 errors, 0 warnings, 0 hints");
    ensure!(nothing, "something was found in a healthy machine:\n{text}");
    let cost = best(&[canvass, "diagnose", HEALTHY_CAPTURE], None)?;
    println!("{HEALTHY} frames of a healthy machine: {:.2} s, {:.1} MiB", cost.cpu, cost.memory as f64 / 1024.0);
    if let Some(first) = text.lines().next() {
        println!("  {first}");
    }
    Ok(())
}
