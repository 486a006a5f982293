//! The LSS slave as CiA 305 demands it, seen from outside.

use super::nmt::Phase;
use super::{Violation, silence, violation};
use crate::Knowledge;
use crate::coverage::{Coverage, LssCommand, LssState};
use crate::property::Property;
use crate::stimulus::Start;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss::{ConfigureCommand, Request, Response};
use canvass_traces::{Duration, Frame, Timestamp};

/// The node-ID that says "not configured".
const NONE: u8 = 255;

/// Writing the non-volatile memory takes a device seconds, and it may answer when it is done.
const STORING: Duration = Duration::from_secs(10);

/// Begins Fastscan anew.
const BEGIN: u8 = 128;

/// What a request does beyond the slave.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Effect {
    Nothing,
    /// A device without node-ID got one and boots.
    Boots,
    /// Something that the models don't follow.
    Lost,
}

/// What may be answered.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Awaited {
    Nothing,
    /// The standard leaves it open.
    Anything,
    Exactly(Response),
    /// Store configuration: success, or why not.
    Stored,
    /// Configure bit timing: success or refusal by what the device supports.
    Timing {
        supported: Option<bool>,
    },
}

/// Whether the slave is in configuration.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Mode {
    Waiting,
    Configuration,
    /// After a request that the standard leaves open.
    Unsure,
}

/// The slave.
#[derive(Clone, Debug)]
pub(super) struct Slave {
    mode: Mode,
    /// The active node-ID is "none".
    unconfigured: bool,
    pending: Option<u8>,
    /// It began without node-ID and was given one, which a reset may take away again.
    given: bool,
    timing_changed: bool,
    /// Parts of the address that have matched in order; `None`: the order was another one.
    selected: Option<u8>,
    /// Bounds that have matched in order; `None`: the order was another one.
    identified: Option<u8>,
    /// The part that Fastscan compares; `None`: not begun, or not known.
    scanning: Option<u8>,
    awaited: Awaited,
    rule: &'static str,
    property: Property,
    due: Timestamp,
    /// An answer that was on its way when a reset came may still come until then.
    grace: Timestamp,
    asked: (LssState, LssCommand),
}

impl Slave {
    pub const fn new() -> Self {
        Self {
            mode: Mode::Waiting,
            unconfigured: false,
            pending: None,
            given: false,
            timing_changed: false,
            selected: Some(0),
            identified: Some(0),
            scanning: None,
            awaited: Awaited::Nothing,
            rule: "",
            property: Property::LegalLss,
            due: Timestamp::MAX,
            grace: Timestamp::ZERO,
            asked: (LssState::Waiting, LssCommand::Unknown),
        }
    }

    pub fn start(&mut self, start: Start) {
        *self = Self { unconfigured: start == Start::Unconfigured, ..Self::new() };
    }

    /// A reset of the NMT slave: whether LSS goes on in its mode, the standard leaves open. An answer that was due may
    /// have been on its way, and come until `grace`.
    pub fn reset_communication(&mut self, grace: Timestamp) {
        let grace = if self.awaited == Awaited::Nothing { Timestamp::ZERO } else { grace };
        *self = Self { mode: Mode::Unsure, unconfigured: self.unconfigured, grace, ..Self::new() };
    }

    /// Whether a reset gives the device another node-ID than it has.
    pub fn moves(&self, knowledge: &Knowledge) -> bool {
        self.pending.is_some_and(|node| node != knowledge.node.raw()) || self.timing_changed || self.given
    }

    fn class(&self) -> LssState {
        match (self.mode, self.unconfigured) {
            (Mode::Configuration, _) => LssState::Configuration,
            (_, true) if self.scanning.is_some() => LssState::Scanning,
            (_, true) => LssState::Unconfigured,
            _ if self.selected.is_some_and(|parts| parts > 0) => LssState::Selecting,
            _ => LssState::Waiting,
        }
    }

    /// Whether anything may come.
    pub fn is_open(&self) -> bool {
        self.awaited == Awaited::Anything
    }

    /// Whether the slave waits, and nothing that was configured waits for a reset.
    pub fn is_at_rest(&self) -> bool {
        self.mode == Mode::Waiting && self.awaited == Awaited::Nothing && self.is_settled()
    }

    /// Whether nothing that was configured waits for a reset.
    pub fn is_settled(&self) -> bool {
        self.pending.is_none() && !self.given && !self.timing_changed
    }

    /// The slave waits; which parts of an address have matched is not known.
    pub fn go_on(&mut self) {
        *self = Self { unconfigured: self.unconfigured, selected: None, identified: None, ..Self::new() };
    }

    pub fn due(&self) -> Option<Timestamp> {
        (self.due < Timestamp::MAX).then_some(self.due)
    }

    /// A request of the fuzzer.
    pub fn asked(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        knowledge: &Knowledge,
        phase: Phase,
        coverage: &mut Coverage,
    ) -> Effect {
        self.asked = (self.class(), LssCommand::of(frame));
        let overlaps = self.due < Timestamp::MAX;
        let (awaited, effect) = self.judge(frame, knowledge, phase);
        let awaited = if overlaps { Awaited::Anything } else { awaited };
        if overlaps {
            self.mode = Mode::Unsure;
        }
        if matches!(awaited, Awaited::Nothing | Awaited::Anything) {
            coverage.lss(self.asked.0, self.asked.1, false);
        }
        let required = matches!(awaited, Awaited::Exactly(_) | Awaited::Stored | Awaited::Timing { .. });
        let patience = if awaited == Awaited::Stored { STORING } else { knowledge.patience.answer };
        self.due = if required { now + patience } else { Timestamp::MAX };
        self.awaited = awaited;
        effect
    }

    fn judge(&mut self, frame: &Frame, knowledge: &Knowledge, phase: Phase) -> (Awaited, Effect) {
        let works = match (knowledge.services.lss, phase) {
            (Some(false), _) => return (Awaited::Nothing, Effect::Nothing),
            (_, Phase::Booting) => return (Awaited::Anything, Effect::Lost),
            (None, _) => false,
            (_, Phase::Operational | Phase::Running | Phase::Unsure) => !knowledge.services.lss_not_in_operational,
            _ => true,
        };
        let request = Request::read(frame.data()).ok().filter(|_| frame.len() == 8);
        let Some(request) = request else {
            self.mode = Mode::Unsure;
            // A slave may fill up what is too short, and take it for a part of an address.
            self.selected = None;
            self.identified = None;
            return (Awaited::Anything, Effect::Nothing);
        };
        self.property = Property::LegalLss;
        let (awaited, effect) = self.answer(request, knowledge);
        match awaited {
            // Where LSS may not work, every silence is right, and what the request did is not known.
            Awaited::Exactly(_) | Awaited::Stored | Awaited::Timing { .. } if !works => {
                self.mode = Mode::Unsure;
                (Awaited::Anything, effect)
            }
            awaited if !works && matches!(request, Request::SwitchGlobal { .. }) => {
                self.mode =
                    if matches!(request, Request::SwitchGlobal { mode: 0 }) { Mode::Waiting } else { Mode::Unsure };
                (awaited, effect)
            }
            awaited => (awaited, effect),
        }
    }

    fn answer(&mut self, request: Request, knowledge: &Knowledge) -> (Awaited, Effect) {
        let nothing = |awaited| (awaited, Effect::Nothing);
        match request {
            Request::SwitchGlobal { mode } => self.switch(mode, knowledge),
            Request::SwitchSelective { part, value } => nothing(self.select(part as u8, value, knowledge)),
            Request::IdentifyRemote { bound, value } => nothing(self.identify(bound as u8, value, knowledge)),
            Request::IdentifyNonConfigured => {
                self.rule = "identify non-configured remote slave";
                nothing(self.only_if(self.unconfigured && self.pending.is_none(), Response::NonConfigured))
            }
            Request::Fastscan { id, bit_check, sub, next } => {
                self.rule = "Fastscan";
                self.property = Property::Fastscan;
                nothing(self.scan(id, bit_check, sub, next, knowledge))
            }
            Request::Unknown { .. } => {
                self.rule = "unknown command specifier";
                nothing(Awaited::Nothing)
            }
            _ => self.configure(request, knowledge),
        }
    }

    fn only_if(&self, condition: bool, response: Response) -> Awaited {
        match (condition, self.pending) {
            (true, _) => Awaited::Exactly(response),
            // What a pending node-ID means for a device that has none yet is left open.
            (false, Some(_)) => Awaited::Anything,
            (false, None) => Awaited::Nothing,
        }
    }

    fn switch(&mut self, mode: u8, knowledge: &Knowledge) -> (Awaited, Effect) {
        let node = knowledge.node.raw();
        self.rule = "switch state global";
        self.selected = Some(0);
        match mode {
            0 => {
                let left = self.mode != Mode::Waiting;
                self.mode = Mode::Waiting;
                match self.pending {
                    Some(own)
                        if own == node
                            && left
                            && (self.unconfigured || knowledge.services.lss_restarts == Some(true)) =>
                    {
                        self.given |= self.unconfigured;
                        self.unconfigured = false;
                        self.pending = None;
                        (Awaited::Nothing, Effect::Boots)
                    }
                    // CiA 305: at the next reset communication.
                    Some(_) if !self.unconfigured && knowledge.services.lss_restarts == Some(false) => {
                        (Awaited::Nothing, Effect::Nothing)
                    }
                    // When a configured device takes its new node-ID over depends on the device.
                    Some(_) if left => (Awaited::Nothing, Effect::Lost),
                    _ => (Awaited::Nothing, Effect::Nothing),
                }
            }
            1 => {
                self.mode = Mode::Configuration;
                (Awaited::Nothing, Effect::Nothing)
            }
            // Reserved.
            _ => {
                self.mode = Mode::Unsure;
                (Awaited::Nothing, Effect::Nothing)
            }
        }
    }

    /// The four parts, each equal, in order. Slaves that accept another order with the serial number last exist.
    fn select(&mut self, part: u8, value: u32, knowledge: &Knowledge) -> Awaited {
        self.rule = "switch state selective";
        let Some(address) = knowledge.address else { return Awaited::Anything };
        let fits = address.get(usize::from(part)) == Some(&value);
        if self.mode == Mode::Configuration {
            // Selective addressing is a service of the waiting state; a slave in configuration may say so again.
            return if part == 3 { Awaited::Anything } else { Awaited::Nothing };
        }
        self.selected = match (part, self.selected) {
            (0, _) if fits => Some(1),
            (part, Some(parts)) if part == parts && fits => Some(parts + 1),
            (_, None) => None,
            // A part again, or out of order: it may count or begin anew.
            (_, Some(parts)) if fits && parts > 0 => None,
            _ => Some(0),
        };
        match (part, self.selected) {
            (3, Some(4)) => {
                self.selected = Some(0);
                let known = self.mode == Mode::Waiting;
                self.mode = Mode::Configuration;
                // A slave that is in configuration already has nothing to say.
                if known { Awaited::Exactly(Response::Switched) } else { Awaited::Anything }
            }
            (3, None) => {
                self.selected = Some(0);
                self.mode = Mode::Unsure;
                Awaited::Anything
            }
            (3, Some(_)) if self.mode == Mode::Unsure => Awaited::Anything,
            _ => Awaited::Nothing,
        }
    }

    fn identify(&mut self, bound: u8, value: u32, knowledge: &Knowledge) -> Awaited {
        self.rule = "identify remote slave";
        let Some([vendor, product, revision, serial]) = knowledge.address else { return Awaited::Anything };
        let fits = match bound {
            0 => value == vendor,
            1 => value == product,
            2 => value <= revision,
            3 => value >= revision,
            4 => value <= serial,
            _ => value >= serial,
        };
        self.identified = match (bound, self.identified) {
            (0, _) if fits => Some(1),
            (bound, Some(bounds)) if bound == bounds && fits => Some(bounds + 1),
            (_, None) => None,
            (_, Some(bounds)) if fits && bounds > 0 => None,
            _ => Some(0),
        };
        match (bound, self.identified) {
            (5, Some(6)) => {
                self.identified = Some(0);
                Awaited::Exactly(Response::Identified)
            }
            (5, None) => {
                self.identified = Some(0);
                Awaited::Anything
            }
            _ => Awaited::Nothing,
        }
    }

    fn scan(&mut self, id: u32, bit_check: u8, sub: u8, next: u8, knowledge: &Knowledge) -> Awaited {
        if (!self.unconfigured || self.mode == Mode::Configuration) && self.pending.is_none() {
            return Awaited::Nothing;
        }
        if self.mode == Mode::Unsure || self.pending.is_some() {
            // It may have begun, gone on or not.
            self.scanning = None;
            return Awaited::Anything;
        }
        if knowledge.services.fastscan == Some(false) {
            self.scanning = None;
            return Awaited::Nothing;
        }
        if bit_check == BEGIN {
            self.scanning = Some(0);
            return Awaited::Exactly(Response::Identified);
        }
        if bit_check > 31 || sub > 3 || next > 3 {
            return Awaited::Nothing;
        }
        // Without a begin the slave may be at its first part.
        let Some(scanning) = self.scanning else {
            if sub == 3 && bit_check == 0 {
                self.mode = Mode::Unsure;
            }
            return Awaited::Anything;
        };
        let Some(address) = knowledge.address else { return Awaited::Anything };
        if sub != scanning || (address[usize::from(sub)] ^ id) >> bit_check != 0 {
            return Awaited::Nothing;
        }
        if bit_check == 0 {
            self.scanning = Some(next);
            match (sub, next) {
                (3, 0..=2) => {
                    self.mode = Mode::Configuration;
                    self.scanning = None;
                }
                // Back before the last part: it must not complete the scan; where it goes on is left open.
                (_, next) if next != sub + 1 => self.scanning = None,
                _ => {}
            }
        }
        Awaited::Exactly(Response::Identified)
    }

    fn configure(&mut self, request: Request, knowledge: &Knowledge) -> (Awaited, Effect) {
        self.rule = match request {
            Request::ConfigureNodeId { .. } => "configure node-ID",
            Request::ConfigureBitTiming { .. } => "configure bit timing",
            Request::ActivateBitTiming { .. } => "activate bit timing",
            Request::StoreConfiguration => "store configuration",
            Request::InquireNodeId => "inquire node-ID",
            _ => "inquire",
        };
        match self.mode {
            Mode::Configuration => {}
            Mode::Waiting => return (Awaited::Nothing, Effect::Nothing),
            Mode::Unsure => {
                let changes = !matches!(request, Request::Inquire { .. } | Request::InquireNodeId);
                return (Awaited::Anything, if changes { Effect::Lost } else { Effect::Nothing });
            }
        }
        let done = |command, error| Awaited::Exactly(Response::Configured { command, error, specific: 0 });
        let awaited = match request {
            Request::ConfigureNodeId { node_id } => {
                let valid = matches!(node_id, 1..=127 | NONE);
                if valid {
                    self.pending = Some(node_id);
                }
                done(ConfigureCommand::NodeId, u8::from(!valid))
            }
            Request::ConfigureBitTiming { table, index } => {
                let rates = knowledge.services.lss_bit_rates.as_ref();
                let reserved = table == 0 && (index == 5 || index > 9);
                let supported = match rates {
                    _ if reserved => Some(false),
                    Some(rates) if table == 0 && index != 9 => Some(rates.contains(&index)),
                    _ => None,
                };
                self.timing_changed |= supported != Some(false);
                Awaited::Timing { supported }
            }
            Request::ActivateBitTiming { .. } => return (Awaited::Anything, Effect::Lost),
            Request::StoreConfiguration => {
                // What a reset brings then is not known.
                self.given = true;
                Awaited::Stored
            }
            Request::Inquire { .. } | Request::InquireNodeId if knowledge.services.lss_inquiry == Some(false) => {
                Awaited::Nothing
            }
            Request::Inquire { part } => match knowledge.address {
                Some(address) => Awaited::Exactly(Response::Part { part, value: address[part as usize] }),
                None => Awaited::Anything,
            },
            Request::InquireNodeId => {
                let active = if self.unconfigured { NONE } else { knowledge.node.raw() };
                match self.pending {
                    // Which of the two a slave tells is left open.
                    Some(_) => Awaited::Anything,
                    None => Awaited::Exactly(Response::NodeId(active)),
                }
            }
            _ => Awaited::Nothing,
        };
        (awaited, Effect::Nothing)
    }

    /// A frame of the slave.
    ///
    /// # Errors
    /// [`Violation`] if the slave must not send it now.
    pub fn answered(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let response = Response::read(frame.data()).ok().filter(|_| frame.len() == 8);
        if now < self.grace && response.is_some() {
            self.grace = Timestamp::ZERO;
            return Ok(());
        }
        let awaited = self.awaited;
        let fits = match (awaited, response) {
            (Awaited::Anything, Some(_)) => true,
            (Awaited::Exactly(expected), Some(actual)) => same(expected, actual) && is_canonical(frame, actual),
            (Awaited::Timing { supported }, Some(actual)) => timing_fits(supported, actual),
            (Awaited::Stored, Some(actual @ Response::Configured { command, .. })) => {
                command == ConfigureCommand::Store && !actual.says_too_much() && is_canonical(frame, actual)
            }
            _ => false,
        };
        coverage.lss(self.asked.0, self.asked.1, true);
        if awaited != Awaited::Anything {
            self.awaited = Awaited::Nothing;
        }
        self.due = Timestamp::MAX;
        if fits {
            return Ok(());
        }
        let expected = self.text(awaited);
        let actual = response.map_or_else(|| format!("{frame}"), |response| format!("{response} ({frame})"));
        Err(violation(self.property, self.rule, expected, actual, now))
    }

    fn text(&self, awaited: Awaited) -> String {
        match awaited {
            Awaited::Nothing => format!("no answer to \"{}\" in this state", self.rule),
            Awaited::Anything => "an answer of eight bytes, or none".to_owned(),
            Awaited::Exactly(response) => format!("{response}, reserved bytes 0"),
            Awaited::Stored => "store configuration: successful, or why not".to_owned(),
            Awaited::Timing { supported: Some(true) } => "configure bit timing: successful".to_owned(),
            Awaited::Timing { supported: Some(false) } => "configure bit timing: bit rate not supported".to_owned(),
            Awaited::Timing { supported: None } => "configure bit timing: successful or not supported".to_owned(),
        }
    }

    /// Something is overdue.
    ///
    /// # Errors
    /// [`Violation`]: silence where an answer is due.
    pub fn expire(&mut self, now: Timestamp) -> Result<(), Violation> {
        if now < self.due {
            return Ok(());
        }
        self.due = Timestamp::MAX;
        let awaited = std::mem::replace(&mut self.awaited, Awaited::Nothing);
        Err(silence(self.property, self.rule, self.text(awaited), now))
    }
}

/// An error is told by code 1, or by 255 with a code of the manufacturer.
fn same(expected: Response, actual: Response) -> bool {
    match (expected, actual) {
        (
            Response::Configured { command, error: 1, .. },
            Response::Configured { command: actual, error: 1 | 255, .. },
        ) => command == actual,
        _ => expected == actual,
    }
}

fn is_canonical(frame: &Frame, response: Response) -> bool {
    let mut bytes = [0; 8];
    response.emit(&mut bytes);
    bytes == frame.bytes()
}

fn timing_fits(supported: Option<bool>, actual: Response) -> bool {
    match (supported, actual) {
        (Some(true), Response::Configured { command: ConfigureCommand::BitTiming, error, .. }) => error == 0,
        (Some(false), Response::Configured { command: ConfigureCommand::BitTiming, error, .. }) => {
            matches!(error, 1 | 255)
        }
        (None, Response::Configured { command: ConfigureCommand::BitTiming, error, .. }) => {
            matches!(error, 0 | 1 | 255)
        }
        _ => false,
    }
}
