//! Node guarding and life guarding (100Ch, 100Dh).

use super::Device;
use super::emcy::Condition;
use super::nmt::Phase;
use crate::Firmware;
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

    /// A reset: as new.
    pub const fn reset(&mut self, firmware: &Firmware) {
        let toggle = self.toggle && firmware.keeps_guarding_toggle_over_reset();
        *self = Self { toggle, ..Self::new() };
    }

    /// 100Ch in milliseconds and 100Dh were set.
    pub fn configure(&mut self, now: Timestamp, guard_millis: u64, factor: u64, firmware: &Firmware) {
        let life_time = Duration::from_millis(guard_millis).times(firmware.life_time_factor(factor));
        if life_time == Duration::ZERO && !firmware.stops_life_guarding_at_zero() {
            return;
        }
        self.life_time = life_time;
        let watched = self.due < Timestamp::MAX || firmware.guards_before_first_request();
        let watched = watched && life_time > Duration::ZERO;
        self.due = if watched { now + life_time } else { Timestamp::MAX };
    }

    /// A remote frame came.
    fn answer(&mut self, now: Timestamp, phase: Phase, firmware: &Firmware) -> Option<ErrorControl> {
        if self.life_time == Duration::ZERO && !firmware.answers_guarding_when_off() {
            return None;
        }
        let toggle = self.toggle;
        if firmware.toggles_guarding() {
            self.toggle = !toggle;
        }
        if self.life_time > Duration::ZERO {
            self.due = now + self.life_time;
        }
        let state = firmware.guarded_state(phase.state());
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
        let beside = !self.heartbeat.is_active() || self.firmware.guards_beside_heartbeat();
        let guarded = self.objects.model.sheet().network.node_guarding && beside;
        if guarded && self.phase.is_running() {
            if let Some(answer) = self.guarding.answer(now, self.phase, &self.firmware) {
                self.send_error_control(answer);
            }
            if !self.objects.model.sheet().quirks.life_guarding_until_reset {
                self.report(now, Condition::Guarding, false);
            }
        }
    }

    /// The master does not ask any more.
    pub(super) fn on_master_lost(&mut self, now: Timestamp) {
        if !self.firmware.reports_lost_master() {
            self.react(now, Condition::Guarding);
        } else {
            self.report(now, Condition::Guarding, true);
        }
    }
}
