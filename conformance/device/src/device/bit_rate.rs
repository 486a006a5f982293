//! Which bit rate the device has, and how it changes to another one (CiA 305, "activate bit timing").

use super::Device;
use super::context::Context;
use super::lss_slave::bit_rate;
use crate::Fault;
use canvass_traces::{Duration, Timestamp};

/// A change under way: silence, the change, silence again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    /// When the device changes; [`Timestamp::MAX`] once it has.
    change: Timestamp,
    /// When it may send again.
    end: Timestamp,
}

impl Activation {
    /// When something happens.
    pub fn timeout(&self) -> Timestamp {
        self.change.min(self.end)
    }
}

impl Device {
    pub(super) fn activation_timeout(&self) -> Timestamp {
        self.activation.as_ref().map_or(Timestamp::MAX, Activation::timeout)
    }

    /// Takes part at that bit rate in bit/s from now on, whatever the bus has. As delivered, it has that of the bus.
    pub fn set_bit_rate(&mut self, bit_rate: u32) {
        self.bit_rate = Some(bit_rate);
        self.delivered_bit_rate = Some(bit_rate);
    }

    /// The LSS master orders the change: no frame for `delay`, the new bit rate, and no frame for `delay` again.
    pub(super) fn activate_bit_rate(&mut self, now: Timestamp, delay: Duration) {
        let delay = if self.context.has(Fault::LssActivatesAtOnce) { Duration::ZERO } else { delay };
        self.activation = Some(Activation { change: now + delay, end: now + delay.times(2) });
        self.context.outbox.clear();
        self.go_on_with_activation(now);
    }

    /// A time of the change has come.
    pub(super) fn go_on_with_activation(&mut self, now: Timestamp) {
        let Some(activation) = &mut self.activation else { return };
        if now >= activation.change {
            activation.change = Timestamp::MAX;
            let rate =
                self.services.lss.pending.bit_timing.and_then(|code| bit_rate(&self.context.objects.model, code));
            self.bit_rate = rate.map(|rate| rate.kbit.saturating_mul(1_000)).or(self.bit_rate);
        }
        // What was to be sent in the meantime is lost, as the controller is off.
        self.context.outbox.clear();
        if self.activation.is_some_and(|activation| now >= activation.end) {
            self.activation = None;
        }
    }

    /// Power-on and reset node: the stored bit rate acts, else that of delivery.
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
