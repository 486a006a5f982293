//! `cargo xtask incidents`: a thousand networks with one fault each, and a thousand healthy ones.

use anyhow::{Result, ensure};
use std::process::Command;

/// How many of each.
const RUNS: &str = "1000";

/// Prints what the first story names, by what breaks: the table of `docs/diagnose.md`.
pub fn incidents() -> Result<()> {
    let tests = ["test", "--release", "--locked", "--package", "canvass-analyzer", "--test", "findings", "incidents"];
    eprintln!("$ CANVASS_INCIDENTS={RUNS} cargo {} -- --nocapture", tests.join(" "));
    let status =
        Command::new("cargo").args(tests).args(["--", "--nocapture"]).env("CANVASS_INCIDENTS", RUNS).status()?;
    ensure!(status.success(), "too many incidents are not named, or something is named in a healthy network");
    Ok(())
}
