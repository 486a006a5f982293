//! Receive PDOs: activation, length, and deadline (CiA 301, 7.2.2.4).

use super::condition::Condition;
use super::context::Context;
use super::objects::Objects;
use super::parameters::Parameters;
use super::pdo::{self, Direction};
use super::routes::{Route, Routes};
use super::service::{Event, Service};
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::object;
use canvass_analyzer::wire::pdo::{MappingEntry, TransmissionType, extract};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{Duration, Frame, Timestamp};

#[derive(Clone, Debug)]
struct Rpdo {
    /// The number of the RPDO; 0 for 1400h and 1600h.
    number: u16,
    cob_id: CobId,
    transmission: TransmissionType,
    mapping: Vec<MappingEntry>,
    /// The length of the mapped objects in bytes.
    len: usize,
    /// The event timer of the RPDO, which is its deadline; zero if there is none.
    deadline: Duration,
    /// The time at which the deadline is missed; [`Timestamp::MAX`] until the first PDO.
    due: Timestamp,
    /// A received PDO that waits for SYNC.
    held: Option<Payload>,
}

/// The data of a PDO, filled up to eight bytes with zeros.
type Payload = [u8; 8];

/// The effect of a received PDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Received {
    /// The values take effect now.
    Act(Payload),
    /// The values take effect at the next SYNC.
    Hold,
    /// The PDO is shorter than its mapping, so the device does not process it.
    TooShort,
}

impl Rpdo {
    /// The RPDOs of the dictionary.
    fn all(parameters: &Parameters) -> Vec<Self> {
        let new = |number| Self {
            number,
            cob_id: CobId(CobId::INVALID),
            transmission: TransmissionType(255),
            mapping: Vec::with_capacity(8),
            len: 0,
            deadline: Duration::ZERO,
            due: Timestamp::MAX,
            held: None,
        };
        pdo::numbers(Direction::Receive, parameters).map(new).collect()
    }

    /// The number of the RPDO in reports; 1 for 1400h and 1600h.
    const fn ordinal(&self) -> u16 {
        self.number + 1
    }

    /// Applies the communication parameters and the mapping.
    fn configure(&mut self, objects: &Objects) {
        let number = |sub| objects.parameters.number_or_zero(object::RPDO_COMMUNICATION_PARAMETER + self.number, sub);
        self.cob_id = CobId(number(1) as u32);
        self.transmission = TransmissionType(number(2) as u8);
        self.deadline = Duration::from_millis(number(5));
        self.mapping.clear();
        self.mapping.extend(pdo::mapping(Direction::Receive, &objects.parameters, self.number));
        self.len = self.mapping.iter().map(|entry| usize::from(entry.bits())).sum::<usize>().div_ceil(8).min(8);
        if self.deadline == Duration::ZERO || !self.cob_id.is_valid() {
            self.due = Timestamp::MAX;
        }
    }

    /// The CAN-ID on which the device receives the PDO; `None` if the PDO is not valid or maps nothing.
    fn can_id(&self, firmware: &Firmware) -> Option<u16> {
        let received = self.cob_id.is_valid() || firmware.has(Fault::RpdoReceivedWhenInvalid);
        (received && !self.mapping.is_empty()).then_some(self.cob_id.can_id() as u16)
    }

    /// Handles leaving operational: a held PDO is dropped.
    fn stop(&mut self, firmware: &Firmware) {
        if !firmware.has(Fault::RpdoHeldOverStop) {
            self.held = None;
        }
        if !firmware.has(Fault::RpdoDeadlineOutlivesStop) {
            self.due = Timestamp::MAX;
        }
    }

    /// The length of the mapped objects in bytes.
    const fn len(&self) -> usize {
        self.len
    }

    /// Handles a received PDO.
    fn on_frame(&mut self, now: Timestamp, data: &[u8], firmware: &Firmware) -> Received {
        if data.len() < self.len && !firmware.has(Fault::RpdoLengthUnchecked) {
            return Received::TooShort;
        }
        let runs = self.due < Timestamp::MAX && firmware.has(Fault::RpdoDeadlineNotRestarted);
        if self.deadline > Duration::ZERO && !firmware.has(Fault::RpdoDeadlineIgnored) && !runs {
            self.due = now + self.deadline;
        }
        let mut payload = [0; 8];
        payload.iter_mut().zip(data).for_each(|(to, from)| *to = *from);
        let is_outer = matches!(self.transmission.0, 0 | 240);
        let at_once = firmware.has(Fault::SynchronousRpdoActsAtOnce)
            || is_outer && firmware.has(Fault::OuterSynchronousRpdosActAtOnce);
        if self.is_synchronous() && !at_once {
            self.held = Some(payload);
            return Received::Hold;
        }
        Received::Act(payload)
    }

    /// Whether the values wait for SYNC.
    fn is_synchronous(&self) -> bool {
        self.transmission.0 <= 240
    }

    /// Handles SYNC: returns the held PDO, whose values take effect now.
    fn on_sync(&mut self) -> Option<Payload> {
        self.held.take()
    }

    /// Handles the end of the window of synchronous PDOs: drops the held PDO.
    fn forget(&mut self) {
        self.held = None;
    }

    /// The time at which the deadline is missed.
    const fn timeout(&self) -> Timestamp {
        self.due
    }

    /// Whether the deadline is missed. A missed deadline is reported once, until the next PDO.
    fn is_late(&mut self, now: Timestamp) -> bool {
        let late = now >= self.due;
        if late {
            self.due = Timestamp::MAX;
        }
        late
    }

    /// Writes the values of a payload to the mapped objects.
    fn apply(&self, now: Timestamp, payload: Payload, context: &mut Context) {
        let most = if context.has(Fault::RpdoFirstObjectOnly) { 1 } else { usize::MAX };
        for (at, value) in self.values(payload).into_iter().take(most) {
            context.objects.receive(now, at, value);
        }
        context.events.push_back(Event::Act);
    }

    /// The mapped objects with their values; dummy entries are left out.
    fn values(&self, payload: Payload) -> Vec<(Multiplexer, u64)> {
        let mut offset = 0;
        let mut values = Vec::with_capacity(self.mapping.len());
        for entry in &self.mapping {
            if let Some(value) = extract(&payload, offset, entry.bits())
                && !entry.is_dummy()
            {
                values.push((entry.object(), value));
            }
            offset += usize::from(entry.bits());
        }
        values
    }
}

/// The RPDOs of a device.
#[derive(Clone, Debug)]
pub(super) struct Rpdos(Vec<Rpdo>);

impl Rpdos {
    /// The RPDOs of the dictionary.
    pub fn new(parameters: &Parameters) -> Self {
        Self(Rpdo::all(parameters))
    }

    fn stop(&mut self, firmware: &Firmware) {
        self.0.iter_mut().for_each(|rpdo| rpdo.stop(firmware));
    }

    fn configure(&mut self, objects: &Objects) {
        self.0.iter_mut().for_each(|rpdo| rpdo.configure(objects));
    }

    /// Handles data for the RPDO with this index.
    pub fn receive(&mut self, now: Timestamp, position: u16, data: &[u8], context: &mut Context) {
        debug_assert!(usize::from(position) < self.0.len(), "routes lead to RPDOs of the device");
        let Some(rpdo) = self.0.get_mut(usize::from(position)) else { return };
        if !context.phase.receives_pdos(context.firmware()) {
            return;
        }
        let too_long = data.len() > rpdo.len();
        let is_right = data.len() == rpdo.len();
        if rpdo.is_synchronous() && context.sync_closed || too_long && context.has(Fault::LongRpdoIgnored) {
            return;
        }
        let received = rpdo.on_frame(now, data, context.firmware());
        let too_short = received == Received::TooShort;
        let ordinal = rpdo.ordinal();
        let reported = too_short && !context.has(Fault::ShortRpdoUnreported);
        context.report(Condition::RpdoTooShort { rpdo: ordinal }, reported);
        let reported = too_long && !context.takes(Liberty::LongRpdoUnreported)
            || is_right && context.has(Fault::RightRpdoReported);
        context.report(Condition::RpdoTooLong { rpdo: ordinal }, reported);
        if !too_short {
            context.report(Condition::RpdoLate { rpdo: ordinal }, false);
        }
        if let Received::Act(payload) = received {
            rpdo.apply(now, payload, context);
        }
    }
}

impl Service for Rpdos {
    fn handle(&mut self, now: Timestamp, route: Route, frame: &Frame, context: &mut Context) {
        if let Route::Rpdo(position) = route {
            self.receive(now, position, frame.data(), context);
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => self.stop(context.firmware()),
            Event::Entered { .. } if !context.phase.receives_pdos(context.firmware()) => {
                self.stop(context.firmware());
            }
            Event::Started => self.configure(&context.objects),
            Event::Written(at, _)
                if matches!(at.index.0, object::RPDO_COMMUNICATION_PARAMETER..object::TPDO_COMMUNICATION_PARAMETER) =>
            {
                self.configure(&context.objects);
                context.routes_changed = true;
            }
            Event::Sync { .. } => {
                for rpdo in &mut self.0 {
                    if let Some(payload) = rpdo.on_sync() {
                        rpdo.apply(now, payload, context);
                    }
                }
            }
            Event::WindowClosed => self.0.iter_mut().for_each(Rpdo::forget),
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        for rpdo in &mut self.0 {
            if rpdo.is_late(now) {
                context.report(Condition::RpdoLate { rpdo: rpdo.ordinal() }, true);
            }
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.0.iter().fold(Timestamp::MAX, |next, rpdo| next.min(rpdo.timeout()))
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        for (position, rpdo) in (0..).zip(&self.0) {
            let can_id = rpdo.can_id(context.firmware());
            can_id.into_iter().for_each(|can_id| routes.set(can_id, Route::Rpdo(position)));
        }
    }
}
