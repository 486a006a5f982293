//! Ctrl-C and requests to terminate: what is under way is ended properly first.

use anyhow::{Context, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user wants the program to end.
#[derive(Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

/// What shells give to a program that Ctrl-C ended.
const KILLED_BY_CTRL_C: i32 = 130;

impl Interrupt {
    /// Waits for Ctrl-C and the like from now on. The second one ends the program at once.
    pub fn watch() -> Result<Self> {
        Self::watch_and(|| ())
    }

    /// The same, and the first one is answered by that message.
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

    /// As if the user had asked for it.
    #[cfg(test)]
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// What is set when it comes.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    /// Whether it came.
    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
