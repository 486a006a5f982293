//! How well a bus and the tester's own machine work: what a verdict on a device must not be blamed on.

use canvass_traces::{Duration, Timestamp};
use std::fmt;

/// Counts since the bus was opened. The difference of two says what happened between them.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Health {
    /// Frames that were on the bus and did not reach the tester: the controller had no room for them, or a queue of the
    /// kernel or of the tester was full.
    pub lost: u64,
    /// How often the way to the bus was interrupted: the interface went down, the adapter was unplugged, bus-off.
    pub interruptions: u64,
    /// How long the interruptions lasted that are over.
    pub interrupted_for: Duration,
    /// When the way to the bus was interrupted that is not back yet.
    pub interrupted_since: Option<Timestamp>,
    /// What the last interruption was, and the state of the controller as far as it is known.
    pub trouble: Option<String>,
    pub error_frames: u64,
    /// How often a full transmit queue was waited for.
    pub waits: u64,
    /// From a frame's time on the bus to the tester's seeing it, while it waited for one; and from the end of a wait in vain
    /// to its seeing that.
    pub receive: Latencies,
    /// From the tester's handing over a frame to its time on the bus.
    pub transmit: Latencies,
    /// By how much the time that a frame was given may be later than its arrival, where frames bring none of their own.
    pub stamping: Latencies,
    /// What is wrong with the time stamps of the adapter: those since are not used, and the ones before may be wrong. It stays.
    pub stamps: Option<StampTrouble>,
}

/// What is wrong with the time stamps of an adapter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StampTrouble {
    /// All frames get the same time.
    Still,
    /// The clock was set, starts again too early or too late, or runs at another speed.
    Jump,
    /// A time that the protocol does not have.
    Range,
}

impl StampTrouble {
    const ALL: [Self; 3] = [Self::Still, Self::Jump, Self::Range];

    /// The word for it in JSON and in transcripts.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::Jump => "jump",
            Self::Range => "range",
        }
    }

    /// The trouble of that name.
    pub(crate) fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|trouble| trouble.name() == name)
    }
}

/// What the time stamps do: `stand still`.
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
    /// The longest that this machine was late, of everything that is counted here.
    pub fn latest(&self) -> Option<Duration> {
        [&self.receive, &self.transmit, &self.stamping].into_iter().filter_map(Latencies::longest).max()
    }

    /// The way to the bus is interrupted from now on.
    pub(crate) fn went_away(&mut self, now: Timestamp, trouble: String) {
        self.was_interrupted(trouble);
        self.interrupted_since.get_or_insert(now);
    }

    /// The way to the bus was interrupted, and is there again already.
    pub(crate) fn was_interrupted(&mut self, trouble: String) {
        self.interruptions += 1;
        self.trouble = Some(trouble);
    }

    /// The way to the bus is there.
    pub(crate) fn came_back(&mut self, now: Timestamp) {
        if let Some(since) = self.interrupted_since.take() {
            self.interrupted_for = self.interrupted_for + now.since(since);
        }
    }

    /// The interruptions until now; `None` if there was none.
    pub fn interruptions(&self, now: Timestamp) -> Option<Interruptions> {
        let lasting = self.interrupted_since.map_or(Duration::ZERO, |since| now.since(since));
        (self.interruptions > 0).then(|| Interruptions {
            count: self.interruptions,
            lasted: self.interrupted_for + lasting,
            last: self.trouble.clone(),
            is_over: self.interrupted_since.is_none(),
        })
    }

    /// A wait that had to end at `due` was seen to have ended at `now`. Every wait ends a little late; more than that is
    /// this machine's being busy.
    pub(crate) fn note_late_end(&mut self, due: Timestamp, now: Timestamp) {
        const USUAL: Duration = Duration::from_millis(1);
        let late = now.since(due);
        if late > USUAL {
            self.receive.add(late);
        }
    }

    /// What happened since `before`.
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

/// How often, and for how long, the way to a bus was interrupted.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Interruptions {
    pub count: u64,
    /// How long, all of them together.
    pub lasted: Duration,
    /// What the last one was.
    pub last: Option<String>,
    /// Whether the way is there again.
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

/// How long something took, many times: counted by powers of two of nanoseconds.
#[derive(Clone, PartialEq, Eq)]
pub struct Latencies([u64; Self::BUCKETS]);

impl Latencies {
    /// The last one holds everything from about 4.6 minutes on.
    const BUCKETS: usize = 40;

    /// Counts one.
    pub fn add(&mut self, span: Duration) {
        let bucket = (u64::BITS - span.0.leading_zeros()) as usize;
        if let Some(count) = self.0.get_mut(bucket.min(Self::BUCKETS - 1)) {
            *count += 1;
        }
    }

    /// How many were counted.
    pub fn count(&self) -> u64 {
        self.0.iter().sum()
    }

    /// A span that so many in a thousand did not exceed, at most twice as long as the shortest such; `None` if none was
    /// counted.
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

    /// A span that none exceeded, at most twice as long as the longest.
    pub fn longest(&self) -> Option<Duration> {
        self.quantile(1_000)
    }

    /// How many were counted in each bucket.
    pub(crate) const fn buckets(&self) -> &[u64; Self::BUCKETS] {
        &self.0
    }

    /// Sets what was counted in a bucket, if there is such a bucket.
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
        // Another sign of the same interruption does not make it begin anew.
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
