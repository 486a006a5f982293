//! A model of the device's PDOs: their identifiers, states, lengths and times.

use super::expected_values::ExpectedValues;
use super::nmt::{Phase, Slave};
use super::sync_count::SyncCount;
use super::{Served, Symptom, Violation, violation};
use crate::Knowledge;
use crate::property::Property;
use canvass_analyzer::object;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{Duration, Frame, Timestamp};

/// The transmissions of one TPDO.
#[derive(Clone, Debug)]
struct Seen {
    /// The index of the TPDO's communication parameters.
    index: u16,
    last: Option<Timestamp>,
    /// The time of the last change of the configuration or the NMT state.
    since: Timestamp,
    /// The SYNC messages since the last change.
    count: SyncCount,
    /// Whether a SYNC came while the device may have been operational.
    heard: bool,
    /// Number of SYNC messages and remote frames that may still be answered.
    open: u8,
    /// The time at which the answer to a SYNC or remote frame is overdue.
    due: Timestamp,
    /// The next PDO may be later by this time, because an inhibit time from before a change of the configuration may
    /// still run.
    lag: Duration,
    /// Whether the bus was full for a while since the last PDO.
    held_up: bool,
    /// Whether a remote frame, not a SYNC, makes the PDO due.
    remote: bool,
    /// The configuration at [`Pdos::version`].
    parameters: Parameters,
}

/// All TPDOs of the device.
#[derive(Clone, Debug)]
pub(super) struct Pdos {
    seen: Vec<Seen>,
    /// The value of [`ExpectedValues::version`] at which the parameters were read.
    version: Option<u64>,
    /// Whether a TPDO may be due. This flag saves a search with every frame, as nearly always none is due.
    may_be_due: bool,
}

impl Pdos {
    pub fn new(knowledge: &Knowledge) -> Self {
        let parameters = knowledge
            .entries()
            .iter()
            .filter(|known| object::is_tpdo_communication(known.at.index.0) && known.at.sub.0 == 1);
        let seen = parameters.map(|known| Seen::new(known.at.index.0)).collect();
        Self { seen, version: None, may_be_due: false }
    }

    pub fn reset(&mut self) {
        self.may_be_due = false;
        for seen in &mut self.seen {
            *seen = Seen { parameters: seen.parameters, ..Seen::new(seen.index) };
        }
    }

    /// Takes over the current configuration, if it has changed.
    fn learn(&mut self, expected_values: &ExpectedValues, knowledge: &Knowledge) {
        if self.version != Some(expected_values.version()) {
            self.version = Some(expected_values.version());
            for seen in &mut self.seen {
                let before =
                    std::mem::replace(&mut seen.parameters, Parameters::of(seen.index, expected_values, knowledge));
                seen.lag = seen.lag.max(before.inhibit.unwrap_or_default());
            }
        }
    }

    /// Whether a valid PDO has, or may have, the identifier of another service. The two can't be distinguished then.
    pub fn shares(
        &mut self,
        now: Timestamp,
        can_id: u16,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> bool {
        self.learn(expected_values, knowledge);
        let mut shares = self.seen.iter().any(|seen| seen.parameters.cob_id.is_none());
        for seen in self.seen.iter_mut().filter(|seen| seen.has(can_id.into())) {
            seen.begin(now);
            shares = true;
        }
        shares
    }

    pub fn due(&self) -> Option<Timestamp> {
        if !self.may_be_due {
            return None;
        }
        self.seen.iter().map(|seen| seen.due).min().filter(|due| *due < Timestamp::MAX)
    }

    /// Handles a change of the NMT state: timers and counters begin anew.
    pub(crate) fn state_changed(&mut self, now: Timestamp, nmt: &Slave) {
        let from_rest = nmt.comes_from_rest();
        for seen in &mut self.seen {
            seen.begin(now);
            seen.heard &= !from_rest;
            if seen.heard {
                seen.count.doubt();
            }
        }
    }

    /// Continues with the device in pre-operational with its power-on configuration. The state of timers and counters
    /// is not known.
    pub fn go_on(&mut self, now: Timestamp) {
        self.reset();
        for seen in &mut self.seen {
            seen.begin(now);
            seen.count.doubt();
        }
    }

    /// Handles a write to an object.
    pub fn configured(&mut self, now: Timestamp, (at, _): (Multiplexer, u64)) {
        let communication = (0x1000..0x1400).contains(&at.index.0);
        for seen in &mut self.seen {
            // A device may restart all PDOs when one of them is configured, or let the other PDOs continue.
            if !communication {
                let in_step = seen.count.is_in_step() && !seen.heard;
                seen.begin(now);
                if !in_step {
                    seen.count.doubt();
                }
            }
            if communication {
                (seen.last, seen.since) = (None, now);
            }
            if matches!(at.index.0, object::COB_ID_SYNC | object::SYNCHRONOUS_COUNTER_OVERFLOW) {
                seen.count.doubt();
            }
        }
    }

    /// Applies a SYNC of the fuzzer.
    ///
    /// # Errors
    /// None so far: a missing PDO is judged when it is overdue.
    pub(crate) fn synchronised(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        writing: bool,
        nmt: &Slave,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> Result<(), Violation> {
        self.learn(expected_values, knowledge);
        let counter = expected_values.number(knowledge, object::SYNCHRONOUS_COUNTER_OVERFLOW, 0).unwrap_or(0);
        let understood = frame.len() == usize::from(counter != 0);
        let rests = !matches!(nmt.phase(), Phase::Operational | Phase::Running | Phase::Unsure);
        for seen in &mut self.seen {
            if rests {
                continue;
            }
            seen.heard = true;
            if nmt.phase() != Phase::Operational || !understood || writing {
                // The device may or may not count this SYNC.
                seen.open();
                seen.count.doubt();
                continue;
            }
            let parameters = seen.parameters;
            match parameters.transmission {
                Some(kind @ 1..=240) if parameters.is_plain() => {
                    if seen.count.sync(kind) && seen.due == Timestamp::MAX {
                        seen.remote = false;
                        seen.due = now + knowledge.patience.answer.max(LONGEST_SYNC_DELAY);
                        self.may_be_due = true;
                    }
                }
                _ => seen.open(),
            }
        }
        Ok(())
    }

    /// Applies a SYNC of the device itself. The standard leaves open whether it counts for the device's own PDOs.
    pub(crate) fn synchronises_itself(&mut self) {
        for seen in &mut self.seen {
            seen.heard = true;
            seen.open();
            seen.count.doubt();
        }
    }

    /// Records that the bus was full until `now`.
    pub(crate) fn held_up(&mut self, now: Timestamp) {
        for seen in &mut self.seen {
            (seen.last, seen.since) = (None, now);
            seen.due = Timestamp::MAX;
            seen.held_up = true;
        }
    }

    /// Applies a remote frame of the fuzzer.
    pub fn asked(
        &mut self,
        now: Timestamp,
        can_id: u16,
        writing: bool,
        nmt: &Slave,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) {
        self.learn(expected_values, knowledge);
        let has = |seen: &Seen| seen.has(can_id.into());
        let alone = self.seen.iter().filter(|seen| has(seen)).count() == 1;
        let certain = alone && !writing && nmt.phase() == Phase::Operational;
        for seen in &mut self.seen {
            seen.open();
            if has(seen) {
                // The answer to a remote frame does not belong to the SYNC count.
                seen.count.doubt();
            }
            if certain && has(seen) && seen.parameters.answers_remote() && seen.due == Timestamp::MAX {
                seen.due = now + knowledge.patience.answer;
                self.may_be_due = true;
                seen.remote = true;
            }
        }
    }

    /// Checks a frame of the device that belongs to no other service.
    ///
    /// # Errors
    /// [`Violation`] if the device must not send it.
    pub fn came(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        nmt: &Slave,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> Result<(), Violation> {
        if !knowledge.is_described() {
            return Ok(());
        }
        self.learn(expected_values, knowledge);
        let id = u32::from(frame.id().as_standard().unwrap_or(u16::MAX));
        let unknown = frame.id().as_standard().is_none()
            || frame.is_remote()
            || self.seen.iter().any(|seen| seen.parameters.cob_id.is_none());
        let mut own = self.seen.iter_mut().filter(|seen| seen.has(id));
        if let Some(first) = own.next() {
            let Some(second) = own.next() else { return first.came(now, frame, nmt, knowledge) };
            // Two PDOs with the same identifier can't be distinguished.
            [first, second].into_iter().chain(own).for_each(|seen| seen.begin(now));
            return Ok(());
        }
        // A PDO with an identifier that changed a moment ago may still be on its way.
        let changing = self.seen.iter().any(|seen| now.since(seen.since) < knowledge.patience.jitter.times(2));
        if unknown || changing || knowledge.bystanders.contains(&(id as u16)) {
            return Ok(());
        }
        if let Some(message) = expected_values.is_off(id as u16) {
            let expected = format!("no message with this identifier: {}", message.reason());
            return Err(violation(Property::Produced, message.rule(), expected, format!("{frame}"), now));
        }
        let expected = "frames only on the identifiers of its services and valid PDOs";
        Err(violation(Property::Pdo, "identifier", expected, format!("{frame}"), now))
    }

    /// Checks whether a PDO is overdue.
    ///
    /// # Errors
    /// [`Violation`] if a PDO is due and has not come.
    pub fn expire(&mut self, now: Timestamp) -> Result<(), Violation> {
        for seen in &mut self.seen {
            if now >= seen.due {
                seen.due = Timestamp::MAX;
                let (rule, cause) = match std::mem::take(&mut seen.remote) {
                    true => ("remote frame", "the remote frame, which bit 30 of its COB-ID allows"),
                    false => ("synchronous TPDO", "the SYNC"),
                };
                let expected = format!("the TPDO of {:04X}h after {cause}", seen.index);
                return Err(missing(seen, violation(Property::Pdo, rule, expected, "none", now)));
            }
        }
        Ok(())
    }

    /// Checks whether cyclic PDOs are missing.
    ///
    /// # Errors
    /// [`Violation`] if cyclic PDOs are missing.
    pub fn finish(
        &mut self,
        now: Timestamp,
        nmt: &Slave,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> Result<(), Violation> {
        if nmt.phase() != Phase::Operational {
            return Ok(());
        }
        self.learn(expected_values, knowledge);
        for seen in &self.seen {
            let Some(period) = seen.parameters.period() else { continue };
            let last = seen.last.unwrap_or(seen.since).max(seen.since);
            if last > Timestamp::ZERO && now.since(last) > late(period, knowledge.patience.jitter) + seen.lag {
                let expected = format!("the TPDO of {:04X}h every {period}", seen.index);
                let actual = format!("none for {}", now.since(last));
                let wrong = missing(seen, violation(Property::Pdo, "event timer", expected, actual, now));
                let most = late(period, knowledge.patience.jitter) + seen.lag;
                return Err(Violation { interval: Some(Box::new((Duration::ZERO, most))), ..wrong });
            }
        }
        Ok(())
    }
}

/// Adds the allowed time between two PDOs to a violation.
fn within(judged: Result<(), Violation>, least: Duration, most: Duration) -> Result<(), Violation> {
    judged.map_err(|wrong| Violation { interval: Some(Box::new((least, most))), ..wrong })
}

/// The violation as the absence of the PDO shows it.
fn missing(seen: &Seen, violation: Violation) -> Violation {
    let can_id = seen.parameters.cob_id.and_then(|cob_id| u16::try_from(cob_id.can_id()).ok());
    Violation { symptom: Symptom::Missing(can_id), ..violation }
}

impl Seen {
    const fn new(index: u16) -> Self {
        Self {
            index,
            parameters: Parameters::UNKNOWN,
            last: None,
            since: Timestamp::ZERO,
            count: SyncCount::new(),
            heard: false,
            open: 0,
            due: Timestamp::MAX,
            remote: false,
            lag: Duration::ZERO,
            held_up: false,
        }
    }

    /// Whether the PDO is valid and has the identifier.
    fn has(&self, can_id: u32) -> bool {
        self.parameters.cob_id.is_some_and(|cob_id| cob_id.is_valid() && cob_id.can_id() == can_id)
    }

    fn begin(&mut self, now: Timestamp) {
        self.last = None;
        self.since = now;
        self.count = SyncCount::new();
        self.due = Timestamp::MAX;
        self.open = 1;
    }

    fn open(&mut self) {
        self.open = self.open.saturating_add(1);
    }

    fn came(&mut self, now: Timestamp, frame: &Frame, nmt: &Slave, knowledge: &Knowledge) -> Result<(), Violation> {
        let parameters = self.parameters;
        let jitter = knowledge.patience.jitter;
        let wrong = |rule, expected: String, actual: String| Err(violation(Property::Pdo, rule, expected, actual, now));
        if nmt.serves_pdo(now) == Served::No {
            let expected = "no PDO outside operational".to_owned();
            return wrong("PDO outside operational", expected, format!("{frame} in {}", nmt.phase().name()));
        }
        if let Some(len) = parameters.length
            && frame.len() != len
            // A TPDO of type 252 contains the data of the last SYNC, which may have come before the configuration.
            && parameters.transmission != Some(252)
            && !(frame.len() == 8 && knowledge.services.padded_tpdos.contains(&(self.index - 0x17FF)))
            && now.since(self.since) > jitter
        {
            return wrong("length of a PDO", format!("{len} bytes, as mapped"), format!("{} bytes", frame.len()));
        }
        let last = self.last.replace(now);
        let lag = std::mem::take(&mut self.lag);
        self.due = Timestamp::MAX;
        if let (Some(kind @ 1..=240), true) = (parameters.transmission, parameters.is_plain())
            && self.count.came(kind)
        {
            return Ok(());
        }
        let asked = self.open > 0;
        self.open = self.open.saturating_sub(1);
        if let (Some(kind @ 1..=240), true) = (parameters.transmission, parameters.is_plain())
            && !asked
            && nmt.phase() == Phase::Operational
        {
            let expected = format!("the TPDO after every {kind} SYNC");
            let actual = format!("a TPDO too early, after {} SYNC messages", self.count.syncs());
            return wrong("synchronous TPDO", expected, actual);
        }
        if std::mem::take(&mut self.held_up) {
            // The PDO waited for the bus; the next PDO may come in time, and thus too soon after this PDO.
            (self.last, self.since) = (None, now);
        }
        if asked {
            // The answer to a remote frame follows no period, and neither does the time from it to the next PDO.
            (self.last, self.since) = (None, now);
        }
        let Some(last) = last else { return Ok(()) };
        let interval = now.since(last);
        if let (Some(inhibit), Some(254 | 255)) = (parameters.inhibit, parameters.transmission)
            && !asked
            && inhibit > jitter
            && interval.nanos() + jitter.nanos() < inhibit.nanos()
        {
            let judged = wrong("inhibit time", format!("at least {inhibit} between two"), format!("{interval}"));
            let least = Duration(inhibit.nanos() - jitter.nanos());
            return within(judged, least, Duration(u64::MAX));
        }
        match parameters.period() {
            Some(period) if !nmt.has_error() && interval > late(period, jitter) + lag => {
                let judged = wrong("event timer", format!("the TPDO every {period}"), format!("after {interval}"));
                within(judged, Duration::ZERO, late(period, jitter) + lag)
            }
            _ => Ok(()),
        }
    }
}

/// Time within which a synchronous TPDO has to follow its SYNC if 1007h sets no window. No clause limits this time; the
/// test cases use the same limit.
const LONGEST_SYNC_DELAY: Duration = Duration::from_millis(500);

/// The maximum time between two cyclic PDOs.
fn late(period: Duration, jitter: Duration) -> Duration {
    Duration(period.nanos() + (period.nanos() / 10).max(jitter.nanos()))
}

/// The communication parameters and mapping of a PDO, as far as they are known.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    cob_id: Option<CobId>,
    transmission: Option<u8>,
    inhibit: Option<Duration>,
    event_timer: Option<Duration>,
    start_value: u64,
    /// Whether the synchronous window has no end.
    open_window: bool,
    /// Whether an object is mapped. A PDO without mapped objects is not sent.
    mapped: bool,
    /// The length of all mapped objects in bytes.
    length: Option<usize>,
}

impl Parameters {
    const UNKNOWN: Self = Self {
        cob_id: None,
        transmission: None,
        inhibit: None,
        event_timer: None,
        start_value: 0,
        open_window: false,
        mapped: false,
        length: None,
    };

    fn of(index: u16, expected_values: &ExpectedValues, knowledge: &Knowledge) -> Self {
        let number = |sub| expected_values.number(knowledge, index, sub);
        Self {
            cob_id: number(1).map(|raw| CobId(raw as u32)),
            transmission: number(2).map(|raw| raw as u8),
            inhibit: number(3).map(|raw| Duration::from_micros(raw * 100)),
            event_timer: number(5).map(Duration::from_millis),
            start_value: number(6).unwrap_or(0),
            open_window: match knowledge.entry(Multiplexer::new(object::SYNCHRONOUS_WINDOW_LENGTH, 0)) {
                Some(_) => expected_values.number(knowledge, object::SYNCHRONOUS_WINDOW_LENGTH, 0) == Some(0),
                None => true,
            },
            mapped: expected_values.number(knowledge, index + 0x200, 0).is_some_and(|count| (1..=64).contains(&count)),
            length: mapped_length(index + 0x200, expected_values, knowledge),
        }
    }

    /// Whether the PDO exists and follows every n-th SYNC from the first on.
    fn is_plain(&self) -> bool {
        // The standard leaves open whether an inhibit time that began before a change of the type still counts.
        let free = self.inhibit.is_none_or(|inhibit| inhibit == Duration::ZERO);
        free && self.mapped && self.open_window && self.start_value == 0 && self.cob_id.is_some_and(CobId::is_valid)
    }

    /// Whether a remote frame must be answered.
    fn answers_remote(&self) -> bool {
        let allows = self.cob_id.is_some_and(|cob_id| cob_id.is_valid() && cob_id.allows_rtr());
        allows
            && self.mapped
            && self.inhibit.is_none_or(|inhibit| inhibit == Duration::ZERO)
            && matches!(self.transmission, Some(253..=255))
    }

    /// The event timer's period, for a PDO that has one.
    fn period(&self) -> Option<Duration> {
        let cyclic =
            self.mapped && matches!(self.transmission, Some(254 | 255)) && self.cob_id.is_some_and(CobId::is_valid);
        let timer = self.event_timer.filter(|timer| cyclic && timer.nanos() > 0)?;
        Some(timer.max(self.inhibit?))
    }
}

/// The length of a PDO in bytes by its mapping, if it is known.
fn mapped_length(mapping: u16, expected_values: &ExpectedValues, knowledge: &Knowledge) -> Option<usize> {
    let count = expected_values.number(knowledge, mapping, 0).filter(|count| (1..=64).contains(count))?;
    let bits = (1..=count as u8).map(|sub| expected_values.number(knowledge, mapping, sub).map(|entry| entry & 0xFF));
    bits.sum::<Option<u64>>().map(|bits| bits.div_ceil(8) as usize)
}
