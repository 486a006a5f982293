//! TIME, consumed and produced (1012h), the clock that it sets, and the high resolution time stamp (1013h).

use super::context::Context;
use super::nmt;
use super::objects::Objects;
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::Firmware;
use crate::models::Network;
use canvass_analyzer::CobId;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::wire::time::TimeOfDay;
use canvass_traces::{Duration, Frame, Timestamp};

/// The device's clock: at power-on it shows the beginning of 1984.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    /// Milliseconds since 1984-01-01 at `set`.
    base: u64,
    set: Timestamp,
    /// What was written to 1013h, and when.
    stamp: (u32, Timestamp),
    cob_id: CobId,
    consumes: bool,
    /// Zero: TIME is not sent.
    period: Duration,
    due: Timestamp,
    firmware: Firmware,
}

/// 1012h bit 31.
const CONSUMES: u32 = 1 << 31;
/// 1012h bit 30.
const PRODUCES: u32 = 1 << 30;

impl Clock {
    /// At power-on.
    pub const fn new(now: Timestamp, firmware: &Firmware) -> Self {
        Self {
            base: 0,
            set: now,
            stamp: (0, now),
            cob_id: CobId(0),
            consumes: false,
            period: Duration::ZERO,
            due: Timestamp::MAX,
            firmware: *firmware,
        }
    }

    /// Takes 1012h over.
    pub fn configure(&mut self, now: Timestamp, parameters: &Parameters, network: &Network, may_send: bool) {
        self.cob_id = CobId(parameters.number_or_zero(0x1012, 0) as u32);
        self.consumes = network.time_consumer && self.cob_id.0 & CONSUMES != 0;
        let period = network.time_period_ms.filter(|_| self.cob_id.0 & PRODUCES != 0).unwrap_or(0);
        self.period = Duration::from_millis(period);
        self.restart(now, may_send);
    }

    /// Begins to send anew, or stops.
    pub fn restart(&mut self, now: Timestamp, may_send: bool) {
        let sends = may_send && self.period > Duration::ZERO;
        self.due = if sends { now + self.period } else { Timestamp::MAX };
    }

    /// The CAN-ID on which TIME is awaited, if it is.
    pub fn can_id(&self) -> Option<u16> {
        self.consumes.then_some(self.cob_id.can_id() as u16)
    }

    /// The CAN-ID that a produced TIME has.
    pub const fn own_can_id(&self) -> u16 {
        self.cob_id.can_id() as u16
    }

    /// TIME came.
    pub fn set(&mut self, now: Timestamp, time: TimeOfDay) {
        if self.firmware.follows_time() {
            self.base = u64::from(time.days) * u64::from(TimeOfDay::DAY) + u64::from(time.milliseconds());
            self.set = now;
        }
    }

    /// 1013h was written.
    pub const fn stamp(&mut self, now: Timestamp, micros: u32) {
        self.stamp = (micros, now);
    }

    /// 1013h: microseconds, from 0 again after 2^32.
    pub const fn micros(&self, now: Timestamp) -> u32 {
        let (written, at) = self.stamp;
        written.wrapping_add((now.since(at).nanos() / 1_000) as u32)
    }

    /// The time of day.
    pub fn time(&self, now: Timestamp) -> TimeOfDay {
        let millis = self.base + now.since(self.set).nanos() / 1_000_000;
        let day = u64::from(TimeOfDay::DAY);
        TimeOfDay { raw_milliseconds: (millis % day) as u32, days: (millis / day) as u16 }
    }

    /// When [`Clock::poll`] wants to be called.
    pub const fn timeout(&self) -> Timestamp {
        self.due
    }

    /// The TIME to send, if it is time for one.
    pub fn poll(&mut self, now: Timestamp) -> Option<TimeOfDay> {
        if now < self.due {
            return None;
        }
        self.due += self.period;
        let mut time = self.time(now);
        if self.firmware.sets_reserved_time_bits() {
            time.raw_milliseconds |= 0xF000_0000;
        }
        Some(time)
    }
}

/// Consumes and produces TIME; the clock itself is an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeService;

impl TimeService {
    fn configure(now: Timestamp, context: &mut Context) {
        let may_send = context.serves(nmt::Service::Broadcast);
        let Objects { parameters, model, clock, .. } = &mut context.objects;
        clock.configure(now, parameters, &model.sheet().network, may_send);
    }
}

impl Service for TimeService {
    fn handle(&mut self, now: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        if context.phase.is_running()
            && frame.len() == 6
            && let Ok(time) = TimeOfDay::read(frame.data())
        {
            context.objects.clock.set(now, time);
            context.events.push_back(Event::Changed);
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Started => Self::configure(now, context),
            Event::Entered { before } => {
                let sends = context.serves(nmt::Service::Broadcast);
                if sends != before.serves(nmt::Service::Broadcast, context.firmware()) {
                    context.objects.clock.restart(now, sends);
                }
            }
            Event::Written(at, _) if at.index.0 == 0x1012 => {
                Self::configure(now, context);
                context.routes_changed = true;
            }
            Event::Written(at, micros) if at.index.0 == 0x1013 => context.objects.clock.stamp(now, micros as u32),
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if let Some(time) = context.objects.clock.poll(now) {
            context.send(time.to_frame(context.objects.clock.own_can_id()));
        }
    }

    fn timeout(&self, context: &Context) -> Timestamp {
        context.objects.clock.timeout()
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        context.objects.clock.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::Time));
    }
}

/// The conditions of a write to 1012h: 11 bits, not restricted, only what the device can, and another CAN-ID not while
/// TIME is consumed or produced.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check(
    value: u64,
    parameters: &Parameters,
    network: &Network,
    firmware: &Firmware,
) -> Result<(), AbortCode> {
    let (old, new) = (CobId(parameters.number_or_zero(0x1012, 0) as u32), CobId(value as u32));
    let reserved = new.0 & 0x1FFF_F800 != 0 || new.is_extended();
    let impossible = new.0 & PRODUCES != 0 && network.time_period_ms.is_none();
    let restricted = new.is_restricted() && firmware.checks_restricted_can_ids();
    let in_use = |cob_id: CobId| cob_id.0 & (CONSUMES | PRODUCES) != 0;
    let moved = in_use(old) && in_use(new) && new.can_id() != old.can_id() && firmware.checks_time_id_while_valid();
    if reserved || impossible || restricted {
        return Err(AbortCode::INVALID_VALUE);
    }
    if moved { Err(firmware.cob_id_code(AbortCode::INVALID_VALUE)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_goes_on_over_midnight() {
        let mut clock = Clock::new(Timestamp::ZERO, &Firmware::PLAIN);
        let eve = TimeOfDay { raw_milliseconds: TimeOfDay::DAY - 1, days: 100 };
        clock.set(Timestamp(5_000_000_000), eve);
        assert_eq!(clock.time(Timestamp(5_002_000_000)), TimeOfDay { raw_milliseconds: 1, days: 101 });
        clock.stamp(Timestamp(1_000), u32::MAX);
        assert_eq!(clock.micros(Timestamp(3_000)), 1);
    }
}
