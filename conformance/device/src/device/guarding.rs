//! Node guarding and life guarding (100Ch, 100Dh).

use super::Device;
use super::emcy::Condition;
use super::nmt::Phase;
use crate::{Fault, Faults};
use canvass_analyzer::wire::error_control::{ErrorControl, State};
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

    /// A reset: as new.
    pub const fn reset(&mut self, faults: Faults) {
        let toggle = self.toggle && faults.has(Fault::GuardingToggleNotReset);
        *self = Self { toggle, ..Self::new() };
    }

    /// 100Ch in milliseconds and 100Dh were set.
    pub fn configure(&mut self, now: Timestamp, guard_millis: u64, factor: u64, faults: Faults) {
        let factor = if faults.has(Fault::LifeTimeFactorIgnored) { factor.min(1) } else { factor };
        let factor = factor + u64::from(faults.has(Fault::LifeTimeFactorOffByOne) && factor > 0);
        let life_time = Duration::from_millis(guard_millis).times(factor);
        if life_time == Duration::ZERO && faults.has(Fault::LifeGuardingNotStopped) {
            return;
        }
        self.life_time = life_time;
        let watched = self.due < Timestamp::MAX || faults.has(Fault::LifeGuardingStartsAtOnce);
        let watched = watched && life_time > Duration::ZERO;
        self.due = if watched { now + life_time } else { Timestamp::MAX };
    }

    /// A remote frame came.
    fn answer(&mut self, now: Timestamp, phase: Phase, faults: Faults) -> Option<ErrorControl> {
        if self.life_time == Duration::ZERO && faults.has(Fault::GuardingSilentWhenOff) {
            return None;
        }
        let toggle = self.toggle;
        if !faults.has(Fault::GuardingToggleStuck) {
            self.toggle = !toggle;
        }
        if self.life_time > Duration::ZERO {
            self.due = now + self.life_time;
        }
        let state = if faults.has(Fault::GuardingWrongState) { State::PRE_OPERATIONAL } else { phase.state() };
        Some(ErrorControl { toggle, state })
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

impl Device {
    /// The master asks for the state. Heartbeat and guarding exclude each other, and heartbeat wins (CiA 301,
    /// 7.2.8.2.2).
    pub(super) fn on_guarding_request(&mut self, now: Timestamp) {
        let beside = !self.heartbeat.is_active() || self.faults.has(Fault::GuardingBesideHeartbeat);
        let guarded = self.objects.model.sheet().network.node_guarding && beside;
        if guarded && self.phase.is_running() {
            if let Some(answer) = self.guarding.answer(now, self.phase, self.faults) {
                self.send_error_control(answer);
            }
            if !self.objects.model.sheet().quirks.life_guarding_until_reset {
                self.report(now, Condition::Guarding, false);
            }
        }
    }

    /// The master does not ask any more.
    pub(super) fn on_master_lost(&mut self, now: Timestamp) {
        if self.faults.has(Fault::LifeGuardingUnreported) {
            self.react(now, Condition::Guarding);
        } else {
            self.report(now, Condition::Guarding, true);
        }
    }
}
