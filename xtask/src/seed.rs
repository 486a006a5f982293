//! The default seed: the date, so that nobody tunes to it.

use anyhow::{Context, Result};
use std::process::Command;

/// The date as a number, such as 20261122.
pub fn today() -> Result<u64> {
    let day = Command::new("date").arg("+%Y%m%d").output().context("date")?;
    String::from_utf8_lossy(&day.stdout).trim().parse().context("date")
}
