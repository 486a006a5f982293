//! NMT states: how they are seen, and how they are reached.

use super::traffic::{is_from, is_tpdo};
use super::{Bench, baseline};
use crate::verdict::{Breach, Judged, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::client::Outcome;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{CanId, Duration, Frame};

/// Producer heartbeat time.
pub const HEARTBEAT_TIME: Multiplexer = Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0);
/// Guard time.
pub const GUARD_TIME: Multiplexer = Multiplexer::new(object::GUARD_TIME, 0);
/// Life time factor.
pub const LIFE_TIME_FACTOR: Multiplexer = Multiplexer::new(object::LIFE_TIME_FACTOR, 0);

/// The periods at which a case lets the device say its state, the first that it takes: short, and no burden on the bus. A
/// right device may have a least time of its own.
const PERIODS_MS: [u16; 4] = [50, 100, 250, 1_000];

/// How often a write that nobody answers is tried.
const TRIES: usize = 2;

/// A device whose heartbeats are further apart is not recognised as being at work.
const LONGEST_HEARTBEAT: Duration = Duration::from_millis(1_100);

/// How many periods without a heartbeat mean that there is none.
const PERIODS: u64 = 4;

/// What the heartbeat producer of a device can do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Heartbeats {
    /// There is none, or it is off for good.
    None,
    /// 1017h takes this time, in milliseconds.
    Settable(u16),
    /// 1017h can't be written: the period is that of the device.
    Fixed(Duration),
}

impl Heartbeats {
    /// Whether 1017h takes a time.
    pub(crate) const fn is_settable(self) -> bool {
        matches!(self, Self::Settable(_))
    }
}

impl Bench<'_> {
    /// What the device's heartbeat producer can do. Found out once.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub(crate) fn heartbeats(&mut self) -> Result<Heartbeats, Stop> {
        if let Some(known) = self.knowledge.heartbeats {
            return Ok(known);
        }
        let found = if self.has(HEARTBEAT_TIME)? { self.heartbeats_of_object()? } else { Heartbeats::None };
        self.knowledge.heartbeats = Some(found);
        Ok(found)
    }

    /// Some descriptions name a 1017h that the device does not have, or that can't be written: that is the matter of one case,
    /// not of all that look at the NMT state.
    fn heartbeats_of_object(&mut self) -> Result<Heartbeats, Stop> {
        let value = match self.upload(HEARTBEAT_TIME)?.outcome {
            Outcome::Uploaded(value) => value,
            Outcome::Aborted(_) => return Ok(Heartbeats::None),
            // A server that answers nothing, or nonsense, says nothing of 1017h.
            _ => return Ok(Heartbeats::Settable(PERIODS_MS[0])),
        };
        if self.can_write(HEARTBEAT_TIME)? {
            for milliseconds in PERIODS_MS {
                match self.takes_period(milliseconds)? {
                    Some(true) => return Ok(Heartbeats::Settable(milliseconds)),
                    Some(false) => {}
                    None => break,
                }
            }
        }
        Ok(match super::sdo::number(&value) {
            0 => Heartbeats::None,
            milliseconds => Heartbeats::Fixed(Duration::from_millis(u64::from(milliseconds))),
        })
    }

    /// Whether 1017h takes a time: everything but an abort is a matter of the cases on downloads. `None` where nobody answers.
    fn takes_period(&mut self, milliseconds: u16) -> Result<Option<bool>, Stop> {
        for _ in 0..TRIES {
            let attempt = self.download(HEARTBEAT_TIME, &milliseconds.to_le_bytes())?;
            if !attempt.is_silent() {
                return Ok(Some(attempt.abort().is_none()));
            }
        }
        Ok(None)
    }

    /// Makes the device show its state: lets it send heartbeats, where it can. Works only where SDOs work, so
    /// before the device is stopped; a reset ends it. One with a fixed period shows it by itself.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device has a heartbeat producer but does not take the time.
    pub fn show_state(&mut self) -> Result<(), Stop> {
        match self.heartbeats()? {
            Heartbeats::Settable(milliseconds) => self.write(HEARTBEAT_TIME, &milliseconds.to_le_bytes()),
            Heartbeats::Fixed(_) => Ok(()),
            Heartbeats::None if self.guard()?.is_none() => self.let_guarding_be_answered(),
            Heartbeats::None => Ok(()),
        }
    }

    /// Gives guarding a life time of a quarter of an hour, where it can be set: some devices answer guarding requests only
    /// with one. One that refuses it keeps its own.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn let_guarding_be_answered(&mut self) -> Result<(), Stop> {
        if self.can_write(GUARD_TIME)? && self.can_write(LIFE_TIME_FACTOR)? {
            self.download(GUARD_TIME, &10_000_u16.to_le_bytes())?;
            self.download(LIFE_TIME_FACTOR, &[100])?;
        }
        Ok(())
    }

    /// Ends the heartbeats of the device, a stored time too: only then guarding is answered.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device has a heartbeat producer but does not take the time.
    pub fn prefer_guarding(&mut self) -> Result<(), Stop> {
        if self.heartbeats()?.is_settable() && self.read_number(HEARTBEAT_TIME)? != 0 {
            self.write(HEARTBEAT_TIME, &[0, 0])?;
        }
        Ok(())
    }

    /// The state that the device shows from now on; `None` if it shows none.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn state(&mut self) -> Result<Option<State>, Stop> {
        let found = self.shown_state()?;
        self.knowledge.was_operational |= found == Some(State::OPERATIONAL);
        Ok(found)
    }

    fn shown_state(&mut self) -> Result<Option<State>, Stop> {
        let period = match self.heartbeats()? {
            Heartbeats::Settable(milliseconds) => Duration::from_millis(u64::from(milliseconds)),
            Heartbeats::Fixed(period) => period,
            Heartbeats::None => return self.guard(),
        };
        self.drain()?;
        self.wait_for_state(period.times(PERIODS))
    }

    /// Asks for the state by node guarding.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn guard(&mut self) -> Result<Option<State>, Stop> {
        self.ask_for_state()?;
        self.wait_for_state(self.timing().silence)
    }

    /// Sends the remote frame of node guarding, without waiting for the answer.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn ask_for_state(&mut self) -> Result<(), Stop> {
        self.drain()?;
        let id = CanId::standard_masked(u32::from(error_control::CAN_ID_BASE) + u32::from(self.node().raw()));
        match Frame::remote(id, 1) {
            Some(request) => self.send(&request).map(|_| ()),
            None => Ok(()),
        }
    }

    fn wait_for_state(&mut self, span: Duration) -> Result<Option<State>, Stop> {
        let cob_id = error_control::CAN_ID_BASE + u16::from(self.node().raw());
        self.wait_for(span, |record| {
            let is_ours = record.frame.cob_id() == Some(cob_id);
            let message = is_ours.then(|| ErrorControl::read(record.frame.data()).ok()).flatten()?;
            (!message.is_boot_up()).then_some(message.state)
        })
    }

    /// Brings the device into a state and sees it there.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if it does not get there.
    pub fn reach(&mut self, state: State) -> Result<(), Stop> {
        self.show_state()?;
        // A command for the state that it is in already is a stimulus of its own.
        if self.state()? == Some(state) {
            return Ok(());
        }
        if let Some(command) = command_to(state) {
            self.command(command)?;
        }
        self.require_state(state)
    }

    /// Demands that the device now is in that state, `after` something. Gives it the time to get there.
    ///
    /// # Errors
    /// Those of the waits; another state, or none, is recorded as a breach.
    pub fn expect_state(&mut self, expected: State, after: &str) -> Judged {
        self.listen(self.timing().reaction)?;
        let found = self.state()?;
        self.check(demand(found == Some(expected), || {
            let actual = found.map_or(Observation::Silence, Observation::State);
            Breach::new(Subject::Device, format!("the device is {expected} after {after}"))
                .expected(Observation::State(expected))
                .found(actual)
        }))
    }

    /// As [`Bench::expect_state`], of a state that a case needs first but is not about.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device shows another or none.
    pub(crate) fn require_state(&mut self, expected: State) -> Judged {
        self.listen(self.timing().reaction)?;
        let found = self.state()?;
        if found == Some(expected) { Ok(()) } else { Err(Stop::Inconclusive(self.not_reached(expected, found))) }
    }

    /// Whether the device says by itself that it is operational: it was at work before the run.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub(crate) fn is_operational(&mut self) -> Result<bool, Stop> {
        if let Some(state) = self.heard_state(LONGEST_HEARTBEAT)? {
            return Ok(state == State::OPERATIONAL);
        }
        let heartbeat_time = self.unjudged(|bench| bench.upload(HEARTBEAT_TIME))?;
        if heartbeat_time.is_silent() {
            // Nobody who can be asked, and nobody who says anything.
            return Ok(false);
        }
        let time = heartbeat_time.value().map_or(0, |value| super::sdo::number(&value));
        if time != 0 {
            let period = Duration::from_millis(u64::from(time) + u64::from(time / 4)) + LONGEST_HEARTBEAT;
            return Ok(self.heard_state(period)? == Some(State::OPERATIONAL));
        }
        if !self.traffic.clients.messages_of_run().is_empty() {
            // Nothing is sent but reads until the user has allowed to test beside others.
            return Ok(false);
        }
        // The first request would begin life guarding, and a device that nobody guards then reports an error.
        let mut product = 1;
        for at in [GUARD_TIME, LIFE_TIME_FACTOR] {
            product *= self.unjudged(|bench| bench.number_at_last(at))?.unwrap_or_default();
        }
        Ok(product == 0 && self.guard()? == Some(State::OPERATIONAL))
    }

    /// The state by the last sign of life in a span: an error control message, or a PDO, which only comes in operational. The span is
    /// waited for to its end, as that shows who else is there.
    fn heard_state(&mut self, span: Duration) -> Result<Option<State>, Stop> {
        let (node, mut state) = (self.node(), None);
        let cob_id = error_control::CAN_ID_BASE + u16::from(node.raw());
        self.wait_for(span, |record| {
            let id = record.frame.cob_id().filter(|_| is_from(node, &record.frame))?;
            let shown = match id {
                _ if id == cob_id => ErrorControl::read(record.frame.data()).ok().map(|message| message.state),
                _ => is_tpdo(id).then_some(State::OPERATIONAL),
            };
            state = shown.or(state);
            None::<()>
        })?;
        Ok(state)
    }

    /// Ends the run: the device is as after power-on, and operational if it was before. Works after Ctrl-C too.
    pub(crate) fn leave(&mut self, operational: bool) {
        // What can fail here has failed before, and is in the reports of the cases.
        self.uncancelled(|bench| {
            let _ = baseline::restart_at_last(bench);
            if operational {
                let _ = bench.command(Command::START);
            }
        });
    }
}

/// The command that leads to a state from every other.
pub const fn command_to(state: State) -> Option<Command> {
    match state {
        State::PRE_OPERATIONAL => Some(Command::ENTER_PRE_OPERATIONAL),
        State::OPERATIONAL => Some(Command::START),
        State::STOPPED => Some(Command::STOP),
        _ => None,
    }
}
