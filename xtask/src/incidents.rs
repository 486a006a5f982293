//! `cargo xtask incidents`: a thousand networks with one fault each, and a thousand healthy ones.

use anyhow::{Result, ensure};
use std::process::Command;

/// Number of networks of each kind.
const RUNS: &str = "1000";

/// Prints the findings named first, by fault: the table of `docs/diagnose.md`.
pub fn incidents() -> Result<()> {
    let tests = ["test", "--release", "--locked", "--package", "canvass-analyzer", "--test", "findings", "incidents"];
    eprintln!("$ CANVASS_INCIDENTS={RUNS} cargo {} -- --nocapture", tests.join(" "));
    let status =
        Command::new("cargo").args(tests).args(["--", "--nocapture"]).env("CANVASS_INCIDENTS", RUNS).status()?;
    ensure!(status.success(), "too many incidents are not named, or a healthy network has a finding");
    Ok(())
}
