//! A model of the LSS slave of CiA 305, seen from outside.

use super::Violation;
use super::layer_setting::{Effect, InOrder, LayerSetting, Mode, Options, includes};
use super::nmt::Phase;
use crate::Knowledge;
use crate::coverage::{Coverage, LssState};
use crate::property::Property;
use crate::stimulus::Start;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{Dialect, Numbered};
use canvass_analyzer::wire::lss::{Bound, ConfigureCommand, Lss, Part, Request, Response};
use canvass_traces::{Duration, Frame, Timestamp};

/// The node-ID of a device that is not configured.
const NONE: u8 = 255;

/// Maximum time of the answer to "store configuration": writing non-volatile memory takes seconds on some devices.
const STORING: Duration = Duration::from_secs(10);

/// The value of the bit check that begins Fastscan anew.
const BEGIN: u8 = 128;

/// The answers that are allowed.
type Awaited = super::layer_setting::Awaited<Lss, OneOf>;

#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum OneOf {
    /// Store configuration succeeds or fails.
    Stored,
    /// Configure bit timing succeeds or fails, depending on whether the device supports the bit rate.
    Timing { supported: Option<bool> },
}

/// The model of the slave.
#[derive(Clone, Debug)]
pub(super) struct Slave {
    pub at: LayerSetting<Lss, OneOf>,
    /// Whether the device has no active node-ID.
    unconfigured: bool,
    pending: Option<u8>,
    /// Whether the device began without node-ID and was given one, which a reset may take away again.
    given: bool,
    timing_changed: bool,
    /// The part that Fastscan compares. `None`: Fastscan has not begun, or the part is not known.
    scanning: Option<u8>,
    /// The time until which an answer that was on its way at a reset may come.
    grace: Timestamp,
}

impl Slave {
    pub const fn new() -> Self {
        Self {
            at: LayerSetting::new(Mode::Waiting),
            unconfigured: false,
            pending: None,
            given: false,
            timing_changed: false,
            scanning: None,
            grace: Timestamp::ZERO,
        }
    }

    pub fn start(&mut self, start: Start) {
        *self = Self { unconfigured: start == Start::Unconfigured, ..Self::new() };
    }

    /// Handles a reset of the NMT slave. The standard leaves open whether LSS keeps its state. An answer that was due
    /// may have been on its way and come until `grace`.
    pub fn reset_communication(&mut self, grace: Timestamp) {
        let grace = if self.at.awaited == Awaited::Nothing { Timestamp::ZERO } else { grace };
        let at = LayerSetting::new(Mode::Unsure);
        *self = Self { at, unconfigured: self.unconfigured, grace, ..Self::new() };
    }

    /// Whether a reset changes the node-ID of the device.
    pub fn moves(&self, knowledge: &Knowledge) -> bool {
        self.pending.is_some_and(|node| node != knowledge.node.raw()) || self.timing_changed || self.given
    }

    pub(super) fn class(&self) -> LssState {
        match self.at.class() {
            LssState::Configuration => LssState::Configuration,
            _ if self.unconfigured && self.scanning.is_some() => LssState::Scanning,
            _ if self.unconfigured => LssState::Unconfigured,
            class => class,
        }
    }

    /// Whether the slave is in waiting state, and no configured value waits for a reset.
    pub fn is_at_rest(&self) -> bool {
        self.at.is_at_rest() && self.is_settled()
    }

    /// Whether no configured value waits for a reset.
    pub(crate) fn is_settled(&self) -> bool {
        self.pending.is_none() && !self.given && !self.timing_changed
    }

    /// Continues with the slave in waiting state. The progress of addressing is not known.
    pub fn go_on(&mut self) {
        *self = Self { unconfigured: self.unconfigured, ..Self::new() };
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
        let class = self.class();
        let (awaited, effect) = self.judge(frame, knowledge, phase);
        let is_store = matches!(Request::read(frame.data()), Ok(Request::StoreConfiguration));
        let patience = if is_store { STORING } else { knowledge.patience.answer };
        self.at.asked((class, frame), awaited, now + patience, coverage);
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
        let Some(request) = self.at.read(frame) else { return (Awaited::Anything, Effect::Nothing) };
        self.at.property = Property::LegalLss;
        let (awaited, effect) = self.answer(request, knowledge);
        match awaited {
            // If LSS may not work, the slave need not answer, and the effect of the request is not known.
            Awaited::Exactly(_) | Awaited::OneOf(_) if !works => {
                self.at.mode = Mode::Unsure;
                (Awaited::Anything, effect)
            }
            awaited if !works && matches!(request, Request::SwitchGlobal { .. }) => {
                self.at.mode =
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
            Request::SwitchSelective { part, value } => nothing(self.select(part, value, knowledge)),
            Request::IdentifyRemote { bound, value } => nothing(self.identify(bound, value, knowledge)),
            Request::IdentifyNonConfigured => {
                self.at.rule = "identify non-configured remote slave";
                nothing(self.only_if(self.unconfigured && self.pending.is_none(), Response::NonConfigured))
            }
            Request::Fastscan { id, bit_check, sub, next } => {
                self.at.rule = "Fastscan";
                self.at.property = Property::Fastscan;
                nothing(self.scan(id, bit_check, sub, next, knowledge))
            }
            Request::Unknown { .. } => {
                self.at.rule = "unknown command specifier";
                nothing(Awaited::Nothing)
            }
            _ => self.configure(request, knowledge),
        }
    }

    fn only_if(&self, condition: bool, response: Response) -> Awaited {
        match (condition, self.pending) {
            (true, _) => Awaited::Exactly(response),
            // CiA 305 leaves open what a pending node-ID means for a device that has no active node-ID.
            (false, Some(_)) => Awaited::Anything,
            (false, None) => Awaited::Nothing,
        }
    }

    fn switch(&mut self, mode: u8, knowledge: &Knowledge) -> (Awaited, Effect) {
        let node = knowledge.node.raw();
        self.at.rule = "switch state global";
        let left = self.at.mode != Mode::Waiting;
        self.at.switch(mode);
        if mode != 0 {
            return (Awaited::Nothing, Effect::Nothing);
        }
        // A device that restarts by itself also uses its new bit rate, which the bus may not have.
        let restarts = knowledge.services.lss_restarts != Some(false);
        match self.pending {
            _ if left && restarts && self.timing_changed => (Awaited::Nothing, Effect::Lost),
            Some(own)
                if own == node && left && (self.unconfigured || knowledge.services.lss_restarts == Some(true)) =>
            {
                self.given |= self.unconfigured;
                self.unconfigured = false;
                self.pending = None;
                (Awaited::Nothing, Effect::Boots)
            }
            // According to CiA 305 the node-ID changes at the next reset communication.
            Some(_) if !self.unconfigured && knowledge.services.lss_restarts == Some(false) => {
                (Awaited::Nothing, Effect::Nothing)
            }
            // It depends on the device when its new node-ID takes effect.
            Some(_) if left => (Awaited::Nothing, Effect::Lost),
            _ => (Awaited::Nothing, Effect::Nothing),
        }
    }

    /// All four parts have to equal the slave's own values, in order. Some slaves accept another order if the serial
    /// number comes last.
    fn select(&mut self, part: Part, value: u32, knowledge: &Knowledge) -> Awaited {
        self.at.rule = "switch state selective";
        let Some(address) = knowledge.address else { return Awaited::Anything };
        if self.at.mode == Mode::Configuration {
            // Selective addressing is a service of the waiting state. A slave in configuration state may confirm it
            // again.
            return if part.is_last() { Awaited::Anything } else { Awaited::Nothing };
        }
        self.at.selected.came(part, address[part as usize] == value);
        if !part.is_last() {
            return Awaited::Nothing;
        }
        let was = self.at.mode;
        match self.at.selected.end::<Part>() {
            Some(true) => self.at.mode = Mode::Configuration,
            Some(false) => {}
            None => self.at.mode = Mode::Unsure,
        }
        match (was, self.at.mode) {
            (Mode::Waiting, Mode::Configuration) => Awaited::Exactly(Response::Switched),
            (Mode::Waiting, Mode::Waiting) => Awaited::Nothing,
            // A slave that already is in configuration state need not answer.
            _ => Awaited::Anything,
        }
    }

    fn identify(&mut self, bound: Bound, value: u32, knowledge: &Knowledge) -> Awaited {
        self.at.rule = "identify remote slave";
        let Some(address) = knowledge.address else { return Awaited::Anything };
        let (part, limit) = Lss::limits(bound);
        self.at.identify(bound, includes::<Lss>(limit, value, address[part as usize]))
    }

    fn scan(&mut self, id: u32, bit_check: u8, sub: u8, next: u8, knowledge: &Knowledge) -> Awaited {
        if (!self.unconfigured || self.at.mode == Mode::Configuration) && self.pending.is_none() {
            return Awaited::Nothing;
        }
        if self.at.mode == Mode::Unsure || self.pending.is_some() {
            // The scan may have begun or gone on, or neither.
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
        // Without a beginning the slave may be at its first part.
        let Some(scanning) = self.scanning else {
            if sub == 3 && bit_check == 0 {
                self.at.mode = Mode::Unsure;
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
                    self.at.mode = Mode::Configuration;
                    self.scanning = None;
                }
                // The scan goes back before its last part. It must not complete; the standard leaves open where it goes
                // on.
                (_, next) if next != sub + 1 => self.scanning = None,
                _ => {}
            }
        }
        Awaited::Exactly(Response::Identified)
    }

    fn configure(&mut self, request: Request, knowledge: &Knowledge) -> (Awaited, Effect) {
        self.at.rule = match request {
            Request::ConfigureNodeId { .. } => "configure node-ID",
            Request::ConfigureBitTiming { .. } => "configure bit timing",
            Request::ActivateBitTiming { .. } => "activate bit timing",
            Request::StoreConfiguration => "store configuration",
            Request::InquireNodeId => "inquire node-ID",
            _ => "inquire",
        };
        match self.at.mode {
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
                Awaited::OneOf(OneOf::Timing { supported })
            }
            Request::ActivateBitTiming { .. } => return (Awaited::Anything, Effect::Lost),
            Request::StoreConfiguration => {
                // The node-ID after the next reset is then not known.
                self.given = true;
                Awaited::OneOf(OneOf::Stored)
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
                    // The standard leaves open which of the two node-IDs a slave reports.
                    Some(_) => Awaited::Anything,
                    None => Awaited::Exactly(Response::NodeId(active)),
                }
            }
            _ => Awaited::Nothing,
        };
        (awaited, Effect::Nothing)
    }

    /// Checks a frame of the slave.
    ///
    /// # Errors
    /// [`Violation`] if the slave must not send it now.
    pub fn answered(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        if now < self.grace && frame.len() == 8 {
            self.grace = Timestamp::ZERO;
            return Ok(());
        }
        self.at.answered(now, frame, coverage)
    }
}

impl Options<Lss> for OneOf {
    fn contain(self, response: Response, is_clean: bool) -> bool {
        let Response::Configured { command, error, .. } = response else { return false };
        match (self, command) {
            (Self::Stored, ConfigureCommand::Store) => !response.says_too_much() && is_clean,
            (Self::Timing { supported: Some(true) }, ConfigureCommand::BitTiming) => error == 0,
            (Self::Timing { supported: Some(false) }, ConfigureCommand::BitTiming) => matches!(error, 1 | 255),
            (Self::Timing { supported: None }, ConfigureCommand::BitTiming) => matches!(error, 0 | 1 | 255),
            _ => false,
        }
    }

    fn text(self) -> String {
        let text = match self {
            Self::Stored => "store configuration: successful, or why not",
            Self::Timing { supported: Some(true) } => "configure bit timing: successful",
            Self::Timing { supported: Some(false) } => "configure bit timing: bit rate not supported",
            Self::Timing { supported: None } => "configure bit timing: successful or not supported",
        };
        text.to_owned()
    }
}
