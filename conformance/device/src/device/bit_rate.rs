//! The bit rate of the device, and the change of the bit rate (CiA 305, "activate bit timing").

use super::Device;
use super::context::Context;
use super::lss_slave::bit_rate;
use crate::Fault;
use canvass_traces::{Duration, Timestamp};

/// A change of the bit rate in progress: silence, the change, silence again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    /// Time of the change; [`Timestamp::MAX`] after it.
    change: Timestamp,
    /// The time from which the device may send again.
    end: Timestamp,
}

impl Activation {
    /// Time of the next event.
    pub fn timeout(&self) -> Timestamp {
        self.change.min(self.end)
    }
}

impl Device {
    pub(super) fn activation_timeout(&self) -> Timestamp {
        self.activation.as_ref().map_or(Timestamp::MAX, Activation::timeout)
    }

    /// Sets the bit rate in bit/s, independently of the bus. Without this call the device has the bit rate of the bus.
    pub fn set_bit_rate(&mut self, bit_rate: u32) {
        self.bit_rate = Some(bit_rate);
        self.delivered_bit_rate = Some(bit_rate);
    }

    /// Handles the LSS master's order: silence for `delay`, the new bit rate, and silence for `delay` again.
    pub(super) fn activate_bit_rate(&mut self, now: Timestamp, delay: Duration) {
        let delay = if self.context.has(Fault::LssActivatesAtOnce) { Duration::ZERO } else { delay };
        self.activation = Some(Activation { change: now + delay, end: now + delay.times(2) });
        self.context.outbox.clear();
        self.go_on_with_activation(now);
    }

    /// Handles the next step of the change.
    pub(super) fn go_on_with_activation(&mut self, now: Timestamp) {
        let Some(activation) = &mut self.activation else { return };
        if now >= activation.change {
            activation.change = Timestamp::MAX;
            let rate =
                self.services.lss.pending.bit_timing.and_then(|code| bit_rate(&self.context.objects.model, code));
            self.bit_rate = rate.map(|rate| rate.kbit.saturating_mul(1_000)).or(self.bit_rate);
        }
        // Frames that waited are lost, as the controller is off.
        self.context.outbox.clear();
        if self.activation.is_some_and(|activation| now >= activation.end) {
            self.activation = None;
        }
    }

    /// Uses the stored bit rate, else the default bit rate, at power-on and reset node.
    pub(super) fn take_stored_bit_rate(&mut self) {
        let Context { objects, store, .. } = &self.context;
        let sheet = objects.model.sheet();
        let code = sheet.network.bit_rate_object.and_then(|at| store.number(at, &objects.parameters));
        let of_object = code.and_then(|code| {
            sheet.bit_rates.iter().find(|rate| rate.object_code.is_some_and(|own| u64::from(own) == code)).copied()
        });
        let of_lss = || store.network().bit_timing.and_then(|code| bit_rate(&objects.model, code));
        let stored = match sheet.network.bit_rate_object {
            Some(_) => of_object,
            None => of_lss(),
        };
        self.bit_rate = stored.map(|rate| rate.kbit.saturating_mul(1_000)).or(self.delivered_bit_rate);
    }
}
