//! TIME: consumed and produced (1012h).

use super::clock::{CONSUMES, PRODUCES};
use super::context::Context;
use super::nmt;
use super::objects::Objects;
use super::parameters::Parameters;
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::models::Network;
use crate::{Fault, Firmware};
use canvass_analyzer::CobId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::wire::time::TimeOfDay;
use canvass_traces::{Frame, Timestamp};

/// Consumes and produces TIME. The clock itself is part of the object dictionary.
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
            Event::Written(at, _) if at.index.0 == object::COB_ID_TIME => {
                Self::configure(now, context);
                context.routes_changed = true;
            }
            Event::Written(at, micros)
                if at.index.0 == object::HIGH_RESOLUTION_TIME_STAMP || context.has(Fault::StampSetByOthers) =>
            {
                context.objects.clock.stamp(now, micros as u32);
            }
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

/// Checks a write to 1012h: a CAN-ID of 11 bits that is not restricted, only directions that the device supports, and
/// no other CAN-ID while TIME is consumed or produced.
///
/// # Errors
/// "Invalid value" otherwise.
pub(super) fn check(
    value: u64,
    parameters: &Parameters,
    network: &Network,
    firmware: &Firmware,
) -> Result<(), AbortCode> {
    let (old, new) = (CobId(parameters.number_or_zero(object::COB_ID_TIME, 0) as u32), CobId(value as u32));
    let reserved = new.0 & 0x1FFF_F800 != 0 || new.is_extended();
    let impossible = new.0 & PRODUCES != 0 && network.time_period_ms.is_none();
    let restricted = new.is_restricted() && !firmware.has(Fault::RestrictedCanIdAccepted);
    let in_use = |cob_id: CobId| cob_id.0 & (CONSUMES | PRODUCES) != 0;
    let moved =
        in_use(old) && in_use(new) && new.can_id() != old.can_id() && !firmware.has(Fault::TimeIdChangeWhileValid);
    if reserved || impossible || restricted || firmware.has(Fault::TimeIdRefused) {
        return Err(AbortCode::INVALID_VALUE);
    }
    if moved { Err(firmware.cob_id_code(AbortCode::INVALID_VALUE)) } else { Ok(()) }
}
