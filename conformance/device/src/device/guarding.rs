//! Node guarding and life guarding (100Ch, 100Dh).

use super::condition::Condition;
use super::context::Context;
use super::nmt::Phase;
use super::service::{Event, Service};
use crate::{Fault, Firmware};
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_traces::{Duration, Timestamp};

/// Answers the master's remote frames, and detects their absence.
#[derive(Clone, Debug)]
pub(super) struct NodeGuarding {
    toggle: bool,
    /// The life time: guard time times life time factor; zero if the device does not monitor the master.
    life_time: Duration,
    /// The time at which the master counts as lost; [`Timestamp::MAX`] until its first remote frame.
    due: Timestamp,
}

impl NodeGuarding {
    /// The state before the first remote frame.
    pub const fn new() -> Self {
        Self { toggle: false, life_time: Duration::ZERO, due: Timestamp::MAX }
    }

    /// Handles a reset.
    const fn reset(&mut self, firmware: &Firmware) {
        let toggle = self.toggle && firmware.has(Fault::GuardingToggleNotReset);
        *self = Self { toggle, ..Self::new() };
    }

    /// Applies the values of 100Ch, in milliseconds, and of 100Dh.
    fn set(&mut self, now: Timestamp, guard_millis: u64, factor: u64, firmware: &Firmware) {
        let life_time = Duration::from_millis(guard_millis).times(life_time_factor(factor, firmware));
        if life_time == Duration::ZERO && firmware.has(Fault::LifeGuardingNotStopped) {
            return;
        }
        self.life_time = life_time;
        let watched = self.due < Timestamp::MAX || firmware.has(Fault::LifeGuardingStartsAtOnce);
        let watched = watched && life_time > Duration::ZERO;
        self.due = if watched { now + life_time } else { Timestamp::MAX };
    }

    /// The answer to a remote frame; restarts the life time.
    fn answer(&mut self, now: Timestamp, phase: Phase, firmware: &Firmware) -> Option<ErrorControl> {
        if self.life_time == Duration::ZERO && firmware.has(Fault::GuardingSilentWhenOff) {
            return None;
        }
        let toggle = self.toggle;
        if !firmware.has(Fault::GuardingToggleStuck) {
            self.toggle = !toggle;
        }
        if self.life_time > Duration::ZERO {
            self.due = now + self.life_time;
        }
        let wrong = firmware.has(Fault::GuardingWrongState);
        let state = if wrong { State::PRE_OPERATIONAL } else { phase.state() };
        Some(ErrorControl { toggle, state })
    }

    /// Applies the current values of 100Ch and 100Dh.
    fn configure(&mut self, now: Timestamp, context: &Context) {
        let number = |index| context.objects.parameters.number_or_zero(index, 0);
        self.set(now, number(object::GUARD_TIME), number(object::LIFE_TIME_FACTOR), context.firmware());
    }

    /// Handles the master's remote frame. While the device sends heartbeats, it does not answer node guarding (CiA 301,
    /// 7.2.8.2.2).
    pub fn on_request(&mut self, now: Timestamp, context: &mut Context) {
        let sheet = context.objects.model.sheet();
        let beside = !context.is_heartbeat_active || context.has(Fault::GuardingBesideHeartbeat);
        let until_reset = sheet.quirks.life_guarding_until_reset;
        if !sheet.network.node_guarding || !beside || !context.phase.is_running() {
            return;
        }
        if let Some(answer) = self.answer(now, context.phase, context.firmware()) {
            context.send_error_control(answer);
        }
        if !until_reset {
            context.report(Condition::Guarding, false);
        }
    }
}

/// The life time factor that the firmware uses for the value of 100Dh.
fn life_time_factor(factor: u64, firmware: &Firmware) -> u64 {
    let factor = if firmware.has(Fault::LifeTimeFactorIgnored) { factor.min(1) } else { factor };
    factor + u64::from(firmware.has(Fault::LifeTimeFactorOffByOne) && factor > 0)
}

impl Service for NodeGuarding {
    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => self.reset(context.firmware()),
            Event::Started | Event::Resumed => self.configure(now, context),
            Event::Written(at, _) if matches!(at.index.0, object::GUARD_TIME | object::LIFE_TIME_FACTOR) => {
                self.configure(now, context);
            }
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if now < self.due {
            return;
        }
        // The loss is reported only once, until the master's next remote frame.
        self.due = Timestamp::MAX;
        if !context.has(Fault::LifeGuardingUnreported) {
            context.report(Condition::Guarding, true);
        } else {
            context.react(Condition::Guarding);
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.due
    }
}
