//! The bit rate of the device, and the change of the bit rate (CiA 305, "activate bit timing").

use super::Device;
use super::context::Context;
use super::objects::Objects;
use crate::models::{BitRate, Model};
use crate::{Fault, Liberty};
use canvass_analyzer::wire::layer_setting::Dialect;
use canvass_analyzer::wire::lmt::Lmt;
use canvass_traces::{Duration, Timestamp};

/// A change of the bit rate in progress: silence, the change, silence again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    /// Time of the change; [`Timestamp::MAX`] after it.
    change: Timestamp,
    /// The new bit rate: a row of the model's table.
    bit_timing: Option<u8>,
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

    /// The device's bit rate in kbit/s; the model's default if the device has that of the bus.
    pub fn bit_rate_kbit(&self) -> u32 {
        self.bit_rate.map_or(self.context.objects.model.sheet().network.default_bit_rate_kbit, |rate| rate / 1_000)
    }

    /// Activates the configured bit rate, as the master of LSS or LMT orders. The device is silent for `delay` before the
    /// change and for another `delay` after it.
    pub(super) fn activate_bit_rate(&mut self, now: Timestamp, bit_timing: Option<u8>, delay: Duration) {
        let delay = if self.context.has(Fault::LssActivatesAtOnce) { Duration::ZERO } else { delay };
        // The second delay is the shortest silence, not the longest.
        let late =
            if self.context.takes(Liberty::BitRateTakenLate) { Duration::from_millis(200) } else { Duration::ZERO };
        self.activation = Some(Activation { change: now + delay, bit_timing, end: now + delay.times(2) + late });
        self.context.outbox.clear();
        self.go_on_with_activation(now);
    }

    /// Handles the next step of the change.
    pub(super) fn go_on_with_activation(&mut self, now: Timestamp) {
        let Some(activation) = &mut self.activation else { return };
        if now >= activation.change {
            activation.change = Timestamp::MAX;
            let bit_timing = activation.bit_timing;
            self.use_bit_rate(bit_timing);
        }
        // Frames that waited are lost, as the controller is off.
        self.context.outbox.clear();
        if self.activation.is_some_and(|activation| now >= activation.end) {
            self.activation = None;
        }
    }

    /// Uses this bit rate of the model's table, or keeps the current one.
    pub(super) fn use_bit_rate(&mut self, bit_timing: Option<u8>) {
        let rate = bit_timing.and_then(|code| bit_rate(&self.context.objects.model, code));
        self.bit_rate = rate.map(|rate| rate.kbit.saturating_mul(1_000)).or(self.bit_rate);
    }

    /// Uses a written bit rate that takes effect at a reset without being stored.
    pub(super) fn take_written_bit_rate(&mut self) {
        let Objects { model, parameters, .. } = &self.context.objects;
        let Some(at) = model.sheet().network.bit_rate_object else { return };
        let rate = parameters.number(at.index.0, at.sub.0).and_then(|code| of_object(model, code));
        // The default stands for the bit rate as delivered, also if a user has delivered the device with another one.
        self.bit_rate = match rate {
            Some(rate) if rate.kbit == model.sheet().network.default_bit_rate_kbit => self.delivered_bit_rate,
            Some(rate) => Some(rate.kbit.saturating_mul(1_000)),
            None => self.bit_rate,
        };
    }

    /// Uses the stored bit rate, else the default bit rate, at power-on and reset node.
    pub(super) fn take_stored_bit_rate(&mut self) {
        let Context { objects, store, .. } = &self.context;
        let sheet = objects.model.sheet();
        let code = sheet.network.bit_rate_object.and_then(|at| store.number(at, &objects.parameters));
        let of_object = code.and_then(|code| of_object(&objects.model, code));
        let of_lss = || store.network().bit_timing.and_then(|code| bit_rate(&objects.model, code));
        let stored = match sheet.network.bit_rate_object {
            Some(_) => of_object,
            None => of_lss(),
        };
        self.bit_rate = stored.map(|rate| rate.kbit.saturating_mul(1_000)).or(self.delivered_bit_rate);
    }
}

/// The bit rate of the model with this code of LSS or LMT.
pub(super) fn bit_rate(model: &Model, code: u8) -> Option<BitRate> {
    let rates = &model.sheet().bit_rates;
    if model.sheet().lmt.is_some() {
        let rate = Lmt::bit_rate(code)?;
        return rates.iter().find(|own| own.kbit.saturating_mul(1_000) == rate).copied();
    }
    rates.iter().find(|rate| rate.lss_code == Some(code)).copied()
}

/// The bit rate of the model with this code in its own object.
fn of_object(model: &Model, code: u64) -> Option<BitRate> {
    let rates = &model.sheet().bit_rates;
    rates.iter().find(|rate| rate.object_code.is_some_and(|own| u64::from(own) == code)).copied()
}
