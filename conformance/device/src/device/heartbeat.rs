//! The heartbeat producer (1017h) and the boot-up message.

use super::nmt::Phase;
use crate::Firmware;
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_traces::{Duration, Timestamp};

/// Sends the state at fixed times.
#[derive(Clone, Debug)]
pub(super) struct HeartbeatProducer {
    period: Duration,
    due: Timestamp,
    /// Heartbeats that a faulty firmware makes up for.
    burst: u8,
    /// The state of the heartbeat before.
    last: State,
}

impl HeartbeatProducer {
    /// Silent.
    pub const fn new() -> Self {
        Self { period: Duration::ZERO, due: Timestamp::MAX, burst: 0, last: State::PRE_OPERATIONAL }
    }

    /// Begins anew with the time of 1017h in milliseconds; 0 is never.
    pub fn start(&mut self, now: Timestamp, millis: u64, firmware: &Firmware) {
        if millis == 0 && !firmware.stops_heartbeat_at_zero() {
            return;
        }
        if self.is_active() && firmware.makes_up_for_heartbeats() {
            self.burst = 4;
        }
        self.period = firmware.heartbeat_period(millis);
        self.due = if millis == 0 { Timestamp::MAX } else { now + self.period };
    }

    /// The end of initialisation: the boot-up message is the first heartbeat, the next one follows one period later.
    pub fn boot(&mut self, now: Timestamp, millis: u64, firmware: &Firmware) {
        self.start(now, millis, firmware);
        self.burst = 0;
        self.last = State::PRE_OPERATIONAL;
        if self.is_active() && firmware.delays_first_heartbeat() {
            self.due += self.period.times(2);
        }
    }

    /// Initialisation: no heartbeat.
    pub const fn stop(&mut self) {
        self.due = Timestamp::MAX;
        self.burst = 0;
    }

    /// Whether there is one at all.
    pub fn is_active(&self) -> bool {
        self.due < Timestamp::MAX
    }

    /// When the next one is sent.
    pub const fn timeout(&self) -> Timestamp {
        if self.burst > 0 && self.due.0 < Timestamp::MAX.0 { Timestamp::ZERO } else { self.due }
    }

    /// The heartbeat, if it is time for one.
    pub fn poll(&mut self, now: Timestamp, phase: Phase, firmware: &Firmware) -> Option<ErrorControl> {
        if now < self.timeout() {
            return None;
        }
        if self.burst > 0 {
            self.burst -= 1;
        } else {
            // From the time planned, not from now: periods don't add up delays.
            self.due += self.period;
        }
        let state = firmware.heartbeat_state(phase.state());
        let before = std::mem::replace(&mut self.last, state);
        let state = if firmware.shows_stale_state() { before } else { state };
        Some(ErrorControl { toggle: firmware.sets_toggle_in_heartbeat(), state })
    }
}
