//! NMT states: how the tester sees them, and how it reaches them.

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

/// Heartbeat periods by which a case makes the device show its state. The case uses the first that the device accepts:
/// short, but no burden on the bus. A correct device may have a minimum period of its own.
const PERIODS_MS: [u16; 4] = [50, 100, 250, 1_000];

/// Number of attempts of a write that is not answered.
const TRIES: usize = 2;

/// Maximum time between heartbeats by which a device is recognised as operational before the run.
const LONGEST_HEARTBEAT: Duration = Duration::from_millis(1_100);

/// Number of periods without a heartbeat after which the producer counts as off.
const PERIODS: u64 = 4;

/// The abilities of the device's heartbeat producer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Heartbeats {
    /// The device has no heartbeat producer, or it is permanently off.
    None,
    /// 1017h accepts this time, in milliseconds.
    Settable(u16),
    /// 1017h can't be written: the device has a fixed period.
    Fixed(Duration),
}

impl Heartbeats {
    /// Whether 1017h accepts a time.
    pub(crate) const fn is_settable(self) -> bool {
        matches!(self, Self::Settable(_))
    }
}

impl Bench<'_> {
    /// The abilities of the device's heartbeat producer. The bench finds them out once.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn heartbeats(&mut self) -> Result<Heartbeats, Stop> {
        if let Some(known) = self.knowledge.heartbeats {
            return Ok(known);
        }
        let found = if self.has(HEARTBEAT_TIME)? { self.heartbeats_of_object()? } else { Heartbeats::None };
        self.knowledge.heartbeats = Some(found);
        Ok(found)
    }

    /// Reads and tries 1017h. Some descriptions contain a 1017h that the device does not have, or that can't be
    /// written: one case judges that, not all cases that look at the NMT state.
    fn heartbeats_of_object(&mut self) -> Result<Heartbeats, Stop> {
        let value = match self.upload(HEARTBEAT_TIME)?.outcome {
            Outcome::Uploaded(value) => value,
            Outcome::Aborted(_) => return Ok(Heartbeats::None),
            // A server without a valid answer says nothing about 1017h.
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

    /// Whether 1017h accepts a time. The cases on downloads judge any answer but an abort. `None` if the device does
    /// not answer.
    fn takes_period(&mut self, milliseconds: u16) -> Result<Option<bool>, Stop> {
        for _ in 0..TRIES {
            let attempt = self.download(HEARTBEAT_TIME, &milliseconds.to_le_bytes())?;
            if !attempt.is_silent() {
                return Ok(Some(attempt.abort().is_none()));
            }
        }
        Ok(None)
    }

    /// Makes the device show its state by heartbeats, if it can send them. Works only while SDO works, so before the
    /// device is stopped; a reset ends the heartbeats. A device with a fixed period shows its state without this.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device has a heartbeat producer but does not accept the time.
    pub(crate) fn show_state(&mut self) -> Result<(), Stop> {
        match self.heartbeats()? {
            Heartbeats::Settable(milliseconds) => self.write(HEARTBEAT_TIME, &milliseconds.to_le_bytes()),
            Heartbeats::Fixed(_) => Ok(()),
            Heartbeats::None if self.guarded_state()?.is_none() => self.let_guarding_be_answered(),
            Heartbeats::None => Ok(()),
        }
    }

    /// Sets a life time of a quarter of an hour for guarding, if it can be set: some devices answer guarding requests
    /// only with a life time. A device that refuses keeps its own.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn let_guarding_be_answered(&mut self) -> Result<(), Stop> {
        if self.can_write(GUARD_TIME)? && self.can_write(LIFE_TIME_FACTOR)? {
            self.download(GUARD_TIME, &10_000_u16.to_le_bytes())?;
            self.download(LIFE_TIME_FACTOR, &[100])?;
        }
        Ok(())
    }

    /// Ends the heartbeats of the device, even with a stored time: a device answers guarding only without heartbeats.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device has a heartbeat producer but does not accept the time.
    pub(crate) fn prefer_guarding(&mut self) -> Result<(), Stop> {
        if self.heartbeats()?.is_settable() && self.read_number(HEARTBEAT_TIME)? != 0 {
            self.write(HEARTBEAT_TIME, &[0, 0])?;
        }
        Ok(())
    }

    /// The state that the device shows from now on; `None` if it shows none.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub fn state(&mut self) -> Result<Option<State>, Stop> {
        let found = self.shown_state()?;
        self.knowledge.was_operational |= found == Some(State::OPERATIONAL);
        Ok(found)
    }

    fn shown_state(&mut self) -> Result<Option<State>, Stop> {
        let period = match self.heartbeats()? {
            Heartbeats::Settable(milliseconds) => Duration::from_millis(u64::from(milliseconds)),
            Heartbeats::Fixed(period) => period,
            Heartbeats::None => return self.guarded_state(),
        };
        self.drain()?;
        self.wait_for_state(period.times(PERIODS))
    }

    /// The state by node guarding; `None` also on a bus that carries no remote frames.
    fn guarded_state(&mut self) -> Result<Option<State>, Stop> {
        match self.guard() {
            Err(Stop::NotApplicable(_)) => Ok(None),
            other => other,
        }
    }

    /// Requests the state by node guarding.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub fn guard(&mut self) -> Result<Option<State>, Stop> {
        self.ask_for_state()?;
        self.wait_for_state(self.timing().silence)
    }

    /// Sends the remote frame of node guarding, without waiting for the answer.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn ask_for_state(&mut self) -> Result<(), Stop> {
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

    /// Brings the device into a state and checks that it shows it.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device does not reach the state.
    pub fn reach(&mut self, state: State) -> Result<(), Stop> {
        self.show_state()?;
        // A command for the current state would be a stimulus of its own.
        if self.state()? == Some(state) {
            return Ok(());
        }
        if let Some(command) = command_to(state) {
            self.command(command)?;
        }
        self.require_state(state)
    }

    /// Requires that the device is in this state; `after` names the event that came before. Allows the device its
    /// reaction time.
    ///
    /// # Errors
    /// Only the errors of the waits. Another state, or none, is recorded as a breach.
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

    /// Requires a state that a case needs but does not test; see [`Bench::expect_state`].
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device shows another state or none.
    pub(crate) fn require_state(&mut self, expected: State) -> Judged {
        self.listen(self.timing().reaction)?;
        let found = self.state()?;
        if found == Some(expected) { Ok(()) } else { Err(Stop::Inconclusive(self.not_reached(expected, found))) }
    }

    /// Whether the device shows by itself that it is operational, which means that it was at work before the run.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn is_operational(&mut self) -> Result<bool, Stop> {
        if let Some(state) = self.heard_state(LONGEST_HEARTBEAT)? {
            return Ok(state == State::OPERATIONAL);
        }
        let heartbeat_time = self.unjudged(|bench| bench.upload(HEARTBEAT_TIME))?;
        if heartbeat_time.is_silent() {
            // The tester can't ask for the state, and the device sends no sign of it.
            return Ok(false);
        }
        let time = heartbeat_time.value().map_or(0, |value| super::sdo::number(&value));
        if time != 0 {
            let period = Duration::from_millis(u64::from(time) + u64::from(time / 4)) + LONGEST_HEARTBEAT;
            return Ok(self.heard_state(period)? == Some(State::OPERATIONAL));
        }
        if self.has_other_clients() {
            // Until the user has allowed a test beside others, the tester only reads.
            return Ok(false);
        }
        // The first guarding request would start life guarding, and a device that is then not guarded reports an error.
        let mut product = 1;
        for at in [GUARD_TIME, LIFE_TIME_FACTOR] {
            product *= self.unjudged(|bench| bench.number_at_last(at))?.unwrap_or_default();
        }
        Ok(product == 0 && self.guarded_state()? == Some(State::OPERATIONAL))
    }

    /// The state according to the last sign of life within `span`: an error control message, or a PDO, which is sent
    /// only in operational. The tester waits for the whole span, because it also shows which other nodes there are.
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

    /// Ends the run: leaves the device as after power-on, and operational if it was operational before. Works after
    /// Ctrl-C too.
    pub(crate) fn leave(&mut self, operational: bool) {
        // A failure here has occurred before, and is in the reports of the cases.
        self.uncancelled(|bench| {
            let _ = baseline::restart_at_last(bench);
            if operational {
                let _ = bench.command(Command::START);
            }
        });
    }
}

/// The NMT command that leads to a state from every other state.
pub(crate) const fn command_to(state: State) -> Option<Command> {
    match state {
        State::PRE_OPERATIONAL => Some(Command::ENTER_PRE_OPERATIONAL),
        State::OPERATIONAL => Some(Command::START),
        State::STOPPED => Some(Command::STOP),
        _ => None,
    }
}
