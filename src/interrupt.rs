//! Ctrl-C and requests to terminate: the current work is ended properly first.

use anyhow::{Context, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user has asked the program to end.
#[derive(Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

/// The exit status of a program that Ctrl-C killed, by the convention of shells.
const KILLED_BY_CTRL_C: i32 = 130;

impl Interrupt {
    /// Watches for Ctrl-C and SIGTERM. The second interrupt ends the program at once.
    pub fn watch() -> Result<Self> {
        Self::watch_and(|| ())
    }

    /// As [`Interrupt::watch`]; the first interrupt prints the message.
    pub fn watch_saying(message: &'static str) -> Result<Self> {
        Self::watch_and(move || crate::output::diagnostic(message))
    }

    fn watch_and(first: impl Fn() + Send + 'static) -> Result<Self> {
        let interrupt = Self::default();
        let seen = interrupt.clone();
        ctrlc::set_handler(move || {
            if seen.0.swap(true, Ordering::Relaxed) {
                std::process::exit(KILLED_BY_CTRL_C);
            }
            first();
        })
        .context("can't watch for Ctrl-C")?;
        Ok(interrupt)
    }

    /// Requests the end, as Ctrl-C does.
    #[cfg(test)]
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// The flag that Ctrl-C sets.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    /// Whether the end was requested.
    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
