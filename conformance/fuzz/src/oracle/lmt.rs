//! The LMT slave as CiA DS-205 demands it, seen from outside.
//!
//! Only configurations, inquiries and "identify remote slave" are answered; what is configured acts after power-off.

use super::nmt::Phase;
use super::{Violation, silence, violation};
use crate::Knowledge;
use crate::coverage::{Coverage, LssCommand, LssState};
use crate::knowledge::LmtAddress;
use crate::property::Property;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lmt::{Bound, ConfigureCommand, Part, Request, Response, Seven};
use canvass_traces::{Frame, Timestamp};

/// What a request does beyond the slave.
pub(super) use super::lss::Effect;

#[derive(Clone, Copy, PartialEq, Debug)]
enum Awaited {
    Nothing,
    /// The standard leaves it open.
    Anything,
    Exactly(Response),
    /// A configuration that succeeds.
    Success(ConfigureCommand),
    /// A configuration that fails, with whatever code.
    Refusal(ConfigureCommand),
    /// A part of an address that is not known yet.
    Part(Part),
}

/// Which of its two modes the slave is in.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Mode {
    Operation,
    Configuration,
    /// After a request that the standard leaves open.
    Unsure,
}

/// The slave.
#[derive(Clone, Debug)]
pub(super) struct Slave {
    mode: Mode,
    /// Parts of the address that have matched in order; `None`: the order was another one.
    selected: Option<u8>,
    /// Bounds that have matched in order; `None`: the order was another one.
    identified: Option<u8>,
    awaited: Awaited,
    rule: &'static str,
    due: Timestamp,
    asked: (LssState, LssCommand),
    /// The serial number that the device itself has told, where nobody else has.
    serial: Option<Seven>,
}

impl Slave {
    pub const fn new() -> Self {
        Self {
            mode: Mode::Operation,
            selected: Some(0),
            identified: Some(0),
            awaited: Awaited::Nothing,
            rule: "",
            due: Timestamp::MAX,
            asked: (LssState::Waiting, LssCommand::Unknown),
            serial: None,
        }
    }

    /// The device was switched on.
    pub const fn start(&mut self) {
        *self = Self { serial: self.serial, ..Self::new() };
    }

    /// A reset of the NMT slave: whether LMT goes on in its mode, the standard leaves open.
    pub const fn reset_communication(&mut self) {
        *self = Self { mode: Mode::Unsure, serial: self.serial, awaited: Awaited::Anything, ..Self::new() };
    }

    /// The slave is in operation; which parts of an address have matched is not known.
    pub const fn go_on(&mut self) {
        *self = Self { serial: self.serial, selected: None, identified: None, ..Self::new() };
    }

    fn class(&self) -> LssState {
        match self.mode {
            Mode::Configuration => LssState::Configuration,
            _ if self.selected.is_some_and(|parts| parts > 0) => LssState::Selecting,
            _ => LssState::Waiting,
        }
    }

    /// Whether the slave is in operation, and awaits nothing.
    pub fn is_at_rest(&self) -> bool {
        self.mode == Mode::Operation && self.awaited == Awaited::Nothing
    }

    pub fn due(&self) -> Option<Timestamp> {
        (self.due < Timestamp::MAX).then_some(self.due)
    }

    /// Whether anything may come.
    pub fn is_open(&self) -> bool {
        self.awaited == Awaited::Anything
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
        self.asked = (self.class(), LssCommand::of_lmt(frame));
        let overlaps = self.due < Timestamp::MAX;
        let (mut awaited, effect) = self.judge(frame, knowledge, phase);
        if overlaps {
            (awaited, self.mode) = (Awaited::Anything, Mode::Unsure);
        }
        let required = !matches!(awaited, Awaited::Nothing | Awaited::Anything);
        if !required {
            coverage.lss(self.asked.0, self.asked.1, false);
        }
        self.due = if required { now + knowledge.patience.answer } else { Timestamp::MAX };
        self.awaited = awaited;
        effect
    }

    fn judge(&mut self, frame: &Frame, knowledge: &Knowledge, phase: Phase) -> (Awaited, Effect) {
        if matches!(phase, Phase::Booting | Phase::Unsure) {
            return (Awaited::Anything, Effect::Lost);
        }
        let Some(request) = Request::read(frame.data()).ok().filter(|_| frame.len() == 8) else {
            // A slave may fill up what is too short.
            (self.mode, self.selected, self.identified) = (Mode::Unsure, None, None);
            return (Awaited::Anything, Effect::Nothing);
        };
        match request {
            Request::SwitchGlobal { mode } => (self.switch(mode), Effect::Nothing),
            Request::SwitchSelective { part, value } => (self.select(part, value, knowledge), Effect::Nothing),
            Request::IdentifyRemote { bound, value } => (self.identify(bound, value, knowledge), Effect::Nothing),
            Request::Unknown { .. } => {
                self.rule = "unknown LMT command specifier";
                (Awaited::Nothing, Effect::Nothing)
            }
            _ => self.configure(request, knowledge),
        }
    }

    const fn switch(&mut self, mode: u8) -> Awaited {
        self.rule = "switch mode global";
        self.selected = Some(0);
        self.mode = match mode {
            0 => Mode::Operation,
            1 => Mode::Configuration,
            // Reserved.
            _ => Mode::Unsure,
        };
        Awaited::Nothing
    }

    /// The three parts, each equal, in order. Success is silent too.
    fn select(&mut self, part: Part, value: Seven, knowledge: &Knowledge) -> Awaited {
        self.rule = "switch mode selective";
        if self.mode == Mode::Configuration {
            return Awaited::Nothing;
        }
        let own = knowledge.lmt.and_then(|address| self.own(part, address));
        let position = part as u8;
        self.selected = match (own, self.selected) {
            (None, _) => None,
            (Some(own), _) if position == 0 => Some(u8::from(own == value)),
            (Some(own), Some(parts)) if parts == position => Some(if own == value { parts + 1 } else { 0 }),
            (_, None) => None,
            // A part again, or out of order: it may count or begin anew.
            (Some(own), Some(parts)) if own == value && parts > 0 => None,
            _ => Some(0),
        };
        if part == Part::SerialNumber {
            match self.selected {
                Some(3) => self.mode = Mode::Configuration,
                None => self.mode = Mode::Unsure,
                Some(_) => {}
            }
            self.selected = Some(0);
        }
        Awaited::Nothing
    }

    fn own(&self, part: Part, address: LmtAddress) -> Option<Seven> {
        match part {
            Part::ManufacturerName => Some(address.manufacturer_name),
            Part::ProductName => Some(address.product_name),
            Part::SerialNumber => address.serial_number.or(self.serial),
        }
    }

    /// The names have to be equal, the serial number within the bounds.
    fn identify(&mut self, bound: Bound, value: Seven, knowledge: &Knowledge) -> Awaited {
        self.rule = "identify remote slave";
        let part = match bound {
            Bound::ManufacturerName => Part::ManufacturerName,
            Bound::ProductName => Part::ProductName,
            Bound::SerialLow | Bound::SerialHigh => Part::SerialNumber,
        };
        let Some(own) = knowledge.lmt.and_then(|address| self.own(part, address)) else {
            self.identified = None;
            return Awaited::Anything;
        };
        // Digits in their order: bytes compare as the number does. What is no digit has no place among them.
        let is_number = value.0.iter().all(|byte| byte >> 4 < 10 && byte & 0xF < 10);
        let fits = match bound {
            Bound::ManufacturerName | Bound::ProductName => value == own,
            _ if !is_number => {
                self.identified = None;
                false
            }
            Bound::SerialLow => value.0 <= own.0,
            Bound::SerialHigh => value.0 >= own.0,
        };
        let position = bound as u8;
        self.identified = match self.identified {
            _ if position == 0 => Some(u8::from(fits)),
            Some(bounds) if bounds == position => Some(if fits { bounds + 1 } else { 0 }),
            Some(bounds) if fits && bounds > 0 => None,
            Some(_) => Some(0),
            None => None,
        };
        if bound != Bound::SerialHigh {
            return Awaited::Nothing;
        }
        match self.identified.replace(0) {
            Some(4) => Awaited::Exactly(Response::Identified),
            Some(_) => Awaited::Nothing,
            None => Awaited::Anything,
        }
    }

    fn configure(&mut self, request: Request, knowledge: &Knowledge) -> (Awaited, Effect) {
        self.rule = match request {
            Request::ConfigureNmtAddress { .. } => "configure NMT address",
            Request::ConfigureBitTiming { .. } => "configure bit timing of LMT",
            Request::ActivateBitTiming { .. } => "activate bit timing of LMT",
            Request::StoreConfiguration => "store configuration of LMT",
            _ => "inquire LMT address",
        };
        match self.mode {
            Mode::Configuration => {}
            Mode::Operation => return (Awaited::Nothing, Effect::Nothing),
            Mode::Unsure => {
                let changes = matches!(request, Request::ActivateBitTiming { .. });
                return (Awaited::Anything, if changes { Effect::Lost } else { Effect::Nothing });
            }
        }
        let awaited = match request {
            Request::ConfigureNmtAddress { node_id: 1..=127 } => Awaited::Success(ConfigureCommand::NmtAddress),
            Request::ConfigureNmtAddress { .. } => Awaited::Refusal(ConfigureCommand::NmtAddress),
            Request::ConfigureBitTiming { table, index } => {
                let exists = table == 0 && knowledge.services.lmt_bit_rates.contains(&index);
                let command = ConfigureCommand::BitTiming;
                if exists { Awaited::Success(command) } else { Awaited::Refusal(command) }
            }
            Request::StoreConfiguration => Awaited::Success(ConfigureCommand::Store),
            Request::Inquire { part } => match knowledge.lmt.and_then(|address| self.own(part, address)) {
                Some(value) => Awaited::Exactly(Response::Part { part, value }),
                None => Awaited::Part(part),
            },
            _ => return (Awaited::Anything, Effect::Lost),
        };
        (awaited, Effect::Nothing)
    }

    /// A frame of the slave.
    ///
    /// # Errors
    /// [`Violation`] if the slave must not send it now.
    pub fn answered(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let response = Response::read(frame.data()).ok().filter(|_| frame.len() == 8);
        let awaited = self.awaited;
        let is_canonical = |response: Response| {
            let mut bytes = [0; 8];
            response.emit(&mut bytes);
            bytes == frame.bytes()
        };
        let fits = match (awaited, response) {
            (Awaited::Anything, Some(_)) => true,
            (Awaited::Exactly(expected), Some(actual)) => actual == expected && is_canonical(actual),
            (Awaited::Success(command), Some(actual)) => {
                actual == Response::Configured { command, error: 0, specific: 0 } && is_canonical(actual)
            }
            (Awaited::Refusal(expected), Some(Response::Configured { command, error, .. })) => {
                command == expected && error != 0
            }
            (Awaited::Part(expected), Some(Response::Part { part, value })) => {
                self.serial = Some(value);
                part == expected
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
        let actual = response.map_or_else(|| format!("{frame}"), |response| format!("{response} ({frame})"));
        Err(violation(Property::LegalLss, self.rule, self.text(awaited), actual, now))
    }

    fn text(&self, awaited: Awaited) -> String {
        match awaited {
            Awaited::Nothing => format!("no answer to \"{}\" in this mode", self.rule),
            Awaited::Anything => "an answer of eight bytes, or none".to_owned(),
            Awaited::Exactly(response) => format!("{response}, reserved bytes 0"),
            Awaited::Success(command) => format!("{}: successful", command.name()),
            Awaited::Refusal(command) => format!("{}: an error code", command.name()),
            Awaited::Part(part) => format!("the {}", part.name()),
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
        Err(silence(Property::LegalLss, self.rule, self.text(awaited), now))
    }
}
