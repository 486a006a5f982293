//! Whether programs may be installed on this machine.

use anyhow::{Result, bail};
use std::sync::atomic::{AtomicBool, Ordering};

static GIVEN: AtomicBool = AtomicBool::new(false);

/// The option that gives it.
pub const OPTION: &str = "--install";

/// The user has said so.
pub fn give() {
    GIVEN.store(true, Ordering::Relaxed);
}

/// Whether the user has said so, or the machine is one that runs nothing but tests and says so by `CI=true`.
fn is_given() -> bool {
    GIVEN.load(Ordering::Relaxed) || std::env::var("CI").is_ok_and(|value| value == "true")
}

/// What passes it on to another xtask, where it was given by the option.
#[cfg(not(feature = "web"))]
pub fn words() -> &'static [&'static str] {
    if GIVEN.load(Ordering::Relaxed) { &[OPTION] } else { &[] }
}

/// An error that says what would be installed, and how, unless that may be done.
pub fn ask(what: &str, how: &str) -> Result<()> {
    if !is_given() {
        bail!("{what} is missing: `{how}` brings it, and with {OPTION} this command does that itself");
    }
    Ok(())
}
