//! The clock of a device, which TIME sets and which the device sends as TIME, and the high resolution time stamp
//! (1013h).

use super::parameters::Parameters;
use crate::models::Network;
use crate::{Fault, Firmware};
use canvass_analyzer::CobId;
use canvass_analyzer::object;
use canvass_analyzer::wire::time::TimeOfDay;
use canvass_traces::{Duration, Timestamp};

/// The device's clock; at power-on it shows the beginning of 1984.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    /// The time at `set`, in milliseconds since 1984-01-01.
    base: u64,
    set: Timestamp,
    /// The value written to 1013h, and its time.
    stamp: (u32, Timestamp),
    cob_id: CobId,
    consumes: bool,
    /// The period of TIME; zero if the device does not send TIME.
    period: Duration,
    due: Timestamp,
    firmware: Firmware,
}

/// 1012h bit 31: the device consumes TIME.
pub(super) const CONSUMES: u32 = 1 << 31;
/// 1012h bit 30: the device produces TIME.
pub(super) const PRODUCES: u32 = 1 << 30;

impl Clock {
    /// The clock at power-on.
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

    /// Applies the value of 1012h.
    pub fn configure(&mut self, now: Timestamp, parameters: &Parameters, network: &Network, may_send: bool) {
        self.cob_id = CobId(parameters.number_or_zero(object::COB_ID_TIME, 0) as u32);
        self.consumes = network.time_consumer && self.cob_id.0 & CONSUMES != 0;
        let goes_on = self.period > Duration::ZERO && self.firmware.has(Fault::TimeNotStopped);
        let is_asked = self.cob_id.0 & PRODUCES != 0 || goes_on;
        let period = network.time_period_ms.filter(|_| is_asked).unwrap_or(0);
        self.period = Duration::from_millis(period);
        self.restart(now, may_send);
    }

    /// Restarts the production of TIME, or stops it.
    pub fn restart(&mut self, now: Timestamp, may_send: bool) {
        let sends = may_send && self.period > Duration::ZERO && !self.firmware.has(Fault::TimeNotProduced);
        self.due = if sends { now + self.period } else { Timestamp::MAX };
    }

    /// The CAN-ID on which the device consumes TIME; `None` if it consumes none.
    pub fn can_id(&self) -> Option<u16> {
        self.consumes.then_some(self.cob_id.can_id() as u16)
    }

    /// The CAN-ID on which the device produces TIME.
    pub(crate) const fn own_can_id(&self) -> u16 {
        self.cob_id.can_id() as u16
    }

    /// Sets the clock to a received TIME.
    pub fn set(&mut self, now: Timestamp, time: TimeOfDay) {
        if !self.firmware.has(Fault::TimeIgnored) {
            self.base = u64::from(time.days) * u64::from(TimeOfDay::DAY) + u64::from(time.milliseconds());
            self.set = now;
        }
    }

    /// Handles a write to 1013h.
    pub const fn stamp(&mut self, now: Timestamp, micros: u32) {
        self.stamp = (micros, now);
    }

    /// The value of 1013h: microseconds, starting at 0 again after 2^32.
    pub const fn micros(&self, now: Timestamp) -> u32 {
        let (written, at) = self.stamp;
        let now = if self.firmware.has(Fault::ClockStands) { at } else { now };
        written.wrapping_add((now.since(at).nanos() / 1_000) as u32)
    }

    /// The time of day.
    pub fn time(&self, now: Timestamp) -> TimeOfDay {
        let shown = if self.firmware.has(Fault::ClockStands) { self.set } else { now };
        let millis = self.base + shown.since(self.set).nanos() / 1_000_000;
        let day = u64::from(TimeOfDay::DAY);
        TimeOfDay { raw_milliseconds: (millis % day) as u32, days: (millis / day) as u16 }
    }

    /// Time of the next call of [`Clock::poll`].
    pub const fn timeout(&self) -> Timestamp {
        self.due
    }

    /// The TIME message, if it is due.
    pub fn poll(&mut self, now: Timestamp) -> Option<TimeOfDay> {
        if now < self.due {
            return None;
        }
        self.due += self.period;
        let mut time = self.time(now);
        if self.firmware.has(Fault::TimeReservedBitsSet) {
            time.raw_milliseconds |= 0xF000_0000;
        }
        Some(time)
    }
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
