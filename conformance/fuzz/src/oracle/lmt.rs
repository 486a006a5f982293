//! A model of the LMT slave of CiA DS-205, seen from outside.
//!
//! Only configurations, inquiries and "identify remote slave" are answered. Configured values take effect after the
//! power was switched off and on.

use super::Violation;
use super::layer_setting::{Effect, InOrder, LayerSetting, Mode, Options, includes};
use super::nmt::Phase;
use crate::Knowledge;
use crate::coverage::Coverage;
use crate::knowledge::LmtAddress;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{Dialect, Limit, Numbered};
use canvass_analyzer::wire::lmt::{Bound, ConfigureCommand, Lmt, Part, Request, Response, Seven};
use canvass_traces::{Frame, Timestamp};

/// The answers that are allowed.
type Awaited = super::layer_setting::Awaited<Lmt, OneOf>;

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum OneOf {
    /// A configuration that succeeds.
    Success(ConfigureCommand),
    /// A configuration that fails, with any code.
    Refusal(ConfigureCommand),
    /// A part of the address whose value is not known yet.
    Part(Part),
}

/// The model of the slave.
#[derive(Clone, Debug)]
pub(super) struct Slave {
    pub at: LayerSetting<Lmt, OneOf>,
    /// The serial number that the device itself has reported, if it is not known otherwise.
    serial: Option<Seven>,
}

impl Slave {
    pub const fn new() -> Self {
        Self { at: LayerSetting::new(Mode::Waiting), serial: None }
    }

    /// Handles power-on of the device.
    pub const fn start(&mut self) {
        self.at = LayerSetting::new(Mode::Waiting);
    }

    /// Handles a reset of the NMT slave. The standard leaves open whether LMT keeps its mode.
    pub const fn reset_communication(&mut self) {
        self.at = LayerSetting::new(Mode::Unsure);
        self.at.awaited = Awaited::Anything;
    }

    /// Continues with the slave in operation mode. The progress of addressing is not known.
    pub fn go_on(&mut self) {
        self.at = LayerSetting::new(Mode::Waiting);
        (self.at.selected, self.at.identified) = (InOrder::UNKNOWN, InOrder::UNKNOWN);
    }

    /// Applies a request of the fuzzer.
    pub fn asked(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        knowledge: &Knowledge,
        phase: Phase,
        coverage: &mut Coverage,
    ) -> Effect {
        let class = self.at.class();
        let (awaited, effect) = self.judge(frame, knowledge, phase);
        self.at.asked((class, frame), awaited, now + knowledge.patience.answer, coverage);
        effect
    }

    fn judge(&mut self, frame: &Frame, knowledge: &Knowledge, phase: Phase) -> (Awaited, Effect) {
        if matches!(phase, Phase::Booting | Phase::Unsure) {
            return (Awaited::Anything, Effect::Lost);
        }
        let Some(request) = self.at.read(frame) else { return (Awaited::Anything, Effect::Nothing) };
        match request {
            Request::SwitchGlobal { mode } => (self.switch(mode), Effect::Nothing),
            Request::SwitchSelective { part, value } => (self.select(part, value, knowledge), Effect::Nothing),
            Request::IdentifyRemote { bound, value } => (self.identify(bound, value, knowledge), Effect::Nothing),
            Request::Unknown { .. } => {
                self.at.rule = "unknown LMT command specifier";
                (Awaited::Nothing, Effect::Nothing)
            }
            _ => self.configure(request, knowledge),
        }
    }

    fn switch(&mut self, mode: u8) -> Awaited {
        self.at.rule = "switch mode global";
        self.at.switch(mode);
        Awaited::Nothing
    }

    /// All three parts have to equal the slave's own values, in order. A successful selection is not answered either.
    fn select(&mut self, part: Part, value: Seven, knowledge: &Knowledge) -> Awaited {
        self.at.rule = "switch mode selective";
        if self.at.mode == Mode::Configuration {
            return Awaited::Nothing;
        }
        if part == Part::ManufacturerName {
            // This part begins an address, whether it fits or not.
            self.at.selected = InOrder::NONE;
        }
        match knowledge.lmt.and_then(|address| self.own(part, address)) {
            Some(own) => self.at.selected.came(part, own == value),
            None => self.at.selected = InOrder::UNKNOWN,
        }
        if part.is_last() {
            match self.at.selected.end::<Part>() {
                Some(true) => self.at.mode = Mode::Configuration,
                Some(false) => {}
                None => self.at.mode = Mode::Unsure,
            }
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

    /// The names have to equal the slave's own names, and the serial number has to be within the bounds.
    fn identify(&mut self, bound: Bound, value: Seven, knowledge: &Knowledge) -> Awaited {
        self.at.rule = "identify remote slave";
        let (part, limit) = Lmt::limits(bound);
        let Some(own) = knowledge.lmt.and_then(|address| self.own(part, address)) else {
            self.at.identified = InOrder::UNKNOWN;
            return Awaited::Anything;
        };
        // A value with a digit that does not exist can't be compared with serial numbers.
        let is_number = value.0.iter().all(|byte| byte >> 4 < 10 && byte & 0xF < 10);
        if limit != Limit::Equal && !is_number {
            self.at.identified = InOrder::UNKNOWN;
        }
        if bound == Bound::ManufacturerName {
            self.at.identified = InOrder::NONE;
        }
        self.at.identify(bound, includes::<Lmt>(limit, value, own))
    }

    fn configure(&mut self, request: Request, knowledge: &Knowledge) -> (Awaited, Effect) {
        self.at.rule = match request {
            Request::ConfigureNodeId { .. } => "configure NMT address",
            Request::ConfigureBitTiming { .. } => "configure bit timing of LMT",
            Request::ActivateBitTiming { .. } => "activate bit timing of LMT",
            Request::StoreConfiguration => "store configuration of LMT",
            _ => "inquire LMT address",
        };
        match self.at.mode {
            Mode::Configuration => {}
            Mode::Waiting => return (Awaited::Nothing, Effect::Nothing),
            Mode::Unsure => {
                let changes = matches!(request, Request::ActivateBitTiming { .. });
                return (Awaited::Anything, if changes { Effect::Lost } else { Effect::Nothing });
            }
        }
        let success = |command| Awaited::OneOf(OneOf::Success(command));
        let refusal = |command| Awaited::OneOf(OneOf::Refusal(command));
        let awaited = match request {
            Request::ConfigureNodeId { node_id: 1..=127 } => success(ConfigureCommand::NodeId),
            Request::ConfigureNodeId { .. } => refusal(ConfigureCommand::NodeId),
            Request::ConfigureBitTiming { table, index } => {
                let exists = table == 0 && knowledge.services.lmt_bit_rates.contains(&index);
                let command = ConfigureCommand::BitTiming;
                if exists { success(command) } else { refusal(command) }
            }
            Request::StoreConfiguration => success(ConfigureCommand::Store),
            Request::Inquire { part } => match knowledge.lmt.and_then(|address| self.own(part, address)) {
                Some(value) => Awaited::Exactly(Response::Part { part, value }),
                None => Awaited::OneOf(OneOf::Part(part)),
            },
            _ => return (Awaited::Anything, Effect::Lost),
        };
        (awaited, Effect::Nothing)
    }

    /// Checks a frame of the slave.
    ///
    /// # Errors
    /// [`Violation`] if the slave must not send it now.
    pub fn answered(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let awaits_part = matches!(self.at.awaited, Awaited::OneOf(OneOf::Part(_)));
        if awaits_part && let Ok(Response::Part { value, .. }) = Response::read(frame.data()) {
            self.serial = Some(value);
        }
        self.at.answered(now, frame, coverage)
    }
}

impl Options<Lmt> for OneOf {
    fn contain(self, response: Response, is_clean: bool) -> bool {
        match (self, response) {
            (Self::Success(expected), Response::Configured { command, error: 0, specific: 0 }) => {
                command == expected && is_clean
            }
            (Self::Refusal(expected), Response::Configured { command, error: 1.., .. }) => command == expected,
            (Self::Part(expected), Response::Part { part, .. }) => part == expected,
            _ => false,
        }
    }

    fn text(self) -> String {
        match self {
            Self::Success(command) => format!("{}: successful", command.name::<Lmt>()),
            Self::Refusal(command) => format!("{}: an error code", command.name::<Lmt>()),
            Self::Part(part) => format!("the {}", part.name()),
        }
    }
}
