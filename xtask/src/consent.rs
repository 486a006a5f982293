//! Permission to install programs on this machine.

use anyhow::{Result, bail};
use std::sync::atomic::{AtomicBool, Ordering};

static GIVEN: AtomicBool = AtomicBool::new(false);

/// The option that gives permission.
pub const OPTION: &str = "--install";

/// Notes the user's permission.
pub fn give() {
    GIVEN.store(true, Ordering::Relaxed);
}

/// Whether the user has given permission, or `CI=true` marks a machine that only runs tests.
fn is_given() -> bool {
    GIVEN.load(Ordering::Relaxed) || std::env::var("CI").is_ok_and(|value| value == "true")
}

/// The arguments that pass the permission on to another xtask.
#[cfg(not(all(feature = "bind", feature = "web")))]
pub fn words() -> &'static [&'static str] {
    if GIVEN.load(Ordering::Relaxed) { &[OPTION] } else { &[] }
}

/// Returns an error with the command of the installation, unless it is permitted.
pub fn ask(what: &str, how: &str) -> Result<()> {
    if !is_given() {
        bail!("{what} is missing: install it with `{how}`, or let this command do it with {OPTION}");
    }
    Ok(())
}
