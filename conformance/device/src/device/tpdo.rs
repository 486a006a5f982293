//! Transmit PDOs: when they are sent, and their values (CiA 301, 7.2.2).

use super::context::Context;
use super::nmt;
use super::objects::Objects;
use super::parameters::Parameters;
use super::pdo::{self, Direction};
use super::service::{Event, Service};
use crate::{Fault, Liberty};
use canvass_analyzer::object;
use canvass_analyzer::wire::pdo::{MappingEntry, TransmissionType, insert};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{CanId, Duration, Frame, Timestamp};

/// Interval at which mapped values are compared with the values that were sent last.
const SAMPLING: Duration = Duration::from_millis(1);

/// Delay after SYNC of synchronous TPDOs in a faulty firmware.
const LATE: Duration = Duration::from_millis(30);

/// Delay after SYNC of synchronous TPDOs in a slow device.
const SLOW: Duration = Duration::from_millis(40);

#[derive(Clone, Debug)]
struct Tpdo {
    /// The number of the TPDO; 0 for 1800h and 1A00h.
    number: u16,
    cob_id: CobId,
    transmission: TransmissionType,
    /// Whether a change of a mapped value is an event that sends the TPDO.
    on_change: bool,
    inhibit: Duration,
    event_timer: Duration,
    /// The SYNC start value: the counter of the first SYNC that the TPDO counts; 0 for any.
    sync_start: u8,
    mapping: Vec<MappingEntry>,
    /// Whether a faulty firmware sends the TPDO although its mapping is empty.
    sends_empty: bool,
    running: bool,
    event_due: Timestamp,
    sample_due: Timestamp,
    inhibited_until: Timestamp,
    /// Whether an event waits for the end of the inhibit time.
    waiting: bool,
    /// Whether the TPDO still waits for the SYNC with the start value.
    awaits_start: bool,
    /// Whether a SYNC came before operational, for a firmware that remembers this SYNC.
    remembered: bool,
    /// Number of SYNCs since the last transmission.
    syncs: u8,
    last: Option<Frame>,
    /// The values that a TPDO of transmission type 252 sampled at the last SYNC.
    sampled: Option<Frame>,
    /// The earlier frame that a faulty firmware sends next.
    late: Option<Frame>,
    /// Whether the frame is filled up to 8 bytes with zeros.
    padded: bool,
}

impl Tpdo {
    /// The TPDOs of the dictionary.
    fn all(parameters: &Parameters) -> Vec<Self> {
        pdo::numbers(Direction::Transmit, parameters).map(Self::new).collect()
    }

    fn new(number: u16) -> Self {
        Self {
            number,
            cob_id: CobId(CobId::INVALID),
            transmission: TransmissionType(255),
            on_change: false,
            inhibit: Duration::ZERO,
            event_timer: Duration::ZERO,
            sync_start: 0,
            mapping: Vec::with_capacity(8),
            sends_empty: false,
            running: false,
            event_due: Timestamp::MAX,
            sample_due: Timestamp::MAX,
            inhibited_until: Timestamp::ZERO,
            waiting: false,
            awaits_start: false,
            remembered: false,
            syncs: 0,
            last: None,
            sampled: None,
            late: None,
            padded: false,
        }
    }

    /// Applies the communication parameters and the mapping, and restarts the timers.
    fn configure(&mut self, now: Timestamp, objects: &Objects) {
        let number = |sub| objects.parameters.number_or_zero(object::TPDO_COMMUNICATION_PARAMETER + self.number, sub);
        let firmware = &objects.firmware;
        // The sampled values have the old CAN-ID and mapping.
        self.sampled = None;
        self.sends_empty = firmware.has(Fault::EmptyPdoValidated);
        let cob_id = CobId(number(1) as u32);
        let kept = firmware.has(Fault::TpdoIdOutlivesReset) && self.cob_id.is_valid() && cob_id.is_valid();
        self.cob_id = if kept { self.cob_id } else { cob_id };
        self.transmission = TransmissionType(number(2) as u8);
        let padded = &objects.model.sheet().network.padded_tpdos;
        self.padded = padded.iter().any(|&number| u16::from(number) == self.number + 1);
        // If the profile's timer (6200h) is the only event, the TPDO has no event timer of its own, and changes of
        // values are no events.
        let is_cyclic = self.number == 0 && objects.model.sheet().quirks.cyclic_tpdo;
        self.on_change = !is_cyclic && objects.model.sheet().network.sent_on_change.contains(&self.transmission.0);
        let unit = if firmware.has(Fault::InhibitTimeInMilliseconds) { 1_000 } else { 100 };
        self.inhibit = Duration::from_micros(number(3) * unit);
        let timer = || objects.application.as_ref().and_then(|application| application.cyclic_timer());
        let millis = match is_cyclic {
            true => timer().map_or(0, |index| objects.parameters.number_or_zero(index, 0)),
            false => number(5),
        };
        let factor = if firmware.has(Fault::EventTimerDoubled) { 2 } else { 1 };
        let late = firmware.has(Fault::EventTimerOffByOne) && millis > 0;
        self.event_timer = Duration::from_millis(millis * factor + u64::from(late));
        let ignored = firmware.has(Fault::SyncStartValueIgnored)
            || objects.parameters.number_or_zero(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0) == 0;
        let sync_start = if ignored { 0 } else { number(6) as u8 };
        self.awaits_start = sync_start != 0 && (self.awaits_start || sync_start != self.sync_start);
        self.sync_start = sync_start;
        self.mapping.clear();
        self.mapping.extend(pdo::mapping(Direction::Transmit, &objects.parameters, self.number));
        if firmware.has(Fault::TpdoBeyondCount) && !self.mapping.is_empty() {
            self.mapping.extend(pdo::entry_beyond(Direction::Transmit, &objects.parameters, self.number));
        }
        if self.running {
            self.arm(now, objects);
        }
    }

    /// Whether frames with this CAN-ID are this TPDO.
    fn uses(&self, can_id: u16) -> bool {
        self.cob_id.is_valid() && self.cob_id.can_id() == u32::from(can_id)
    }

    /// Whether the TPDO is sent after SYNC.
    fn is_synchronous(&self) -> bool {
        self.transmission.0 <= 240
    }

    /// Handles entering operational: sends an event-driven TPDO at once.
    fn start(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        self.running = true;
        if !objects.has(Fault::SyncCountNotReset) {
            self.syncs = if objects.takes(Liberty::SyncCountFromMiddle) { self.transmission.0 / 2 } else { 0 };
        }
        self.awaits_start = self.sync_start != 0 || objects.has(Fault::SyncWithoutStartValueIgnored);
        self.last = None;
        self.sampled = None;
        self.late = None;
        self.waiting = false;
        self.inhibited_until = Timestamp::ZERO;
        self.arm(now, objects);
        let owed = std::mem::take(&mut self.remembered) || objects.has(Fault::SynchronousTpdoAtStart);
        if owed && self.is_synchronous() {
            return self.transmit(now, objects);
        }
        if !self.is_event_driven() {
            return None;
        }
        let is_first_missing = objects.has(Fault::FirstPositionMissing) && self.event_timer > Duration::ZERO;
        if is_first_missing || objects.has(Fault::TpdoNotSentAtStart) {
            self.last = self.is_active().then(|| self.frame(now, objects));
            return None;
        }
        self.transmit(now, objects)
    }

    /// Handles leaving operational.
    fn stop(&mut self) {
        self.running = false;
        self.waiting = false;
        self.event_due = Timestamp::MAX;
        self.sample_due = Timestamp::MAX;
    }

    fn arm(&mut self, now: Timestamp, objects: &Objects) {
        let active = self.is_active() && self.is_event_driven();
        let timed = active && self.event_timer > Duration::ZERO;
        self.event_due = if timed { now + self.event_timer } else { Timestamp::MAX };
        let sampled = active && self.on_change && objects.is_moving();
        self.sample_due = if sampled { now + SAMPLING } else { Timestamp::MAX };
    }

    fn is_active(&self) -> bool {
        self.running && self.cob_id.is_valid() && (self.sends_empty || !self.mapping.is_empty())
    }

    fn is_event_driven(&self) -> bool {
        self.transmission >= TransmissionType::EVENT_MANUFACTURER
    }

    /// Time of the next call of [`Tpdo::poll`].
    fn timeout(&self) -> Timestamp {
        let waiting = if self.waiting { self.inhibited_until } else { Timestamp::MAX };
        self.event_due.min(self.sample_due).min(waiting)
    }

    /// Does the work that is due at the time of [`Tpdo::timeout`].
    fn poll(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        let mut frame = None;
        if now >= self.event_due {
            let planned = self.event_due + self.event_timer;
            frame = self.transmit(now, objects);
            self.event_due = planned;
        }
        if now >= self.sample_due {
            self.sample_due = now + SAMPLING;
            frame = frame.or_else(|| self.on_change(now, objects));
        }
        if self.waiting && now >= self.inhibited_until {
            frame = frame.or_else(|| self.transmit(now, objects));
        }
        frame
    }

    /// Handles a possible change of a mapped value: sends the TPDO if its data has changed.
    fn on_change(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        let watched = self.is_active() && self.is_event_driven() && self.on_change;
        if !watched || self.last == Some(self.frame(now, objects)) {
            return None;
        }
        self.transmit(now, objects)
    }

    /// Handles a SYNC; `counter` is the SYNC counter, if the producer counts.
    fn on_sync(&mut self, now: Timestamp, counter: Option<u8>, objects: &Objects) -> Option<Frame> {
        if !self.is_active() {
            self.remembered = !self.running && objects.has(Fault::SyncRememberedOverStart);
            return None;
        }
        if self.awaits_start && self.is_synchronous() {
            let begins = |counter| match objects.has(Fault::SyncStartPassedBegins) {
                true => counter >= self.sync_start,
                false => counter == self.sync_start,
            };
            if counter.is_some_and(|counter| !begins(counter)) {
                return None;
            }
            self.awaits_start = objects.has(Fault::SyncStartAgain);
        }
        match self.transmission {
            TransmissionType::SYNCHRONOUS_ACYCLIC => {
                let changed = self.last != Some(self.frame(now, objects));
                let event = changed && !objects.takes(Liberty::OwnEvents);
                let always = objects.has(Fault::AcyclicTpdoWithoutEvent);
                if event || always { self.transmit(now, objects) } else { None }
            }
            TransmissionType::RTR_SYNCHRONOUS => {
                self.sampled = Some(self.frame(now, objects));
                None
            }
            transmission => {
                let cycle = transmission.cycle()?;
                self.syncs = self.syncs.saturating_add(1);
                if self.syncs < cycle && !objects.has(Fault::SyncCycleIgnored) {
                    return None;
                }
                self.syncs = 0;
                let delay = match () {
                    () if objects.takes(Liberty::SyncTpdoIn40Ms) => SLOW,
                    () if objects.has(Fault::SyncTpdoLate) => LATE,
                    () => return self.transmit(now, objects),
                };
                (self.waiting, self.inhibited_until) = (true, now + delay);
                None
            }
        }
    }

    /// Handles a remote frame for the TPDO.
    fn on_remote(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        let allowed = self.cob_id.allows_rtr() || objects.has(Fault::RemoteFrameAnsweredWhenNotAllowed);
        if !self.is_active() || !allowed || objects.has(Fault::TpdoRemoteUnanswered) {
            return None;
        }
        match self.transmission {
            TransmissionType::RTR_SYNCHRONOUS if !objects.has(Fault::RtrTypeSampledAtOnce) => self.sampled,
            _ => Some(self.frame(now, objects)),
        }
    }

    /// Sends the TPDO, or keeps the event waiting until the end of the inhibit time.
    fn transmit(&mut self, now: Timestamp, objects: &Objects) -> Option<Frame> {
        self.waiting = self.waiting && objects.has(Fault::TpdoRepeatsAfterInhibit);
        if !self.is_active() {
            return None;
        }
        if now < self.inhibited_until {
            self.waiting = !objects.has(Fault::TpdoLostWhenInhibited);
            return None;
        }
        if self.is_event_driven() && !objects.has(Fault::InhibitTimeIgnored) {
            self.inhibited_until = now + self.inhibit;
        }
        if self.event_due < Timestamp::MAX {
            self.event_due = now + self.event_timer;
        }
        let frame = self.frame(now, objects);
        self.last = Some(frame);
        if objects.has(Fault::TpdoPositionLate) {
            return self.late.replace(frame).or(Some(frame));
        }
        Some(frame)
    }

    /// The TPDO with the current values of the mapped objects.
    fn frame(&self, now: Timestamp, objects: &Objects) -> Frame {
        let mut payload = [0; 8];
        let mut offset = 0;
        for (n, entry) in self.mapping.iter().enumerate() {
            let again = self.mapping.iter().take(n).any(|before| before.object() == entry.object());
            let value = objects.number(now, entry.object(), again).unwrap_or(0);
            // The mapping was checked when it was written, so all values fit.
            insert(&mut payload, offset, entry.bits(), value);
            offset += usize::from(entry.bits());
        }
        let id = CanId::standard_masked(self.cob_id.can_id());
        let len = if self.padded { 8 } else { offset.div_ceil(8).min(8) };
        Frame::new(id, payload.get(..len).unwrap_or(&[])).unwrap_or(Frame::full(id, payload))
    }
}

/// The TPDOs of a device.
#[derive(Clone, Debug)]
pub(super) struct Tpdos(Vec<Tpdo>);

impl Tpdos {
    /// The TPDOs of the dictionary.
    pub fn new(parameters: &Parameters) -> Self {
        Self(Tpdo::all(parameters))
    }

    /// Whether frames with this CAN-ID are a TPDO of the device.
    pub(crate) fn use_id(&self, can_id: u16) -> bool {
        self.0.iter().any(|tpdo| tpdo.uses(can_id))
    }

    /// Whether frames with this CAN-ID are a synchronous TPDO of the device.
    pub(crate) fn use_synchronously(&self, can_id: u16) -> bool {
        self.0.iter().any(|tpdo| tpdo.is_synchronous() && tpdo.uses(can_id))
    }

    /// Handles a remote frame; returns whether it requests a TPDO.
    pub fn on_remote(&mut self, now: Timestamp, can_id: u16, context: &mut Context) -> bool {
        let Some(tpdo) = self.0.iter_mut().find(|tpdo| tpdo.uses(can_id)) else { return false };
        tpdo.on_remote(now, &context.objects).into_iter().for_each(|frame| context.send(frame));
        true
    }

    /// Applies the communication parameters and mappings of all TPDOs.
    pub fn configure(&mut self, now: Timestamp, context: &Context) {
        self.0.iter_mut().for_each(|tpdo| tpdo.configure(now, &context.objects));
    }

    fn start(&mut self, now: Timestamp, context: &mut Context) {
        for tpdo in &mut self.0 {
            tpdo.start(now, &context.objects).into_iter().for_each(|frame| context.send(frame));
        }
    }
}

impl Service for Tpdos {
    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => self.0.iter_mut().for_each(Tpdo::stop),
            Event::Started => {
                self.configure(now, context);
                if context.serves(nmt::Service::Pdo) {
                    self.start(now, context);
                }
            }
            Event::Entered { .. } if context.serves(nmt::Service::Pdo) => self.start(now, context),
            Event::Entered { .. } => self.0.iter_mut().for_each(Tpdo::stop),
            Event::Resumed => self.configure(now, context),
            Event::Written(at, value) => self.on_written(now, at, value, context),
            Event::Changed => {
                for tpdo in &mut self.0 {
                    tpdo.on_change(now, &context.objects).into_iter().for_each(|frame| context.send(frame));
                }
            }
            Event::Sync { counter } => {
                for tpdo in &mut self.0 {
                    tpdo.on_sync(now, counter, &context.objects).into_iter().for_each(|frame| context.send(frame));
                }
            }
            Event::WindowClosed => {
                let is_late = |frame: &Frame| frame.id().as_standard().is_some_and(|id| self.use_synchronously(id));
                context.outbox.retain(|frame| !is_late(frame));
            }
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        for tpdo in &mut self.0 {
            tpdo.poll(now, &context.objects).into_iter().for_each(|frame| context.send(frame));
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.0.iter().fold(Timestamp::MAX, |next, tpdo| next.min(tpdo.timeout()))
    }
}

impl Tpdos {
    fn on_written(&mut self, now: Timestamp, at: Multiplexer, value: u64, context: &mut Context) {
        let concerns = match at.index.0 {
            object::TPDO_COMMUNICATION_PARAMETER..object::AFTER_PDO_PARAMETERS => true,
            // A faulty firmware does not notice that the SYNC counter was switched on after the start value was
            // written.
            object::SYNCHRONOUS_COUNTER_OVERFLOW if context.has(Fault::LateSyncCounterOverlooked) => false,
            object::COB_ID_SYNC..=object::SYNCHRONOUS_WINDOW_LENGTH | object::SYNCHRONOUS_COUNTER_OVERFLOW => true,
            _ => {
                let application = context.objects.application.as_ref();
                application.is_some_and(|it| it.changes_tpdos(at) || !it.resets(at, value).is_empty())
            }
        };
        if concerns {
            self.configure(now, context);
        }
    }
}
