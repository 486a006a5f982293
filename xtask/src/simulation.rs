//! Measures the speed of simulated devices.

use crate::measure::release;
use crate::run::run;
use anyhow::{Context, Result, bail};
use std::process::{Command, Stdio};

/// Number of exchanges with each model.
const FUZZED: &str = "500000";

/// Builds, measures and prints: SDO exchanges with one device, fuzzing, and a day of a network.
pub fn simulation() -> Result<()> {
    println!("\nsimulated bus, one thread");
    build_examples()?;
    run(&release("examples/bus_speed"), &[])?;
    for target in ["all", "sdo", "lss"] {
        println!("fuzzing {target}, its reference models included, processor time");
        run(&release("examples/soak"), &["models", FUZZED, "1", target])?;
    }
    let (frames, bus_seconds, nanos) = day()?;
    let seconds = nanos / 1e9;
    println!(
        "eight encoders at 250 kbit/s: {:.1} hours of bus time, {:.2} million frames, in {seconds:.1} s ({:.2} M frames/s)",
        bus_seconds / 3600.0,
        frames / 1e6,
        frames / nanos * 1e3
    );
    Ok(())
}

/// Builds the examples that exchange frames with simulated devices.
pub fn build_examples() -> Result<()> {
    let packages = ["--package", "canvass-device", "--package", "canvass-fuzzer"];
    run("cargo", &[&["build", "--release", "--locked", "--examples"], &packages[..]].concat())
}

/// The number of frames, the seconds on the bus, and the nanoseconds that the simulation took.
fn day() -> Result<(f64, f64, f64)> {
    let mut command = Command::new(release("examples/network_day"));
    let output = command.stderr(Stdio::inherit()).output().with_context(|| format!("can't run {command:?}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
    match numbers[..] {
        [frames, bus_seconds, nanos] if nanos > 0.0 => Ok((frames, bus_seconds, nanos)),
        _ => bail!("{command:?} says {text}"),
    }
}
