//! Wear of memories that are written too often.

use super::context::{Context, Scene};
use super::seen::Seen;

/// The limits for writes.
#[derive(Clone, Copy)]
pub(crate) struct WearLimits {
    /// A lower number of writes is not judged.
    pub times: u64,
    /// Number of writes that the memory bears.
    pub cycles: u64,
    /// The service life in years.
    pub years: u64,
}

/// Number of writes to a memory.
#[derive(Default)]
pub(crate) struct Wear {
    count: u64,
    first: Option<Seen>,
}

impl Wear {
    /// Counts a write.
    pub fn count(&mut self, context: &Context<'_>) {
        self.count += 1;
        self.first.get_or_insert_with(|| context.seen());
    }

    /// The first write, and the text of the finding, if there were too many writes within the capture.
    pub fn judge(&self, limits: &WearLimits, scene: &Scene<'_>) -> Option<(&Seen, String)> {
        const SECONDS_OF_YEAR: u64 = 365 * 86_400;
        let bearable = SECONDS_OF_YEAR.saturating_mul(limits.years) / limits.cycles;
        let first = self.first.as_ref().filter(|_| scene.has_times() && self.count >= limits.times)?;
        let every = scene.now.since(scene.start).nanos() / 1_000_000_000 / self.count;
        let message = || format!("{} stores, one every {every} s; the memory bears one every {bearable} s", self.count);
        (every < bearable).then(|| (first, message()))
    }
}
