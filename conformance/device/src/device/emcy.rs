//! EMCY: sends the errors of the device (1014h, 1015h), and receives the errors of other nodes (1028h).

use super::context::Context;
use super::nmt;
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::CobId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Frame, Timestamp};

/// Sends EMCY messages, and handles EMCY messages of other nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmcyService;

impl EmcyService {
    /// The next EMCY that may be sent now; `None` if there is none.
    fn next(now: Timestamp, context: &mut Context) -> Option<Frame> {
        if now < Self.timeout(context) {
            return None;
        }
        let inhibit =
            Duration::from_micros(100 * context.objects.parameters.number_or_zero(object::INHIBIT_TIME_EMCY, 0));
        if inhibit > Duration::ZERO && context.has(Fault::EmcyMutedByInhibitTime) {
            // This faulty firmware loses its waiting messages.
            while context.objects.errors.poll(now, Duration::ZERO).is_some() {}
            return None;
        }
        // While bit 31 of 1014h is set, the message is dropped and the next message may follow at once.
        loop {
            let emcy = context.objects.errors.poll(now, inhibit)?;
            let cob_id = Self::cob_id(context)?;
            if cob_id.is_valid() || context.has(Fault::EmcySentWhenInvalid) {
                let frame = emcy.to_frame(cob_id.can_id() as u16);
                let remote = context.has(Fault::EmcyMovedIsRemote) && Some(cob_id) != Self::usual(context);
                return if remote { Frame::remote(frame.id(), frame.len() as u8) } else { Some(frame) };
            }
        }
    }

    fn due(context: &Context) -> Timestamp {
        if context.serves(nmt::Service::Emcy) { context.objects.errors.timeout() } else { Timestamp::MAX }
    }

    /// The COB-ID of EMCY in the predefined connection set.
    fn usual(context: &Context) -> Option<CobId> {
        Some(CobId(u32::from(emcy::CAN_ID_BASE) + u32::from(context.node?.raw())))
    }

    fn cob_id(context: &Context) -> Option<CobId> {
        let usual = Self::usual(context)?;
        let own = context.objects.parameters.number(object::COB_ID_EMCY, 0).map_or(usual, |raw| CobId(raw as u32));
        Some(if context.has(Fault::EmcyKeepsCanId) { CobId(own.0 & !0x7FF | usual.0) } else { own })
    }
}

impl Service for EmcyService {
    /// Handles the EMCY of a node that 1028h names.
    fn handle(&mut self, _: Timestamp, _: Route, frame: &Frame, context: &mut Context) {
        if frame.len() == 8 && context.phase.is_running() {
            context.objects.received_emcy = u64::from_le_bytes(frame.bytes());
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => context.objects.errors.reset(),
            Event::Entered { before: nmt::Phase::Stopped } => context.objects.errors.after_stopped(),
            Event::Written(at, value)
                if at.index.0 == object::INHIBIT_TIME_EMCY && context.takes(Liberty::InhibitFromWrite) =>
            {
                context.objects.errors.inhibit_until(now + Duration::from_micros(100 * value));
            }
            Event::Written(at, _) if at.index.0 == object::PREDEFINED_ERROR_FIELD => {
                context.objects.errors.clear_history();
            }
            Event::Written(at, _) if matches!(at.index.0, object::COB_ID_EMCY | object::EMERGENCY_CONSUMER) => {
                context.routes_changed = true;
            }
            _ => {}
        }
    }

    fn timeout(&self, context: &Context) -> Timestamp {
        Self::due(context)
    }

    fn transmit(&mut self, now: Timestamp, context: &mut Context) {
        while let Some(frame) = Self::next(now, context) {
            context.send(frame);
        }
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        let parameters = &context.objects.parameters;
        for cob_id in
            (1..=127).map_while(|sub| parameters.number(object::EMERGENCY_CONSUMER, sub)).map(|raw| CobId(raw as u32))
        {
            if cob_id.is_valid() && cob_id.can_id() != 0 {
                routes.set(cob_id.can_id() as u16, Route::PeerEmcy);
            }
        }
    }
}

/// Checks a write to 1014h: a CAN-ID of 11 bits that is not restricted. The CAN-ID may change only while bit 31 is set.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check_cob_id(value: u64, parameters: &Parameters, firmware: &Firmware) -> Result<(), AbortCode> {
    let (old, new) = (CobId(parameters.number_or_zero(object::COB_ID_EMCY, 0) as u32), CobId(value as u32));
    if firmware.takes(Liberty::CobIdRewriteRefused) && old.is_valid() && new.is_valid() {
        return Err(firmware.cob_id_code(AbortCode::INVALID_VALUE));
    }
    check_peer_cob_id(value, old, firmware, !firmware.has(Fault::EmcyIdChangeWhileValid))
}

/// Checks a write to a COB-ID of 1028h or of a further SDO channel, by the rules of [`check_cob_id`].
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check_peer_cob_id(
    value: u64,
    old: CobId,
    firmware: &Firmware,
    stays_while_valid: bool,
) -> Result<(), AbortCode> {
    let new = CobId(value as u32);
    let extended = new.is_extended() && !firmware.has(Fault::CobIdFrameBitTaken);
    let reserved = new.0 & (0x1FFF_F800 | CobId::NO_RTR) != 0 || extended;
    let reserved =
        reserved && (!firmware.has(Fault::CobIdBitsUnchecked) || new.0 & CobId::NO_RTR != 0 || new.is_extended());
    let restricted = new.is_valid() && new.is_restricted() && !firmware.has(Fault::RestrictedCanIdAccepted);
    if reserved || restricted {
        return Err(AbortCode::INVALID_VALUE);
    }
    let moved = old.is_valid() && new.is_valid() && new.can_id() != old.can_id() && stays_while_valid;
    if moved { Err(firmware.cob_id_code(AbortCode::INVALID_VALUE)) } else { Ok(()) }
}
