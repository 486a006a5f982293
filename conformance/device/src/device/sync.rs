//! SYNC: consumed and produced, with or without a counter (1005h, 1006h, 1007h, 1019h).

use super::condition::Condition;
use super::context::Context;
use super::nmt::{self, Order};
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::models::Network;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::CobId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::wire::sync::{CAN_ID, Sync as SyncMessage};
use canvass_traces::{Duration, Frame, Timestamp};

#[derive(Clone, Debug)]
pub(super) struct SyncObject {
    cob_id: CobId,
    produces: bool,
    period: Duration,
    /// The highest value of the SYNC counter (1019h); 0 for SYNC without a counter.
    overflow: u8,
    /// Whether produced SYNC messages have a counter.
    sends_counter: bool,
    /// Whether 1019h exists. Without 1019h the device does not detect a wrong length of SYNC.
    counts: bool,
    /// The counter of the next produced SYNC.
    counter: u8,
    due: Timestamp,
    /// Duration after SYNC in which synchronous PDOs may be sent and received; zero for no limit.
    window: Duration,
    window_end: Timestamp,
    is_closed: bool,
}

/// The first value of the SYNC counter.
const FIRST: u8 = 1;

impl SyncObject {
    /// The state in which the device neither consumes nor produces SYNC.
    pub const fn new() -> Self {
        Self {
            cob_id: CobId(CobId::INVALID),
            produces: false,
            period: Duration::ZERO,
            overflow: 0,
            sends_counter: false,
            counts: false,
            counter: FIRST,
            due: Timestamp::MAX,
            window: Duration::ZERO,
            window_end: Timestamp::MAX,
            is_closed: false,
        }
    }

    /// Applies the parameters. If parameters of the producer have changed, the production restarts.
    fn configure(&mut self, now: Timestamp, context: &Context) {
        let (parameters, firmware) = (&context.objects.parameters, context.firmware());
        let network = &context.objects.model.sheet().network;
        let number = |index| parameters.number_or_zero(index, 0);
        let before = (self.produces, self.period, self.overflow);
        // Without 1005h the device uses the predefined COB-ID.
        if !firmware.has(Fault::SyncKeepsCanId) || self.cob_id.0 == CobId::INVALID {
            self.cob_id = CobId(parameters.number(object::COB_ID_SYNC, 0).unwrap_or(CAN_ID.into()) as u32);
        }
        let factor = if firmware.has(Fault::SyncPeriodDoubled) { 2 } else { 1 };
        self.period = Duration::from_micros(number(object::COMMUNICATION_CYCLE_PERIOD)).times(factor);
        let is_asked = is_producing(number(object::COB_ID_SYNC)) || firmware.has(Fault::SyncProducedUnasked);
        self.produces = network.sync_producer && is_asked && self.period > Duration::ZERO;
        self.counts = parameters.number(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0).is_some();
        self.overflow = number(object::SYNCHRONOUS_COUNTER_OVERFLOW) as u8;
        self.sends_counter =
            self.overflow > 0 || firmware.has(Fault::SyncMovedCounts) && self.cob_id.can_id() != u32::from(CAN_ID);
        let ignored = firmware.has(Fault::SyncWindowIgnored);
        self.window =
            if ignored { Duration::ZERO } else { Duration::from_micros(number(object::SYNCHRONOUS_WINDOW_LENGTH)) };
        if self.window == Duration::ZERO {
            self.window_end = Timestamp::MAX;
            self.is_closed = false;
        }
        if before != (self.produces, self.period, self.overflow) {
            self.restart(now, context.serves(nmt::Service::Broadcast), firmware);
        }
    }

    /// Restarts the production of SYNC, or stops it in stopped and during initialisation.
    fn restart(&mut self, now: Timestamp, may_send: bool, firmware: &Firmware) {
        self.due = if self.produces && may_send { now + self.period } else { Timestamp::MAX };
        if !firmware.has(Fault::SyncCounterNotReset) {
            self.counter = if firmware.has(Fault::SyncCounterFromZero) { 0 } else { 1 };
        }
    }

    /// The CAN-ID on which the device consumes SYNC; `None` for CAN-ID 0 and for 29 bits.
    fn can_id(&self) -> Option<u16> {
        (!self.cob_id.is_extended() && self.cob_id.can_id() != 0).then_some(self.cob_id.can_id() as u16)
    }

    /// The next SYNC to produce, if it is due.
    fn next(&mut self, now: Timestamp) -> Option<SyncMessage> {
        if now < self.due {
            return None;
        }
        self.due += self.period;
        if !self.sends_counter {
            return Some(SyncMessage { counter: None });
        }
        let counter = self.counter;
        self.counter = if counter >= self.overflow { FIRST } else { counter + 1 };
        Some(SyncMessage { counter: Some(counter) })
    }

    /// The CAN-ID on which the device produces SYNC.
    pub(crate) const fn own_can_id(&self) -> u16 {
        self.cob_id.can_id() as u16
    }

    /// Whether a received SYNC has the length that 1019h requires.
    fn has_length(&self, len: usize, firmware: &Firmware) -> bool {
        !self.counts || firmware.has(Fault::SyncLengthUnchecked) || len == usize::from(self.overflow != 0)
    }

    /// Handles a received or sent SYNC: opens the window of synchronous PDOs.
    fn open(&mut self, now: Timestamp) {
        self.is_closed = false;
        if self.window > Duration::ZERO {
            self.window_end = now + self.window;
        }
    }

    /// Whether the window closes now; `true` only once for each SYNC.
    fn close(&mut self, now: Timestamp) -> bool {
        let closes = now >= self.window_end;
        if closes {
            self.window_end = Timestamp::MAX;
            self.is_closed = true;
        }
        closes
    }
}

impl Service for SyncObject {
    /// Handles a received SYNC. If its length is right, synchronous PDOs are received and sent.
    fn handle(&mut self, now: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        if !context.phase.is_running() || !context.objects.consumes_sync() {
            return;
        }
        if context.objects.model.sheet().quirks.sync_without_data && !frame.data().is_empty() {
            return;
        }
        let fits = self.has_length(frame.len(), context.firmware());
        let reported = !fits && !context.takes(Liberty::SyncLengthUnreported) || context.has(Fault::RightSyncReported);
        context.report(Condition::SyncLength, reported);
        if fits {
            self.open(now);
            context.events.push_back(Event::Sync { counter: frame.data().first().copied() });
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Started => {
                self.configure(now, context);
                self.restart(now, true, context.firmware());
            }
            Event::Entered { before } => {
                let sends = context.serves(nmt::Service::Broadcast);
                if sends != before.serves(nmt::Service::Broadcast, context.firmware()) {
                    self.restart(now, sends, context.firmware());
                }
            }
            Event::Written(at, _)
                if matches!(
                    at.index.0,
                    object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH | object::SYNCHRONOUS_COUNTER_OVERFLOW
                ) =>
            {
                self.configure(now, context);
                context.routes_changed |= at.index.0 == object::COB_ID_SYNC;
            }
            _ => {}
        }
        context.sync_closed = self.is_closed;
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if let Some(sync) = self.next(now) {
            context.send(sync.to_frame(self.own_can_id()));
            if sync.counter.is_none() && context.has(Fault::SyncHangsWithoutCounter) {
                return context.order(Order::Hang);
            }
            self.open(now);
            if !context.has(Fault::SyncOwnUnheeded) {
                context.events.push_back(Event::Sync { counter: sync.counter });
            }
        }
        if self.close(now) {
            context.events.push_back(Event::WindowClosed);
        }
        context.sync_closed = self.is_closed;
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.due.min(self.window_end)
    }

    fn find_routes(&self, _: &Context, routes: &mut Routes) {
        self.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::Sync));
    }
}

/// Whether 1005h bit 30 is set: the device produces SYNC.
const fn is_producing(cob_id: u64) -> bool {
    cob_id & CobId::NO_RTR as u64 != 0
}

/// Checks a write to 1005h: a CAN-ID of 11 bits that is not restricted, bit 30 only if the device can produce SYNC, and
/// no other CAN-ID during production.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check_cob_id(
    value: u64,
    parameters: &Parameters,
    network: &Network,
    firmware: &Firmware,
) -> Result<(), AbortCode> {
    let (old, new) = (CobId(parameters.number_or_zero(object::COB_ID_SYNC, 0) as u32), CobId(value as u32));
    let reserved = new.0 & 0x1FFF_F800 != 0 && !firmware.has(Fault::CobIdBitsUnchecked) || new.is_extended();
    let impossible = is_producing(value) && !network.sync_producer;
    let restricted = new.is_restricted() && !firmware.has(Fault::RestrictedCanIdAccepted);
    let moved = is_producing(old.0.into()) && new.can_id() != old.can_id() && is_producing(value);
    let moved = moved && !firmware.has(Fault::SyncIdChangeWhileProducing);
    if reserved || impossible || restricted || firmware.has(Fault::SyncIdRefused) {
        return Err(AbortCode::INVALID_VALUE);
    }
    if moved { Err(firmware.cob_id_code(AbortCode::INVALID_VALUE)) } else { Ok(()) }
}

/// Checks a write to 1006h: the period must not be shorter than the device allows.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check_period(value: u64, network: &Network) -> Result<(), AbortCode> {
    let too_fast = network.sync_producer && (1..u64::from(network.sync_period_least_us)).contains(&value);
    if too_fast { Err(AbortCode::INVALID_VALUE) } else { Ok(()) }
}

/// Checks a write to 1019h: 0 or 2 to 240, and only while 1006h is 0.
///
/// # Errors
/// "Invalid value" for other values, or "present device state" while 1006h is not 0.
pub(super) fn check_overflow(value: u64, parameters: &Parameters, firmware: &Firmware) -> Result<(), AbortCode> {
    if parameters.number_or_zero(object::COMMUNICATION_CYCLE_PERIOD, 0) != 0
        && !firmware.has(Fault::SyncOverflowChangeWhileProducing)
    {
        let general = firmware.takes(Liberty::OverflowCodeGeneral);
        return Err(if general { AbortCode::GENERAL } else { AbortCode::DEVICE_STATE });
    }
    let known = matches!(value, 0 | 2..=240) || firmware.has(Fault::SyncOverflowUnchecked);
    match value {
        _ if known => Ok(()),
        241.. => Err(firmware.limit_code()),
        _ => Err(AbortCode::INVALID_VALUE),
    }
}
