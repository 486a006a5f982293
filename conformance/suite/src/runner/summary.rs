//! The outcome of a run in numbers.

use crate::verdict::Kind;
use canvass_bus::{Health, StampTrouble};
use canvass_traces::{Duration, Timestamp};
use std::fmt;

/// The outcome of a run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Summary {
    counts: [usize; Kind::ALL.len()],
    /// How long the run took on the clock of the bus.
    pub duration: Duration,
    /// The user ended the run before all cases had run.
    pub cancelled: bool,
    /// Why the run ended before its last case, where the user has not ended it.
    pub ended_early: Option<EndedEarly>,
    /// How many cases could not be judged for want of a description of the device.
    pub undescribed: usize,
    /// How well the tester's own machine kept up, on a live bus.
    pub host: Option<HostTiming>,
    /// How often the device was told to write its non-volatile memory: it wears out.
    pub stores: u32,
    /// How many cases ended differently when they were repeated.
    pub flaky: usize,
    /// How many of those that are not good do not count yet.
    pub quarantined: usize,
    /// The device is known to be as it was before the run. `false` too where that could not be seen.
    pub is_as_found: bool,
}

/// Why a run ended before its last case.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EndedEarly {
    /// What the device sends makes no sense.
    NoProtocol,
    /// A case failed, and the user wants no more than the first failure.
    FirstFailure,
    /// It took as long as the user had given it.
    TimeIsOver,
}

impl fmt::Display for EndedEarly {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoProtocol => "the device does not follow the protocol",
            Self::FirstFailure => "a case failed, and the run ends with the first failure",
            Self::TimeIsOver => "its time was over",
        })
    }
}

/// How well the tester's own machine kept up. Each bound is at most twice the longest span that it holds for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct HostTiming {
    /// 99 of 100 frames reached the waiting tester within this time after their time on the bus.
    pub receive_usually: Duration,
    /// All within this.
    pub receive_always: Duration,
    /// From the tester's handing over a frame to its time on the bus: 99 of 100 within this.
    pub transmit_usually: Duration,
    /// All within this.
    pub transmit_always: Duration,
    /// Frames that did not reach the tester.
    pub lost: u64,
    /// How often the way to the bus was interrupted.
    pub interruptions: u64,
    /// For how long, all in all.
    pub interrupted_for: Duration,
    /// What is wrong with the time stamps of the adapter.
    pub stamps: Option<StampTrouble>,
}

impl HostTiming {
    pub(super) fn of(health: &Health, now: Timestamp) -> Self {
        let (receive, transmit) = (&health.receive, &health.transmit);
        let interrupted_for = health.interruptions(now).map(|interruptions| interruptions.lasted).unwrap_or_default();
        Self {
            interrupted_for,
            receive_usually: receive.quantile(990).unwrap_or_default(),
            receive_always: receive.longest().unwrap_or_default(),
            transmit_usually: transmit.quantile(990).unwrap_or_default(),
            transmit_always: transmit.longest().unwrap_or_default(),
            lost: health.lost,
            interruptions: health.interruptions,
            stamps: health.stamps,
        }
    }
}

impl Summary {
    /// How many cases ended that way.
    pub const fn count(&self, kind: Kind) -> usize {
        self.counts[kind as usize]
    }

    /// How many cases there are reports of.
    pub fn total(&self) -> usize {
        self.counts.iter().sum()
    }

    /// How many cases ran to an end.
    pub fn executed(&self) -> usize {
        Kind::ALL.into_iter().filter(|kind| kind.is_executed()).map(|kind| self.count(kind)).sum()
    }

    /// Whether all that could be judged is good: no case failed, the tester did not fail, and no precondition was out
    /// of reach, but for cases in quarantine. A device about which nothing could be found out must not look like a good one.
    pub const fn is_good(&self) -> bool {
        self.count(Kind::Fail) + self.count(Kind::Error) + self.count(Kind::Inconclusive) == self.quarantined
    }

    /// Counts a case.
    pub const fn add(&mut self, kind: Kind) {
        self.counts[kind as usize] += 1;
    }
}
