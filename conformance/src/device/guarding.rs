//! Node guarding and life guarding (100Ch, 100Dh).

use super::nmt::Phase;
use crate::{Fault, Faults};
use canvass_analyzer::wire::error_control::ErrorControl;
use canvass_traces::{Duration, Timestamp};

/// Answers the master's remote frames, and misses them.
#[derive(Clone, Debug)]
pub(super) struct NodeGuarding {
    toggle: bool,
    /// Guard time times life time factor; zero: the master is not watched.
    life_time: Duration,
    /// The master is lost then. [`Timestamp::MAX`] until its first remote frame.
    due: Timestamp,
}

impl NodeGuarding {
    /// Before the first remote frame.
    pub const fn new() -> Self {
        Self { toggle: false, life_time: Duration::ZERO, due: Timestamp::MAX }
    }

    /// Reset communication: as [`NodeGuarding::new`].
    pub fn reset(&mut self, faults: Faults) {
        let toggle = self.toggle && faults.has(Fault::GuardingToggleNotReset);
        *self = Self { toggle, ..Self::new() };
    }

    /// 100Ch in milliseconds and 100Dh were set.
    pub fn configure(&mut self, now: Timestamp, guard_millis: u64, factor: u64, faults: Faults) {
        let factor = if faults.has(Fault::LifeTimeFactorIgnored) { factor.min(1) } else { factor };
        self.life_time = Duration::from_millis(guard_millis).times(factor);
        if self.life_time == Duration::ZERO {
            self.due = Timestamp::MAX;
        } else if self.due < Timestamp::MAX || faults.has(Fault::LifeGuardingStartsAtOnce) {
            self.due = now + self.life_time;
        }
    }

    /// A remote frame came.
    pub fn answer(&mut self, now: Timestamp, phase: Phase, faults: Faults) -> ErrorControl {
        let toggle = self.toggle;
        if !faults.has(Fault::GuardingToggleStuck) {
            self.toggle = !toggle;
        }
        if self.life_time > Duration::ZERO {
            self.due = now + self.life_time;
        }
        ErrorControl { toggle, state: phase.state() }
    }

    /// When the master is lost.
    pub const fn timeout(&self) -> Timestamp {
        self.due
    }

    /// Whether the master is lost now; says so once, until its next remote frame.
    pub fn is_lost(&mut self, now: Timestamp) -> bool {
        let lost = now >= self.due;
        if lost {
            self.due = Timestamp::MAX;
        }
        lost
    }
}
