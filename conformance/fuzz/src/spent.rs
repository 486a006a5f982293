//! The use of the time of a run. On a live bus the waits decide how many sequences are tried.

use canvass_traces::Duration;
use std::fmt;
use std::ops::AddAssign;

/// The reason of a wait.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cause {
    /// The start of the device, and reading or writing back its values after the start.
    Start,
    /// Reading the state of a device after a violation, without a reset.
    Recovery,
    /// An answer that came.
    Answer,
    /// An answer that was due and did not come.
    Missing,
    /// Silence when no answer was due.
    Silence,
    /// The answer to a request that replaces waiting for silence.
    Question,
    /// A pause of the sequence.
    Pause,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 7] =
        [Self::Start, Self::Recovery, Self::Answer, Self::Missing, Self::Silence, Self::Question, Self::Pause];

    /// The cause in words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Start => "starts",
            Self::Recovery => "recoveries",
            Self::Answer => "answers",
            Self::Missing => "missing answers",
            Self::Silence => "silence",
            Self::Question => "questions",
            Self::Pause => "pauses",
        }
    }
}

/// Number and total duration of the waits for each cause.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Spent {
    waits: [(u64, Duration); Cause::ALL.len()],
}

impl Spent {
    /// Adds a wait.
    pub fn add(&mut self, cause: Cause, time: Duration) {
        let (count, sum) = &mut self.waits[cause as usize];
        *count += 1;
        *sum = *sum + time;
    }

    /// Number and total duration of the waits for a cause.
    pub const fn of(&self, cause: Cause) -> (u64, Duration) {
        self.waits[cause as usize]
    }

    /// The total duration of all waits.
    pub fn total(&self) -> Duration {
        self.waits.iter().fold(Duration::ZERO, |total, (_, sum)| total + *sum)
    }

    /// The waits since `before`.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let mut waits = self.waits;
        for ((count, sum), (count_before, sum_before)) in waits.iter_mut().zip(before.waits) {
            *count -= count_before;
            *sum = Duration(sum.nanos() - sum_before.nanos());
        }
        Self { waits }
    }
}

impl AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        for ((count, sum), (more, time)) in self.waits.iter_mut().zip(other.waits) {
            *count += more;
            *sum = *sum + time;
        }
    }
}

impl fmt::Display for Spent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, cause) in Cause::ALL.into_iter().enumerate() {
            let (count, time) = self.of(cause);
            let separator = if n == 0 { "" } else { ", " };
            write!(f, "{separator}{} {count} times {:.1} s", cause.name(), time.nanos() as f64 / 1e9)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_are_counted_by_their_cause() {
        let mut spent = Spent::default();
        spent.add(Cause::Answer, Duration::from_millis(100));
        let before = spent;
        spent.add(Cause::Answer, Duration::from_millis(300));
        spent.add(Cause::Silence, Duration::from_millis(50));
        let mut since = spent.since(&before);
        assert_eq!(since.of(Cause::Answer), (1, Duration::from_millis(300)));
        assert_eq!(since.total(), Duration::from_millis(350));
        since += before;
        assert_eq!(since, spent);
        assert!(spent.to_string().contains("answers 2 times 0.4 s, missing answers 0 times 0.0 s"), "{spent}");
    }
}
