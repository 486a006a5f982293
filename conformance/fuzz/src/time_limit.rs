//! The end of a run, whatever the device does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The time limit of a run. It is checked between the frames of a sequence on a live device, and between the tries of
/// making a sequence shorter, because a device that never answers or never falls silent makes one sequence last
/// minutes.
#[derive(Clone, Debug, Default)]
pub struct TimeLimit {
    /// The end of the run. `None` if there is no limit.
    pub ends: Option<Instant>,
    /// Whether the user has ended the run.
    pub cancelled: Arc<AtomicBool>,
}

impl TimeLimit {
    /// Whether the run has to end now.
    pub fn is_over(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed) || self.ends.is_some_and(|ends| Instant::now() >= ends)
    }

    /// The remaining time of the run. `None` if there is no limit.
    pub fn left(&self) -> Option<Duration> {
        self.ends.map(|ends| ends.saturating_duration_since(Instant::now()))
    }
}
