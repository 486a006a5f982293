//! The heartbeat producer (1017h) and the boot-up message.

use super::nmt::Phase;
use crate::{Fault, Faults};
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
    pub fn start(&mut self, now: Timestamp, millis: u64, faults: Faults) {
        if millis == 0 && faults.has(Fault::HeartbeatNotStopped) {
            return;
        }
        let factor = if faults.has(Fault::HeartbeatPeriodDoubled) { 2 } else { 1 };
        let millis = if faults.has(Fault::HeartbeatTimerRounded) { millis.next_multiple_of(64) } else { millis };
        if self.is_active() && faults.has(Fault::HeartbeatBurst) {
            self.burst = 4;
        }
        self.period = Duration::from_millis(millis).times(factor);
        self.due = if millis == 0 { Timestamp::MAX } else { now + self.period };
    }

    /// The end of initialisation: the boot-up message is the first heartbeat, the next one follows one period later.
    pub fn boot(&mut self, now: Timestamp, millis: u64, faults: Faults) {
        self.start(now, millis, faults);
        self.burst = 0;
        self.last = State::PRE_OPERATIONAL;
        if self.is_active() && faults.has(Fault::HeartbeatLateAfterBootUp) {
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
    pub fn poll(&mut self, now: Timestamp, phase: Phase, faults: Faults) -> Option<ErrorControl> {
        if now < self.timeout() {
            return None;
        }
        if self.burst > 0 {
            self.burst -= 1;
        } else {
            // From the time planned, not from now: periods don't add up delays.
            self.due += self.period;
        }
        let state = if faults.has(Fault::HeartbeatWrongState) { State::PRE_OPERATIONAL } else { phase.state() };
        let before = std::mem::replace(&mut self.last, state);
        let state = if faults.has(Fault::HeartbeatStateLate) { before } else { state };
        Some(ErrorControl { toggle: faults.has(Fault::HeartbeatToggles), state })
    }
}

/// The messages at the end of initialisation.
pub(super) fn boot_up(faults: Faults) -> impl Iterator<Item = ErrorControl> {
    let count = match () {
        () if faults.has(Fault::BootUpMissing) => 0,
        () if faults.has(Fault::BootUpTwice) => 2,
        () => 1,
    };
    let message = match faults.has(Fault::BootUpWrongData) {
        true => ErrorControl::heartbeat(State::PRE_OPERATIONAL),
        false => ErrorControl::BOOT_UP,
    };
    std::iter::repeat_n(message, count)
}
