//! The outcome of a run in numbers.

use crate::verdict::Kind;
use canvass_bus::{Health, StampTrouble};
use canvass_traces::{Duration, Timestamp};
use std::fmt;

/// The outcome of a run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Summary {
    counts: [usize; Kind::ALL.len()],
    /// The duration of the run on the clock of the bus.
    pub duration: Duration,
    /// Whether the user ended the run before all cases had run.
    pub cancelled: bool,
    /// The reason why the run ended before its last case, if the user did not end it.
    pub ended_early: Option<EndedEarly>,
    /// Number of cases that could not be judged without a description of the device.
    pub undescribed: usize,
    /// How well the tester's own machine kept up; `None` if the bus is not a live one.
    pub host: Option<HostTiming>,
    /// Number of commands that made the device write its non-volatile memory, which wears out.
    pub stores: u32,
    /// Number of cases whose repetitions ended differently.
    pub flaky: usize,
    /// Number of failed, inconclusive and erroneous cases that do not count because of a quarantine.
    pub quarantined: usize,
    /// Whether the device is known to be as before the run; `false` also if that could not be checked.
    pub is_as_found: bool,
}

/// The reason why a run ended before its last case.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EndedEarly {
    /// The answers of the device make no sense.
    NoProtocol,
    /// A case failed, and the user wants the run to end with the first failure.
    FirstFailure,
    /// The time limit of the run has passed.
    TimeIsOver,
}

impl fmt::Display for EndedEarly {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoProtocol => "the device does not follow the protocol",
            Self::FirstFailure => "a case failed, and the run ends with the first failure",
            Self::TimeIsOver => "its time limit was reached",
        })
    }
}

/// How well the tester's own machine kept up. Each bound is at most twice the longest delay that it covers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct HostTiming {
    /// Bound for 99 of 100 frames on the time from the bus to the waiting tester.
    pub receive_usually: Duration,
    /// Bound for all frames on the time from the bus to the waiting tester.
    pub receive_always: Duration,
    /// Bound for 99 of 100 frames on the time from the tester's handover to the bus.
    pub transmit_usually: Duration,
    /// Bound for all frames on the time from the tester's handover to the bus.
    pub transmit_always: Duration,
    /// Number of frames that did not reach the tester.
    pub lost: u64,
    /// Number of interruptions of the connection to the bus.
    pub interruptions: u64,
    /// Total duration of the interruptions.
    pub interrupted_for: Duration,
    /// The defect of the adapter's time stamps, if there is one.
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
    /// Number of cases with this verdict.
    pub const fn count(&self, kind: Kind) -> usize {
        self.counts[kind as usize]
    }

    /// Number of cases that have a report.
    pub fn total(&self) -> usize {
        self.counts.iter().sum()
    }

    /// Number of cases that ran to an end.
    pub fn executed(&self) -> usize {
        Kind::ALL.into_iter().filter(|kind| kind.is_executed()).map(|kind| self.count(kind)).sum()
    }

    /// Whether every case that could be judged is good: apart from cases in quarantine, none failed, none was
    /// inconclusive, and the tester did not fail. A device about which nothing could be found out must not look good.
    pub const fn is_good(&self) -> bool {
        self.count(Kind::Fail) + self.count(Kind::Error) + self.count(Kind::Inconclusive) == self.quarantined
    }

    /// Counts a case.
    pub const fn add(&mut self, kind: Kind) {
        self.counts[kind as usize] += 1;
    }
}
