//! The heartbeat producer (1017h) and the boot-up message.

use super::context::Context;
use super::nmt::Phase;
use super::service::{Event, Service};
use crate::{Fault, Firmware};
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_traces::{Duration, Timestamp};

/// The resolution in milliseconds of the timer of a faulty firmware.
const COARSE: u64 = 64;

/// Sends heartbeats periodically.
#[derive(Clone, Debug)]
pub(super) struct HeartbeatProducer {
    period: Duration,
    due: Timestamp,
    /// Number of heartbeats of a burst that a faulty firmware still has to send.
    burst: u8,
    /// The state in the last heartbeat.
    last: State,
}

impl HeartbeatProducer {
    /// The state without heartbeats.
    pub const fn new() -> Self {
        Self { period: Duration::ZERO, due: Timestamp::MAX, burst: 0, last: State::PRE_OPERATIONAL }
    }

    /// Restarts with the producer heartbeat time in milliseconds; 0 switches heartbeats off.
    fn start(&mut self, now: Timestamp, millis: u64, firmware: &Firmware) {
        if millis == 0 && firmware.has(Fault::HeartbeatNotStopped) {
            return;
        }
        if self.is_active() && firmware.has(Fault::HeartbeatBurst) {
            self.burst = 4;
        }
        self.period = period(millis, firmware);
        self.due = if millis == 0 { Timestamp::MAX } else { now + self.period };
    }

    /// Handles the end of initialisation: the boot-up message counts as the first heartbeat, so the next heartbeat
    /// follows a period later.
    fn boot(&mut self, now: Timestamp, millis: u64, firmware: &Firmware) {
        self.start(now, millis, firmware);
        self.burst = 0;
        self.last = State::PRE_OPERATIONAL;
        if self.is_active() && firmware.has(Fault::HeartbeatLateAfterBootUp) {
            self.due += self.period.times(2);
        }
    }

    /// Handles the begin of initialisation, during which no heartbeats are sent.
    const fn stop(&mut self) {
        self.due = Timestamp::MAX;
        self.burst = 0;
    }

    /// Whether the device sends heartbeats.
    fn is_active(&self) -> bool {
        self.due < Timestamp::MAX
    }

    /// The current heartbeat.
    fn heartbeat(&mut self, phase: Phase, firmware: &Firmware) -> ErrorControl {
        if self.burst > 0 {
            self.burst -= 1;
        } else {
            // The next heartbeat is due relative to the planned time of this heartbeat, so that delays do not add up.
            self.due += self.period;
        }
        let wrong = firmware.has(Fault::HeartbeatWrongState);
        let state = if wrong { State::PRE_OPERATIONAL } else { phase.state() };
        let before = std::mem::replace(&mut self.last, state);
        let state = if firmware.has(Fault::HeartbeatStateLate) { before } else { state };
        ErrorControl { toggle: firmware.has(Fault::HeartbeatToggles), state }
    }
}

/// The time between heartbeats for a value of 1017h.
fn period(millis: u64, firmware: &Firmware) -> Duration {
    let rounded = firmware.has(Fault::HeartbeatTimerRounded);
    let millis = if rounded { millis.next_multiple_of(COARSE) } else { millis };
    Duration::from_millis(millis).times(if firmware.has(Fault::HeartbeatPeriodDoubled) { 2 } else { 1 })
}

impl Service for HeartbeatProducer {
    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        let firmware = context.firmware();
        match event {
            Event::Initialise => self.stop(),
            Event::Started | Event::Resumed => {
                let stored = context.objects.parameters.number_or_zero(object::PRODUCER_HEARTBEAT_TIME, 0);
                self.boot(now, if firmware.has(Fault::StoredConfigurationIdle) { 0 } else { stored }, firmware);
            }
            Event::Entered { .. } if firmware.has(Fault::HeartbeatLostOnStateChange) => self.stop(),
            Event::Written(at, millis) if at.index.0 == object::PRODUCER_HEARTBEAT_TIME => {
                self.start(now, millis, firmware);
            }
            _ => {}
        }
        context.is_heartbeat_active = self.is_active();
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if now >= self.timeout(context) {
            let heartbeat = self.heartbeat(context.phase, context.firmware());
            context.send_error_control(heartbeat);
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        if self.burst > 0 && self.is_active() { Timestamp::ZERO } else { self.due }
    }
}
