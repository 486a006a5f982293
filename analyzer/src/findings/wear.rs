//! Memories that are written more often than they bear.

use super::context::{Context, Scene};
use super::seen::Seen;

/// How often a memory may be written.
#[derive(Clone, Copy)]
pub struct WearLimits {
    /// Fewer writes in a capture are not judged.
    pub times: u64,
    /// How many writes the memory bears.
    pub cycles: u64,
    /// The service life.
    pub years: u64,
}

/// How often a memory was written.
#[derive(Default)]
pub struct Wear {
    count: u64,
    first: Option<Seen>,
}

impl Wear {
    /// One more write.
    pub fn count(&mut self, context: &Context<'_>) {
        self.count += 1;
        self.first.get_or_insert_with(|| context.seen());
    }

    /// The first write, and what is to be said, if there were too many within the capture.
    pub fn judge(&self, limits: &WearLimits, scene: &Scene<'_>) -> Option<(&Seen, String)> {
        const SECONDS_OF_YEAR: u64 = 365 * 86_400;
        let bearable = SECONDS_OF_YEAR.saturating_mul(limits.years) / limits.cycles;
        let first = self.first.as_ref().filter(|_| scene.has_times() && self.count >= limits.times)?;
        let every = scene.now.since(scene.start).nanos() / 1_000_000_000 / self.count;
        let message = || format!("{} stores, one every {every} s; one every {bearable} s is bearable", self.count);
        (every < bearable).then(|| (first, message()))
    }
}
