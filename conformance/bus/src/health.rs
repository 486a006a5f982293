//! The health of a bus and of the tester's own machine. A device must not be blamed for their defects.

use canvass_traces::{Duration, Timestamp};
use std::fmt;

/// Counters since the bus was opened. The difference of two readings counts the events between them.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Health {
    /// Number of frames of the bus that did not reach the tester: the controller had no room for them, or a queue of
    /// the kernel or of the tester was full.
    pub lost: u64,
    /// Number of interruptions of the bus: the interface went down, the adapter was unplugged, bus-off.
    pub interruptions: u64,
    /// Duration of all interruptions that are over.
    pub interrupted_for: Duration,
    /// Begin of the current interruption.
    pub interrupted_since: Option<Timestamp>,
    /// The cause of the last interruption, with the state of the controller if known.
    pub trouble: Option<String>,
    pub error_frames: u64,
    /// Number of waits because the transmit queue was full.
    pub waits: u64,
    /// Delay from a frame's time on the bus until the tester received it, if the tester was waiting; and from the end
    /// of a wait without frame until the tester noticed the end.
    pub receive: Latencies,
    /// Delay from the tester's sending of a frame to its time on the bus.
    pub transmit: Latencies,
    /// Uncertainty of the time of a frame, if frames have no timestamps of their own.
    pub stamping: Latencies,
    /// The fault of the adapter's time stamps, if one was found: later stamps are not used, and earlier ones may be
    /// wrong. The fault is never cleared.
    pub stamps: Option<StampTrouble>,
}

/// A fault of an adapter's time stamps.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StampTrouble {
    /// All frames get the same time stamp.
    Still,
    /// The clock was set, or restarts too early or too late, or runs at another speed.
    Jump,
    /// A time stamp has a value that the protocol does not allow.
    Range,
}

impl StampTrouble {
    const ALL: [Self; 3] = [Self::Still, Self::Jump, Self::Range];

    /// The name in JSON and in transcripts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::Jump => "jump",
            Self::Range => "range",
        }
    }

    /// The fault of that name.
    pub(crate) fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|trouble| trouble.name() == name)
    }
}

/// The behaviour of the time stamps in words, such as `stand still`.
impl fmt::Display for StampTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Still => "stand still",
            Self::Jump => "jump or run at another speed",
            Self::Range => "exceed 59999 ms",
        })
    }
}

impl Health {
    /// The longest delay of this machine among the counted ones.
    pub fn latest(&self) -> Option<Duration> {
        [&self.receive, &self.transmit, &self.stamping].into_iter().filter_map(Latencies::longest).max()
    }

    /// Begins an interruption.
    pub(crate) fn went_away(&mut self, now: Timestamp, trouble: String) {
        self.was_interrupted(trouble);
        self.interrupted_since.get_or_insert(now);
    }

    /// Counts an interruption that is already over.
    pub(crate) fn was_interrupted(&mut self, trouble: String) {
        self.interruptions += 1;
        self.trouble = Some(trouble);
    }

    /// Ends the current interruption.
    pub(crate) fn came_back(&mut self, now: Timestamp) {
        if let Some(since) = self.interrupted_since.take() {
            self.interrupted_for = self.interrupted_for + now.since(since);
        }
    }

    /// The interruptions so far; `None` if there was none.
    pub fn interruptions(&self, now: Timestamp) -> Option<Interruptions> {
        let lasting = self.interrupted_since.map_or(Duration::ZERO, |since| now.since(since));
        (self.interruptions > 0).then(|| Interruptions {
            count: self.interruptions,
            lasted: self.interrupted_for + lasting,
            last: self.trouble.clone(),
            is_over: self.interrupted_since.is_none(),
        })
    }

    /// Counts the delay of a wait that should have ended at `due` and ended at `now`. Every wait ends slightly late; a
    /// longer delay shows that this machine is busy.
    pub(crate) fn note_late_end(&mut self, due: Timestamp, now: Timestamp) {
        const USUAL: Duration = Duration::from_millis(1);
        let late = now.since(due);
        if late > USUAL {
            self.receive.add(late);
        }
    }

    /// The difference since `before`.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            lost: self.lost.saturating_sub(before.lost),
            interruptions: self.interruptions.saturating_sub(before.interruptions),
            interrupted_for: Duration(self.interrupted_for.0.saturating_sub(before.interrupted_for.0)),
            interrupted_since: self.interrupted_since,
            trouble: self.trouble.clone().filter(|_| self.interruptions > before.interruptions),
            error_frames: self.error_frames.saturating_sub(before.error_frames),
            waits: self.waits.saturating_sub(before.waits),
            receive: self.receive.since(&before.receive),
            transmit: self.transmit.since(&before.transmit),
            stamping: self.stamping.since(&before.stamping),
            stamps: self.stamps,
        }
    }
}

/// Number and duration of a bus's interruptions.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Interruptions {
    pub count: u64,
    /// Total duration of all interruptions.
    pub lasted: Duration,
    /// The cause of the last interruption.
    pub last: Option<String>,
    /// Whether the bus is back.
    pub is_over: bool,
}

/// `2 interruptions of the bus, for 1.502 s in all so far (can0 went down)`.
impl fmt::Display for Interruptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, lasted, last, is_over } = self;
        let lasted = Duration::from_millis(lasted.nanos() / 1_000_000);
        match count {
            1 => write!(f, "1 interruption of the bus, for {lasted}")?,
            _ => write!(f, "{count} interruptions of the bus, for {lasted} in all")?,
        }
        f.write_str(if *is_over { "" } else { " so far" })?;
        last.as_ref().map_or(Ok(()), |last| write!(f, " ({last})"))
    }
}

/// A histogram of durations, in powers of two of nanoseconds.
#[derive(Clone, PartialEq, Eq)]
pub struct Latencies([u64; Self::BUCKETS]);

impl Latencies {
    /// The last bucket holds all durations from about 4.6 minutes on.
    const BUCKETS: usize = 40;

    /// Counts a duration.
    pub fn add(&mut self, span: Duration) {
        let bucket = (u64::BITS - span.0.leading_zeros()) as usize;
        if let Some(count) = self.0.get_mut(bucket.min(Self::BUCKETS - 1)) {
            *count += 1;
        }
    }

    /// Number of durations.
    pub fn count(&self) -> u64 {
        self.0.iter().sum()
    }

    /// The upper bound of the bucket that contains the quantile `per_mille`/1000: at most twice the exact value. `None`
    /// if no duration was counted.
    pub fn quantile(&self, per_mille: u64) -> Option<Duration> {
        let total = self.count();
        let rank = (total * per_mille).div_ceil(1_000).max(1);
        let mut seen = 0;
        let bucket = self.0.iter().position(|count| {
            seen += count;
            total > 0 && seen >= rank
        })?;
        Some(Duration((1 << bucket) - 1))
    }

    /// A duration that no counted duration exceeds, at most twice the longest one; `None` if nothing was counted.
    pub fn longest(&self) -> Option<Duration> {
        self.quantile(1_000)
    }

    /// The number of durations in each bucket.
    pub(crate) const fn buckets(&self) -> &[u64; Self::BUCKETS] {
        &self.0
    }

    /// Sets the count of a bucket; `None` if the bucket does not exist.
    pub(crate) fn set(&mut self, bucket: usize, count: u64) -> Option<()> {
        *self.0.get_mut(bucket)? = count;
        Some(())
    }

    fn since(&self, before: &Self) -> Self {
        let mut counts = self.0;
        counts.iter_mut().zip(&before.0).for_each(|(count, before)| *count = count.saturating_sub(*before));
        Self(counts)
    }
}

impl Default for Latencies {
    fn default() -> Self {
        Self([0; Self::BUCKETS])
    }
}

impl fmt::Debug for Latencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// `half within 65.535 µs, 99 % within 131.071 µs, all within 1.048 ms`.
impl fmt::Display for Latencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.quantile(500), self.quantile(990), self.longest()) {
            (Some(half), Some(most), Some(all)) => {
                write!(f, "half within {half}, 99 % within {most}, all within {all}")
            }
            _ => f.write_str("none"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interruptions_are_counted_and_measured() {
        let at = |seconds: u64| Timestamp(seconds * 1_000_000_000);
        let mut health = Health::default();
        assert_eq!(health.interruptions(at(1)), None);
        health.went_away(at(1), "can0 went down".to_owned());
        let told = health.interruptions(at(3)).map(|interruptions| interruptions.to_string());
        assert_eq!(told.as_deref(), Some("1 interruption of the bus, for 2 s so far (can0 went down)"));
        health.came_back(at(4));
        health.came_back(at(5));
        let first = health.clone();
        health.went_away(at(6), "can0 was removed".to_owned());
        // Another sign of the same interruption does not restart it.
        health.went_away(at(7), "can0 was removed".to_owned());
        health.came_back(at(8));
        let told = health.interruptions(at(9)).map(|interruptions| interruptions.to_string());
        assert_eq!(told.as_deref(), Some("3 interruptions of the bus, for 5 s in all (can0 was removed)"));
        let since = health.since(&first);
        assert_eq!((since.interruptions, since.interrupted_for), (2, Duration::from_secs(2)));
    }

    #[test]
    fn quantiles_are_bounds() {
        let mut latencies = Latencies::default();
        assert_eq!(latencies.longest(), None);
        for _ in 0..99 {
            latencies.add(Duration::from_micros(50));
        }
        latencies.add(Duration::from_millis(20));
        let (half, most, all) = (latencies.quantile(500), latencies.quantile(990), latencies.longest());
        assert!(half == most && half.is_some_and(|half| (50_000..100_000).contains(&half.0)), "{half:?}");
        assert!(all.is_some_and(|all| (20_000_000..40_000_000).contains(&all.0)), "{all:?}");
        let before = latencies.clone();
        latencies.add(Duration(u64::MAX));
        latencies.add(Duration::ZERO);
        assert_eq!(latencies.since(&before).count(), 2);
        assert_eq!(latencies.since(&before).quantile(500), Some(Duration::ZERO));
    }
}
