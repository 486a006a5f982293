//! Whether the device can become operational at all. If it can't, a case that needs operational may pass or fail only
//! for this reason.

use super::Bench;
use crate::verdict::{Breach, Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::{Observation, Subject};

const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);

/// A device that does not become operational.
pub(crate) enum KeptOut {
    /// The device was operational earlier in this run, but since the last case, or a case shortly before it, it no
    /// longer can be.
    Newly(Breach),
    /// The device was never operational as far as is known, or an earlier case has reported that it no longer can be.
    Known(Reason),
}

impl Bench<'_> {
    /// Whether the last case has commanded the device to become operational.
    pub(crate) const fn has_started_it(&self) -> bool {
        self.traffic.watch.has_started()
    }

    /// Resets the device and commands it to become operational; `None` if it does, or if it does not show its state.
    /// Frames sent here do not belong to the case before. `case`: the id of that case, if it can fail.
    pub(crate) fn kept_out_of_operational(&mut self, case: Option<&'static str>) -> Option<KeptOut> {
        self.traffic.watch.forget();
        let found = self.unjudged(Self::state_after_two_starts);
        self.restore();
        self.changes.settle_journal();
        // If the check was interrupted, nothing is known.
        let found = found.ok()?;
        self.knowledge.shows_no_state = found.is_none();
        let Some((state, reason)) = found.filter(|(state, _)| *state != State::OPERATIONAL) else {
            self.knowledge.kept_out_since = None;
            return None;
        };
        if !self.knowledge.was_operational {
            return Some(KeptOut::Known(reason));
        }
        Some(match (self.knowledge.kept_out_since, case) {
            (None, None) => KeptOut::Known(reason),
            (None, Some(_)) => {
                self.knowledge.kept_out_since = case;
                let breach = Breach::new(Subject::Device, "the device can be brought into operational, as before");
                let breach = breach.expected(Observation::State(State::OPERATIONAL)).found(Observation::State(state));
                KeptOut::Newly(breach.told(reason.actual))
            }
            (Some(since), _) => {
                KeptOut::Known(Reason { actual: format!("{}, since {since}", reason.actual), ..reason })
            }
        })
    }

    /// The state that the device shows after a reset and the command to become operational, with a reason for the
    /// report. A device that is not operational then is reset once more: what the case did can spoil the next start
    /// alone, which the cases on starts judge.
    fn state_after_two_starts(&mut self) -> Result<Option<(State, Reason)>, Stop> {
        match self.state_after_start()? {
            Some((state, _)) if state != State::OPERATIONAL => self.state_after_start(),
            found => Ok(found),
        }
    }

    /// The state that the device shows after a reset and the command to become operational, with a reason for the
    /// report.
    fn state_after_start(&mut self) -> Result<Option<(State, Reason)>, Stop> {
        self.prepare()?;
        self.show_state()?;
        self.command(Command::START)?;
        self.listen(self.timing().reaction)?;
        let found = self.state()?;
        Ok(found.map(|state| (state, self.not_reached(State::OPERATIONAL, found))))
    }

    /// The reason that the device is not in the state that a case needs. It includes an error that the device reports,
    /// which may be the cause.
    pub(super) fn not_reached(&mut self, expected: State, found: Option<State>) -> Reason {
        let mut actual = found.map_or_else(|| "no message that shows the state".to_owned(), |state| state.to_string());
        if expected == State::OPERATIONAL
            && let Some(error) = self.reported_error()
        {
            actual = format!("{actual}; it reports an error, which may be the cause: {error}");
        }
        Reason::new(format!("the device can be brought into {expected}"), expected.to_string(), actual)
    }

    /// The last error that the device has reported, or the error that its error register shows.
    fn reported_error(&mut self) -> Option<String> {
        if let Some((_, emcy)) = self.traffic.watch.emergencies().last() {
            return Some(format!("EMCY {emcy}"));
        }
        let register = self.unjudged(|bench| bench.read_number(ERROR_REGISTER)).ok()?;
        (register != 0).then(|| format!("{ERROR_REGISTER} is {register:02X}h"))
    }
}
