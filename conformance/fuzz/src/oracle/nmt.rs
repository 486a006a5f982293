//! A model of the NMT slave and its error control: states by command, boot-up, heartbeat and guarding.

use super::expected_values::{ExpectedValues, Extent};
use super::{Served, Violation, violation};
use crate::Knowledge;
use crate::property::Property;
use crate::stimulus::Start;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{Emcy, EmcyCode};
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_analyzer::wire::nmt::{Command, Nmt};
use canvass_traces::{Duration, Frame, Timestamp};

/// After a command, frames that were already on their way may come for this time plus the measuring jitter.
pub(super) const GRACE: Duration = Duration::from_millis(3);

/// The NMT state of the device, as far as it is known.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Phase {
    /// Without node-ID.
    Unconfigured,
    /// Between reset and boot-up.
    Booting,
    PreOperational,
    Operational,
    Stopped,
    /// Pre-operational or operational: some devices start themselves after the boot-up message (1F80h, 6000h).
    Running,
    /// Any state, after a frame that the standard does not describe.
    Unsure,
}

impl Phase {
    /// The name of the phase.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unconfigured => "without node-ID",
            Self::Booting => "initialisation",
            Self::PreOperational => "pre-operational",
            Self::Operational => "operational",
            Self::Stopped => "stopped",
            Self::Running => "pre-operational or operational",
            Self::Unsure => "any NMT state",
        }
    }
}

/// Number of sub-indexes of 1029h that the model reads: 1 for communication errors, the others for errors of the device
/// profile and the manufacturer.
const ERROR_CLASSES: u8 = 16;

/// The change that a frame caused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Change {
    None,
    State,
    Reset(Extent),
}

/// The model of the slave.
#[derive(Clone, Debug)]
pub(crate) struct Slave {
    phase: Phase,
    /// The phase before the time [`Slave::changed`].
    before: Phase,
    changed: Timestamp,
    /// The time at which the boot-up message is overdue.
    boot_due: Timestamp,
    /// The time at which the answer to a guarding request is overdue.
    guard_due: Timestamp,
    /// Number of guarding requests that may be answered.
    guard_open: u8,
    /// The time of the last guarding request.
    guarded: Timestamp,
    /// The toggle bit of the next guarding answer. `None`: not known.
    toggle: Option<bool>,
    last_heartbeat: Option<Timestamp>,
    /// The time of the last command before the boot-up message.
    commanded_early: Timestamp,
    /// Whether the last heartbeat may have waited for the bus.
    waited: bool,
    /// A train of frames without a pause, of the device or the fuzzer: the end of its first and of its last frame.
    train: (Timestamp, Timestamp),
    /// The time until which error control may still show the state before the last change, because the bus was full.
    old_until: Timestamp,
    /// The heartbeat period, once it was written. `None`: not known.
    period: Option<Duration>,
    period_since: Timestamp,
    /// Whether the device has sent a heartbeat since its start.
    beats: bool,
    /// The time at which the heartbeat was switched off, if the device had sent one.
    switched_off: Timestamp,
    /// The tolerance of measured times.
    jitter: Duration,
    /// Time after a command during which earlier frames may still come.
    grace: Duration,
    /// Whether the device sends a boot-up message.
    announces: bool,
    /// Whether a command came while the device may still have been booting.
    early: bool,
    /// The phase to which a reported error may lead by itself, as long as the error lasts. A command "start" proves
    /// nothing then: CiA 301 (7.5.2.32) does not say when a device with an error may be operational again.
    kept_by_error: Option<Phase>,
}

impl Slave {
    pub fn new(jitter: Duration, announces: bool) -> Self {
        Self {
            jitter,
            announces,
            early: false,
            kept_by_error: None,
            grace: Duration(jitter.nanos() + GRACE.nanos()),
            phase: Phase::Unsure,
            before: Phase::Unsure,
            changed: Timestamp::ZERO,
            boot_due: Timestamp::MAX,
            guard_due: Timestamp::MAX,
            guard_open: 0,
            guarded: Timestamp::ZERO,
            toggle: Some(false),
            last_heartbeat: None,
            commanded_early: Timestamp::ZERO,
            waited: false,
            train: (Timestamp::ZERO, Timestamp::ZERO),
            old_until: Timestamp::ZERO,
            period: None,
            period_since: Timestamp::ZERO,
            beats: false,
            switched_off: Timestamp::ZERO,
        }
    }

    /// Handles a start: the device has booted, or waits for a node-ID.
    pub fn start(&mut self, now: Timestamp, start: Start) {
        *self = Self::new(self.jitter, self.announces);
        self.phase = match start {
            Start::Configured => Phase::Running,
            Start::Unconfigured => Phase::Unconfigured,
        };
        self.changed = now;
    }

    /// Continues with a device that was just commanded from any state to pre-operational.
    pub fn go_on(&mut self, now: Timestamp) {
        *self = Self::new(self.jitter, self.announces);
        (self.before, self.phase) = (Phase::Operational, Phase::PreOperational);
        self.changed = now;
        self.toggle = None;
    }

    /// Whether the device may leave operational and enter it again by itself, because of an error.
    pub(crate) const fn has_error(&self) -> bool {
        self.kept_by_error.is_some()
    }

    /// Whether the device was certainly not operational before the last change.
    pub(crate) fn comes_from_rest(&self) -> bool {
        !matches!(self.before, Phase::Operational | Phase::Running | Phase::Unsure)
    }

    /// The current phase.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Time after a command during which earlier frames may still come.
    pub fn grace(&self) -> Duration {
        self.grace
    }

    /// Whether the SDO server has to answer.
    pub(crate) fn serves_sdo(&self) -> Served {
        match self.phase {
            Phase::PreOperational | Phase::Operational | Phase::Running => Served::Yes,
            // Without a boot-up message the end of initialisation can't be seen.
            Phase::Booting if !self.announces => Served::Unsure,
            Phase::Unconfigured | Phase::Booting | Phase::Stopped => Served::No,
            Phase::Unsure => Served::Unsure,
        }
    }

    /// Whether the device may send a PDO now.
    pub(crate) fn serves_pdo(&self, now: Timestamp) -> Served {
        match self.phase {
            Phase::Operational => Served::Yes,
            Phase::Unsure | Phase::Running => Served::Unsure,
            _ if matches!(self.before, Phase::Operational | Phase::Running) && now < self.changed + self.grace => {
                Served::Unsure
            }
            _ => Served::No,
        }
    }

    /// Whether a frame may have been on its way when the reset was commanded.
    pub(crate) fn was_just_reset(&self, now: Timestamp) -> bool {
        self.phase == Phase::Booting && now < self.changed + self.grace
    }

    /// Whether the device may send an EMCY now.
    pub(crate) fn serves_emcy(&self, now: Timestamp) -> bool {
        !matches!(self.phase, Phase::Stopped) || now < self.changed + self.grace
    }

    fn enter(&mut self, now: Timestamp, phase: Phase) -> Change {
        if self.phase == phase {
            return Change::None;
        }
        self.before = self.phase;
        self.phase = phase;
        self.changed = now;
        Change::State
    }

    /// Records that the device, which has a node-ID, starts booting.
    pub fn boots(&mut self, now: Timestamp, knowledge: &Knowledge) {
        self.enter(now, Phase::Booting);
        self.changed = now;
        self.boot_due = now + knowledge.patience.boot;
        self.guard_due = Timestamp::MAX;
        self.guard_open = 0;
        self.toggle = self.announces.then_some(false);
        self.last_heartbeat = None;
        self.period = None;
        self.kept_by_error = None;
    }

    /// Applies an NMT frame of the fuzzer.
    pub fn commanded(&mut self, now: Timestamp, frame: &Frame, knowledge: &Knowledge) -> Change {
        let boots = self.phase == Phase::Booting;
        if boots && self.announces {
            self.commanded_early = now;
            if resets(frame, knowledge) {
                // A device that obeys a reset in initialisation begins it anew.
                self.boot_due = now + knowledge.patience.boot;
            }
        }
        if self.phase == Phase::Unconfigured || boots && self.announces {
            return Change::None;
        }
        let Ok(message) = Nmt::read(frame.data()) else { return Change::None };
        if message.node != 0 && message.node != knowledge.node.raw() {
            return Change::None;
        }
        if boots && !message.command.is_reset() {
            // The command may have come too early to be obeyed.
            self.early = true;
            return Change::None;
        }
        let change = match message.command {
            Command::START => match self.kept_by_error {
                Some(phase) => {
                    // The device may be operational again, so that timers begin anew.
                    self.enter(now, phase);
                    self.changed = now;
                    Change::State
                }
                None => self.enter(now, Phase::Operational),
            },
            Command::STOP => self.enter(now, Phase::Stopped),
            Command::ENTER_PRE_OPERATIONAL => self.enter(now, Phase::PreOperational),
            Command::RESET_NODE => Change::Reset(Extent::Node),
            Command::RESET_COMMUNICATION => Change::Reset(Extent::Communication),
            _ => Change::None,
        };
        if frame.len() > 2 && change != Change::None {
            // The standard defines two bytes, so the effect of a longer command is unknown.
            self.enter(now, Phase::Unsure);
            self.boot_due = Timestamp::MAX;
            return Change::State;
        }
        if let Change::Reset(_) = change {
            self.boots(now, knowledge);
        }
        change
    }

    /// Records a guarding request of the fuzzer.
    pub fn guarded(&mut self, now: Timestamp, writing: bool, expected_values: &ExpectedValues, knowledge: &Knowledge) {
        if matches!(self.phase, Phase::Unconfigured | Phase::Booting) {
            return;
        }
        if knowledge.services.guarding != Some(false) {
            self.guard_open = self.guard_open.saturating_add(1);
            self.guarded = now;
        }
        // A write under way may switch the heartbeat on.
        let known = self.phase != Phase::Unsure && !writing;
        if knowledge.services.guarding == Some(true)
            && produces_heartbeat(expected_values, knowledge) == Some(false)
            && known
        {
            self.guard_due = now + knowledge.patience.answer;
        }
    }

    /// Applies a written value that changes error control.
    pub fn configured(&mut self, now: Timestamp, change: (Multiplexer, u64)) {
        if change.0 == HEARTBEAT_TIME {
            self.period = Some(Duration::from_millis(change.1));
            self.period_since = now;
            self.switched_off = if change.1 == 0 && self.beats { now } else { Timestamp::ZERO };
            self.last_heartbeat = None;
            // The guarding request just before may have come too late.
            self.guard_due = Timestamp::MAX;
            self.guard_open = 0;
            self.toggle = None;
        }
    }

    /// Takes over a heartbeat period that was read, but whose write was not seen to succeed.
    fn learn(&mut self, now: Timestamp, expected_values: &ExpectedValues, knowledge: &Knowledge) {
        let Some(time) = expected_values.number(knowledge, HEARTBEAT_TIME.index.0, 0) else { return };
        if self.period.is_some_and(|period| period != Duration::from_millis(time)) {
            self.configured(now, (HEARTBEAT_TIME, time));
        }
    }

    /// Checks whether the device may send anything but error control now.
    ///
    /// # Errors
    /// [`Violation`] if the device must not send the frame.
    pub(crate) fn may_speak(&self, now: Timestamp, frame: &Frame, knowledge: &Knowledge) -> Result<(), Violation> {
        let silent = match self.phase {
            Phase::Unconfigured => true,
            // Without a boot-up message the end of initialisation can't be seen.
            Phase::Booting => knowledge.services.boot_up_message,
            _ => false,
        };
        if !silent || now < self.changed + self.grace {
            return Ok(());
        }
        let expected = "nothing but the boot-up message in initialisation";
        Err(violation(Property::Silent, "frame before the boot-up message", expected, format!("{frame}"), now))
    }

    /// Checks a frame with the identifier of error control.
    ///
    /// # Errors
    /// [`Violation`] if the state, the period or the toggle bit is wrong.
    pub fn shown(
        &mut self,
        now: Timestamp,
        frame: &Frame,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> Result<Change, Violation> {
        let &[byte] = frame.data() else {
            let expected = "an error control message of one byte";
            return Err(violation(Property::NmtState, "length of error control", expected, format!("{frame}"), now));
        };
        let message = ErrorControl { toggle: byte & 0x80 != 0, state: State(byte & 0x7F) };
        if self.phase == Phase::Booting && self.announces {
            return self.booted(now, message);
        }
        if self.phase == Phase::Booting {
            self.boot_due = Timestamp::MAX;
            self.enter(now, Phase::Unsure);
        }
        if message.is_boot_up() && self.announces {
            let expected = "no boot-up message: nobody reset the device";
            let property = Property::NoRestart;
            return Err(violation(property, "boot-up without reset", expected, "a boot-up message", now));
        }
        self.learn(now, expected_values, knowledge);
        let mut may_be_old = self.may_be_old(now);
        match produces_heartbeat(expected_values, knowledge) {
            // The frame may be a heartbeat: of a device that does not guard, or the last before 1017h became 0.
            Some(false) if self.guard_open > 0 && !(guards(knowledge) && now >= self.switched_off + self.grace) => {
                (self.toggle, self.guard_due) = (None, Timestamp::MAX);
            }
            Some(false) if self.guard_open > 0 => {
                may_be_old &= !self.is_fresh(now, knowledge);
                self.guard_open -= 1;
                self.guard_due = Timestamp::MAX;
                self.check_toggle(now, message)?;
            }
            Some(false) if knowledge.services.guarding == Some(false) && now >= self.period_since + self.grace => {
                let expected = "nothing: there is neither heartbeat nor guarding";
                let actual = "an error control message";
                return Err(violation(Property::NmtState, "error control without need", expected, actual, now));
            }
            Some(beats) => {
                self.beats |= beats;
                self.check_heartbeat(now, message)?;
            }
            // The frame may be a heartbeat or an answer to guarding.
            None => {
                (self.period, self.toggle) = (None, None);
                (self.guard_open, self.guard_due) = (0, Timestamp::MAX);
            }
        }
        self.check_state(now, message, may_be_old)
    }

    fn booted(&mut self, now: Timestamp, message: ErrorControl) -> Result<Change, Violation> {
        if !message.is_boot_up() {
            if now < self.changed + self.grace {
                return Ok(Change::None);
            }
            let expected = "the boot-up message, 00h";
            let actual = format!("{:02X}h", message.state.0);
            return Err(violation(Property::NmtState, "boot-up message", expected, actual, now));
        }
        self.boot_due = Timestamp::MAX;
        // The device may have obeyed a command that came while the boot-up message waited for the bus.
        let commanded_early = self.commanded_early > Timestamp::ZERO && now < self.commanded_early + self.grace;
        Ok(self.enter(now, if commanded_early { Phase::Unsure } else { Phase::Running }))
    }

    /// Notes an NMT command that is not judged: it may be a reset.
    pub fn restarted(&mut self, now: Timestamp, frame: &Frame, knowledge: &Knowledge) {
        if resets(frame, knowledge) {
            self.boots(now, knowledge);
        }
    }

    /// Notes an error control frame that is not judged: it may be the boot-up message.
    pub fn started(&mut self, now: Timestamp, frame: &Frame) {
        let is_boot_up = ErrorControl::read(frame.data()).is_ok_and(|message| message.is_boot_up());
        if self.phase == Phase::Booting && is_boot_up {
            self.boot_due = Timestamp::MAX;
            self.enter(now, Phase::Unsure);
        }
    }

    /// Handles an EMCY of the device. After an error, 1029h determines the next state, in NMT state operational at once
    /// and in the other states as soon as the device is started.
    pub(crate) fn erred(
        &mut self,
        now: Timestamp,
        emcy: &Frame,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> Change {
        let code = Emcy::read(emcy.data()).ok().and_then(|emcy| emcy.code());
        let [_, _, register, ..] = emcy.bytes();
        let next = after_error(code, expected_values, knowledge);
        match code {
            // The error register says whether an error is left.
            Some(EmcyCode(0..=0xFF)) if register == 0 => self.kept_by_error = None,
            Some(EmcyCode(0..=0xFF)) => {}
            _ => self.kept_by_error = next.or(self.kept_by_error),
        }
        match (self.phase, next) {
            (Phase::Operational, Some(next)) => self.enter(now, next),
            _ => Change::None,
        }
    }

    /// Records that the device may have left operational by itself.
    pub fn doubt(&mut self, now: Timestamp) {
        if self.phase == Phase::Operational {
            self.enter(now, Phase::Running);
        }
    }

    /// Records that the bus was full until `now`.
    pub(crate) fn held_up(&mut self, now: Timestamp) {
        if self.may_be_old(now) {
            self.old_until = now + self.grace;
        }
        self.last_heartbeat = None;
        self.period_since = now;
    }

    /// Records that a frame of the device or of the fuzzer was on the bus until `now`.
    pub fn passed(&mut self, now: Timestamp) {
        let begin = if now.since(self.train.1) > self.jitter { now } else { self.train.0 };
        self.train = (begin, now);
    }

    /// Whether frames with higher priority have followed each other without a pause since `due`. Heartbeats have the
    /// lowest priority.
    fn is_behind(&self, now: Timestamp, due: Timestamp) -> bool {
        self.train.0 <= due && now.since(self.train.1) <= self.jitter
    }

    /// Handles the end of the required silence: the device answers no earlier guarding request any more.
    pub const fn quiet(&mut self) {
        self.guard_open = 0;
    }

    fn check_toggle(&mut self, now: Timestamp, message: ErrorControl) -> Result<(), Violation> {
        let before = self.toggle.replace(!message.toggle);
        if let Some(toggle) = before.filter(|&toggle| toggle != message.toggle) {
            let expected = format!("the toggle bit {}", u8::from(toggle));
            let actual = format!("{}", u8::from(message.toggle));
            return Err(violation(Property::NmtState, "toggle bit of guarding", expected, actual, now));
        }
        Ok(())
    }

    fn check_heartbeat(&mut self, now: Timestamp, message: ErrorControl) -> Result<(), Violation> {
        if message.toggle {
            let expected = "bit 7 of a heartbeat 0";
            return Err(violation(Property::NmtState, "heartbeat with toggle bit", expected, "1", now));
        }
        let Some(period) = self.period else { return Ok(()) };
        if period > Duration(0) && now < self.period_since + self.jitter.times(2) {
            // This heartbeat may have waited for the bus. The next one comes in time.
            (self.last_heartbeat, self.waited) = (Some(now), true);
            return Ok(());
        }
        let since = self.last_heartbeat.replace(now);
        if period == Duration(0) {
            if now < self.period_since + self.jitter {
                return Ok(());
            }
            let expected = "no heartbeat: 1017h is 0";
            return Err(violation(Property::NmtState, "heartbeat although off", expected, "a heartbeat", now));
        }
        let Some(since) = since else { return Ok(()) };
        let tolerance = self.tolerance(period);
        let actual = now.since(since);
        // A heartbeat may come early after a change of state.
        let late =
            actual.nanos() > period.nanos() + tolerance.nanos() && !self.is_behind(now, since + period + tolerance);
        // The next heartbeat after a delayed heartbeat comes in time.
        let is_long = period > self.jitter.times(20);
        let early = !std::mem::take(&mut self.waited)
            && is_long
            && actual.nanos() + tolerance.nanos() < period.nanos()
            && now.since(self.changed) > period;
        if late || early {
            return Err(self.wrong_period(now, period, format!("{actual}")));
        }
        Ok(())
    }

    fn check_state(&mut self, now: Timestamp, message: ErrorControl, may_be_old: bool) -> Result<Change, Violation> {
        let shown = match message.state {
            State::PRE_OPERATIONAL => Phase::PreOperational,
            State::OPERATIONAL => Phase::Operational,
            State::STOPPED => Phase::Stopped,
            other => {
                let expected = "a state of 04h, 05h or 7Fh";
                let actual = format!("{:02X}h", other.0);
                return Err(violation(Property::NmtState, "unknown state", expected, actual, now));
            }
        };
        match self.phase {
            // A device with an error may enter and leave operational by itself.
            phase if self.kept_by_error == Some(phase) && (phase == Phase::Unsure || shown != Phase::Stopped) => {
                Ok(Change::None)
            }
            Phase::Unsure => Ok(self.enter(now, shown)),
            Phase::Running if may_be_old => Ok(Change::None),
            Phase::Running if shown != Phase::Stopped => Ok(self.enter(now, shown)),
            phase if phase == shown => Ok(Change::None),
            _ if may_be_old => Ok(Change::None),
            phase => {
                let rule = "state in error control";
                Err(violation(Property::NmtState, rule, phase.name(), shown.name(), now))
            }
        }
    }

    /// Whether a heartbeat may be from before the last change, because it has waited for the bus since then.
    fn may_be_old(&self, now: Timestamp) -> bool {
        now < (self.changed + self.grace).max(self.old_until)
    }

    /// Whether this guarding answer shows the state after the last command. The request must have come so long after
    /// the command that earlier answers would have come before, and no other guarding request may be open.
    fn is_fresh(&self, now: Timestamp, knowledge: &Knowledge) -> bool {
        self.guard_open == 1 && self.guarded >= self.changed + knowledge.patience.quiet && now >= self.old_until
    }

    /// The time at which an answer is overdue.
    pub fn due(&self) -> Option<Timestamp> {
        let due = self.boot_due.min(self.guard_due);
        (due < Timestamp::MAX).then_some(due)
    }

    /// Checks whether an answer is overdue at `now`.
    ///
    /// # Errors
    /// [`Violation`] if an answer is due and has not come.
    pub fn expire(&mut self, now: Timestamp, knowledge: &Knowledge) -> Result<(), Violation> {
        if now >= self.boot_due {
            self.boot_due = Timestamp::MAX;
            let early = std::mem::take(&mut self.early);
            self.enter(now, if early { Phase::Unsure } else { Phase::Running });
            if knowledge.services.boot_up_message {
                let expected = format!("a boot-up message within {}", knowledge.patience.boot);
                return Err(violation(Property::NmtState, "boot-up after reset", expected, "none", now));
            }
        }
        if now >= self.guard_due {
            self.guard_due = Timestamp::MAX;
            self.guard_open = 0;
            let expected = "an answer to the guarding request";
            return Err(violation(Property::NmtState, "guarding", expected, "none", now));
        }
        Ok(())
    }

    /// Checks whether heartbeats are missing.
    ///
    /// # Errors
    /// [`Violation`] if heartbeats are missing.
    pub fn finish(
        &mut self,
        now: Timestamp,
        expected_values: &ExpectedValues,
        knowledge: &Knowledge,
    ) -> Result<(), Violation> {
        if produces_heartbeat(expected_values, knowledge).is_none() {
            return Ok(());
        }
        self.learn(now, expected_values, knowledge);
        let Some(period) = self.period.filter(|period| *period > Duration(0)) else { return Ok(()) };
        let last = self.last_heartbeat.unwrap_or(self.period_since);
        let running = !matches!(self.phase, Phase::Unconfigured | Phase::Booting);
        if running && now.since(last).nanos() > period.nanos() + self.tolerance(period).nanos() {
            return Err(self.wrong_period(now, period, format!("none for {}", now.since(last))));
        }
        Ok(())
    }

    fn wrong_period(&self, now: Timestamp, period: Duration, actual: String) -> Violation {
        let expected = format!("heartbeats every {period}");
        let tolerance = self.tolerance(period);
        let least = Duration(period.nanos().saturating_sub(tolerance.nanos()));
        let wrong = violation(Property::NmtState, "period of the heartbeat", expected, actual, now);
        Violation { interval: Some(Box::new((least, period + tolerance))), ..wrong }
    }

    /// The tolerance of the heartbeat period.
    fn tolerance(&self, period: Duration) -> Duration {
        Duration((period.nanos() / 10).max(self.jitter.nanos()))
    }
}

/// The producer heartbeat time in ms.
const HEARTBEAT_TIME: Multiplexer = Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0);

/// The phase to which an error with this code leads a device in operational; `None` if it stays. Sub-index 1 of 1029h is
/// for communication errors. The device decides which class any other error belongs to.
fn after_error(code: Option<EmcyCode>, expected_values: &ExpectedValues, knowledge: &Knowledge) -> Option<Phase> {
    let communication = code.is_some_and(|code| matches!(code.0 >> 8, 0x81 | 0x82));
    let classes = 1..=if communication { 1 } else { ERROR_CLASSES };
    let exists = |sub: &u8| {
        !knowledge.is_described() || knowledge.entry(Multiplexer::new(object::ERROR_BEHAVIOR, *sub)).is_some()
    };
    let (mut stays, mut leaves) = (false, false);
    for sub in classes.filter(exists) {
        match expected_values.number(knowledge, object::ERROR_BEHAVIOR, sub) {
            Some(1) => stays = true,
            Some(0) => leaves = true,
            _ => return Some(Phase::Unsure),
        }
    }
    (!stays || leaves).then_some(Phase::Running)
}

/// Whether a dictionary with guarding is described, or the manual says that the device answers guarding requests. 100Ch
/// is mandatory for devices with node guarding (CiA 301, 7.5.2.11).
fn guards(knowledge: &Knowledge) -> bool {
    let is_described = knowledge.entry(Multiplexer::new(object::GUARD_TIME, 0)).is_some();
    knowledge.services.guarding.unwrap_or(is_described)
}

/// Whether a frame commands a reset of the device, alone or with all nodes.
fn resets(frame: &Frame, knowledge: &Knowledge) -> bool {
    let named = |node: u8| node == 0 || node == knowledge.node.raw();
    Nmt::read(frame.data()).is_ok_and(|nmt| named(nmt.node) && nmt.command.is_reset())
}

/// Whether the device produces heartbeats; `None`: not known.
fn produces_heartbeat(expected_values: &ExpectedValues, knowledge: &Knowledge) -> Option<bool> {
    let exists = knowledge.entry(HEARTBEAT_TIME).is_some();
    match expected_values.number(knowledge, HEARTBEAT_TIME.index.0, 0) {
        Some(period) => Some(period != 0),
        None if exists || !knowledge.is_described() => None,
        None => Some(false),
    }
}
