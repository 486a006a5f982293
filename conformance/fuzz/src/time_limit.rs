//! When a run ends, whatever the device does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Until when a run may go on. It is looked at between the frames of a sequence on a live device, and between the tries of
/// making a sequence shorter: a device that answers nothing, or never falls silent, makes one sequence last minutes.
#[derive(Clone, Debug, Default)]
pub struct TimeLimit {
    /// The end; `None`: there is none.
    pub ends: Option<Instant>,
    /// Whether the user has ended the run.
    pub cancelled: Arc<AtomicBool>,
}

impl TimeLimit {
    /// Whether the run is to end now.
    pub fn is_over(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed) || self.ends.is_some_and(|ends| Instant::now() >= ends)
    }

    /// How long the run may go on; `None`: as long as it takes.
    pub fn left(&self) -> Option<Duration> {
        self.ends.map(|ends| ends.saturating_duration_since(Instant::now()))
    }
}
